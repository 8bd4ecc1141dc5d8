// A blurred step on the sphere, sharpened: four resolutions by six times, as Figure 3.9 of the
// thesis.
//
//     shock_sphere_bench            the table, as Markdown
//     shock_sphere_bench OUT.png    and the picture
//
// Smoothing is α = 10⁻⁴ for signal and potential, times are those of the thesis' own (area 1,
// values from 0 to 1). Seconds are processor time of one thread.

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <cmath>
#include <ctime>
#include <vector>

#include "fixtures.h"
#include "mq/draw/contact_sheet.h"
#include "mq/draw/render.h"
#include "mq/filter/shock.h"
#include "mq/io/model.h"
#include "mq/linear/conjugate_gradients.h"

namespace mq {
namespace {

const std::vector<double> times = {1e-5, 1e-4, 1e-3, 1e-2, 10, 1e6};

double processor_seconds() { return double(std::clock()) / CLOCKS_PER_SEC; }

/// From 0.1 below to 0.9 above, a quarter of the radius wide; tilted, so that no vertex is on a
/// ridge.
double step(const Vector3& p) {
  const Vector3 up = Vector3(0.2, 0.1, 1).normalized();
  return 0.5 + 0.4 * std::tanh(4 * p.dot(up));
}

struct Row {
  Surface surface;
  std::vector<Shocked> shocked;
  std::vector<double> seconds;
};

Row sharpened(int level) {
  Row row{make_surface(fixtures::sphere(level)), {}, {}};
  const VertexSpace space(row.surface);
  const TraceMesh mesh(row.surface);
  Signal phi(space.size(), 1);
  for (int v = 0; v < space.size(); ++v)
    phi(v, 0) = step(row.surface.mesh.positions[std::size_t(v)]);
  const double weight = 1e-4 * space.scale().area;
  const Vector P = shock_potential(space, phi, {weight, weight}, conjugate_gradient_solver());
  const SurfaceFlow flow = SurfaceFlow::downhill(mesh, P);
  for (const double time : times) {
    Shocked one;
    one.rate = potential_rate(space, P);
    one.time = time_from({ShockTime::Unit::absolute, time}, space, P);
    const double start = processor_seconds();
    Advected advected = flow.advect(phi, one.time);
    row.seconds.push_back(processor_seconds() - start);
    one.signal = std::move(advected.signal);
    one.counts = advected.counts;
    row.shocked.push_back(std::move(one));
  }
  return row;
}

/// The mean over the sphere of |φ − φ of the finest mesh|, at the coarser one's vertices, which
/// come first among those of the finer one.
double difference(const Signal& coarse, const Signal& finest) {
  return (coarse - finest.topRows(coarse.rows())).cwiseAbs().mean();
}

Image<float> portrait(const Row& row, std::size_t column) {
  std::vector<float> colours;
  for (Eigen::Index v = 0; v < row.shocked[column].signal.rows(); ++v)
    colours.insert(colours.end(), 3, float(row.shocked[column].signal(v, 0)));
  RenderOptions options;
  options.width = options.height = 150;
  options.paint = RenderOptions::Paint::vertex_colours;
  options.view = parse_view("15,10");
  options.view.up = View::Up::z;
  options.light = RenderOptions::Light::none;
  return Renderer(row.surface).draw({.vertex_values = colours}, options);
}

}  // namespace
}  // namespace mq

int main(int count, char** words) {
  using namespace mq;
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  std::vector<Row> rows;
  for (const int level : {6, 7, 8, 9}) rows.push_back(sharpened(level));
  const auto line = [](const std::string& first, const auto& cell) {
    fmt::print("| {} |", first);
    for (std::size_t i = 0; i < times.size(); ++i) fmt::print(" {} |", cell(i));
    fmt::print("\n");
  };
  line("vertices", [](std::size_t i) { return fmt::format("t = {:g}", times[i]); });
  line("---", [](std::size_t) { return std::string("---"); });
  for (const Row& row : rows) {
    const auto vertices = fmt::format("{}", row.surface.mesh.vertex_count());
    line(vertices + ", seconds",
         [&](std::size_t i) { return fmt::format("{:.3f}", row.seconds[i]); });
    line("million triangles per second", [&](std::size_t i) {
      const PathCounts& c = row.shocked[i].counts;
      return fmt::format("{:.0f}", 1e-6 * double(c.triangles + c.edges) / row.seconds[i]);
    });
    line("crossed per path", [&](std::size_t i) {
      const PathCounts& c = row.shocked[i].counts;
      return fmt::format("{:.1f}", double(c.triangles + c.edges) / double(c.paths));
    });
    line("paths at rest", [&](std::size_t i) {
      const PathCounts& c = row.shocked[i].counts;
      return fmt::format("{:.0f} %", 100 * double(c.resting) / double(c.paths));
    });
    line("difference from the finest", [&](std::size_t i) {
      return fmt::format("{:.0e}",
                         difference(row.shocked[i].signal, rows.back().shocked[i].signal));
    });
  }
  fmt::print("\nrelative times on the finest:");
  for (const Shocked& one : rows.back().shocked) fmt::print(" {:.3g}", one.time * one.rate);
  fmt::print("\n");
  if (count < 2) return 0;
  std::vector<Tile> tiles;
  for (const Row& row : rows)
    for (std::size_t i = 0; i < times.size(); ++i)
      tiles.push_back(
          {portrait(row, i), fmt::format("{} t={:g}", row.surface.mesh.vertex_count(), times[i])});
  write_image(words[1],
              contact_sheet(tiles, {.columns = int(times.size()), .gap = 6, .text_scale = 1}));
  return 0;
}
