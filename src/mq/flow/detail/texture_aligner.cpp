/// As `SurfaceAligner`, with texels for vertices: signals are averaged onto textures of half the size, fields are
/// interpolated from them, carried from plane to plane; paths run over the cells between texels (`AtlasFlow`).

#include "mq/flow/detail/texture_aligner.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "mq/base/parallel.h"
#include "mq/base/stopwatch.h"
#include "mq/flow/detail/surface_warp.h"
#include "mq/flow/detail/transfer_weights.h"
#include "mq/linear/conjugate_gradients.h"
#include "mq/trace/atlas_flow.h"

namespace mq {
namespace {

constexpr double texels_per_length = 1.3;           // of the texture on which X of the last scale lives, at least
constexpr double texels_per_smoothed_length = 2.6;  // of that of another scale, with its signals, at least
constexpr double texels_per_light = 2;     // of the texture on which light is found, at least

}  // namespace

TextureAligner::TextureAligner(const FlowTextures& textures, const MeshFlowOptions& options, const Signal& source,
                               const Signal& target, double detail)
    : LevelAligner(options), textures_(textures) {
  Signal both(source.rows(), 2 * source.cols());
  both << textures_[0].shown(source), textures_[0].shown(target);
  both = without_light(both, detail);
  raw_.push_back({both.leftCols(source.cols()), both.rightCols(source.cols())});
  auto& [first, second] = raw_[0];
  const Vector& mass = textures_[0].lumped_mass();
  const Eigen::RowVectorXd mean = mass.transpose() * (first + second) / (2 * mass.sum());
  for (Signal* signal : {&first, &second}) {
    const Eigen::RowVectorXd own = mass.transpose() * *signal / mass.sum();
    const double variance = (mass.transpose() * (signal->rowwise() - own).array().square().matrix()).mean() / mass.sum();
    signal->rowwise() -= mean;
    if (variance > 0) *signal /= std::sqrt(variance);
  }
  for (int m = 0; m + 1 < textures_.count(); ++m)
    raw_.push_back({textures_.restricted(m, raw_[std::size_t(m)].source),
                    textures_.restricted(m, raw_[std::size_t(m)].target)});
}

/// The smallest texture on which fields of a level show.
int TextureAligner::resolution_of_field(const FlowScale& scale) const {
  const double texels = scale.smoothed() ? texels_per_smoothed_length : texels_per_length;
  int m = 0;
  while (m + 1 < textures_.count() && textures_[m + 1].spacing() * texels <= scale.length) ++m;
  return m;
}

/// (M + weight·S)⁻¹·M·φ.
Signal TextureAligner::smoothed(int m, const Signal& signal, double weight) const {
  if (!(weight > 0)) return signal;
  const FlowTexture& texture = textures_[m];
  const TexelSpace& space = texture.space();
  const SparseMatrix A = space.regularised_system(1, weight);
  const Signal change = -weight * space.stiffness_times(signal);
  Signal correction = Signal::Zero(signal.rows(), signal.cols());
  if (weight > 100 * texture.spacing() * texture.spacing())
    space.solver({.tolerance = 1e-3})(A, {})->solve(change, correction);
  else
    conjugate_gradients(A, change, correction, jacobi_preconditioner(A), {.tolerance = 1e-3});
  return signal + correction;
}

/// φ − Smooth(φ, detail²), found at the smallest size that shows it.
Signal TextureAligner::without_light(const Signal& signal, double detail) const {
  if (!(detail > 0)) return signal;
  int m = 0;
  while (m + 1 < textures_.count() && textures_[m + 1].spacing() * texels_per_light <= detail) ++m;
  Signal low = signal;
  for (int k = 0; k < m; ++k) low = textures_.restricted(k, low);
  low = smoothed(m, low, detail * detail);
  for (int k = m; k > 0; --k) low = textures_.prolongated_signal(k - 1, low);
  return signal - low;
}

TextureAligner::Ends TextureAligner::ends_along(int m, const Vector& z, const std::vector<ChartPlace>* from) const {
  const TraceAtlas& domain = textures_[m].domain();
  const std::vector<ChartPlace>& starts = from ? *from : textures_[m].starts().places;
  std::vector<std::array<double, 2>> velocities = textures_[m].vectors().velocities(z);
  Ends ends;
  if (options_.alignment == FlowAlignment::forward) {
    ends.target = AtlasFlow::along(domain, velocities).trace(starts, 1).ends;
    return ends;
  }
  ends.target = AtlasFlow::along(domain, velocities).trace(starts, 0.5).ends;
  for (auto& [x, y] : velocities) x = -x, y = -y;
  ends.source = AtlasFlow::along(domain, velocities).trace(starts, 0.5).ends;
  return ends;
}

/// Signals at the places, or as they are where there are none.
Signal TextureAligner::looked_up(int m, const Signal& signal, const std::vector<ChartPlace>& places) const {
  Signal values = places.empty() ? signal : Signal(std::ssize(places), signal.cols());
  parallel_for(std::ssize(places), [&](std::int64_t i) {
    textures_[m].domain().plain_value(signal, places[std::size_t(i)], values.middleRows(i, 1));
  });
  return values;
}

/// Every n-th texel.
void TextureAligner::place_probes(Probes& probes) const {
  const FlowTexture& finest = textures_[0];
  const int step = finest.size() / std::max(1, options_.probes);
  if (step < 2) return;
  std::vector<double> mass;
  for (int i = step / 2; i < finest.size(); i += step) {
    if (finest.starts().outside[std::size_t(i)]) continue;
    probes.starts.push_back(finest.starts().places[std::size_t(i)]);
    mass.push_back(finest.lumped_mass()[i]);
  }
  probes.mass = Eigen::Map<const Vector>(mass.data(), std::ssize(mass));
}

FlowLevel& TextureAligner::enter(const FlowScale& scale) {
  MeshFlowLevel& level = levels_.emplace_back();
  length_ = scale.length;
  const int before = at_;
  move_to(resolution_of_field(scale), resolution_of_signals(scale));
  level.vertices = seen().size();
  const Stopwatch watch;
  const Pair& raw = raw_[std::size_t(seen_)];
  const Eigen::Index channels = raw.source.cols();
  if (scale.smoothed()) {
    Signal both(raw.source.rows(), 2 * channels);
    both << raw.source, raw.target;
    both = smoothed(seen_, both, length_ * length_ / 2);
    signals_ = Pair{both.leftCols(channels), both.rightCols(channels)};
  } else {
    signals_.reset();
  }
  if (options_.gradient_weight > 0) {
    if (!signals_) signals_ = raw;
    for (Signal* signal : {&signals_->source, &signals_->target}) {
      const Signal gradient = seen().vectors().gradient(*signal);
      Signal with(signal->rows(), 2 * channels);
      with.leftCols(channels) = *signal;
      for (Eigen::Index i = 0; i < with.rows(); ++i)
        with.row(i).tail(channels) =
            std::sqrt(options_.gradient_weight) * length_ * gradient.middleRows(2 * i, 2).colwise().norm();
      *signal = std::move(with);
    }
  }
  level.smooth_seconds = watch.seconds();
  if (!multigrid_ || before != at_) {
    smoothness_weight_ = 0;
    multigrid_.emplace(texture().transfers(), BlockMultigridOptions{.tolerance = options_.tolerance});
  }
  return level;
}

/// With a Y, differences count less the larger they are there: 1/√(1 + (δ_c + ⟨Y, ∇μ_c⟩)²/ϵ²).
TextureAligner::TexelTerms TextureAligner::terms(const Signal& difference, const Signal& gradients,
                                                 const Vector* Y) const {
  TexelTerms result;
  result.texels.resize(std::size_t(difference.rows()));
  const Vector& mass = seen().lumped_mass();
  const double robust = options_.robust_data;
  result.trace = parallel_sum(difference.rows(), 0.0, [&](std::int64_t begin, std::int64_t end) {
    double trace = 0;
    for (std::int64_t i = begin; i < end; ++i) {
      TexelTerms::Texel& texel = result.texels[std::size_t(i)];
      for (Eigen::Index c = 0; c < difference.cols(); ++c) {
        const double x = gradients(2 * i, c), y = gradients(2 * i + 1, c), d = difference(i, c);
        double weight = mass[i];
        if (Y && robust > 0) {
          const double left = (d + (*Y)[2 * i] * x + (*Y)[2 * i + 1] * y) / robust;
          weight /= std::sqrt(1 + left * left);
        }
        texel.xx += weight * x * x;
        texel.xy += weight * x * y;
        texel.yy += weight * y * y;
        texel.x += weight * d * x;
        texel.y += weight * d * y;
      }
      trace += texel.xx + texel.yy;
    }
    return trace;
  });
  return result;
}

/// The terms of X on the texture of fields, where signals are on a finer one: Pᵀg, and in place of PᵀGP the blocks of its
/// rows on the diagonal, which is not less, Σ_i |Σ_j w_ij x_j|² ≤ Σ_i Σ_j w_ij |x_j|², and as smoothness couples
/// neighbours more than differences do hardly more.
TextureAligner::TexelTerms TextureAligner::gathered(TexelTerms terms) const {
  for (int m = seen_; m < at_; ++m) {
    const BlockTransfer& P = textures_.transfer(m);
    std::vector<TexelTerms::Texel> coarse(std::size_t(P.columns));
    parallel_for(P.columns, [&](std::int64_t j) {
      TexelTerms::Texel& sum = coarse[std::size_t(j)];
      for (int e = P.child_starts[std::size_t(j)]; e < P.child_starts[std::size_t(j) + 1]; ++e) {
        const BlockTransfer::Entry& child = P.children[std::size_t(e)];
        const double weight = mq::weight_of(child);
        if (!(weight > 0)) continue;
        const double c = child.cosine, s = child.sine, cc = c * c / weight, cs = c * s / weight, ss = s * s / weight;
        const TexelTerms::Texel& fine = terms.texels[std::size_t(child.column)];
        sum.xx += cc * fine.xx + 2 * cs * fine.xy + ss * fine.yy;
        sum.xy += cs * (fine.yy - fine.xx) + (cc - ss) * fine.xy;
        sum.yy += ss * fine.xx - 2 * cs * fine.xy + cc * fine.yy;
        sum.x += c * fine.x + s * fine.y;
        sum.y += c * fine.y - s * fine.x;
      }
    });
    terms.texels = std::move(coarse);
  }
  return terms;
}

/// weight·L without its diagonal. What the multigrid has is taken back where only the weight is another.
BlockMatrix<double> TextureAligner::weighted_smoothness(double weight, const std::vector<float>& shares) {
  const bool kept = shares.empty() && smoothness_weight_ > 0;
  BlockMatrix<double> A = kept ? multigrid_->take_matrix()
                               : texture().vectors().regularised_system(0, 1, shares.empty() ? texture().limits() : shares);
  const double factor = kept ? weight / smoothness_weight_ : weight;
  smoothness_.resize(A.rows());
  parallel_for(A.rows(), [&](std::int64_t i) {
    for (int e = A.starts[std::size_t(i)]; e < A.starts[std::size_t(i) + 1]; ++e) {
      std::array<double, 4>& block = A.blocks[std::size_t(e)];
      if (A.columns[std::size_t(e)] != i)
        for (double& value : block) value *= factor;
      else if (!kept)
        smoothness_[i] = block[0];
    }
  });
  smoothness_weight_ = shares.empty() ? weight : 0;
  return A;
}

/// (G + weight·L)·Y = −g, held as `DataTerms::held` does.
Vector TextureAligner::corrected(const TexelTerms& terms, double weight, const std::vector<float>& shares,
                                 const Progress& progress) {
  MeshFlowLevel& level = levels_.back();
  const Stopwatch building;
  constexpr double hold = 1e-3;
  const double held = hold * terms.trace / texture().area();
  BlockMatrix<double> A = weighted_smoothness(weight, shares);
  const Vector& mass = texture().lumped_mass();
  Vector b(2 * std::int64_t(texture().size()));
  parallel_for(texture().size(), [&](std::int64_t i) {
    const TexelTerms::Texel& texel = terms.texels[std::size_t(i)];
    for (int e = A.starts[std::size_t(i)]; e < A.starts[std::size_t(i) + 1]; ++e) {
      if (A.columns[std::size_t(e)] != i) continue;
      const double own = weight * smoothness_[i] + held * mass[i];
      A.blocks[std::size_t(e)] = {own + texel.xx, texel.xy, texel.xy, own + texel.yy};
    }
    b[2 * i] = -texel.x;
    b[2 * i + 1] = -texel.y;
  });
  level.build_seconds += building.seconds();
  const Stopwatch solving;
  multigrid_->set_matrix(std::move(A), progress.step("levels", 0.3));
  Vector Y = Vector::Zero(b.size());
  level.cycles += multigrid_->solve(b, Y, progress.step("solve", 0.7)).cycles;
  level.solve_seconds += solving.seconds();
  level.unknowns = int(Y.size());
  level.change.smoothness = weight * texture().vectors().smoothness_energy(Y, shares.empty() ? texture().limits() : shares);
  return Y;
}

/// ⟨g, Y⟩ and ⟨Y, G·Y⟩.
std::array<double, 2> TextureAligner::products(const TexelTerms& terms, const Vector& Y) {
  double linear = 0, quadratic = 0;
  for (std::size_t i = 0; i < terms.texels.size(); ++i) {
    const TexelTerms::Texel& texel = terms.texels[i];
    const double x = Y[2 * Eigen::Index(i)], y = Y[2 * Eigen::Index(i) + 1];
    linear += texel.x * x + texel.y * y;
    quadratic += texel.xx * x * x + 2 * texel.xy * x * y + texel.yy * y * y;
  }
  return {linear, quadratic};
}

double TextureAligner::correct(const Progress& progress, double share) {
  const Progress step = progress.step("step", share);
  Signal difference = met_.target - met_.source;
  Signal gradients = seen().vectors().gradient(
      options_.alignment == FlowAlignment::forward ? met_.target : Signal(0.5 * (met_.source + met_.target)));
  met_ = {};
  TexelTerms data = gathered(terms(difference, gradients, nullptr));
  if (!(data.trace > 0)) return 0;
  const double weight = weight_of(data);
  const bool robust = options_.robust_data > 0 || options_.robust_smoothness > 0;
  if (!(options_.robust_data > 0)) difference = gradients = {};
  const int times = robust ? std::max(1, options_.reweightings) : 1;
  std::vector<float> shares;
  Y_ = Vector::Zero(2 * std::int64_t(texture().size()));
  for (int k = 0; k < times; ++k) {
    if (options_.robust_data > 0) {
      const Vector Y = seen_ < at_ ? carried(Y_, seen_) : Y_;
      data = gathered(terms(difference, gradients, &Y));
    }
    if (k > 0 && options_.robust_smoothness > 0) {
      shares = texture().vectors().gradient_norms(Y_);
      for (std::size_t e = 0; e < shares.size(); ++e)
        shares[e] = float(texture().limits()[e] / std::sqrt(1 + std::pow(shares[e] / options_.robust_smoothness, 2)));
    }
    Y_ = corrected(data, weight, shares, step.step("solve", 1.0 / times));
  }
  const auto [linear, quadratic] = products(data, Y_);
  levels_.back().change.data = quadratic + 2 * linear;
  const double scale = quadratic > 0 ? -linear / quadratic : 0;  // α* of (4.8)
  if (scale > 0) levels_.back().scale = scale;
  return scale;
}

}  // namespace mq
