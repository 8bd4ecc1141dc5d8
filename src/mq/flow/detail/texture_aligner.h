#pragma once
/// Two textures of one atlas, aligned level by level on it and on coarser ones.

#include <optional>
#include <string>
#include <vector>

#include "mq/flow/detail/coarse_to_fine.h"
#include "mq/flow/surface_optical_flow.h"
#include "mq/flow/texture_levels.h"

namespace mq {

/// Where the source and the target are looked up for each texel. Empty: at the texel itself.
struct TexelEnds {
  std::vector<ChartPlace> source, target;
};

/// Textures as `coarse_to_fine` sees them: each level is worked on at the smallest size that shows it, with fields that
/// have a vector per texel. Errors are those of `MeshFlow`, with texels for vertices. Levels and options must stay.
class TextureAligner final : public FlowDomain {
 public:
  /// Prepares the signals: without what varies more slowly than `detail` (model units), brought to scale.
  TextureAligner(const FlowTextures& textures, const MeshFlowOptions& options, const Signal& source,
                 const Signal& target, double detail);

  /// Puts X = 0 on the texture of the first scale.
  void begin(const std::vector<FlowScale>& scales);

  std::string name(const FlowScale& scale) const override;
  double work(const FlowScale& scale) const override;
  double blend_error() const override { return blend_error_; }
  FlowLevel& enter(const FlowScale& scale) override;
  void go_back_if_better() override;
  void look_up() override;
  double level_error() const override { return error_; }
  int most_steps() const override { return (at_ > 0 ? 2 : 1) * options_.steps; }
  double correct(const Progress& progress, double share) override;
  FlowErrorChange attempt(double factor) override;
  void take() override;
  void leave() override { now_ -= factor_ * Y_; }
  double measure() override;
  void keep() override;
  void forget() override { best_.setZero(); }
  std::optional<double> settled_error() override;
  void finish() override;

  /// Two components per texel of the finest texture, in its plane.
  Vector take_field() { return std::move(best_); }
  std::vector<MeshFlowLevel> take_levels() { return std::move(levels_); }

 private:
  struct Pair {
    Signal source, target;
  };

  /// Some texels of the finest texture, at which errors of fields on coarser ones are taken.
  struct Probes {
    std::vector<ChartPlace> starts;
    Vector mass;
    double blend_error = 0;
  };

  /// Σ_c (δ_c + ⟨Y, ∇μ_c⟩)² dA as ⟨Y, G·Y⟩ + 2⟨g, Y⟩ + ..., per texel.
  struct TexelTerms {
    struct Texel {
      double xx = 0, xy = 0, yy = 0, x = 0, y = 0;
    };
    std::vector<Texel> texels;
    double trace = 0;
  };

  const FlowTexture& texture() const { return textures_[at_]; }
  int texture_for(const FlowScale& scale) const;
  TexelEnds ends_along(int m, const Vector& z, const std::vector<ChartPlace>& starts) const;
  Pair warped(int m, const Pair& pair, const TexelEnds& ends) const;
  double error_of(int m, const Pair& pair, const TexelEnds& ends) const;
  void place_probes();
  double probe(const TexelEnds& ends) const;
  double error_from_coarse(Vector z) const;
  void move_to(int m);
  Signal smoothed(int m, const Signal& signal, double weight) const;
  Signal without_light(const Signal& signal, double detail) const;
  TexelTerms terms(const Signal& difference, const Signal& gradients, const Vector* Y) const;
  double weight_of(const TexelTerms& terms) const { return length_ * length_ * terms.trace / texture().area(); }
  double scale_of(const TexelTerms& terms, const Vector& Y) const;
  Vector corrected(const TexelTerms& terms, double weight, const std::vector<float>& shares, const Progress& progress);

  const FlowTextures& textures_;
  const MeshFlowOptions& options_;
  std::vector<Pair> raw_;  ///< prepared signals, per texture
  double blend_error_ = 0;
  Probes probes_;

  int at_ = 0;              ///< the texture at hand
  Vector now_, best_;       ///< X there, and the one of the least error on the finest texture
  bool same_ = true;        ///< they are the same, and `ends_` those of both
  bool estimated_ = false;  ///< the error of the best, at the probes
  TexelEnds ends_;          ///< of paths along X

  std::vector<MeshFlowLevel> levels_;
  double length_ = 0;  ///< ℓ of the level
  Pair signals_;       ///< at the level
  Pair met_;           ///< looked up along X
  double error_ = 0;   ///< of these
  std::optional<BlockMultigrid> multigrid_;
  std::optional<BlockMatrix<double>> smoothness_;  ///< L on the texture at hand

  Vector Y_;            ///< the correction at hand
  double factor_ = 0;   ///< of it in X, while it is tried
  TexelEnds next_ends_;  ///< then
  Pair next_;
  double next_error_ = 0;
};

}  // namespace mq
