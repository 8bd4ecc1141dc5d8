#pragma once
/// Models and their systems, which solvers are measured on.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mq/base/random.h"
#include "mq/fem/multigrid_solver.h"
#include "mq/fem/texel_space.h"
#include "mq/io/model.h"
#include "mq/linear/connected_components.h"
#include "mq/linear/direct.h"
#include "mq/linear/residual.h"
#include "mq/sample/sample.h"

namespace mq::bench {

/// A model with its texels. Does not move: the space refers to the rest.
struct Case {
  std::string name;
  Surface surface;
  Atlas atlas;
  std::unique_ptr<TexelSpace> space;
};

inline bool is_sample(const std::string& name) {
  const auto& all = sample_names();
  return std::any_of(all.begin(), all.end(), [&](const SampleInfo& s) { return s.name == name; });
}

inline Atlas sample_atlas(const std::string& name, int size, Surface& surface) {
  const Sample sample = make_sample(name, {.texture_size = size});
  surface = make_surface(sample.mesh);
  return make_atlas(surface, {sample.texture});
}

/// The textures' own sizes; 1024² where there is no picture.
inline std::vector<TextureSize> sizes_of(const Model& model) {
  std::vector<TextureSize> sizes(std::max<std::size_t>(1, model.textures.size()), {1024, 1024});
  for (int t = 0; t < model.mesh.triangle_count(); ++t)
    sizes.resize(std::max(sizes.size(), std::size_t(model.mesh.texture(t) + 1)), {1024, 1024});
  for (std::size_t i = 0; i < model.textures.size(); ++i)
    if (const Image<float>& pixels = model.textures[i].pixels; !pixels.empty())
      sizes[i] = {pixels.width(), pixels.height(), model.textures[i].wrap};
  return sizes;
}

/// A sample at a size of texture, or a file with its textures scaled.
class Source {
 public:
  explicit Source(const std::string& name) : name_(name) {
    if (is_sample(name)) return;
    model_ = read_model(name);
    sizes_ = sizes_of(*model_);
  }

  std::unique_ptr<Case> at(double scale) const {
    auto c = std::make_unique<Case>();
    if (model_) {
      c->name = std::filesystem::path(name_).stem().string();
      c->surface = make_surface(model_->mesh);
      std::vector<TextureSize> sizes = sizes_;
      for (TextureSize& size : sizes) {
        size.width = std::max(1, int(std::lround(size.width * scale)));
        size.height = std::max(1, int(std::lround(size.height * scale)));
      }
      c->atlas = make_atlas(c->surface, sizes);
    } else {
      c->name = name_;
      c->atlas = sample_atlas(name_, int(std::lround(1024 * scale)), c->surface);
    }
    return c;
  }

 private:
  std::string name_;
  std::optional<Model> model_;
  std::vector<TextureSize> sizes_;
};

/// With about so many texels; 0: at its own size.
inline std::unique_ptr<Case> make_case(const std::string& name, double texels) {
  const Source source(name);
  double scale = 1;
  std::unique_ptr<Case> c = source.at(scale);
  if (texels > 0) {
    scale *= std::sqrt(texels / c->atlas.texel_area);
    c = source.at(scale);
  }
  c->space = std::make_unique<TexelSpace>(c->surface, c->atlas);
  // Texels at the borders of charts count too: many, where charts are small.
  for (int round = 0; round < 3 && texels > 0; ++round) {
    const double ratio = texels / c->space->size();
    if (std::abs(ratio - 1) < 0.03) break;
    scale *= std::sqrt(ratio);
    c = source.at(scale);
    c->space = std::make_unique<TexelSpace>(c->surface, c->atlas);
  }
  return c;
}

/// How charts distort the surface, with σ₁ and σ₂ the singular values of the maps of triangles into the texture, the
/// model scaled so that both areas are equal (thesis 5.8.4): the values that 99 of 100 texels stay below.
struct Distortion {
  double stretch = 1;    ///< σ₁ / σ₂, at least 1
  double authalic = 0;   ///< ½ log²(σ₁·σ₂)
  double conformal = 0;  ///< ½ log²(σ₁ / σ₂)
};

/// The least of the values that so many of the texels, by area, stay at or below.
inline double weighted_percentile(std::vector<std::pair<double, double>> values, double share) {
  std::ranges::sort(values);
  double all = 0, sum = 0;
  for (const auto& [value, area] : values) all += area;
  for (const auto& [value, area] : values)
    if ((sum += area) >= share * all) return value;
  return 0;
}

inline Distortion distortion_of_most(const Case& c) {
  std::vector<std::pair<double, double>> stretch, authalic;  // and the texels that have it
  double texels = 0, surface = 0;
  for (int t = 0; t < c.surface.mesh.triangle_count(); ++t) {
    if (c.atlas.chart[t] < 0) continue;
    const auto& p = c.atlas.corners[t];
    const double x1 = p[1].column() - p[0].column(), y1 = p[1].row() - p[0].row();
    const double x2 = p[2].column() - p[0].column(), y2 = p[2].row() - p[0].row();
    const double area = std::abs(x1 * y2 - x2 * y1) / 2;
    if (!(area > 0)) continue;
    const TexelMetric metric = texel_metric(c.surface, c.atlas, t);
    stretch.emplace_back(metric.stretch, area);
    authalic.emplace_back(metric.density, area);
    texels += area;
    surface += area * metric.density;
  }
  for (auto& [density, area] : authalic) {
    const double scaled = std::log(density * texels / surface);
    density = scaled * scaled / 2;
  }
  Distortion most;
  most.stretch = weighted_percentile(std::move(stretch), 0.99);
  most.authalic = weighted_percentile(std::move(authalic), 0.99);
  most.conformal = std::log(most.stretch) * std::log(most.stretch) / 2;  // it grows with the stretch
  return most;
}

/// (M + alpha·area·S)·X = M·ψ with ψ random in [0, 1), or S·X = S·ψ where alpha is infinite.
struct System {
  SparseMatrix A;
  Signal B;
  std::vector<int> component;  ///< per texel, where A·1 = 0
};

inline System make_system(const TexelSpace& space, double alpha) {
  const Random random(1);
  Signal psi(space.size(), 3);
  for (Eigen::Index i = 0; i < psi.size(); ++i) psi.data()[i] = random.uniform(std::uint64_t(i));
  System s;
  if (std::isinf(alpha)) {
    s.A = space.regularised_system(0, 1);
    multiply(s.A, psi, s.B);
    s.component = connected_components(s.A);
  } else {
    SparseMatrix A = space.regularised_system(1, alpha * space.scale().area);
    s.A.swap(A);  // Eigen's matrices are copied, not moved
    multiply(space.mass(), psi, s.B);
  }
  return s;
}

/// What may be factored: constants are held at one texel of each component.
inline SparseMatrix definite(const System& system) {
  SparseMatrix A = system.A;
  std::vector<char> held(system.component.size(), 0);
  for (int k = 0; k < int(system.component.size()); ++k)
    if (!std::exchange(held[system.component[k]], 1)) A.coeffRef(k, k) *= 2;
  return A;
}

/// X less its mean on each component, where constants do not count.
inline Signal without_constants(const System& system, Signal X) {
  if (system.component.empty()) return X;
  const Signal sum = component_sums(system.component, X);
  const Signal size = component_sums(system.component, Signal::Ones(X.rows(), 1));
  for (Eigen::Index k = 0; k < X.rows(); ++k) {
    const int c = system.component[k];
    X.row(k) -= sum.row(c) / size(c, 0);
  }
  return X;
}

/// X with A·X = B to rounding: by `direct`, made or given these values, or by ours to 1e-12.
inline Signal direct_solution(const System& system, std::unique_ptr<DirectSolver>& direct) {
  const SparseMatrix A = definite(system);
  if (direct)
    direct->refactor(A);
  else
    direct = std::make_unique<DirectSolver>(A);
  Signal X = direct->solve(system.B);
  X += direct->solve(residual(system.A, X, system.B));
  return without_constants(system, std::move(X));
}

inline Signal our_solution(const Case& c, const System& system) {
  Signal X = Signal::Zero(system.B.rows(), system.B.cols());
  multigrid_solver(c.space->texels(), {.tolerance = 1e-12, .max_cycles = 200})(system.A, {})
      ->solve(system.B, X);
  return without_constants(system, std::move(X));
}

}  // namespace mq::bench
