#pragma once
/// Values for the texels of a model's textures that lie outside charts, so that neither seams nor
/// the smaller levels of a mipmap show what was there.

#include <cstdint>
#include <limits>
#include <vector>

#include "mq/filter/chart_borders.h"
#include "mq/model/model_signal.h"

namespace mq {

struct FillOptions {
  ValueSpace values = {};
  double weight = 100;  ///< of agreement at seams against smoothness, per texel of a seam; 0:
                        ///< charts go on by themselves
  double distance = std::numeric_limits<double>::infinity();  ///< texels beyond those of charts
  std::optional<Depth> depth = {};  ///< see `TextureSignalOptions`
};

/// First the texels that lookups at the borders of charts read: the smoothest values for which the
/// two sides of each seam agree, with everything inside charts as it is. Then all others, each from
/// the nearest that a triangle covers.
///
///     const TextureFill fill(model, {}, messages);
///     fill.put(fill.solve(), model.model);
class TextureFill {
 public:
  /// Finds what is outside, and makes the space. The model must outlive the object. Throws
  /// `InvalidInput` where it has no texture coordinates or an option is negative, and what `TextureSignal` throws.
  TextureFill(const TexturedModel& model, const FillOptions& options, Messages& messages,
              const Progress& progress = {});

  const TextureSignal& signal() const { return signal_; }

  /// How many texels at borders are solved for.
  std::int64_t border_texels() const;

  /// The signal as it is and with new values at borders.
  struct Solution {
    Signal before, after;
    SolveReport report;
  };
  Solution solve(const Progress& progress = {}) const;

  /// Puts the solution into a model like this one, and spreads values over what is farther outside.
  /// Returns how many texels no chart reads.
  std::int64_t put(const Solution& solution, Model& model) const;

 private:
  FillOptions options_;
  std::vector<Coverage> coverage_;
  TextureSignal signal_;
  std::vector<char> border_;
};

/// Gives texels of the model's pictures that no chart reads the values of the nearest one that one does, so that
/// nothing else is to be seen in smaller levels of a mipmap. `texels`: those that charts read (`ModelSignal::texels`).
void spread_past_charts(std::span<const Texels::Place> texels, TexturedModel& model);

/// The same around unknowns of the label `unseen` alone, which were filled: texels to which others are nearer keep
/// their values. Of the pictures of `changed`, which is `model` with other ones.
void spread_past_unseen(const std::vector<int>& labels, const TexelSpace& space, const TexturedModel& model,
                        Model& changed);

}  // namespace mq
