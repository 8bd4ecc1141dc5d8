#pragma once
/// The cells of every texture that a part of a texel space needs, while they are collected.

#include <array>
#include <unordered_set>
#include <vector>

#include "mq/atlas/seams.h"
#include "mq/fem/texel_part.h"

namespace mq {

class PartWindows {
 public:
  /// The texels of a texture from (x0, y0) to before (x1, y1).
  struct Window {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  };

  /// All cells within `near` texels of a texel of the part.
  PartWindows(const Atlas& atlas, const BlockOwners& owners, int part, int near);

  /// No texel is of the part.
  bool empty() const;

  /// Whether a place lies in a cell within `near` texels of a texel of the part, or of a place that was added.
  bool is_near(const TexturePlace& place) const;

  /// Adds the cells around a place.
  void add(const TexturePlace& place);

  /// After all were added: `of` may be asked.
  void close();

  /// Its outermost cells are not needed, but where the texture itself ends. Empty: nothing of the texture is.
  const Window& of(int texture) const { return windows_[std::size_t(texture)]; }

  /// Whether the rectangle around a triangle meets a cell that is needed, or nearly.
  bool meets(int texture, const std::array<TexelPoint, 3>& corners) const;

  /// Per cell of the grid of `part`, whose textures are the windows, 1 where it is needed.
  std::vector<char> cells(const Atlas& part) const;

 private:
  std::int64_t key(int texture, int x, int y) const;
  std::array<int, 2> wrapped(const TexturePlace& place) const;
  bool owns_near(int texture, int x, int y) const;

  /// visit(texture, x0, y0, x1, y1) of rectangles [x0, x1) × [y0, y1) of cells that are needed: around the part's
  /// blocks and around places that were added.
  template <class Visit>
  void for_each_needed(const Visit& visit) const;

  const Atlas& atlas_;
  const BlockOwners& owners_;
  int part_, near_;
  std::vector<Window> windows_;                 ///< texels that are needed, then with what is around them
  std::unordered_set<std::int64_t> added_;      ///< cells of places
  std::vector<std::vector<char>> coarse_;       ///< per texture, squares of `coarse_side` texels that are met
};

}  // namespace mq
