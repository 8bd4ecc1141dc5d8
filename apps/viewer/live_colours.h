#pragma once
/// Distances as colours in a model's pictures, as often as they change.

#include <memory>
#include <vector>

#include "mq/draw/false_colour.h"
#include "mq/fem/texels.h"
#include "mq/model/model_signal.h"
#include "texture_set.h"

namespace mq::view {

class LiveColours {
 public:
  /// `pictures` are those of a result of `domain`, which has textures.
  LiveColours(const ModelSignal& domain, std::shared_ptr<TextureSet> pictures);

  const std::shared_ptr<TextureSet>& pictures() const { return pictures_; }

  /// The largest distance that is shown.
  double most(const Vector& distance) const;

  enum class Colours {
    nearly,  ///< from a table, as fine as nobody sees
    exactly  ///< those that the verb writes
  };
  void show(const Vector& distance, const DistanceColours& scale, Colours colours);

 private:
  std::shared_ptr<TextureSet> pictures_;
  Texels texels_;             ///< places only: what pictures show of the signal
  std::vector<int> unknown_;  ///< of each of them
  std::vector<int> place_;    ///< of their distances in a table of colours
};

}  // namespace mq::view
