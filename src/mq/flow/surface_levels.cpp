#include "mq/flow/surface_levels.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/Geometry>

#include "mq/base/parallel.h"
#include "mq/fem/tangent_fields.h"
#include "mq/flow/detail/transfer_weights.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/norm.h"

namespace mq {

namespace {

constexpr double worth_it = 0.7;  // a mesh with this share of the vertices is another level

BlockTransfer transfer_between(const FlowMesh& fine, const FlowMesh& coarse,
                               const CoarsenedSurface& coarsened) {
  const int rows = fine.vertex_count();
  BlockTransfer P;
  P.columns = coarse.vertex_count();
  P.starts.assign(rows + 1, 0);
  const auto count = [&](int i) {
    const ClosestPoint& place = coarsened.places[i];
    return place.triangle < 0 ? 0 : int((place.barycentric.array() > 0).count());
  };
  for (int i = 0; i < rows; ++i) P.starts[i + 1] = P.starts[i] + count(i);
  P.entries.resize(P.starts[rows]);
  parallel_for(rows, [&](std::int64_t i) {
    const ClosestPoint& place = coarsened.places[i];
    int at = P.starts[i];
    const Vector3 &n = fine.normal(int(i)), &axis = fine.axis(int(i));
    for (int k = 0; k < 3 && place.triangle >= 0; ++k) {
      const double weight = place.barycentric[k];
      if (!(weight > 0)) continue;
      const int j = coarse.surface().mesh.triangles[place.triangle][k];
      const Vector3 first = carried(coarse.axis(j), coarse.normal(j), n);
      const double x = first.dot(axis), y = first.dot(n.cross(axis)), length = std::hypot(x, y);
      const double c = length > 0 ? weight / length : 0;
      P.entries[at++] = {j, float(c * x), float(c * y)};
    }
  });
  P.finish();
  return P;
}

/// Per vertex twice the diagonal of the box around what it is connected to.
std::vector<double> reaches(const Mesh& mesh) {
  std::vector<int> parent(mesh.positions.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const Triangle& t : mesh.triangles)
    for (const int k : {1, 2}) {
      const int a = root(t[0]), b = root(t[k]);
      parent[std::max(a, b)] = std::min(a, b);
    }
  std::vector<Eigen::AlignedBox3d> boxes(parent.size());
  for (int v = 0; v < mesh.vertex_count(); ++v) boxes[root(v)].extend(mesh.positions[v]);
  std::vector<double> result(parent.size());
  for (int v = 0; v < mesh.vertex_count(); ++v) result[v] = 2 * boxes[root(v)].diagonal().norm();
  return result;
}

}  // namespace

FlowMesh::FlowMesh(const Surface& surface, const Progress& progress)
    : surface_(surface),
      space_(surface),
      trace_(surface),
      frames_(vertex_frames(surface, space_.shapes())),
      reach_(reaches(surface.mesh)) {
  const Mesh& mesh = surface.mesh;
  const std::vector<FlatTriangle>& shapes = space_.shapes();
  const int vertices = vertex_count(), triangles = surface.triangle_count();
  progress.at(0.5);

  edge_turns_.resize(3 * std::size_t(triangles));
  turns_.resize(3 * std::size_t(triangles));
  edge_weights_.assign(3 * std::size_t(triangles), 0.0);
  parallel_for(3 * std::int64_t(triangles), [&](std::int64_t h) {
    if (shapes[h / 3].empty()) return;
    turns_[h] = {std::cos(frames_.into_triangle[h]), std::sin(frames_.into_triangle[h])};
    edge_turns_[h] = {std::cos(frames_.along(HalfEdge(h))), std::sin(frames_.along(HalfEdge(h)))};
    const double here = shapes[h / 3].half_cotangent((h % 3 + 2) % 3);
    const HalfEdge twin = surface.twins[h];
    const bool inner = twin >= 0 && !shapes[twin / 3].empty();
    edge_weights_[h] =
        inner ? std::max(0.0, (here + shapes[twin / 3].half_cotangent((twin % 3 + 2) % 3)) / 2)
              : std::max(0.0, here);
  });

  mass_ = Vector::Zero(vertices);
  normals_.assign(vertices, Vector3::Zero());
  axes_.assign(vertices, Vector3::Zero());
  const std::vector<Vector3> normals = vertex_normals(mesh);
  parallel_for(vertices, [&](std::int64_t v) {
    for (const int* c = space_.corners_begin(int(v)); c != space_.corners_end(int(v)); ++c) {
      mass_[v] += shapes[*c / 3].area() / 3;
      if (frames_.at_source[*c] != 0) continue;
      const Vector3 edge = mesh.position(*c / 3, (*c % 3 + 1) % 3) - mesh.positions[v];
      normals_[v] = normals[v];
      axes_[v] = safe_unit(Vector3(edge - normals[v].dot(edge) * normals[v]));
    }
  });
  const int used = int(std::count_if(normals_.begin(), normals_.end(),
                                     [](const Vector3& n) { return !n.isZero(0); }));
  spacing_ = std::sqrt(2 / std::sqrt(3.0) * area() / std::max(1, used));
  progress.at(1);
}

Vector FlowMesh::triangle_field(const Vector& z) const {
  const Mesh& mesh = surface_.mesh;
  Vector X = Vector::Zero(2 * std::int64_t(mesh.triangle_count()));
  parallel_for(mesh.triangle_count(), [&](std::int64_t t) {
    if (space_.shapes()[t].empty()) return;
    double x = 0, y = 0;
    for (int k = 0; k < 3; ++k) {
      const auto [c, s] = turns_[3 * t + k];
      const double p = z[2 * mesh.triangles[t][k]], q = z[2 * mesh.triangles[t][k] + 1];
      x += c * p - s * q;
      y += s * p + c * q;
    }
    X[2 * t] = x / 3;
    X[2 * t + 1] = y / 3;
  });
  return X;
}

Vector FlowMesh::vertex_field(const Vector& X) const {
  Vector z = Vector::Zero(2 * std::int64_t(vertex_count()));
  parallel_for(vertex_count(), [&](std::int64_t v) {
    double x = 0, y = 0, area = 0;
    for (const int* corner = space_.corners_begin(int(v)); corner != space_.corners_end(int(v)); ++corner) {
      const int t = *corner / 3;
      const auto [c, s] = turns_[*corner];
      const double a = space_.shapes()[t].area(), p = X[2 * t], q = X[2 * t + 1];
      x += a * (c * p + s * q);
      y += a * (c * q - s * p);
      area += a;
    }
    if (area > 0) z.segment<2>(2 * v) = Vector2(x, y) / area;
  });
  return z;
}

FlowMeshes::FlowMeshes(const Surface& surface, int coarsest, const Progress& progress) {
  meshes_.push_back(std::make_unique<FlowMesh>(surface, progress.step("finest mesh", 0.4)));
  while (meshes_.back()->vertex_count() > coarsest) {
    const FlowMesh& fine = *meshes_.back();
    auto coarser = std::make_unique<CoarsenedSurface>(
        coarsen(fine.surface(), 2 * fine.spacing(), progress.step("coarser meshes", 0.3)));
    if (coarser->surface.mesh.vertex_count() > worth_it * fine.vertex_count()) break;
    auto coarse = std::make_unique<FlowMesh>(coarser->surface);
    transfers_.push_back(
        std::make_shared<const BlockTransfer>(transfer_between(fine, *coarse, *coarser)));
    coarser_.push_back(std::move(coarser));
    meshes_.push_back(std::move(coarse));
  }
  progress.at(1);
}

Signal FlowMeshes::restricted(int m, const Signal& signal) const {
  const BlockTransfer& P = *transfers_[m];
  const Vector& mass = meshes_[m]->lumped_mass();
  Signal coarse = Signal::Zero(P.columns, signal.cols());
  parallel_for(P.columns, [&](std::int64_t j) {
    double sum = 0;
    for (int c = P.child_starts[j]; c < P.child_starts[j + 1]; ++c) {
      const int i = P.children[c].column;
      const double weight = mass[i] * weight_of(P.children[c]);
      coarse.row(j) += weight * signal.row(i);
      sum += weight;
    }
    if (sum > 0) coarse.row(j) /= sum;
  });
  return coarse;
}

Signal FlowMeshes::prolongated(int m, const Signal& signal) const {
  return prolongated_by_weights(*transfers_[m], signal);
}

std::vector<int> FlowMeshes::on_finest(int m) const {
  std::vector<int> result(meshes_[m]->vertex_count());
  std::iota(result.begin(), result.end(), 0);
  for (int k = m; k > 0; --k)
    for (int& v : result) v = coarser_[k - 1]->source[v];
  return result;
}

std::vector<std::shared_ptr<const BlockTransfer>> FlowMeshes::transfers_from(int m) const {
  return {transfers_.begin() + m, transfers_.end()};
}

}  // namespace mq
