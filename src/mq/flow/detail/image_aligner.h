#pragma once
/// Two images moved towards each other along a field, and the correction of the field that brings
/// them nearer: one linearised step of optical flow at one scale.

#include <cmath>
#include <vector>

#include "mq/base/progress.h"
#include "mq/flow/image_flow.h"
#include "mq/flow/image_system.h"
#include "mq/image/image.h"

namespace mq {

/// ψ of width ϵ, 0 for squares, with what it is made quadratic by: ψ(s²) ≈ w·s² + const.
struct Penalty {
  double width = 0;
  double value(double square) const {
    if (width == 0) return square;
    return 2 * width * (std::sqrt(square + width * width) - width);
  }
  double weight(double square) const {
    return width == 0 ? 1 : width / std::sqrt(square + width * width);
  }
};

/// Two signals moved towards each other.
struct MovedImages {
  Image<float> source, target;
  std::vector<char> inside;  ///< whether both places are in the image
  std::vector<float> cost;   ///< Σ_c ψ_D per pixel
};

struct MovedCosts {
  double before = 0, after = 0;
  MovedCosts operator+(const MovedCosts& other) const {
    return {before + other.before, after + other.after};
  }
};

/// The costs of two fields over the pixels that both keep in the images: none gets better by what
/// it moves out of sight.
MovedCosts compared(const MovedImages& before, const MovedImages& after);

/// The mean of ψ_D over pixels and channels, where what is out of sight counts as in `blend`.
double error_of(const MovedImages& moved, const MovedImages& blend);

/// What one scale is made of.
struct ImageScale {
  Image<float> source, target;
  double length = 0;  ///< pixels of this grid
  Penalty data;

  /// Where this field jumps from pixel to pixel corrections may, too; empty: nowhere.
  Image<float> torn{};
};

/// Both arguments must stay.
class ImageAligner {
 public:
  ImageAligner(const ImageScale& scale, const ImageFlowOptions& options)
      : scale_(scale), options_(options) {}

  MovedImages move(const Image<float>& X) const;

  /// A correction and its scale α*; α* = 0 where there is nothing to correct.
  struct Correction {
    FlowPlanes Y;
    double scale = 0;
    int cycles = 0;
  };
  Correction correct(const MovedImages& moved, const Progress& progress) const;

 private:
  struct Equations;

  std::vector<float> smoothness_weights(const FlowPlanes& Y) const;
  Equations linearised(const MovedImages& moved, const FlowPlanes& Y) const;
  static double best_scale(const std::vector<float>& d11, const std::vector<float>& d12,
                           const std::vector<float>& d22, const Equations& equations,
                           const FlowPlanes& Y);

  const ImageScale& scale_;
  const ImageFlowOptions& options_;
};

}  // namespace mq
