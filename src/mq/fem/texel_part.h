#pragma once
/// A part of a texel space, made without the rest of it: what one of several processes holds of a model.
///
/// Blocks of texels are handed out to parts (texel_blocks.h); a texel belongs to the part that its block belongs to.
/// The part's space is made of the cells around its own texels and of those that seams couple to them; textures
/// are cut down to where these lie. So the rows of its own texels, in matrices and in right-hand sides, are
/// those of the whole space, entry for entry (cells are integrated in other coordinates, which differ by whole
/// texels: to rounding); rows of the halo, which other parts own, are incomplete and not to be used.

#include <memory>
#include <vector>

#include "mq/atlas/texel_blocks.h"
#include "mq/fem/texel_space.h"

namespace mq {

/// Which part every texel is of.
struct BlockOwners {
  const TexelBlocks& blocks;
  std::vector<int> part;  ///< per block

  int operator()(const Texels::Place& texel) const {
    return part[std::size_t(blocks.block(texel.texture, texel.x, texel.y))];
  }
};

/// Where the surface shows own texels of a part: at the centres of those that triangles cover, and at other points,
/// where neighbours take part.
class ShownPlaces {
 public:
  /// The largest value ≥ 0 that is shown, of one per unknown of the part's space; what is not finite does not count.
  double largest(const Vector& values) const;

 private:
  friend class TexelPart;
  std::vector<int> covered_, ends_;
  std::vector<BasisWeight> weights_;  ///< of each point up to its end
};

class TexelPart {
 public:
  /// Surface, atlas, seams (of the whole atlas) and owners must outlive the part. Takes the part's own cells and
  /// a pass over the triangles and seams of the whole; holds, beside its space, arrays over all triangles of the
  /// surface and eight bytes for each texel of the smallest rectangle of each texture around what it needs. `how` says
  /// all but the cells.
  /// Where a texture repeats it is that texture. Throws what `TexelSpace` throws; a part of which no texel belongs
  /// to any chart has no space.
  TexelPart(const Surface& surface, const Atlas& atlas, const Seams& seams, const BlockOwners& owners, int part,
            const TexelSpaceOptions& how = {}, const Progress& progress = {});
  ~TexelPart();
  TexelPart(const TexelPart&) = delete;
  TexelPart& operator=(const TexelPart&) = delete;

  bool empty() const { return own_.empty(); }

  /// Not of an empty part.
  const TexelSpace& space() const { return *space_; }

  /// That of the space: the triangles that it needs, in textures that are cut down to where these lie.
  const Atlas& atlas() const { return *atlas_; }

  /// The unknowns of the space that belong to the part, ascending: in the order of the whole space.
  const std::vector<int>& own() const { return own_; }

  /// Per unknown of the space the texel of the whole atlas that it is.
  const std::vector<Texels::Place>& places() const { return places_; }

  /// Per unknown of the space the part it belongs to.
  const std::vector<int>& owner() const { return owner_; }

  /// Whether any own texel is of this texture: its picture is wanted.
  bool has_texture(int texture) const;

  /// The own unknowns whose functions do not vanish on the boundary of the whole's domain, ascending. As long as there
  /// is a space.
  std::vector<int> boundary() const;

  /// Over all parts these are the places that `TexelSpace::largest_shown` looks at. As long as there is a space.
  ShownPlaces shown() const;

  /// Lets go of the space, once its matrices are made; places and owners stay.
  void let_go_of_space();

 private:
  const Surface& surface_;
  int part_;
  std::unique_ptr<Atlas> atlas_;
  std::unique_ptr<TexelSpace> space_;
  std::vector<int> own_, owner_;
  std::vector<Texels::Place> places_;
};

}  // namespace mq
