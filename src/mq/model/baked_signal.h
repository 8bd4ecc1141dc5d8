#pragma once
/// Colours of one model carried to another that lies on it: to other charts, to a coarser or finer
/// mesh, from textures to vertices and back.

#include <cstdint>

#include "mq/filter/sample_fit.h"
#include "mq/model/messages.h"
#include "mq/model/model_signal.h"

namespace mq {

struct BakeOptions {
  double within = 0.05;  ///< how far the source may be, in its diagonals
  double angle = 60;     ///< and how it may be turned, degrees between normals
  int samples = 0;       ///< per texel and direction; 0: as many as show all that the source has
  ValueSpace values = {};
};

/// What the source shows, as a signal of the target.
struct BakedSignal {
  Signal values = {};  ///< per unknown, in the channels of the source
  int samples = 0;
  enum class Kind {
    mean,          ///< of what each texel covers: the target is coarser than the source
    least_squares  ///< the target shows the source best
  } kind = Kind::mean;
  SolveReport fit = {};
  std::int64_t points = 0;  ///< at which the source was looked at
  std::int64_t same = 0;    ///< of these, on triangles that both have
  std::int64_t unseen =
      0;                ///< unknowns that no part of the source belongs to: filled over the surface
  double accuracy = 0;  ///< how well the target lies on the source, model units
  Depth depth = Depth::u8;  ///< the deepest of the source
};

/// For the `TextureSignal` of a target: texels as renderers look them up, bilinear on each side of
/// a seam, so that both sides of it show what the source does.
TextureSignalOptions baking_options(const TexturedModel& target, const ValueSpace& values = {});

/// Looks at the source where the target lies on it: where a triangle has the same corners as the
/// one of its number in the source, there, else at the closest point that faces the same way
/// (`FacingPoints`). The source's textures are taken, bilinear, and where it has none its colours
/// at vertices. Where the texels of the target are at least one and a half times as far apart as
/// the source's, each has the mean of what it covers, else they are fitted (`SampleFit`). The model
/// must be that of the signal (`baking_options`).
///
/// Throws `InvalidInput` where the source has no colours, its textures do not store colours alike,
/// or nothing of it faces the target; and `Unsupported` for a normal map in tangent space, which is of
/// the source's charts.
BakedSignal bake(const TexturedModel& source, const TexturedModel& target,
                 const ModelSignal& signal, const BakeOptions& options, Messages& messages,
                 const Progress& progress = {});

/// Gives the target pictures of the values in place of its own, texels outside charts as the charts
/// go on; or colours at its vertices.
void put_baked(const BakedSignal& baked, const ModelSignal& signal, const ValueSpace& values,
               TexturedModel& target);

}  // namespace mq
