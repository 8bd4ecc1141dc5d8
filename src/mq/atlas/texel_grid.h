#pragma once
/// One numbering for the texels, and one for the cells, of all textures, with what a lookup outside
/// a texture finds.

#include <array>
#include <cstdint>
#include <vector>

#include "mq/atlas/atlas.h"
#include "mq/base/error.h"

namespace mq {

class TexelGrid {
 public:
  /// Throws `InvalidInput` when the textures together have more than 2³¹ texels.
  explicit TexelGrid(const std::vector<TextureSize>& textures) : textures_(textures) {
    for (const TextureSize& t : textures_) {
      texel_offsets_.push_back(texel_offsets_.back() + std::int64_t(t.width) * t.height);
      cell_offsets_.push_back(cell_offsets_.back() + std::int64_t(t.width + 1) * (t.height + 1));
    }
    require(cell_offsets_.back() < INT32_MAX,
            "the textures have more than 2^31 texels together: use smaller ones");
  }

  int texture_count() const { return int(textures_.size()); }
  const TextureSize& texture(int k) const { return textures_[k]; }
  int texel_count() const { return int(texel_offsets_.back()); }
  int cell_count() const { return int(cell_offsets_.back()); }
  int first_texel(int k) const { return int(texel_offsets_[k]); }
  int first_cell(int k) const { return int(cell_offsets_[k]); }

  /// Rows of cells of texture k, numbered 0 to height; `cell_row` says which an unwrapped row is.
  int cell_rows(int k) const { return textures_[k].height + 1; }
  int cell_row(int k, int row) const { return wrap_cell(row, textures_[k].height, textures_[k]); }
  /// The same for columns, 0 to width.
  int cell_column(int k, int column) const {
    return wrap_cell(column, textures_[k].width, textures_[k]);
  }

  /// The cell at an unwrapped column and row. Cells left of the first texel exist: there a clamped
  /// texture is constant across the border.
  int cell(int k, int column, int row) const {
    const TextureSize& t = textures_[k];
    return int(cell_offsets_[k]) + wrap_cell(row, t.height, t) * (t.width + 1) +
           wrap_cell(column, t.width, t);
  }

  /// The texel at an unwrapped place.
  int texel(int k, int column, int row) const {
    const TextureSize& t = textures_[k];
    return int(texel_offsets_[k]) + wrap_texel(row, t.height, t) * t.width +
           wrap_texel(column, t.width, t);
  }

  /// The texels at the corners of a cell: left top, right top, left bottom, right bottom.
  std::array<int, 4> corners(int k, int column, int row) const {
    return {texel(k, column, row), texel(k, column + 1, row), texel(k, column, row + 1),
            texel(k, column + 1, row + 1)};
  }

 private:
  static int modulo(int i, int n) { return i >= 0 ? i % n : n - 1 - (-1 - i) % n; }
  static int clamp(int i, int low, int high) { return i < low ? low : i > high ? high : i; }
  static int wrap_texel(int i, int n, const TextureSize& t) {
    if (i >= 0 && i < n) return i;
    return t.wrap == Wrap::repeat ? modulo(i, n) : clamp(i, 0, n - 1);
  }
  static int wrap_cell(int i, int n, const TextureSize& t) {
    if (i >= 0 && i < n) return i + 1;
    return 1 + (t.wrap == Wrap::repeat ? modulo(i, n) : clamp(i, -1, n - 1));
  }

  std::vector<TextureSize> textures_;
  std::vector<std::int64_t> texel_offsets_{0}, cell_offsets_{0};
};

}  // namespace mq
