// Optical flow on meshes: known motions found again, the published method beside the hierarchical
// one, and time by size.
//
//     flow_bench motions          end point errors on sphere, torus and plane, as Markdown
//     flow_bench thesis [N [S]]   the thesis' presets beside ours on a torus of N vertices, 27,000,
//                                 turned by S/2 to 3·S/2 spacings (8)
//     flow_bench last [N [S]]     on the same torus what the last length and `detail` do to E
//     flow_bench size N...        time on tori of so many vertices
//     flow_bench levels N         the same level by level, seconds on the wall
//     flow_bench tables N...      of each basis the size of its systems and the time of their parts
//     flow_bench system N BASIS   the row of one basis: triangle, Whitney, vertex or gradient
//     flow_bench pair FOLDER      a torus of 60,000 vertices: first.ply, second.ply, whose colours
//                                 are turned by 10 to 30 spacings, blend.ply with both mixed
//
// Seconds are processor time of all threads; where only the wall's are known of a part, its share
// of them times the processor time of the whole.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "fixtures.h"
#include "mq/base/stopwatch.h"
#include "mq/flow/surface_levels.h"
#include "mq/flow/surface_optical_flow.h"
#include "mq/flow/surface_systems.h"
#include "mq/io/model.h"
#include "mq/linear/block_multigrid.h"
#include "mq/mesh/geometry.h"
#include "mq/sample/noise.h"
#include "mq/trace/surface_flow.h"

namespace mq {
namespace {

double processor_seconds() { return double(std::clock()) / CLOCKS_PER_SEC; }

using Motion = std::function<Vector3(const Vector3&)>;

struct Pair {
  Surface surface;
  Signal source, target;
  double spacing = 0;
};

/// Three channels of noise whose largest features are about 1/scale wide, and the same moved along.
Pair moved(const Mesh& mesh, double scale, const Motion& back) {
  Pair pair{make_surface(mesh), {}, {}, 0};
  const Noise noise(7);
  const int vertices = pair.surface.mesh.vertex_count();
  pair.source.resize(vertices, 3);
  pair.target.resize(vertices, 3);
  for (int v = 0; v < vertices; ++v) {
    const Vector3 p = pair.surface.mesh.positions[v], q = back(p);
    for (int c = 0; c < 3; ++c) {
      const Vector3 offset = Vector3(31.4, 7.3, 3.7) * c;
      pair.source(v, c) = noise.octaves(scale * p + offset, 4);
      pair.target(v, c) = noise.octaves(scale * q + offset, 4);
    }
  }
  pair.spacing = std::sqrt(2 / std::sqrt(3.0) * pair.surface.area / vertices);
  return pair;
}

Motion rotation(double angle, const Vector3& axis) {
  return [turn = Eigen::AngleAxisd(angle, axis.normalized())](const Vector3& p) {
    return Vector3(turn * p);
  };
}

/// Mean distance of path ends from where vertices truly go, in spacings, where `counts` says so.
double end_point_error(const Pair& pair, const Vector& field, const Motion& truth,
                       const std::function<bool(const Vector3&)>& counts) {
  const TraceMesh mesh(pair.surface);
  const auto ends = SurfaceFlow::along(mesh, field).trace_vertices(1).ends;
  double sum = 0;
  int count = 0;
  for (std::size_t v = 0; v < ends.size(); ++v) {
    const Vector3& p = pair.surface.mesh.positions[v];
    if (!counts(p)) continue;
    Vector3 end = Vector3::Zero();
    for (int k = 0; k < 3; ++k)
      end += ends[v].barycentric[k] * pair.surface.mesh.position(ends[v].triangle, k);
    sum += (end - truth(p)).norm();
    ++count;
  }
  return sum / count / pair.spacing;
}

/// |φ₀(p − X/2) − φ₁(p + X/2)|² of the signals as given, relative to the linear blend's.
double halfway_error(const Pair& pair, const Vector& field) {
  const TraceMesh mesh(pair.surface);
  const WarpedPair halfway = warp_pair(mesh, field, pair.source, pair.target, 0.5);
  return (halfway.source - halfway.target).squaredNorm() /
         (pair.source - pair.target).squaredNorm();
}

void motions() {
  struct Case {
    std::string name;
    Mesh mesh;
    double scale;
    std::function<Motion(double)> by;  ///< the motion over a length
    std::function<bool(const Vector3&)> counts;
  };
  const auto everywhere = [](const Vector3&) { return true; };
  Mesh square = fixtures::flat_square(181, 0.2);
  square.uvs.clear(), square.corner_uvs.clear();
  const Vector3 axis(0.2, 0.3, 1), along = Vector3(0.8, 0.6, 0);
  const std::vector<Case> cases = {
      {"sphere", fixtures::sphere(7), 1.0, [=](double l) { return rotation(l, axis); }, everywhere},
      {"torus", fixtures::torus(268, 124), 0.8,
       [](double l) { return rotation(l, Vector3::UnitZ()); }, everywhere},
      {"plane", square, 3.0,
       [=](double l) { return Motion([=](const Vector3& p) { return Vector3(p + l * along); }); },
       [](const Vector3& p) { return (p - Vector3(0.5, 0.5, 0)).cwiseAbs().maxCoeff() < 0.25; }}};
  fmt::print(
      "| surface | shift | halfway | forward | halfway, one scale | forward, one scale |\n"
      "|---|---|---|---|---|---|\n");
  for (const Case& c : cases)
    for (const double shift : {1.0, 2.0, 5.0, 10.0, 20.0, 40.0}) {
      const Surface surface = make_surface(c.mesh);
      const double spacing = std::sqrt(2 / std::sqrt(3.0) * surface.area / c.mesh.vertex_count());
      const Pair pair = moved(c.mesh, c.scale, c.by(-shift * spacing));
      fmt::print("| {} | {} |", c.name, shift);
      for (const bool scales : {true, false})
        for (const FlowAlignment alignment : {FlowAlignment::halfway, FlowAlignment::forward}) {
          MeshFlowOptions options;
          options.alignment = alignment;
          options.detail = {0, Length::Unit::percent};
          options.largest =
              scales ? Length{25, Length::Unit::percent} : Length{3 * spacing, Length::Unit::model};
          options.smallest = {(scales ? 2 : 3) * spacing, Length::Unit::model};
          options.steps = scales ? 2 : 20;
          const MeshFlow flow = mesh_flow(pair.surface, pair.source, pair.target, options);
          fmt::print(" {:.2f} |",
                     end_point_error(pair, flow.field, c.by(shift * spacing), c.counts));
        }
      fmt::print("\n");
    }
}

/// A torus whose texture turns, more on one side than on the other.
Pair twisted_torus(int vertices, double shift) {
  const int n = int(std::lround(std::sqrt(vertices * 480.0 / 225))), m = n * 225 / 480;
  const Mesh mesh = fixtures::torus(n, m);
  const double spacing =
      std::sqrt(2 / std::sqrt(3.0) * make_surface(mesh).area / mesh.vertex_count());
  return moved(mesh, 2, [=](const Vector3& p) {
    const double angle = shift * spacing * (1 + 0.5 * std::sin(3 * std::atan2(p.y(), p.x())));
    return rotation(-angle, Vector3::UnitZ())(p);
  });
}

/// Seconds of matrices, of solving, and of smoothing and warping.
std::array<double, 3> parts(const MeshFlow& flow) {
  std::array<double, 3> all = {0, 0, 0};
  for (const MeshFlowLevel& level : flow.levels) {
    all[0] += level.build_seconds;
    all[1] += level.solve_seconds;
    all[2] += level.smooth_seconds + level.warp_seconds;
  }
  return all;
}

void line(const std::string& name, const Pair& pair, const MeshFlow& flow, double seconds) {
  const auto [build, solve, warp] = parts(flow);
  fmt::print("| {} | {} | {:.5f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} |\n", name,
             flow.levels.back().unknowns, halfway_error(pair, flow.field), seconds,
             flow.prepare_seconds, build, solve, warp);
  std::fflush(stdout);
}

const std::vector<std::pair<FlowBasis, std::string>> bases = {{FlowBasis::triangle, "triangle"},
                                                              {FlowBasis::whitney, "Whitney"},
                                                              {FlowBasis::vertex, "vertex"},
                                                              {FlowBasis::gradient, "gradient"}};

void thesis(int vertices, double shift) {
  const Pair pair = twisted_torus(vertices, shift);
  fmt::print("{} vertices, shifts of {} to {} spacings; E relative to the linear blend's\n\n",
             pair.surface.mesh.vertex_count(), shift / 2, shift * 3 / 2);
  fmt::print(
      "| method | unknowns | E | processor s | prepare | matrices | solve | smooth and warp |\n"
      "|---|---|---|---|---|---|---|---|\n");
  const auto run = [&](const std::string& name, const MeshFlowOptions& options) {
    const double start = processor_seconds();
    const MeshFlow flow = mesh_flow(pair.surface, pair.source, pair.target, options);
    line(name, pair, flow, processor_seconds() - start);
  };
  MeshFlowOptions options;
  run("hierarchical", options);
  MeshFlowOptions lit = options;
  lit.detail = {0, Length::Unit::percent};
  run("hierarchical, detail 0", lit);
  for (const auto& [basis, name] : bases) run("thesis, " + name, thesis_flow(basis));
  for (const FlowSolver solver : {FlowSolver::hierarchical, FlowSolver::direct})
    for (const auto& [basis, name] : bases) {
      options.basis = basis;
      options.solver = solver;
      run((solver == FlowSolver::direct ? "direct, " : "hierarchical, ") + name, options);
    }
}

/// E by the last length, in spacings, and by what is left out as light.
void last_lengths(int vertices, double shift) {
  const Pair pair = twisted_torus(vertices, shift);
  const std::array<double, 6> details = {0, 0.5, 1, 2, 4, 8};
  fmt::print("| last length |");
  for (const double detail : details) fmt::print(" detail {} % |", detail);
  fmt::print("\n|---|---|---|---|---|---|---|\n");
  for (const double last : {0.7, 1.0, 1.25, 1.5, 2.0, 2.5}) {
    fmt::print("| {} |", last);
    for (const double detail : details) {
      MeshFlowOptions options;
      options.detail = {detail, Length::Unit::percent};
      options.smallest = {last * pair.spacing, Length::Unit::model};
      const MeshFlow flow = mesh_flow(pair.surface, pair.source, pair.target, options);
      fmt::print(" {:.6f} |", halfway_error(pair, flow.field));
      std::fflush(stdout);
    }
    fmt::print("\n");
  }
}

void sizes(const std::vector<int>& all) {
  fmt::print(
      "| vertices | E | wall s | processor s | prepare | matrices | solve | smooth and warp |\n"
      "|---|---|---|---|---|---|---|---|\n");
  for (const int vertices : all) {
    const Pair pair = twisted_torus(vertices, 10);
    const double start = processor_seconds();
    const MeshFlow flow = mesh_flow(pair.surface, pair.source, pair.target);
    const double seconds = processor_seconds() - start;
    const auto [build, solve, warp] = parts(flow);
    fmt::print("| {} | {:.5f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} |\n",
               pair.surface.mesh.vertex_count(), halfway_error(pair, flow.field), flow.seconds,
               seconds, flow.prepare_seconds, build, solve, warp);
  }
}

void levels(int vertices) {
  const Pair pair = twisted_torus(vertices, 10);
  const MeshFlow flow = mesh_flow(pair.surface, pair.source, pair.target);
  fmt::print(
      "| l | vertices | steps | cycles | error | smooth | matrices | solve | warp |\n"
      "|---|---|---|---|---|---|---|---|---|\n");
  for (const MeshFlowLevel& level : flow.levels)
    fmt::print("| {:.3g} | {} | {} | {} | {:.5f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} |\n",
               level.length, level.vertices, level.steps, level.cycles,
               level.error / flow.blend_error, level.smooth_seconds, level.build_seconds,
               level.solve_seconds, level.warp_seconds);
  fmt::print("\n{:.2f} s, of which preparing {:.2f} s\n", flow.seconds, flow.prepare_seconds);
}

/// The same system in one basis, by a factorisation.
void factored(const FlowMesh& mesh, const DataTerms& data, double weight, FlowBasis basis,
              const std::string& name) {
  DirectFlowSolver solver(mesh, basis);
  // Processor seconds per second on the wall, of one solve.
  const auto busy = [&] {
    const Stopwatch wall;
    const double start = processor_seconds();
    solver.solve(data, weight);
    return (processor_seconds() - start) / wall.seconds();
  };
  const double first = busy(), analysis = first * solver.cost().analyse_seconds;
  const double share = busy();
  const FlowSystemCost cost = solver.cost();
  const int vertices = mesh.vertex_count();
  fmt::print("| {} | {} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} |\n",
             vertices, name, double(cost.unknowns) / vertices,
             double(cost.smoothness_entries) / double(cost.unknowns), double(cost.entries) * 1e-6,
             share * cost.build_seconds, analysis, share * cost.factor_seconds,
             share * cost.substitute_seconds);
  std::fflush(stdout);
}

DataTerms last_data(const Pair& pair, const FlowMesh& mesh) {
  const Signal difference = pair.target - pair.source, mean = 0.5 * (pair.source + pair.target);
  return data_terms(mesh.space(), difference, mean);
}

double last_weight(const Pair& pair, const FlowMesh& mesh, const DataTerms& data) {
  return 4 * pair.spacing * pair.spacing * data.trace / mesh.area();
}

void system_of(const Pair& pair, const std::string& name) {
  const FlowMesh mesh(pair.surface);
  const DataTerms data = last_data(pair, mesh);
  for (const auto& [basis, own] : bases)
    if (own == name) factored(mesh, data, last_weight(pair, mesh, data), basis, name);
}

/// Thesis Tables 4.4 to 4.6: one system of the last level, by basis, and ours beside them.
void systems(const Pair& pair) {
  const FlowMesh mesh(pair.surface);
  const DataTerms data = last_data(pair, mesh);
  const int vertices = pair.surface.mesh.vertex_count();
  const double weight = last_weight(pair, mesh, data);
  double last = processor_seconds();
  const auto passed = [&] {
    const double now = processor_seconds();
    return now - std::exchange(last, now);
  };
  VertexSystem system = vertex_system(mesh, data, weight);
  const double build = passed();
  const FlowMeshes meshes(pair.surface, 100);
  const double coarse = passed();
  BlockMultigrid multigrid(meshes.transfers_from(0), {.tolerance = 1e-3});
  multigrid.set_matrix(std::move(system.matrix));
  const double set_up = passed();
  Vector z = Vector::Zero(system.right_hand_side.size());
  const int cycles = multigrid.solve(system.right_hand_side, z).cycles;
  fmt::print("| {} | vertex, multigrid | 2 | | | {:.2f} | {:.2f} | {:.2f} | {:.2f} ({} cycles) |\n",
             vertices, build, coarse, set_up, passed(), cycles);
  for (const auto& [basis, name] : bases) factored(mesh, data, weight, basis, name);
}

/// Thesis Table 4.3: a correction pass on the mesh itself.
void passes(const Pair& pair) {
  MeshFlowOptions ours;
  for (const auto& [name, options] :
       {std::pair{"thesis, Whitney", thesis_flow(FlowBasis::whitney)}, std::pair{"ours", ours}}) {
    const double start = processor_seconds();
    const MeshFlow flow = mesh_flow(pair.surface, pair.source, pair.target, options);
    const double busy = (processor_seconds() - start) / flow.seconds;
    const MeshFlowLevel& last = flow.levels.back();
    const double steps = std::max(1, last.steps);
    fmt::print("| {} | {} | {:.2f} | {:.2f} | {:.2f} |\n", pair.surface.mesh.vertex_count(), name,
               busy * last.smooth_seconds, busy * last.warp_seconds / steps,
               busy * (last.build_seconds + last.solve_seconds) / steps);
  }
}

void tables(const std::vector<int>& sizes) {
  fmt::print("| vertices | method | smooth | warp | estimate |\n|---|---|---|---|---|\n");
  for (const int n : sizes) passes(twisted_torus(n, 10));
  fmt::print(
      "\n| vertices | basis | unknowns per vertex | entries of S per row | entries, millions | "
      "construct | analyse or coarsen | factor or set up | substitute or solve |\n"
      "|---|---|---|---|---|---|---|---|---|\n");
  for (const int n : sizes) systems(twisted_torus(n, 10));
}

void write_coloured(const std::string& path, const Mesh& mesh, const Signal& colours) {
  Model model;
  model.mesh = mesh;
  model.mesh.uvs.clear(), model.mesh.corner_uvs.clear();
  model.colors.channels = int(colours.cols());
  for (Eigen::Index v = 0; v < colours.rows(); ++v)
    for (Eigen::Index c = 0; c < colours.cols(); ++c)
      model.colors.values.push_back(float(0.5 + 0.4 * colours(v, c)));
  write_model(path, model);
}

void write_pair(const std::string& folder) {
  Pair pair = twisted_torus(60000, 20);
  const Mesh& mesh = pair.surface.mesh;
  // Spots with edges, which show twice when mixed.
  for (Signal* signal : {&pair.source, &pair.target}) *signal = (8 * signal->array()).tanh();
  write_coloured(folder + "/first.ply", mesh, pair.source);
  write_coloured(folder + "/second.ply", mesh, pair.target);
  write_coloured(folder + "/blend.ply", mesh, 0.5 * (pair.source + pair.target));
}

}  // namespace
}  // namespace mq

int main(int count, char** arguments) {
  const std::string what = count > 1 ? arguments[1] : "";
  if (what == "motions") {
    mq::motions();
  } else if (what == "thesis") {
    mq::thesis(count > 2 ? std::atoi(arguments[2]) : 27000,
               count > 3 ? std::atof(arguments[3]) : 8);
  } else if (what == "last") {
    mq::last_lengths(count > 2 ? std::atoi(arguments[2]) : 27000,
                     count > 3 ? std::atof(arguments[3]) : 8);
  } else if (what == "levels" && count > 2) {
    mq::levels(std::atoi(arguments[2]));
  } else if (what == "system" && count > 3) {
    mq::system_of(mq::twisted_torus(std::atoi(arguments[2]), 10), arguments[3]);
  } else if (what == "pair" && count > 2) {
    mq::write_pair(arguments[2]);
  } else if ((what == "size" || what == "tables") && count > 2) {
    std::vector<int> sizes;
    for (int i = 2; i < count; ++i) sizes.push_back(std::atoi(arguments[i]));
    what == "size" ? mq::sizes(sizes) : mq::tables(sizes);
  } else {
    fmt::print(
        "flow_bench motions | thesis [N [shift]] | last [N [shift]] | size N... | levels N | "
        "tables N... | system N "
        "BASIS | pair FOLDER\n");
    return 2;
  }
}
