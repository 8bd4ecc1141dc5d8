#pragma once
/// A photograph in light, and light in the values of a signal.

#include <span>
#include <string>
#include <vector>

#include "mq/io/cameras.h"
#include "mq/model/model_signal.h"
#include "mq/views/view_choice.h"

namespace mq {

struct PhotographLight {
  Image<float> light;    ///< three channels, or four with alpha
  PinholeCamera camera;  ///< of the picture as it is
  std::string remark;    ///< where its size is not its camera's

  /// Throws what `read_photograph` and `fitted_camera` throw, and `InvalidInput` for other channels.
  static PhotographLight read(const Photograph& photograph);
};

/// How far a place of a picture is from its middle, in half diagonals.
double radius_in(int width, int height, const Vector2& place);

/// What becomes of light in a signal of textures.
class PhotographValues {
 public:
  /// Throws `InvalidInput` where textures of the model do not store colours alike and its values are those
  /// stored, or where it has other channels than grey or colours.
  PhotographValues(const TexturedModel& model, const TextureSignal& signal);

  /// The photograph's light, evened out as the photograph of that number, in the signal's values; its alpha stays.
  Image<float> of(const PhotographLight& photograph, const Exposures& exposures, int number) const;

  /// Of colours, a row each, in the signal's colour channels.
  Signal of_colours(std::span<const LightColour> colours) const;

  /// Rows of colours, and whatever follows them, with the alpha that the signal may have: 1.
  Signal with_alpha(const Signal& values) const;

 private:
  Image<float> worked(Image<float> light) const;

  ColourSpace space_;
  TransferFunction transfer_;  ///< of what the model's textures store
  int channels_;
};

}  // namespace mq
