#include "mq/io/film.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <tuple>

#include "mq/base/error.h"

namespace mq {
namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr double most_coordinate = 65535;
constexpr double farthest_drawn = 1e18;  // graphics cards multiply lengths in floats, to 3.4e38

void append_u32(Bytes& bytes, std::uint32_t value) {
  for (int k = 0; k < 4; ++k) bytes.push_back(std::byte(value >> (8 * k)));
}

Bytes deflated(const Bytes& bytes) {
  uLongf size = compressBound(uLong(bytes.size()));
  Bytes result(size);
  const int status = compress2(reinterpret_cast<Bytef*>(result.data()), &size,
                               reinterpret_cast<const Bytef*>(bytes.data()), uLong(bytes.size()),
                               Z_BEST_COMPRESSION);
  if (status != Z_OK) throw IoError(fmt::format("zlib: compress2 ended with status {}", status));
  result.resize(size);
  return result;
}

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

/// The vertices of a segment as a graphics card wants them: once for each pair of texture
/// coordinates and colour.
struct Points {
  std::vector<int> vertices, uvs;  ///< of each point; -1: no texture coordinates
  std::vector<std::array<float, 3>> colours;
  std::vector<Triangle> triangles;
  std::vector<std::array<int, 2>> edges;  ///< of charts, each once
};

Points points_of(const EvolvingSegment& segment, const std::vector<Lifespan>& lives,
                 const LifeColour& colour, int frame_count) {
  Points result;
  std::map<std::tuple<int, int, int, int>, int> known;
  for (int t = 0; t < segment.triangle_count(); ++t) {
    const Lifespan& life = lives[t];
    Triangle& corners = result.triangles.emplace_back();
    for (int k = 0; k < 3; ++k) {
      const int vertex = segment.triangles[t][k];
      const int uv = segment.corner_uvs.empty() ? -1 : segment.corner_uvs[t][k];
      const auto [place, is_new] =
          known.try_emplace({vertex, uv, life.first, life.last}, int(result.vertices.size()));
      if (is_new) {
        result.vertices.push_back(vertex);
        result.uvs.push_back(uv);
        result.colours.push_back(colour(life.first, life.last, frame_count));
      }
      corners[k] = place->second;
    }
  }
  // An edge between two points that has one triangle is that of a chart; both of its sides are one
  // line on the surface.
  std::map<std::array<int, 2>, int> sides;
  for (const Triangle& triangle : result.triangles)
    for (int k = 0; k < 3; ++k) {
      const int a = triangle[k], b = triangle[(k + 1) % 3];
      ++sides[{std::min(a, b), std::max(a, b)}];
    }
  std::map<std::array<int, 2>, bool> drawn;
  for (const auto& [points, count] : sides) {
    if (count > 1) continue;
    const int a = result.vertices[points[0]], b = result.vertices[points[1]];
    if (drawn.try_emplace({std::min(a, b), std::max(a, b)}, true).second)
      result.edges.push_back(points);
  }
  return result;
}

class FilmBlock {
 public:
  FilmBlock(const EvolvingSegment& segment, const Points& points, const FilmBox& box) : box_(box) {
    for (const int vertex : points.vertices) append_u32(bytes_, std::uint32_t(vertex));
    if (!segment.uvs.empty())
      for (const int uv : points.uvs)
        for (int k = 0; k < 2; ++k)
          append_u32(bytes_,
                     std::bit_cast<std::uint32_t>(uv < 0 ? 0.0F : float(segment.uvs[uv][k])));
    for (const auto& colour : points.colours)
      for (const float c : colour)
        bytes_.push_back(std::byte(std::lround(255 * std::clamp(c, 0.0F, 1.0F))));
    for (const Triangle& triangle : points.triangles)
      for (const int point : triangle) append_u32(bytes_, std::uint32_t(point));
    for (const auto& edge : points.edges)
      for (const int point : edge) append_u32(bytes_, std::uint32_t(point));
    before_.assign(3 * std::size_t(segment.vertex_count()), 0);
  }

  void add_frame(const std::vector<Vector3>& positions) {
    std::vector<std::uint16_t> folded;
    for (int k = 0; k < 3; ++k) {
      const double extent = box_.high[k] - box_.low[k];
      for (const Vector3& p : positions) {
        std::uint16_t& before = before_[folded.size()];
        const auto now = std::uint16_t(
            extent > 0 ? std::lround((p[k] - box_.low[k]) / extent * most_coordinate) : 0);
        const auto step = std::int16_t(now - before);
        folded.push_back(std::uint16_t((step << 1) ^ (step >> 15)));
        before = now;
      }
    }
    for (const int shift : {0, 8})
      for (const std::uint16_t value : folded) bytes_.push_back(std::byte(value >> shift));
  }

  Bytes finish() const { return deflated(bytes_); }

 private:
  const FilmBox& box_;
  Bytes bytes_;
  std::vector<std::uint16_t> before_;
};

}  // namespace

Film make_film(const EvolvingReader& reader, const std::vector<int>& frames,
               const LifeColour& colour, const Progress& progress) {
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

  Film film;
  OrderedJson numbers = OrderedJson::array(), segments = OrderedJson::array();
  for (std::size_t i = 0; i < frames.size();) {
    const int s = reader.frames()[frames[i]].segment;
    const EvolvingSegment& segment = connectivity.segments[s];
    const Points points = points_of(segment, lives[s], colour, int(reader.frames().size()));
    FilmBlock block(segment, points, box);
    const std::size_t first = i;
    for (; i < frames.size() && reader.frames()[frames[i]].segment == s; ++i) {
      block.add_frame(reader.positions(frames[i]));
      numbers.push_back(reader.frames()[frames[i]].number);
      packing.at(double(i + 1) / double(frames.size()));
    }
    film.blocks.push_back(block.finish());
    segments.push_back({{"first", first},
                        {"frames", i - first},
                        {"vertices", segment.vertex_count()},
                        {"points", points.vertices.size()},
                        {"triangles", points.triangles.size()},
                        {"edges", points.edges.size()},
                        {"has_uvs", !segment.uvs.empty()}});
  }
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
