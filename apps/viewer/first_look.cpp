// A look has as many cubes along the model's diagonal as a pane has pixels for a few of each: more is not seen before
// the model itself is there.
#include "first_look.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

#include "mq/base/parallel.h"
#include "mq/image/colour.h"
#include "mq/io/image_file.h"
#include "mq/mesh/geometry.h"

namespace mq::view {
namespace {

constexpr int cubes_per_diagonal = 200;
constexpr int few_triangles = 100'000;       // are shown as they are
constexpr std::int64_t most_samples = 200'000;  // of the texture, for the colours
constexpr int picture_side = 1024;
constexpr Colour clay = {0.8F, 0.79F, 0.765F};

float displayed(float value, const Texture& texture) {
  return float(std::clamp(holds_light(texture.format) ? srgb_from_linear(double(value)) : double(value), 0.0, 1.0));
}

Colour texel(const Texture& texture, int x, int y) {
  const Image<float>& pixels = texture.pixels;
  Colour colour;
  for (int c = 0; c < 3; ++c) colour[std::size_t(c)] = displayed(pixels(x, y, pixels.channels() < 3 ? 0 : c), texture);
  return colour;
}

/// Of a texture that repeats.
Colour colour_at(const Texture& texture, const Vector2& uv) {
  const auto place = [](double at, int size) { return std::min(int((at - std::floor(at)) * size), size - 1); };
  if (!std::isfinite(uv.x()) || !std::isfinite(uv.y())) return clay;
  return texel(texture, place(uv.x(), texture.pixels.width()), place(1 - uv.y(), texture.pixels.height()));
}

/// Means of four texels of each block.
Image<float> few_texels(const Texture& texture) {
  const Image<float>& pixels = texture.pixels;
  const int block = (std::max(pixels.width(), pixels.height()) + picture_side - 1) / picture_side;
  Image<float> few(std::max(1, pixels.width() / block), std::max(1, pixels.height() / block), 3);
  parallel_for(few.height(), [&](std::int64_t y) {
    for (int x = 0; x < few.width(); ++x)
      for (const int down : {block / 4, 3 * block / 4})
        for (const int right : {block / 4, 3 * block / 4}) {
          const Colour one = texel(texture, std::min(x * block + right, pixels.width() - 1),
                                   std::min(int(y) * block + down, pixels.height() - 1));
          for (int c = 0; c < 3; ++c) few(x, int(y), c) += one[std::size_t(c)] / 4;
        }
  }, 16);
  return few;
}

/// Sums of colours at the vertices of a look.
struct Sums {
  std::vector<Colour> colours;
  std::vector<float> counts;

  explicit Sums(std::size_t size) : colours(size, Colour{0, 0, 0}), counts(size, 0) {}
  void add(int vertex, const Colour& colour) {
    for (std::size_t c = 0; c < 3; ++c) colours[std::size_t(vertex)][c] += colour[c];
    ++counts[std::size_t(vertex)];
  }
  std::vector<float> means() const {
    std::vector<float> values;
    values.reserve(3 * colours.size());
    for (std::size_t v = 0; v < colours.size(); ++v)
      for (std::size_t c = 0; c < 3; ++c) values.push_back(counts[v] > 0 ? colours[v][c] / counts[v] : clay[c]);
    return values;
  }
};

bool has_picture(const Model& model, int texture) {
  return texture >= 0 && std::size_t(texture) < model.textures.size() &&
         !model.textures[std::size_t(texture)].pixels.empty();
}

/// Whether all corners are those of vertices and coordinates that are there, which who reads on will tell.
bool is_whole(const Mesh& mesh) {
  const auto within = [](const std::vector<Triangle>& triangles, int least, int end) {
    return std::ranges::all_of(triangles, [&](const Triangle& t) {
      return std::ranges::all_of(t, [&](int i) { return i >= least && i < end; });
    });
  };
  const bool finite = std::ranges::all_of(mesh.positions, [](const Vector3& p) { return p.allFinite(); });
  return finite && mesh.triangle_count() > 0 && within(mesh.triangles, 0, mesh.vertex_count()) &&
         within(mesh.corner_uvs, -1, int(mesh.uvs.size()));
}

/// Colours of the model's vertices, or of its textures; none where it has neither.
std::vector<float> colours_of(const Model& model, const std::vector<int>& joined, std::size_t count) {
  const Mesh& mesh = model.mesh;
  Sums sums(count);
  const bool textured = mesh.has_uvs() && has_picture(model, 0);
  if (!textured && model.colors.channels == 0) return {};
  if (!textured) {
    const int channels = model.colors.channels;
    for (int v = 0; v < mesh.vertex_count(); ++v) {
      const float* const values = &model.colors.values[std::size_t(v) * std::size_t(channels)];
      sums.add(joined[std::size_t(v)], {values[0], values[channels < 3 ? 0 : 1], values[channels < 3 ? 0 : 2]});
    }
    return sums.means();
  }
  const auto sample = [&](int t, int k) {
    const int texture = mesh.texture(t);
    if (has_picture(model, texture) && mesh.textured(t))
      sums.add(joined[std::size_t(mesh.triangles[std::size_t(t)][std::size_t(k)])],
               colour_at(model.textures[std::size_t(texture)], mesh.uv(t, k)));
  };
  const std::int64_t step = std::max<std::int64_t>(1, 3 * std::int64_t(mesh.triangle_count()) / most_samples);
  for (std::int64_t t = 0; t < mesh.triangle_count(); t += step)
    for (int k = 0; k < 3; ++k) sample(int(t), k);
  for (int t = 0; t < mesh.triangle_count(); ++t)  // those that were left out
    for (int k = 0; k < 3; ++k)
      if (sums.counts[std::size_t(joined[std::size_t(mesh.triangles[std::size_t(t)][std::size_t(k)])])] == 0) sample(t, k);
  return sums.means();
}

}  // namespace

void FirstLooks::join_vertices(const Mesh& mesh) {
  joined_.resize(std::size_t(mesh.vertex_count()));
  if (mesh.triangle_count() <= few_triangles) {
    for (std::size_t v = 0; v < joined_.size(); ++v) joined_[v] = int(v);
    few_.positions = mesh.positions;
    few_.triangles = mesh.triangles;
    return;
  }
  const Box box = bounding_box(mesh);
  const double side = std::max(box.diagonal() / cubes_per_diagonal, 1e-300);
  std::unordered_map<std::int64_t, int> vertex_of;
  std::vector<int> members;
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    std::int64_t cube = 0;
    for (int i = 0; i < 3; ++i) {
      const double at = (mesh.positions[std::size_t(v)][i] - box.low[i]) / side;
      cube = cube * (cubes_per_diagonal + 3) + std::int64_t(std::clamp(at, -1.0, cubes_per_diagonal + 1.0)) + 1;
    }
    const auto [found, is_new] = vertex_of.try_emplace(cube, int(few_.positions.size()));
    if (is_new) {
      few_.positions.push_back(Vector3::Zero());
      members.push_back(0);
    }
    joined_[std::size_t(v)] = found->second;
    few_.positions[std::size_t(found->second)] += mesh.positions[std::size_t(v)];
    ++members[std::size_t(found->second)];
  }
  for (std::size_t v = 0; v < members.size(); ++v) few_.positions[v] /= members[v];
  for (const Triangle& t : mesh.triangles) {
    const Triangle now = {joined_[std::size_t(t[0])], joined_[std::size_t(t[1])], joined_[std::size_t(t[2])]};
    if (now[0] != now[1] && now[1] != now[2] && now[2] != now[0]) few_.triangles.push_back(now);
  }
}

std::unique_ptr<FirstLook> FirstLooks::operator()(const Model& model) {
  if (joined_.empty() && !is_whole(model.mesh)) return nullptr;
  if (joined_.empty()) join_vertices(model.mesh);
  if (few_.triangles.empty()) return nullptr;
  auto look = std::make_unique<FirstLook>();
  look->triangles = model.mesh.triangle_count();
  look->has_uvs = model.mesh.has_uvs();
  Model& few = look->scene.model;
  few.path = model.path;
  few.mesh = few_;
  few.colors = {3, colours_of(model, joined_, few_.positions.size())};
  look->coloured = !few.colors.values.empty();
  if (!look->coloured) few.colors = {};
  if (has_picture(model, 0)) look->picture = few_texels(model.textures.front());
  if (surface_.mesh.triangles.empty()) surface_ = make_surface(few_, {WeldOptions::Kind::none});
  look->scene.surface = surface_;
  look->drawn = std::make_unique<DrawnModel>(look->scene);
  return look;
}

}  // namespace mq::view
