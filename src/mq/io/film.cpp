#include "mq/io/film.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "mq/base/error.h"
#include "mq/io/detail/evolving_manifest.h"
#include "mq/io/detail/store_coder.h"

namespace mq {
namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr double farthest_drawn = 1e18;       // graphics cards multiply lengths in floats, to 3.4e38
constexpr double float_steps = 0x1p24;        // floats have as many up to a power of two
constexpr double extent_parts = 65536;        // of which half a one may be lost
constexpr double least_uv_step = 0x1p-19;     // a 32nd texel of the largest textures, 16384 wide

struct FilmBox {
  Vector3 low = Vector3::Constant(std::numeric_limits<double>::infinity()), high = -low;

  void add(const EvolvingReader& reader, int frame) {
    for (const Vector3& p : reader.positions(frame)) {
      if (p.cwiseAbs().maxCoeff() > farthest_drawn)
        throw Unsupported(
            fmt::format("{}, frame {}: found a vertex at {:.6g}, {:.6g}, {:.6g}, wanted at most {:.0e} "
                        "from 0, which browsers draw; scale it down",
                        reader.manifest().string(), reader.frames()[std::size_t(frame)].number, p.x(), p.y(), p.z(),
                        farthest_drawn));
      low = low.cwiseMin(p), high = high.cwiseMax(p);
    }
  }
};

double film_step(const EvolvingReader& reader, const FilmBox& box, const std::optional<double>& error) {
  const double farthest = std::max(box.low.cwiseAbs().maxCoeff(), box.high.cwiseAbs().maxCoeff());
  const double extent = (box.high - box.low).maxCoeff();
  const double most = error ? *error * (box.high - box.low).norm() : extent / extent_parts;
  double step = is_step(reader.step()) ? reader.step() : 0;
  for (const double off : {most, farthest / float_steps})
    if (off > std::numeric_limits<double>::min()) step = std::max(step, step_within(off));
  return step > 0 ? step : 1;  // all is at 0
}

double film_uv_step(const EvolvingReader& reader, const EvolvingMesh& connectivity) {
  double farthest = 1;
  for (const EvolvingSegment& segment : connectivity.segments)
    for (const Vector2& uv : segment.uvs) farthest = std::max(farthest, uv.cwiseAbs().maxCoeff());
  return std::max({reader.uv_step(), least_uv_step, std::exp2(std::ceil(std::log2(farthest / float_steps)))});
}

void put_number(Bytes& bytes, std::uint64_t value) {
  for (; value >= 128; value >>= 7) bytes.push_back(std::byte(value | 128));
  bytes.push_back(std::byte(value));
}

/// Which colour each life has, and the segments' triangles by these.
class LifeRuns {
 public:
  void add(const std::vector<Lifespan>& lives) {
    for (std::size_t t = 0; t < lives.size();) {
      const std::pair<int, int> life(lives[t].first, lives[t].last);
      const std::size_t begin = t;
      while (t < lives.size() && lives[t].first == life.first && lives[t].last == life.second) ++t;
      put_number(runs_, t - begin);
      put_number(runs_, std::uint64_t(known_.try_emplace(life, int(known_.size())).first->second));
    }
  }

  Bytes bytes(const LifeColour& colour, int frame_count) const {
    std::vector<std::pair<int, int>> lives(known_.size());
    for (const auto& [life, place] : known_) lives[std::size_t(place)] = life;
    Bytes bytes;
    put_number(bytes, lives.size());
    for (const auto& [first, last] : lives)
      for (const float c : colour(first, last, frame_count))
        put_number(bytes, std::uint64_t(std::lround(255 * std::clamp(c, 0.0F, 1.0F))));
    bytes.insert(bytes.end(), runs_.begin(), runs_.end());
    return bytes;
  }

 private:
  std::map<std::pair<int, int>, int> known_;
  Bytes runs_;
};

void append(Film& film, const StorePiece& piece) {
  film.manifest += piece.line;
  if (piece.begins_group) film.blocks.emplace_back();
  film.blocks.back().insert(film.blocks.back().end(), piece.block.begin(), piece.block.end());
}

}  // namespace

Film make_film(const EvolvingReader& reader, const std::vector<int>& frames, const LifeColour& colour,
               const FilmOptions& options, const Progress& progress) {
  require(!frames.empty(), "a film wants one frame at least");
  EvolvingMesh connectivity;
  for (int s = 0; s < int(reader.segments().size()); ++s)
    connectivity.segments.push_back(reader.segment(s));
  for (const StoredFrame& frame : reader.frames())
    connectivity.frames.push_back({frame.number, frame.segment, {}});
  const auto lives = coordinate_lifespans(connectivity);

  FilmBox box;
  const Progress measuring = progress.step("measure", 0.2), packing = progress.step("pack", 0.8);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    box.add(reader, frames[i]);
    measuring.at(double(i + 1) / double(frames.size()));
  }

  StoreCoder coder(film_step(reader, box, options.error), film_uv_step(reader, connectivity), store_group_frames);
  Film film{.manifest = coder.head(options.blocks_name, "{}")};
  LifeRuns runs;
  OrderedJson numbers = OrderedJson::array(), segments = OrderedJson::array();
  for (std::size_t i = 0; i < frames.size();) {
    const int s = reader.frames()[std::size_t(frames[i])].segment;
    const EvolvingSegment& segment = connectivity.segments[std::size_t(s)];
    append(film, coder.add_segment(segment));
    runs.add(lives[std::size_t(s)]);
    const std::size_t first = i;
    for (; i < frames.size() && reader.frames()[std::size_t(frames[i])].segment == s; ++i) {
      const int number = reader.frames()[std::size_t(frames[i])].number;
      for (const StorePiece& piece : coder.add_frame(number, reader.positions(frames[i]), {})) append(film, piece);
      numbers.push_back(number);
      packing.at(double(i + 1) / double(frames.size()));
    }
    segments.push_back({{"first", first},
                        {"frames", i - first},
                        {"vertices", segment.vertex_count()},
                        {"triangles", segment.triangle_count()},
                        {"has_uvs", !segment.uvs.empty()}});
  }
  film.lives = runs.bytes(colour, int(reader.frames().size()));
  const auto corner = [](const Vector3& p) { return OrderedJson{p.x(), p.y(), p.z()}; };
  film.description = OrderedJson{
      {"frames", numbers},
      {"low", corner(box.low)},
      {"high", corner(box.high)},
      {"segments",
       segments}}.dump();
  return film;
}

}  // namespace mq
