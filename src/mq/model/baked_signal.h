#pragma once
/// Colours of one model carried to another that lies on it: to other charts, to a coarser or finer
/// mesh, from textures to vertices and back.

#include <cstdint>
#include <memory>

#include "mq/filter/sample_fit.h"
#include "mq/model/messages.h"
#include "mq/model/model_signal.h"
#include "mq/model/normal_axes.h"

namespace mq {

struct BakeOptions {
  double within = 0.05;  ///< how far the source may be, in its diagonals
  double angle = 60;     ///< and how it may be turned, degrees between normals
  int samples = 0;       ///< per texel and direction; 0: as many as show all that the source has
  ValueSpace values = {};

  /// What of the source: its pictures, or where it has none its colours at vertices; or the shading
  /// normals of its shape, as a normal map of the target.
  enum class Shown { pictures, shading_normals } shown = Shown::pictures;

  /// What becomes of the factors of the source's materials: they stay in its materials, for a target that
  /// has these; or the values are multiplied by them, or by all but that of alpha.
  enum class Factors { apart, applied, applied_but_alpha } factors = Factors::apart;
  /// What a picture holds that is made of colours at vertices that are light (glTF) in floating point: light;
  /// or as pictures of any other source display values, of 16 bits.
  enum class FloatColours { light, displayed } float_colours = FloatColours::light;
  /// Normal maps become such as glTF has: in tangent space, green up. Else those in object space stay in
  /// it, and green stays down.
  bool to_tangent_space = false;
};

/// The frames of a normal map in tangent space that was baked.
struct BakedNormals {
  std::shared_ptr<const ShadingFrames> source;  ///< null: the source's map is in object space
  std::shared_ptr<const ShadingFrames> target;
};

/// What the source shows, as a signal of the target.
struct BakedSignal {
  Signal values =
      {};  ///< per unknown, in the channels of the source; first d, where there are `normals`
  std::shared_ptr<const BakedNormals> normals = {};  ///< null: values are as the source stores them
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
  bool is_light = false;    ///< as the source's pictures hold it
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
/// A normal map in tangent space is in the frames of its charts (normal_axes.h), so its normals n,
/// seen in the model's axes, become what they add to the shading normals N of the target, d = n −
/// N; one field over all seams, 0 where a flat map meets the same shading. `put_baked` puts
/// normalise(N + d) into the frames of the target: those of its file, or that the file made anew
/// will hold (`frames_to_write`). One in object space stays in it.
///
/// Throws `InvalidInput` where the source has no colours, its textures do not store colours alike,
/// or nothing of it faces the target, for normal maps without z, and where they are put into charts
/// that overlap; and `Unsupported` for normals in tangent space at vertices.
BakedSignal bake(const TexturedModel& source, const TexturedModel& target,
                 const ModelSignal& signal, const BakeOptions& options, Messages& messages,
                 const Progress& progress = {});

/// Gives the target pictures of the values in place of its own (normals in tangent space coded, of
/// unit length), texels outside charts as the charts go on; or colours at its vertices.
void put_baked(const BakedSignal& baked, const ModelSignal& signal, const ValueSpace& values,
               TexturedModel& target);

}  // namespace mq
