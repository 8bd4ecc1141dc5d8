// How much of the noise of normals filters take off (thesis, Figure 3.10, with figures): the mean
// angle between the normals of the triangles of a clean mesh, and of the same mesh after noise and
// a filter. Every filter's normals are fitted to in the same way (`NormalFit`, five steps), and of
// each filter the best of a few settings counts.
//
//     normal_noise_bench [-o FOLDER] [MESH...]
//
// Without meshes: a cube and the owl. With -o the shapes at the noise of 0.3 edges are written as
// PLY.
#include <fmt/format.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "mq/base/random.h"
#include "mq/baseline/normal_denoise.h"
#include "mq/filter/geometry_filter.h"
#include "mq/filter/geometry_shock.h"
#include "mq/io/model.h"
#include "mq/mesh/geometry.h"
#include "mq/sample/implicit.h"
#include "mq/sample/owl.h"
#include "mq/sample/shapes.h"

namespace {

using namespace mq;

constexpr double noises[] = {0.1, 0.2, 0.3, 0.5};  // standard deviations, in mean edge lengths
constexpr double pictured = 0.3;

/// Every vertex moved along its normal by a normally distributed distance.
Mesh noisy(const Surface& clean, double noise) {
  Mesh mesh = clean.mesh;
  const std::vector<Vector3> normals = vertex_normals(mesh);
  const double deviation = noise * mean_edge_length(clean);
  const Random random(17);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const double radius = std::sqrt(-2 * std::log(1 - random.uniform(2 * v)));
    const double angle = 2 * std::numbers::pi * random.uniform(2 * v + 1);
    mesh.positions[v] += deviation * radius * std::cos(angle) * normals[v];
  }
  return mesh;
}

/// By area of the clean mesh, degrees.
double mean_angle(const Mesh& clean, const Mesh& other) {
  double sum = 0, total = 0;
  for (int t = 0; t < clean.triangle_count(); ++t) {
    const double area = triangle_area(clean, t);
    const Vector3 a = triangle_normal(clean, t), b = triangle_normal(other, t);
    sum += area * std::atan2(a.cross(b).norm(), a.dot(b));
    total += area;
  }
  return sum / total * 180 / std::numbers::pi;
}

/// A filter with one choice of its settings.
struct Setting {
  std::string name;
  std::function<std::vector<Vector3>(const Surface&)> normals;  ///< of triangles
};

struct Method {
  std::string name;
  std::vector<Setting> settings;
};

double area_of_edges(const Surface& surface, double edges) {
  const double length = edges * mean_edge_length(surface);
  return length * length;
}

std::vector<Vector3> shocked(const Surface& surface, double before, double field, double tau) {
  const double area = surface.area;
  const GeometryShockOptions options{.normal_alpha = area_of_edges(surface, before) / area,
                                     .signal_alpha = area_of_edges(surface, field) / area,
                                     .potential_alpha = area_of_edges(surface, field) / area,
                                     .time = {ShockTime::Unit::relative, tau}};
  return sharpen_shape(surface, options).normals;
}

std::vector<Method> methods() {
  std::vector<Method> all = {
      {"bilateral", {}}, {"mean shift", {}}, {"smooth", {}}, {"shock", {}}, {"smooth, shock", {}}};
  for (const double difference : {0.2, 0.35, 0.5})
    for (const double place : {1.0, 1.5})
      for (const int iterations : {5, 20})
        all[0].settings.push_back(
            {fmt::format("σ {:g} {:g}, {} times", place, difference, iterations),
             [=](const Surface& s) {
               return bilateral_normals(s, {place, difference, iterations});
             }});
  for (const double difference : {0.35, 0.5, 0.8})
    for (const double place : {1.0, 2.0})
      all[1].settings.push_back(
          {fmt::format("σ {:g} {:g}", place, difference), [=](const Surface& s) {
             return mean_shift_normals(s, {place, difference});
           }});
  for (const double edges : {0.5, 1.0, 2.0, 3.0})
    all[2].settings.push_back(
        {fmt::format("{:g} edges", edges), [=](const Surface& s) {
           return filter_normals(s, {.weight = area_of_edges(s, edges), .beta = 0}).of_triangles;
         }});
  for (const double field : {2.0, 4.0})
    for (const double tau : {0.3, 1.0, 4.0}) {
      all[3].settings.push_back({fmt::format("field {:g}, τ {:g}", field, tau),
                                 [=](const Surface& s) { return shocked(s, 0, field, tau); }});
      for (const double before : {1.0, 2.0})
        all[4].settings.push_back(
            {fmt::format("{:g} edges, field {:g}, τ {:g}", before, field, tau),
             [=](const Surface& s) { return shocked(s, before, field, tau); }});
    }
  return all;
}

void write(const std::string& folder, const std::string& name, const Mesh& mesh) {
  if (folder.empty()) return;
  Model model;
  model.mesh = mesh;
  model.mesh.uvs.clear(), model.mesh.corner_uvs.clear(), model.mesh.textures.clear();
  write_model(std::filesystem::path(folder) / (name + ".ply"), model);
}

void measure(const std::string& name, const Surface& clean, const std::string& folder) {
  write(folder, name + "_clean", clean.mesh);
  for (const double noise : noises) {
    Mesh mesh = noisy(clean, noise);
    const Surface surface = make_surface(mesh, {WeldOptions::Kind::none});
    const NormalFit fit(surface);
    const bool draw = noise == pictured;
    if (draw) write(folder, name + "_noisy", mesh);
    fmt::print("| {} | {:g} | {:.1f} |", name, noise, mean_angle(clean.mesh, mesh));
    std::string chosen;
    for (const Method& method : methods()) {
      double best = std::numeric_limits<double>::infinity();
      std::string how;
      Mesh shape;
      for (const Setting& setting : method.settings) {
        mesh.positions = fit.fit(setting.normals(surface), 5).positions;
        const double angle = mean_angle(clean.mesh, mesh);
        if (angle >= best) continue;
        best = angle, how = setting.name, shape = mesh;
      }
      fmt::print(" {:.1f} |", best);
      chosen += fmt::format("{}{}: {}", chosen.empty() ? "" : "; ", method.name, how);
      if (draw) {
        std::string file = name + "_" + method.name;
        std::erase(file, ',');
        std::ranges::replace(file, ' ', '_');
        write(folder, file, shape);
      }
    }
    fmt::print(" {} |\n", chosen);
    std::fflush(stdout);
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::string folder;
  std::vector<std::string> files;
  for (int i = 1; i < argc; ++i) {
    if (std::string(argv[i]) == "-o" && i + 1 < argc)
      folder = argv[++i];
    else
      files.emplace_back(argv[i]);
  }
  if (!folder.empty()) std::filesystem::create_directories(folder);
  fmt::print("| model | noise | noisy |");
  for (const Method& method : methods()) fmt::print(" {} |", method.name);
  fmt::print(" settings |\n|---|---|---|");
  for (std::size_t i = 0; i < methods().size(); ++i) fmt::print("---|");
  fmt::print("---|\n");
  if (files.empty()) {
    measure("cube", make_surface(cube_cross(28).mesh), folder);
    measure(
        "owl",
        make_surface(mesh_of_solid(
            owl_solid, {.low = {-0.75, -1, -0.7}, .high = {0.75, 1.08, 0.7}, .triangles = 10000})),
        folder);
  }
  for (const std::string& file : files)
    measure(std::filesystem::path(file).stem().string(), make_surface(read_model(file).mesh),
            folder);
}
