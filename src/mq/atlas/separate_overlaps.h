#pragma once
/// Charts that share texels, laid apart: where a texel of a picture stands for several places of
/// the surface, each gets a texel of its own.

#include <optional>
#include <vector>

#include "mq/atlas/atlas.h"
#include "mq/base/progress.h"

namespace mq {

/// An atlas of the same surface in larger textures, of which the pictures are the left top. Charts
/// are moved by whole texels, so that everything that is computed on them is what it would be at
/// home, but that no two of them read the same texel. Nor does any part of a chart read texels that
/// another part reads elsewhere on the surface (`InjectiveParts`): what is a chart here may be part
/// of one there, and edges between such parts are seams. No texture repeats.
struct SeparatedAtlas {
  Atlas atlas;

  /// Texels of the larger textures that charts were moved to, in rows of equal height.
  struct Patch {
    int x = 0, width = 0;
    int by_x = 0, by_y = 0;  ///< how far it was moved, texels
  };
  struct Shelf {
    int texture = 0, y = 0, height = 0;
    std::vector<Patch> patches;  ///< from left to right
  };
  std::vector<Shelf> shelves;  ///< by texture, from top to bottom
  std::vector<TextureSize> pictures;

  /// A texel of a picture.
  struct Home {
    int x = 0, y = 0;
    bool inside = true;  ///< false: of a picture that does not repeat, the border texel next to it
  };
  /// The texel whose copy texel (x, y) of a larger texture is.
  Home home(int texture, int x, int y) const;
};

/// Nothing where no texel stands for several places. Charts stay where they are, the largest first,
/// while they share no texel with one that stays; the others are moved, and with them all that
/// leave [0,1]. Throws `Unsupported` when the larger textures would have more than 2³¹ texels (a
/// floor tiled a hundred times over). Linear in the rows of texels that triangles cross, and in the
/// texels.
std::optional<SeparatedAtlas> separate_overlaps(const Surface& surface, const Atlas& atlas,
                                                const Progress& progress = {});

}  // namespace mq
