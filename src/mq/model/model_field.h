#pragma once
/// Vector fields on a model: its curvature, its harmonic fields, the gradient of its colours, or a file.

#include <filesystem>
#include <optional>

#include "mq/fem/tangent_fields.h"
#include "mq/model/model_signal.h"

namespace mq {

/// Noise of single texels has no direction.
inline constexpr Length usual_gradient_smoothing = {2, Length::Unit::texels};

struct FieldRequest {
  enum class Kind {
    max_curvature,  ///< principal directions, as strong as the two curvatures differ
    min_curvature,
    harmonic,  ///< without curl and divergence
    gradient,  ///< of the brightness of the textures, smoothed (`usual_gradient_smoothing`), or of the colours at vertices
    file,      ///< a .vf file, or a .ply file with vx, vy, vz at its vertices or faces
    map,       ///< a picture of directions in tangent space (field_map.h)
    strokes    ///< the smoothest one that goes along the strokes of a .json file (field_strokes.h)
  } kind = Kind::max_curvature;
  int number = 1;              ///< which of the harmonic fields, from 1
  std::filesystem::path file = {};  ///< of the last three kinds
  enum class Turn { none, quarter } turn = Turn::none;  ///< by 90 degrees, counter-clockwise

  /// Scaled such that the strongest is 1 (`scaled_to_one`); of length 1 wherever it is not 0; as it is.
  enum class Strength { scaled, unit, kept } strength = Strength::scaled;
};

struct ModelField {
  TangentField field;                  ///< a vector in space per triangle, tangent to it
  /// Of maps, and of strokes and gradients on textures, the same, finer: two components per texel, see
  /// `TexelVectorSpace`; else empty.
  Vector texels = {};
  std::optional<int> harmonic_fields;  ///< how many there are, where one was asked for
};

/// Throws `IoError` where the file is no field for this mesh, or holds no strokes or no picture.
void check_field(const TexturedModel& model, const FieldRequest& request);

/// Throws `InvalidInput` or `IoError` with the remedy where there is no such field, or it is 0
/// everywhere.
ModelField model_field(const TexturedModel& model, const ModelSignal& signal,
                       const FieldRequest& request, const Progress& progress = {});

}  // namespace mq
