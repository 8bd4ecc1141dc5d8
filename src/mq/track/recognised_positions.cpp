#include "mq/track/recognised_positions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "mq/base/parallel.h"
#include "mq/mesh/geometry.h"
#include "mq/track/detail/shares.h"
#include "mq/track/path_lengths.h"
#include "mq/track/recognised_points.h"

namespace mq {
namespace {

/// Vertices that pull, beside those of nodes, and points of the target that they are looked for among.
constexpr int pulled_vertices = 500, target_points = 2500;
/// Ways to match extremities that are tried: at most so many, whose score is this part of the best, at least.
constexpr int most_ways = 6;
constexpr double least_score = 0.93;
/// How many of them are given back.
constexpr int most_tried = 2;
/// Steps of Gauss and Newton, and after how many lengths are found again.
constexpr int recognition_steps = 14, steps_between_lengths = 4;
/// From the first to the last step: what moves and normals count (p and n), and the stiffness.
constexpr std::array move_weights = {0.01, 1.0}, normal_weights = {0.1, 4.0}, stiffnesses = {2.0, 0.05};
/// More than this difference of lengths, in spacings, is none of the same point: a path that was not there.
constexpr double most_length_difference = 4;
/// Widths of Welsch's weights, in medians, and the least, in spacings: of differences of lengths, and of moves.
constexpr double difference_widths = 2, least_difference_width = 0.5;
constexpr double move_widths = 4, least_move_width = 1;
/// Of distances that tell ways apart, in spacings.
constexpr double most_distance = 4;

double between(const std::array<double, 2>& ends, double part) {
  return ends[0] * std::pow(ends[1] / ends[0], part);
}

/// Points spread over a mesh, about so many, by area: centres of equal parts of triangles.
std::vector<SurfacePoint> spread_points(const Mesh& mesh, int count) {
  const std::vector<double> areas = triangle_areas(mesh);
  double total = 0, sum = 0;
  for (const double area : areas) total += area;
  std::vector<SurfacePoint> points;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const double before = std::floor(sum / total * count);
    sum += areas[t];
    const double due = std::floor(sum / total * count) - before;
    if (due < 1) continue;
    const int n = int(std::ceil(std::sqrt(due)));
    const auto add = [&](double a, double b) { points.push_back({t, Vector3(a, b, n - a - b) / n}); };
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) {
        add(i + 1.0 / 3, j + 1.0 / 3);
        if (i + j + 1 < n) add(i + 2.0 / 3, j + 2.0 / 3);
      }
  }
  return points;
}

/// Vertices of nodes and some of the others.
std::vector<int> pulled(const DeformationGraph& graph, int vertex_count) {
  std::vector<int> vertices;
  for (int i = 0; i < graph.node_count(); ++i) vertices.push_back(graph.vertex_of(i));
  const int stride = std::max(1, vertex_count / pulled_vertices);
  for (int v = 0; v < vertex_count; v += stride) vertices.push_back(v);
  std::ranges::sort(vertices);
  const auto repeated = std::ranges::unique(vertices);
  vertices.erase(repeated.begin(), repeated.end());
  return vertices;
}

/// Tries one way after the other.
class Recogniser {
 public:
  Recogniser(DeformationGraph& graph, const Mesh& rest, std::span<const Vector3> current,
             const TrackTarget& target, const RecognitionOptions& options)
      : graph_(graph),
        rest_(rest),
        current_(current),
        options_(options),
        other_(target.surface().mesh),
        mesh_(rest),
        turned_(graph.fitted(rest.positions, current)),
        vertices_(pulled(graph, int(current.size()))),
        points_(spread_points(other_, target_points)) {
    mesh_.positions.assign(current.begin(), current.end());
    mine_ = extremities(mesh_);
    theirs_ = extremities(other_);
    for (const SurfacePoint& p : points_) {
      there_.push_back(point_at(other_, p));
      normals_there_.push_back(value_at(other_, target.normals(), p).normalized());
    }
    const std::vector<double> shares = area_shares(mesh_);
    double sum = 0;
    for (const int v : vertices_) sum += shares[v];
    for (const int v : vertices_) masses_.push_back(shares[v] / sum);
  }

  std::vector<MatchedExtremities> ways(std::span<const Vector3> begin, double diagonal) const {
    std::vector<std::vector<double>> moves;
    for (const int a : mine_.vertices) {
      moves.emplace_back();
      for (const int b : theirs_.vertices)
        moves.back().push_back((begin[a] - other_.positions[b]).norm() / diagonal);
    }
    std::vector<MatchedExtremities> found = matched_extremities(mine_, theirs_, moves, most_ways);
    while (!found.empty() && found.back().score < least_score * found.front().score) found.pop_back();
    return found;
  }

  struct Found {
    std::vector<Vector3> positions;
    double distance = 0;  ///< of these from where they belong, mean, in spacings
  };
  Found operator()(const MatchedExtremities& way, const Progress& progress);

 private:
  /// Per point a row of lengths to extremities, in spacings.
  using Rows = std::vector<double>;
  struct Place {
    int point = 0;
    double difference = 0, move = 0;
  };

  void put_lengths(const MatchedExtremities& way, const Extremities& mine);
  std::vector<Place> places(double part, std::size_t extremity_count) const;
  std::vector<PointConstraint> pulls(const std::vector<Place>& places, double part) const;

  DeformationGraph& graph_;
  const Mesh& rest_;
  std::span<const Vector3> current_;
  const RecognitionOptions& options_;
  const Mesh& other_;
  Mesh mesh_;  ///< where it is at the moment
  std::vector<NodeMotion> turned_;
  std::vector<int> vertices_;
  std::vector<SurfacePoint> points_;
  std::vector<Vector3> there_, normals_there_;
  std::vector<double> masses_;
  Extremities mine_, theirs_;
  Rows lengths_here_, lengths_there_;
};

/// Those of the surface are scaled, so that at the extremities they are what they are on the target: near
/// one as there, elsewhere by the mean, weighted by inverse squares of lengths. A leg that is stretched is
/// longer by a tenth.
void Recogniser::put_lengths(const MatchedExtremities& way, const Extremities& mine) {
  const std::size_t count = way.pairs.size();
  const double spacing = options_.spacing;
  std::vector<double> ratios(count * count);
  for (std::size_t k = 0; k < count; ++k)
    for (std::size_t j = 0; j < count; ++j) {
      const auto [a, b] = way.pairs[k];
      const auto [c, d] = way.pairs[j];
      ratios[k * count + j] = a == c ? theirs_.means[b] / mine_.means[a]
                                     : theirs_.lengths[b][theirs_.vertices[d]] /
                                           mine.lengths[a][mine.vertices[c]];
    }
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    std::vector<double> weights(count);
    for (std::size_t j = 0; j < count; ++j) {
      const double length = mine.lengths[way.pairs[j][0]][vertices_[i]] / spacing;
      weights[j] = 1 / (length * length + 1e-3);
    }
    for (std::size_t k = 0; k < count; ++k) {
      double sum = 0, weight = 0;
      for (std::size_t j = 0; j < count; ++j) {
        if (!std::isfinite(ratios[k * count + j])) continue;  // on parts that do not touch
        sum += weights[j] * ratios[k * count + j];
        weight += weights[j];
      }
      const double scale = weight > 0 ? sum / weight : 1;
      lengths_here_[i * count + k] = scale * mine.lengths[way.pairs[k][0]][vertices_[i]] / spacing;
    }
  }
  for (std::size_t j = 0; j < points_.size(); ++j)
    for (std::size_t k = 0; k < count; ++k)
      lengths_there_[j * count + k] =
          value_at(other_, theirs_.lengths[way.pairs[k][1]], points_[j]) / spacing;
}

std::vector<Recogniser::Place> Recogniser::places(double part, std::size_t extremity_count) const {
  const std::vector<Vector3> normals = vertex_normals(mesh_);
  const double of_move = between(move_weights, part), of_normal = between(normal_weights, part);
  const double most = most_length_difference * most_length_difference;
  std::vector<Place> found(vertices_.size());
  parallel_for(
      std::ssize(found),
      [&](std::int64_t i) {
        const Vector3 &x = mesh_.positions[vertices_[i]], &n = normals[vertices_[i]];
        const double* here = &lengths_here_[i * extremity_count];
        double least = std::numeric_limits<double>::infinity();
        for (std::size_t j = 0; j < there_.size(); ++j) {
          const double move = (there_[j] - x).squaredNorm() / (options_.spacing * options_.spacing);
          const double cost = of_move * move + of_normal * (1 - n.dot(normals_there_[j]));
          if (!(cost < least)) continue;
          const double* there = &lengths_there_[j * extremity_count];
          double sum = 0;
          for (std::size_t k = 0; k < extremity_count; ++k) {
            const double difference = here[k] - there[k];
            sum += difference * difference < most ? difference * difference : most;
          }
          sum /= double(extremity_count);
          if (!(cost + sum < least)) continue;
          least = cost + sum;
          found[i] = {int(j), std::sqrt(sum), std::sqrt(move)};
        }
      },
      16);
  return found;
}

std::vector<PointConstraint> Recogniser::pulls(const std::vector<Place>& places, double part) const {
  std::vector<double> differences, moves;
  for (const Place& p : places) {
    differences.push_back(p.difference);
    moves.push_back(p.move);
  }
  const double width = std::max(difference_widths * median(std::move(differences)), least_difference_width);
  const double move_width = std::max(move_widths * median(std::move(moves)), least_move_width);
  std::vector<PointConstraint> constraints(current_.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Place& p = places[i];
    // What has far to go at first is what all this is for.
    const double too_far = part > 0.5 ? p.move / move_width : 0, unlike = p.difference / width;
    const double weight = masses_[i] * std::exp(-(unlike * unlike + too_far * too_far) / 2);
    constraints[vertices_[i]].add(weight * Eigen::Matrix3d::Identity(),
                                  there_[p.point] - mesh_.positions[vertices_[i]]);
  }
  return constraints;
}

Recogniser::Found Recogniser::operator()(const MatchedExtremities& way, const Progress& progress) {
  const std::size_t count = way.pairs.size();
  lengths_here_.assign(count * vertices_.size(), 0);
  lengths_there_.assign(count * points_.size(), 0);
  put_lengths(way, mine_);
  std::vector<NodeMotion> motions(std::size_t(graph_.node_count()));
  for (int step = 0;; ++step) {
    progress.at(double(step) / recognition_steps);
    const double part = double(step) / recognition_steps;
    mesh_.positions = graph_.deformed(current_, motions);
    if (step > 0 && step < recognition_steps && step % steps_between_lengths == 0) {
      Extremities now = mine_;
      now.lengths = PathLengths(mesh_)(now.vertices);
      put_lengths(way, now);
    }
    const std::vector<Place> at = places(part, count);
    if (step == recognition_steps) {
      Found found{mesh_.positions};
      for (std::size_t i = 0; i < at.size(); ++i)
        found.distance += masses_[i] * std::min(at[i].move, most_distance);
      return found;
    }
    graph_.gauss_newton_step(current_, pulls(at, part), rest_.positions, turned_,
                             {between(stiffnesses, part), options_.elasticity}, motions);
  }
}

}  // namespace

std::vector<std::vector<Vector3>> recognised_positions(DeformationGraph& graph, const Mesh& rest,
                                                       std::span<const Vector3> current,
                                                       std::span<const Vector3> begin,
                                                       const TrackTarget& target,
                                                       const RecognitionOptions& options,
                                                       const Progress& progress) {
  Recogniser recogniser(graph, rest, current, target, options);
  const std::vector<MatchedExtremities> ways = recogniser.ways(begin, target.diagonal());
  std::vector<Recogniser::Found> all;
  for (const MatchedExtremities& way : ways)
    all.push_back(recogniser(way, progress.step("way", 1 / double(ways.size()))));
  std::ranges::stable_sort(all, {}, &Recogniser::Found::distance);
  std::vector<std::vector<Vector3>> positions;
  for (Recogniser::Found& found : all)
    if (std::ssize(positions) < most_tried) positions.push_back(std::move(found.positions));
  return positions;
}

}  // namespace mq
