/// Distances from a source that moves (`LiveGeodesic`): milliseconds per frame, and how far what is shown is from
/// `GeodesicDistance`, after a jump and while the source moves.
///
///     live_geodesic_bench [MODEL [TEXELS [THREADS]]]
///     live_geodesic_bench pictures FOLDER
///
/// The second writes textures of the sample bust with the distances of some frames after a jump. MODEL is a sample.
/// Errors are in per cent: the mean and the root mean square over all texels and the largest, of
/// the distance that is exact on average; and the largest of a texel's own distance beyond a tenth of the farthest.
/// The published method is compared with where it ends too. Times are the best of several rounds, said also as
/// parts of a full solution and of a copy of a signal, which are timed beside them.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <tbb/global_control.h>

#include "mq/base/stopwatch.h"
#include "mq/draw/false_colour.h"
#include "mq/filter/live_geodesic.h"
#include "mq/io/model.h"
#include "sample_space.h"

namespace mq {
namespace {

constexpr int rounds = 5;
using Method = LiveGeodesicOptions::Method;
using Part = LiveGeodesicStep::Part;

const char* word(Part part) {
  switch (part) {
    case Part::front: return "front";
    case Part::misses: return "misses";
    case Part::carry: return "carry";
    case Part::boundary: return "boundary";
    case Part::directions: return "directions";
    case Part::moments: return "moments";
    case Part::cycle: return "cycle";
    case Part::published: return "published";
    default: return "rest";
  }
}

/// What differs from the exact distances, in per cent.
struct Error {
  double mean = 0, rms = 0, most = 0, most_of_own = 0;
};

Error error_of(const Vector& found, const Vector& exact) {
  const double farthest = exact.maxCoeff(), mean = exact.mean();
  Error error;
  for (Eigen::Index i = 0; i < exact.size(); ++i) {
    const double d = std::abs(found[i] - exact[i]);
    error.mean += d, error.rms += d * d, error.most = std::max(error.most, d);
    if (exact[i] > 0.1 * farthest) error.most_of_own = std::max(error.most_of_own, d / exact[i]);
  }
  const double count = double(exact.size());
  return {100 * error.mean / count / mean, 100 * std::sqrt(error.rms / count) / mean, 100 * error.most / mean,
          100 * error.most_of_own};
}

std::string words(const Error& e) {
  return fmt::format("{:8.3f} {:8.3f} {:8.2f} {:8.2f}", e.mean, e.rms, e.most, e.most_of_own);
}

class Bench {
 public:
  explicit Bench(const TexelSpace& space) : space_(space), exact_(space), positions_(space.positions()) {
    const Stopwatch watch;
    const Geodesic found = exact_.from(source(space.size() / 3));
    full_ = watch.seconds();
    fmt::print("{} texels, the farthest {:.0f} spacings away; GeodesicDistance: {:.0f} ms\n", space.size(),
               found.distance.maxCoeff() / space.scale().texel_spacing, 1e3 * full_);
    Vector from = found.distance, to = from;
    copy_ = 1;
    for (int k = 0; k < 4 * rounds; ++k) {
      const Stopwatch copying;
      std::copy(from.begin(), from.end(), to.begin());
      copy_ = std::min(copy_, copying.seconds());
      from[k] += to[k + 1];
    }
    fmt::print("a copy of a signal: {:.2f} ms\n", 1e3 * copy_);
  }

  void jump(Method method, int frames, int most_nodes);
  void drag(Method method, double texels_per_frame, int frames, int most_nodes);

 private:
  std::vector<GeodesicSource> source(int unknown) const { return {{unknown, 0, positions_[std::size_t(unknown)]}}; }
  std::string time(double seconds) const {
    return fmt::format("{:6.1f} ms {:5.1f} % {:4.0f} x", 1e3 * seconds, 100 * seconds / full_, seconds / copy_);
  }
  /// Texels along a way over the surface, some spacings from each to the next.
  std::vector<int> way(double spacings, int count) const;

  const TexelSpace& space_;
  GeodesicDistance exact_;
  std::vector<Vector3> positions_;
  double full_ = 0, copy_ = 0;
};

std::vector<int> Bench::way(double spacings, int count) const {
  std::vector<int> places = {space_.size() / 3};
  Vector3 ahead = Vector3(0.6, 0.64, 0.48) * spacings * space_.scale().texel_spacing;
  while (std::ssize(places) < count) {
    const Vector3 wanted = positions_[std::size_t(places.back())] + ahead;
    int nearest = 0;
    for (int k = 1; k < space_.size(); ++k)
      if ((positions_[std::size_t(k)] - wanted).squaredNorm() < (positions_[std::size_t(nearest)] - wanted).squaredNorm())
        nearest = k;
    ahead = (positions_[std::size_t(nearest)] - positions_[std::size_t(places.back())]).normalized() * ahead.norm();
    places.push_back(nearest);
  }
  return places;
}

void Bench::jump(Method method, int frames, int most_nodes) {
  LiveGeodesic live(space_, {.method = method, .most_front_nodes = most_nodes});
  const int before = space_.size() / 5, after = space_.size() / 3;
  const Vector exact = exact_.from(source(after)).distance;
  std::vector<double> seconds(std::size_t(frames), 1e9);
  std::vector<Part> parts(seconds.size(), Part::rest);
  std::vector<Vector> shown(seconds.size());
  for (int round = 0; round < rounds; ++round) {
    live.move(source(before));
    for (int k = 0; k < 3; ++k) live.step();
    for (std::size_t f = 0; f < seconds.size(); ++f) {
      const Stopwatch watch;
      if (f == 0) live.move(source(after));
      const LiveGeodesicStep did = live.step();
      seconds[f] = std::min(seconds[f], watch.seconds());
      parts[f] = did.part;
      if (did.shown == LiveGeodesicStep::Shown::anew) shown[f] = live.distance();
    }
  }
  Vector own;
  if (method == Method::published) {
    for (int k = 0; k < 40; ++k) live.step();
    own = live.distance();
  }
  double sum = 0;
  fmt::print(" frame part       time, of a full solution, copies; since     mean      rms     most of own{}\n",
             own.size() > 0 ? ";     of where it ends" : "");
  for (std::size_t f = 0; f < seconds.size() && parts[f] != Part::rest; ++f) {
    sum += seconds[f];
    fmt::print("  {:3d}  {:10s} {} {:6.0f} ms {}", f + 1, word(parts[f]), time(seconds[f]), 1e3 * sum,
               shown[f].size() > 0 ? words(error_of(shown[f], exact)) : "");
    if (own.size() > 0) fmt::print(" {}", words(error_of(shown[f], own)));
    fmt::print("\n");
  }
}

void Bench::drag(Method method, double texels_per_frame, int frames, int most_nodes) {
  LiveGeodesic live(space_, {.method = method, .most_front_nodes = most_nodes});
  std::vector<double> seconds;
  Error worst, mean;
  const std::vector<int> places = way(texels_per_frame, frames);
  for (const int place : places) {
    const Vector exact = exact_.from(source(place)).distance;
    double best = 1e9;
    for (int round = 0; round < rounds; ++round) {
      const Stopwatch watch;
      live.move(source(place));
      live.step();
      best = std::min(best, watch.seconds());
    }
    seconds.push_back(best);
    const Error e = error_of(live.distance(), exact);
    mean.mean += e.mean / frames, mean.rms += e.rms / frames;
    worst = {std::max(worst.mean, e.mean), std::max(worst.rms, e.rms), std::max(worst.most, e.most),
             std::max(worst.most_of_own, e.most_of_own)};
  }
  std::ranges::sort(seconds);
  fmt::print("  {} texels a frame, {} frames: median {}; worst {:.1f} ms; {:.0f} frames per second\n", texels_per_frame,
             frames, time(seconds[seconds.size() / 2]), 1e3 * seconds.back(), 1 / seconds[seconds.size() / 2]);
  fmt::print("    mean {:.3f} rms {:.3f}; of the worst frame {}\n", mean.mean, mean.rms, words(worst));
}

/// What Figure 5.17 of the thesis shows of both methods: the place, the frames and the sources before and after.
void write_pictures(const std::filesystem::path& folder) {
  const Sample sample = make_sample("bust", {.texture_size = 1024, .seed = 0});  // as `marquetry sample` does
  const Surface surface = make_surface(sample.mesh);
  const Atlas atlas = make_atlas(surface, {sample.texture});
  const TexelSpace space(surface, atlas);
  const std::vector<Vector3> positions = space.positions();
  const auto source = [&](const Vector3& place) -> std::vector<GeodesicSource> {
    const auto nearest = std::ranges::min_element(positions, {}, [&](const Vector3& p) { return (p - place).squaredNorm(); });
    return {{int(nearest - positions.begin()), 0, *nearest}};
  };
  const Vector exact = GeodesicDistance(space).from(source({0, 0.3, 1})).distance;
  const DistanceColours scale{.most = exact.maxCoeff(), .lines = 24, .line_width = 1.5 * space.scale().texel_spacing};
  const auto write = [&](const std::string& name, const Vector& distance) {
    std::vector<Image<float>> pictures = {Image<float>(1024, 1024, 3)};
    space.scatter(distance_colours(distance.cwiseMax(0), scale), pictures);
    write_image(folder / (name + ".png"), pictures.front());
  };
  for (const Method method : {Method::published, Method::progressive}) {
    LiveGeodesic live(space, {.method = method});
    live.move(source({1, -0.3, 0}));
    for (int k = 0; k < 3; ++k) live.step();
    live.move(source({0, 0.3, 1}));
    for (int frame = 1; frame <= 8; ++frame) {
      live.step();
      if (frame == 1 || frame == 2 || frame == 4 || frame == 8)
        write(fmt::format("{}_{}", method == Method::published ? "published" : "progressive", frame), live.distance());
    }
  }
  write("exact", exact);
}

}  // namespace
}  // namespace mq

int main(int argc, char** argv) {
  using Method = mq::LiveGeodesicOptions::Method;
  const std::string name = argc > 1 ? argv[1] : "bust";
  if (name == "pictures" && argc > 2) {
    mq::write_pictures(argv[2]);
    return 0;
  }
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, argc > 3 ? std::atoi(argv[3]) : 2);
  const auto model = mq::make_sample_space(name, argc > 2 ? std::atof(argv[2]) : 670'000);
  fmt::print("{}: ", name);
  mq::Bench bench(*model->space);
  for (const int nodes : {mq::LiveGeodesicOptions{}.most_front_nodes, 200'000}) {
    fmt::print("progressive, fronts of at most {} nodes, after a jump:\n", nodes);
    bench.jump(Method::progressive, 60, nodes);
    fmt::print("progressive, dragged:\n");
    for (const double texels : {3.0, 20.0}) bench.drag(Method::progressive, texels, 12, nodes);
  }
  fmt::print("published, after a jump:\n");
  bench.jump(Method::published, 8, 0);
  fmt::print("published, dragged:\n");
  bench.drag(Method::published, 3, 6, 0);
}
