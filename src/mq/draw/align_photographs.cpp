// With a small turn ω and step τ in the camera's axes a place goes to X + ω × X + τ there. The Jacobian of
// the picture's place is taken by differences, through whatever lens there is, once per size of pictures.

#include "mq/draw/align_photographs.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "mq/base/parallel.h"
#include "mq/draw/detail/parts_that_agree.h"
#include "mq/draw/detail/usual_residual.h"
#include "mq/image/resample.h"

namespace mq {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Jacobian = Eigen::Matrix<double, 2, 6>;

/// The camera turned and moved.
PinholeCamera moved(const PinholeCamera& camera, const Vector6& motion) {
  const Vector3 turn = motion.head<3>();
  const double angle = turn.norm();
  PinholeCamera result = camera;
  if (angle > 0) {
    const Eigen::Matrix3d rotation = Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
    result.rotation = rotation * camera.rotation;
    result.translation = rotation * camera.translation;
  }
  result.translation += motion.tail<3>();
  return result;
}

/// A photograph at one size, where its places lie in it, and what they move by.
class SizedPhotograph {
 public:
  SizedPhotograph(const AlignedPhotograph& photograph, std::span<const Vector3> places, int divisor, bool to_move)
      : places_(places), photograph_(photograph) {
    const auto side = [&](int size) { return std::max(2, size / divisor); };
    if (divisor > 1)
      smaller_ = area_scaled(photograph.grey, side(photograph.grey.width()), side(photograph.grey.height()));
    if (to_move) find_jacobians();
  }

  std::size_t size() const { return photograph_.places.size(); }

  /// Brightness and its derivatives by pixels of the camera.
  struct Value {
    double value, dx, dy;
    double squared_gradient() const { return dx * dx + dy * dy; }
  };
  std::optional<Value> at(const PinholeCamera& camera, std::size_t k) const {
    const auto place = camera.project(places_[std::size_t(photograph_.places[k])]);
    if (!place) return std::nullopt;
    const Image<float>& grey = smaller_.empty() ? photograph_.grey : smaller_;
    const double across = double(grey.width()) / camera.width, down = double(grey.height()) / camera.height;
    const double x = across * place->x() - 0.5, y = down * place->y() - 0.5;
    const auto value = [&](double column, double row) {
      float v = 0;
      sample(grey, column, row, Wrap::clamp, {&v, 1});
      return double(v);
    };
    return Value{value(x, y), across * (value(x + 0.5, y) - value(x - 0.5, y)),
                 down * (value(x, y + 0.5) - value(x, y - 0.5))};
  }

  const Jacobian& jacobian(std::size_t k) const { return jacobians_[k]; }

 private:
  void find_jacobians() {
    const PinholeCamera& camera = photograph_.camera;
    jacobians_.assign(size(), Jacobian::Zero());
    parallel_for(std::ssize(jacobians_), [&](std::int64_t k) {
      const Vector3& point = places_[std::size_t(photograph_.places[std::size_t(k)])];
      const auto middle = camera.project(point);
      if (!middle) return;
      const double depth = (camera.rotation * point + camera.translation).norm();
      for (int j = 0; j < 6; ++j) {
        const double step = j < 3 ? 1e-6 : 1e-6 * depth;
        Vector6 motion = Vector6::Zero();
        motion[j] = step;
        if (const auto there = moved(camera, motion).project(point))
          jacobians_[std::size_t(k)].col(j) = (*there - *middle) / step;
      }
    });
  }

  std::span<const Vector3> places_;
  const AlignedPhotograph& photograph_;
  Image<float> smaller_;  ///< empty: at its own size
  std::vector<Jacobian> jacobians_;
};

/// a·I + b.
struct Tone {
  double a = 1, b = 0;
};

/// Reorders the values.
double middle_of(std::vector<double>& values) {
  std::nth_element(values.begin(), values.begin() + std::ssize(values) / 2, values.end());
  return values[values.size() / 2];
}

struct Means {
  std::vector<double> value, weight;
  std::vector<int> count;
  std::vector<double> squares, believed;  ///< Σ of weights times squared gradients, and of weights

  /// `Residual::detail` of a photograph at a place: its squared gradient counts up to the mean of the others', so that
  /// the outline of what is before it alone, strong as it may be, tells nothing.
  double detail(std::size_t place, double w, double squared_gradient) const {
    const double others = believed[place] - w;
    if (!(others > 0)) return 0;
    return w * std::min(squared_gradient, std::max(0.0, squares[place] - w * squared_gradient) / others);
  }
};

/// What photographs show of their places; nothing outside of them.
using Value = SizedPhotograph::Value;
using Values = std::vector<std::optional<Value>>;

std::vector<Values> values_of(std::span<const SizedPhotograph> sized, std::span<const AlignedPhotograph> photographs) {
  std::vector<Values> values(sized.size());
  parallel_for(std::ssize(sized), [&](std::int64_t v) {
    for (std::size_t k = 0; k < sized[v].size(); ++k) values[v].push_back(sized[v].at(photographs[v].camera, k));
  }, 1);
  return values;
}

/// What one photograph says of a place.
struct Said {
  double value, weight, squared_gradient;
};

/// The value that has half of the weights on each side; sorts.
double weighted_median(std::span<Said> said) {
  std::ranges::sort(said, {}, &Said::value);
  double all = 0, below = 0;
  for (const Said& one : said) all += one.weight;
  for (std::size_t k = 0; k + 1 < said.size(); ++k) {
    below += said[k].weight;
    if (below > all / 2) return said[k].value;
    if (below == all / 2) return (said[k].value + said[k + 1].value) / 2;
  }
  return said.back().value;
}

/// Robust: weights are Cauchy's, of the distance from the median of those that show the place, on the scale of what
/// they are apart. `trust`: of each photograph's places, times their weights.
Means means_of(std::span<const Values> values, std::span<const AlignedPhotograph> photographs,
               std::span<const Tone> tones, std::span<const std::vector<float>> trust, Usual usual,
               std::size_t places) {
  const std::vector<double> none(places, 0.0);
  Means means{none, none, std::vector<int>(places, 0), none, none};
  const auto for_each = [&](const auto& visit) {
    for (std::size_t v = 0; v < values.size(); ++v)
      for (std::size_t k = 0; k < values[v].size(); ++k)
        if (const auto& found = values[v][k])
          visit(std::size_t(photographs[v].places[k]),
                Said{tones[v].a * found->value + tones[v].b, double(photographs[v].weights[k]) * trust[v][k],
                     tones[v].a * tones[v].a * found->squared_gradient()});
  };
  for_each([&](std::size_t i, const Said& one) {
    ++means.count[i];
    means.squares[i] += one.weight * one.squared_gradient, means.believed[i] += one.weight;
  });
  std::vector<std::size_t> offsets(places + 1, 0);
  for (std::size_t i = 0; i < places; ++i) offsets[i + 1] = offsets[i] + std::size_t(means.count[i]);
  std::vector<Said> said(offsets.back());
  std::vector<std::size_t> next(offsets.begin(), offsets.end() - 1);
  for_each([&](std::size_t i, const Said& one) { said[next[i]++] = one; });
  const auto of = [&](std::size_t i) { return std::span(said).subspan(offsets[i], offsets[i + 1] - offsets[i]); };
  std::vector<double> medians(places, 0.0);
  std::vector<Residual> apart;
  for (std::size_t i = 0; i < places; ++i) {
    if (of(i).empty()) continue;
    medians[i] = weighted_median(of(i));
    if (of(i).size() > 2)
      for (const Said& one : of(i))
        apart.push_back({std::abs(one.value - medians[i]), means.detail(i, one.weight, one.squared_gradient)});
  }
  const double scale = apart.empty() ? 1 : std::max(1e-3, 3 * usual_residual(apart, usual));
  for (std::size_t i = 0; i < places; ++i) {
    for (const Said& one : of(i)) {
      const double w = one.weight / (1 + std::pow((one.value - medians[i]) / scale, 2));
      means.value[i] += w * one.value, means.weight[i] += w;
    }
    means.value[i] = means.weight[i] > 0 ? means.value[i] / means.weight[i] : medians[i];
  }
  return means;
}

constexpr double fewest_shared = 50;

/// The tone that gives a photograph the mean and the spread of the others, where it shares places; robust, as what is in
/// front of some of these, and as plain as they are, would shift it for all.
Tone tone_of(const Values& values, const AlignedPhotograph& photograph, std::span<const float> trust, Usual usual,
             const Means& means) {
  constexpr int rounds = 5;
  const auto for_each = [&](const auto& visit) {
    for (std::size_t k = 0; k < values.size(); ++k)
      if (const std::size_t i = std::size_t(photograph.places[k]); values[k] && means.count[i] >= 2)
        visit(i, *values[k], double(trust[k]), double(photograph.weights[k]));
  };
  double believed = 0;
  std::vector<double> shifts;
  for_each([&](std::size_t i, const Value& found, double w, double) {
    believed += w, shifts.push_back(means.value[i] - found.value);
  });
  if (believed < fewest_shared) return {};
  Tone tone{1, middle_of(shifts)};
  std::vector<Residual> residuals;
  for (int round = 0; round < rounds; ++round) {
    double n = 0, own = 0, own_squares = 0, others = 0, others_squares = 0;
    residuals.clear();
    for_each([&](std::size_t i, const Value& found, double w, double weight) {
      residuals.push_back({std::abs(tone.a * found.value + tone.b - means.value[i]),
                           means.detail(i, w * weight, found.squared_gradient())});
    });
    const double scale = std::max(1e-3, 2 * usual_residual(residuals, usual));
    for_each([&](std::size_t i, const Value& found, double w, double) {
      const double value = found.value, mean = means.value[i];
      w /= 1 + std::pow((tone.a * value + tone.b - mean) / scale, 2);
      n += w, own += w * value, own_squares += w * value * value;
      others += w * mean, others_squares += w * mean * mean;
    });
    if (!(n > 0)) return tone;
    const double spread = own_squares / n - std::pow(own / n, 2);
    const double wanted = others_squares / n - std::pow(others / n, 2);
    const double a = spread > 0 && wanted > 0 ? std::clamp(std::sqrt(wanted / spread), 0.2, 5.0) : 1;
    tone = {a, others / n - a * own / n};
  }
  return tone;
}

/// A place that a photograph shares: what it shows too much, and how that grows from pixel to pixel.
struct Row {
  std::size_t place;  ///< of the photograph's
  Eigen::RowVector2d gradient;
  double residual, weight;
};

/// Nothing where too little is shared. Weights are robust.
std::vector<Row> rows_of(const Values& values, const AlignedPhotograph& photograph, const Tone& tone,
                         std::span<const float> trust, Usual usual, const Means& means) {
  std::vector<Row> rows;
  std::vector<Residual> residuals;
  for (std::size_t k = 0; k < values.size(); ++k) {
    const std::size_t i = std::size_t(photograph.places[k]);
    const auto& found = values[k];
    if (!found || means.count[i] < 2) continue;
    rows.push_back({k, tone.a * Eigen::RowVector2d(found->dx, found->dy),
                    tone.a * found->value + tone.b - means.value[i], double(photograph.weights[k]) * trust[k]});
    if (const Row& row = rows.back(); trust[k] > 0.5F)
      residuals.push_back({std::abs(row.residual), means.detail(i, row.weight, row.gradient.squaredNorm())});
  }
  if (double(residuals.size()) < fewest_shared) return {};
  const double scale = std::max(1e-4, 2 * usual_residual(residuals, usual));
  for (Row& row : rows) row.weight /= 1 + std::pow(row.residual / scale, 2);
  return rows;
}

/// One Gauss–Newton step of a camera: of the data's terms, + λ Σ |p_k − p⁰_k|² over all places that it shows, p⁰ where
/// they were at first, so that what shares little is not turned by its blur, nor what is plain by its noise.
void move(const SizedPhotograph& sized, std::span<const Row> rows, const AlignedPhotograph& photograph,
          const PinholeCamera& before, std::span<const Vector3> places, PinholeCamera& camera) {
  constexpr double held = 0.01, plain = 3e-5;  // of what data say of a place; what noise says: squared slope per pixel
  Matrix6 A = Matrix6::Zero();
  Vector6 b = Vector6::Zero();
  double said = 0, weights = 0;
  for (const Row& row : rows) {
    const Vector6 slope = (row.gradient * sized.jacobian(row.place)).transpose();
    A += row.weight * slope * slope.transpose();
    b -= row.weight * row.residual * slope;
    said += row.weight * row.gradient.squaredNorm() / 2;
    weights += row.weight;
  }
  if (!(said > 0)) return;
  const double hold = (held + 3 * std::pow(plain * weights / said, 2)) * said / weights;
  for (std::size_t k = 0; k < sized.size(); ++k) {
    const Vector3& place = places[std::size_t(photograph.places[k])];
    const auto from = before.project(place), now = camera.project(place);
    if (!from || !now) continue;
    const double weight = photograph.weights[k] * hold;
    A += weight * sized.jacobian(k).transpose() * sized.jacobian(k);
    b -= weight * sized.jacobian(k).transpose() * (*now - *from);
  }
  A.diagonal() *= 1 + 1e-4;  // motions that nothing shows stay 0
  A.diagonal().array() += 1e-12 * A.diagonal().maxCoeff();
  const Vector6 step = A.ldlt().solve(b);
  if (step.allFinite()) camera = moved(camera, step);
}

/// Takes back what all cameras have moved by as one, against the surface: the small motion ω × X + τ of the model that
/// brings places nearest, in pixels, to where they were. Photographs tell nothing of it, but rounding and blur would let
/// it grow.
void undo_common_motion(std::span<const SizedPhotograph> sized, std::span<const PinholeCamera> before,
                        std::span<const Vector3> places, std::vector<AlignedPhotograph>& photographs) {
  Matrix6 A = Matrix6::Zero();
  Vector6 b = Vector6::Zero();
  std::vector<Matrix6> to_camera;  // motions of the model as those of each camera's axes
  for (std::size_t v = 0; v < photographs.size(); ++v) {
    const PinholeCamera& camera = photographs[v].camera;
    Matrix6& turned = to_camera.emplace_back(Matrix6::Zero());
    if (camera.rotation == before[v].rotation && camera.translation == before[v].translation) continue;  // it stays
    turned.topLeftCorner<3, 3>() = turned.bottomRightCorner<3, 3>() = camera.rotation;
    for (int j = 0; j < 3; ++j)
      turned.block<3, 1>(3, j) = camera.translation.cross(Vector3(camera.rotation.col(j)));
    for (std::size_t k = 0; k < sized[v].size(); ++k) {
      const Vector3& place = places[std::size_t(photographs[v].places[k])];
      const auto from = before[v].project(place), to = camera.project(place);
      if (!from || !to) continue;
      const Jacobian J = sized[v].jacobian(k) * turned;
      A += J.transpose() * J;
      b += J.transpose() * (*from - *to);
    }
  }
  A.diagonal() *= 1 + 1e-9;
  A.diagonal().array() += 1e-12 * A.diagonal().maxCoeff();
  const Vector6 motion = A.ldlt().solve(b);
  if (!motion.allFinite()) return;
  for (std::size_t v = 0; v < photographs.size(); ++v)
    photographs[v].camera = moved(photographs[v].camera, to_camera[v] * motion);
}

/// One of its correction: of all f with the data's terms, + μ Σ |f_i − f_j|² over neighbours of the lattice
/// + ν Σ |f_i|².
void bend(std::span<const Vector3> places, const AlignedPhotograph& photograph, std::span<const Row> rows,
          PinholeCamera& camera) {
  if (rows.empty()) return;
  constexpr double stiff = 0.2, held = 1e-3;  // times the mean of what data say of a point
  Correction& correction = camera.correction;
  const int points = correction.columns * correction.rows;
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd b = Eigen::VectorXd::Zero(2 * points);
  double said = 0;
  for (const Row& row : rows) {
    const auto place = camera.uncorrected(places[std::size_t(photograph.places[row.place])]);
    const Correction::Corners corners = correction.around(place->x() / camera.width, place->y() / camera.height);
    const Eigen::RowVector2d slope = camera.width * row.gradient;
    said += row.weight * slope.squaredNorm();
    for (std::size_t i = 0; i < 4; ++i)
      for (int c = 0; c < 2; ++c) {
        const double left = row.weight * corners.weights[i] * slope[c];
        b[2 * corners.points[i] + c] -= left * row.residual;
        for (std::size_t j = 0; j < 4; ++j)
          for (int d = 0; d < 2; ++d)
            entries.emplace_back(2 * corners.points[i] + c, 2 * corners.points[j] + d,
                                 left * corners.weights[j] * slope[d]);
      }
  }
  const double mean = said / (2 * points);
  const auto tie = [&](int i, int j, double weight) {  // j = −1: to 0
    for (int c = 0; c < 2; ++c) {
      const double apart = correction.offsets[std::size_t(i)][c] - (j < 0 ? 0 : correction.offsets[std::size_t(j)][c]);
      entries.emplace_back(2 * i + c, 2 * i + c, weight);
      b[2 * i + c] -= weight * apart;
      if (j < 0) continue;
      entries.emplace_back(2 * j + c, 2 * j + c, weight);
      entries.emplace_back(2 * i + c, 2 * j + c, -weight);
      entries.emplace_back(2 * j + c, 2 * i + c, -weight);
      b[2 * j + c] += weight * apart;
    }
  };
  for (int i = 0; i < points; ++i) {
    tie(i, -1, held * mean);
    if (i % correction.columns + 1 < correction.columns) tie(i, i + 1, stiff * mean);
    if (i + correction.columns < points) tie(i, i + correction.columns, stiff * mean);
  }
  Eigen::SparseMatrix<double> A(2 * points, 2 * points);
  A.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors(A);
  const Eigen::VectorXd step = factors.solve(b);
  if (factors.info() != Eigen::Success || !step.allFinite()) return;
  for (int i = 0; i < points; ++i) correction.offsets[std::size_t(i)] += step.segment<2>(2 * i);
}

/// Of a photograph's places, how far they are to be believed: by the parts of the picture that they lie in.
std::vector<float> trust_in(const Values& values, const AlignedPhotograph& photograph, const Tone& tone,
                            std::span<const int> cells, const Correction& lattice, const Means& means) {
  constexpr double noise = 0.02;  // of brightness
  std::vector<Compared> compared;
  for (std::size_t k = 0; k < values.size(); ++k) {
    const std::size_t i = std::size_t(photograph.places[k]);
    if (const auto& found = values[k]; found && means.count[i] >= 2)
      compared.push_back({cells[k], tone.a * found->value + tone.b, means.value[i], photograph.weights[k]});
  }
  const std::vector<float> of_cells = parts_that_agree(compared, lattice.columns - 1, lattice.rows - 1, noise);
  std::vector<float> result(values.size());
  for (std::size_t k = 0; k < result.size(); ++k) result[k] = of_cells[std::size_t(cells[k])];
  return result;
}

/// A lattice of square cells, so many along the longer side.
Correction no_correction(const PinholeCamera& camera, int cells) {
  const double cell = double(std::max(camera.width, camera.height)) / cells;
  Correction correction;
  correction.columns = std::max(2, int(std::lround(camera.width / cell)) + 1);
  correction.rows = std::max(2, int(std::lround(camera.height / cell)) + 1);
  correction.offsets.assign(std::size_t(correction.columns) * std::size_t(correction.rows), Vector2::Zero());
  return correction;
}

/// The cells of a lattice that places lie in.
std::vector<int> cells_of(const AlignedPhotograph& photograph, const Correction& lattice,
                          std::span<const Vector3> places) {
  std::vector<int> cells;
  for (const int i : photograph.places) {
    const auto place = photograph.camera.project(places[std::size_t(i)]);
    const auto at = [&](double part, int points) { return std::clamp(int(part * (points - 1)), 0, points - 2); };
    cells.push_back(!place ? 0
                           : at(place->y() / photograph.camera.height, lattice.rows) * (lattice.columns - 1) +
                                 at(place->x() / photograph.camera.width, lattice.columns));
  }
  return cells;
}

/// What lies behind a passer-by is bent as what is around, and says nothing of the camera.
double moved_by(const AlignedPhotograph& photograph, const PinholeCamera& before, std::span<const float> trust,
                std::span<const Vector3> places) {
  double sum = 0, all = 0;
  for (std::size_t k = 0; k < photograph.places.size(); ++k) {
    const Vector3& place = places[std::size_t(photograph.places[k])];
    const auto from = before.project(place), to = photograph.camera.project(place);
    if (from && to) sum += trust[k] * (*to - *from).squaredNorm(), all += trust[k];
  }
  return all > 0 ? std::sqrt(sum / all) : 0;
}

}  // namespace

void align_photographs(std::span<const Vector3> places, std::vector<AlignedPhotograph>& photographs,
                       const Progress& progress) {
  struct Stage {
    int divisor;  ///< of the pictures' size
    bool bends;   ///< or moves
    int rounds;
  };
  constexpr std::array<Stage, 5> stages = {
      {{4, false, 20}, {2, false, 20}, {1, false, 20}, {2, true, 10}, {1, true, 10}}};
  constexpr int rounds_of_trust = 5, cells = 24;
  std::vector<PinholeCamera> before;
  std::vector<Correction> lattices;
  std::vector<std::vector<int>> parts;
  std::vector<std::vector<float>> trust;
  for (const AlignedPhotograph& photograph : photographs) {
    before.push_back(photograph.camera);
    lattices.push_back(no_correction(photograph.camera, cells));
    parts.push_back(cells_of(photograph, lattices.back(), places));
    trust.emplace_back(photograph.places.size(), 1.0F);
  }
  std::vector<Tone> tones(photographs.size());
  for (std::size_t stage = 0; stage < stages.size(); ++stage) {
    const auto [divisor, bends, rounds] = stages[stage];
    const Usual usual = bends ? Usual::everywhere : Usual::at_detail;
    std::vector<SizedPhotograph> sized;
    for (const AlignedPhotograph& photograph : photographs) sized.emplace_back(photograph, places, divisor, !bends);
    {  // Brightness by what is to be believed, which does not depend on it: a passer-by would shift it everywhere.
      const std::vector<Values> values = values_of(sized, photographs);
      const std::vector<Tone> none(photographs.size());
      const Means first = means_of(values, photographs, none, trust, usual, places.size());
      parallel_for(std::ssize(photographs), [&](std::int64_t v) {
        trust[std::size_t(v)] = trust_in(values[v], photographs[v], none[v], parts[v], lattices[v], first);
      }, 1);
      const Means plain = means_of(values, photographs, none, trust, usual, places.size());
      for (std::size_t v = 0; v < sized.size(); ++v)
        tones[v] = tone_of(values[v], photographs[v], trust[v], usual, plain);
    }
    for (int round = 0; round < rounds; ++round) {
      const std::vector<Values> values = values_of(sized, photographs);
      const Means means = means_of(values, photographs, tones, trust, usual, places.size());
      parallel_for(std::ssize(photographs), [&](std::int64_t v) {
        AlignedPhotograph& one = photographs[v];
        if (round % rounds_of_trust == 0)
          trust[std::size_t(v)] = trust_in(values[v], one, tones[v], parts[v], lattices[v], means);
        const std::vector<Row> rows = rows_of(values[v], one, tones[v], trust[v], usual, means);
        if (rows.empty()) return;
        if (bends && one.camera.correction.empty()) one.camera.correction = lattices[v];
        if (bends)
          bend(places, one, rows, one.camera);
        else
          move(sized[v], rows, one, before[v], places, one.camera);
      }, 1);
      progress.at((double(stage) + double(round + 1) / rounds) / double(stages.size()));
    }
    if (!bends) undo_common_motion(sized, before, places, photographs);
  }
  for (std::size_t v = 0; v < photographs.size(); ++v)
    photographs[v].moved = moved_by(photographs[v], before[v], trust[v], places);
}

}  // namespace mq
