#pragma once
/// Two textures of one atlas, aligned level by level on it and on coarser ones.

#include <array>
#include <optional>
#include <vector>

#include "mq/flow/detail/level_aligner.h"
#include "mq/flow/texture_levels.h"

namespace mq {

/// Textures as `coarse_to_fine` sees them: each level is worked on at the smallest size that shows it, with fields that
/// have a vector per texel, two components in its plane. Signals of the last level are not smoothed, and seen on the
/// finest texture; its field has no need of it. Levels and options must stay.
class TextureAligner final : public LevelAligner<Vector, ChartPlace> {
 public:
  /// Prepares the signals: without what varies more slowly than `detail` (model units), brought to scale.
  TextureAligner(const FlowTextures& textures, const MeshFlowOptions& options, const Signal& source,
                 const Signal& target, double detail);

  FlowLevel& enter(const FlowScale& scale) override;
  int most_steps() const override { return (seen_ > 0 ? 2 : 1) * options_.steps; }
  double correct(const Progress& progress, double share) override;

  /// Two components per texel of the finest texture, in its plane.
  Vector take_field() { return std::move(best_); }

 private:
  /// Σ_c (δ_c + ⟨Y, ∇μ_c⟩)² dA as ⟨Y, G·Y⟩ + 2⟨g, Y⟩ + ..., per texel.
  struct TexelTerms {
    struct Texel {
      double xx = 0, xy = 0, yy = 0, x = 0, y = 0;
    };
    std::vector<Texel> texels;
    double trace = 0;
  };

  int resolution_of_field(const FlowScale& scale) const override;
  int resolution_of_signals(const FlowScale& scale) const override {
    return scale.smoothed() ? resolution_of_field(scale) : 0;
  }
  const Vector& masses(int m) const override { return textures_[m].lumped_mass(); }
  Vector zero(int m) const override { return Vector::Zero(2 * std::int64_t(textures_[m].size())); }
  Ends ends_along(int m, const Vector& z, const std::vector<ChartPlace>* starts) const override;
  Signal looked_up(int m, const Signal& signal, const std::vector<ChartPlace>& places) const override;
  void place_probes(Probes& probes) const override;
  Vector prolongated(int m, const Vector& z) const override { return textures_.prolongated(m - 1, z); }
  void advance(Vector& X, double factor, const Vector& Y) const override { X += factor * Y; }
  double smoothness_of(const Vector& z) const override {
    return texture().vectors().smoothness_energy(z) / texture().area();
  }

  const FlowTexture& texture() const { return textures_[at_]; }  ///< of X
  const FlowTexture& seen() const { return textures_[seen_]; }
  Signal smoothed(int m, const Signal& signal, double weight) const;
  Signal without_light(const Signal& signal, double detail) const;
  TexelTerms terms(const Signal& difference, const Signal& gradients, const Vector* Y) const;
  TexelTerms gathered(TexelTerms terms) const;
  double weight_of(const TexelTerms& terms) const { return length_ * length_ * terms.trace / texture().area(); }
  static std::array<double, 2> products(const TexelTerms& terms, const Vector& Y);
  BlockMatrix<double> weighted_smoothness(double weight, const std::vector<float>& shares);
  Vector corrected(const TexelTerms& terms, double weight, const std::vector<float>& shares, const Progress& progress);

  const FlowTextures& textures_;
  double smoothness_weight_ = 0;  ///< of L in the matrix of `multigrid_`; 0: what is there is of no use
  Vector smoothness_;             ///< the diagonal of L
};

}  // namespace mq
