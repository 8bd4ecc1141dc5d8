#include "mq/model/field_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <complex>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/fem/texel_vector_space.h"
#include "mq/io/image_file.h"
#include "mq/io/tiles.h"
#include "mq/model/outputs.h"

namespace mq {
namespace {

/// 1, or −1 in charts seen from behind, where y grows the other way round x.
double upward(const Atlas& atlas, int chart) { return chart >= 0 && atlas.charts[std::size_t(chart)].mirrored ? -1 : 1; }

/// Whether blue says lengths: it is black all over in flow maps.
char has_lengths(const Image<float>& map) {
  for (int y = 0; y < map.height() && map.channels() > 2; ++y)
    for (int x = 0; x < map.width(); ++x)
      if (map(x, y, 2) > 0) return 1;
  return 0;
}

/// The vector of a pixel; what is black is no direction of length √2 but the ground that something was painted on.
std::complex<double> decoded_vector(std::span<const float> pixel, char lengths) {
  constexpr double least = 1.0 / 64, most = 1.2;
  const std::complex<double> vector(2.0 * pixel[0] - 1, 2.0 * pixel[1] - 1);
  const double length = std::abs(vector);
  if (length < least || length > most) return 0;
  return lengths ? double(pixel[2]) / length * vector : vector;
}

}  // namespace

FieldMap field_map(const TexturedModel& model, const ModelSignal& signal, const ModelField& field) {
  require(signal.texel_space() != nullptr, "a map of a field has texels, and the model has no texture coordinates");
  const TexelSpace& space = *signal.texel_space();
  const Atlas& atlas = *signal.texel_atlas();
  const TexelVectorSpace vectors(model.surface, atlas, space);
  const Vector z = field.texels.size() > 0 ? field.texels : vectors.from_triangles(field.field);
  const std::vector<std::complex<double>> rightward = vectors.rightward();
  FieldMap map{Signal(space.size(), 3), 0};
  parallel_for(space.size(), [&](std::int64_t i) {
    const std::complex<double> vector = std::conj(rightward[std::size_t(i)]) * std::complex<double>(z[2 * i], z[2 * i + 1]);
    const double length = std::abs(vector);
    const int chart = space.texels().chart[std::size_t(i)];
    if (length > 1e-9)
      map.values.row(i) << 0.5 + 0.5 * vector.real() / length, 0.5 + 0.5 * upward(atlas, chart) * vector.imag() / length,
          length;
    else
      map.values.row(i) << 0.5, 0.5, 0;
  });
  for (Eigen::Index i = 0; i < space.size(); ++i) map.beyond += z.segment<2>(2 * i).norm() > 1 + 1e-6;
  return map;
}

std::vector<std::filesystem::path> map_files(const TexturedModel& model, const std::filesystem::path& file) {
  const std::size_t count = model.texture_sizes.size();
  if (count <= 1 && file.string().find("%s") == std::string::npos) return {file};
  if (count > 1 && file.string().find("%s") == std::string::npos && !tile_name(file.string()))
    throw InvalidInput(fmt::format("{}: is one map, and the model has {} textures: put %s in its name, which stands for each "
                                   "texture's own, or <UDIM> for the number of its tile, as when they are written",
                                   file.string(), count));
  return Outputs(file.string(), model.model, Outputs::Kind::pictures).paths();
}

ModelField field_of_map(const TexturedModel& model, const ModelSignal& signal, const std::filesystem::path& file) {
  require(signal.texel_space() != nullptr, file.string() + ": is a map of a field, which texels show; there are none");
  const TexelSpace& space = *signal.texel_space();
  const Atlas& atlas = *signal.texel_atlas();
  std::vector<Image<float>> maps;
  std::vector<char> lengths;
  for (const std::filesystem::path& path : map_files(model, file)) {
    const Image<float>& map = maps.emplace_back(read_texture(path).pixels);
    if (map.channels() < 2)
      throw IoError(fmt::format("{}: has one channel; a map of a field has its direction in red and green", path.string()));
    lengths.push_back(has_lengths(map));
  }
  const TexelVectorSpace vectors(model.surface, atlas, space);
  const std::vector<std::complex<double>> rightward = vectors.rightward();
  ModelField field{{}, Vector(2 * Eigen::Index(space.size())), {}};
  parallel_for(space.size(), [&](std::int64_t i) {
    const Texels::Place& place = space.texels().places[std::size_t(i)];
    const TextureSize& size = model.texture_sizes[std::size_t(place.texture)];
    const Image<float>& map = maps[std::size_t(place.texture)];
    const auto pixel_of = [](int texel, int texels, int pixels) {
      return std::min(int((texel + 0.5) * pixels / texels), pixels - 1);
    };
    std::complex<double> vector =
        decoded_vector(map.pixel(pixel_of(place.x, size.width, map.width()), pixel_of(place.y, size.height, map.height())),
                       lengths[std::size_t(place.texture)]);
    if (upward(atlas, space.texels().chart[std::size_t(i)]) < 0) vector = std::conj(vector);
    vector *= rightward[std::size_t(i)];
    field.texels[2 * i] = vector.real();
    field.texels[2 * i + 1] = vector.imag();
  });
  field.field = vectors.on_triangles(field.texels);
  return field;
}

}  // namespace mq
