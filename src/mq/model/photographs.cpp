#include "mq/model/photographs.h"

#include <fmt/format.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "mq/base/words.h"
#include "mq/filter/modulation.h"
#include "mq/image/colour.h"
#include "mq/io/image_file.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

/// Takes the last channel out of a picture.
Image<float> split_alpha(Texture& texture) {
  Image<float>& pixels = texture.pixels;
  Image<float> alpha(pixels.width(), pixels.height(), 1);
  Image<float> rest(pixels.width(), pixels.height(), pixels.channels() - 1);
  for (int y = 0; y < pixels.height(); ++y)
    for (int x = 0; x < pixels.width(); ++x) {
      alpha(x, y) = pixels.pixel(x, y).back();
      std::copy_n(pixels.pixel(x, y).begin(), rest.channels(), rest.pixel(x, y).begin());
    }
  pixels = std::move(rest);
  return alpha;
}

/// The colours of a picture as `wanted` stores them, display values or light.
void restore(Texture& picture, TransferFunction wanted) {
  const TransferFunction found = transfer(picture);
  if (found == wanted) return;
  picture.pixels =
      encode(decode(picture.pixels, ColourSpace::linear, found), ColourSpace::linear, wanted);
}

bool works_on_stored(const TextureSignal& signal) {
  return signal.value_space().space == ColourSpace::stored;
}

}  // namespace

TransferFunction common_transfer(const Model& model) {
  for (std::size_t i = 1; i < model.textures.size(); ++i)
    require(
        transfer(model.textures[i]) == transfer(model.textures[0]),
        fmt::format("{} and {} do not store colours alike (light in floating point, display values "
                    "otherwise), so a photograph cannot fit both: choose {} linear or log",
                    texture_file(model, 0), texture_file(model, i), option_name("space")));
  return transfer(model.textures.at(0));
}

Partial partial_of_textures(const TexturedModel& model, const TextureSignal& signal,
                            std::vector<Texture> textures,
                            std::span<const Image<float>> confidence) {
  require(textures.size() == model.texture_sizes.size() &&
              (confidence.empty() || confidence.size() == textures.size()),
          fmt::format("a photograph of {} for a model of {}: give one each, and as many of "
                      "confidence",
                      counted(std::ssize(textures), "picture"),
                      counted(std::ssize(model.texture_sizes), "texture")));
  std::vector<Image<float>> shown;
  for (std::size_t i = 0; i < textures.size(); ++i) {
    require(
        !confidence.empty() || has_alpha(textures[i].pixels.channels()),
        fmt::format("{}: {}: has no alpha channel to tell what it shows; give {} pictures",
                    textures[i].path.string(), option_name("partial"), option_name("confidence")));
    Image<float> alpha;
    const bool surplus = textures[i].pixels.channels() == signal.channels() + 1;
    if (has_alpha(textures[i].pixels.channels()) && (confidence.empty() || surplus))
      alpha = split_alpha(textures[i]);
    if (works_on_stored(signal)) restore(textures[i], transfer(model.model.textures[i]));
    shown.push_back(confidence.empty() ? std::move(alpha) : confidence[i]);
  }
  return {signal.values_of(textures),
          mask_of_pictures(signal.space().texels(), model.texture_sizes, shown)};
}

std::string remark_on_size(const Photograph& photograph, const PinholeCamera& fitted) {
  const PinholeCamera& camera = photograph.camera;
  if (fitted.width == camera.width && fitted.height == camera.height) return {};
  return fmt::format(
      "{}: is {} × {}, and its camera is of pictures of {} × {}: it is taken for the same picture at another size",
      photograph.picture.string(), fitted.width, fitted.height, camera.width, camera.height);
}

bool axes_seem_exchanged(const Mesh& mesh, std::span<const PinholeCamera> cameras) {
  constexpr int most_places = 1000;
  const int step = 1 + mesh.vertex_count() / most_places;
  // How many have most of it in their pictures.
  const auto count = [&](const Eigen::Matrix3d& turn) {
    return std::ranges::count_if(cameras, [&](const PinholeCamera& camera) {
      int in = 0, all = 0;
      for (int v = 0; v < mesh.vertex_count(); v += step)
        ++all, in += camera.project(turn * mesh.positions[std::size_t(v)]).has_value();
      return 2 * in > all;
    });
  };
  Eigen::Matrix3d z_from_y;
  z_from_y << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  const auto turned = std::max(count(z_from_y), count(z_from_y.transpose()));
  return turned > count(Eigen::Matrix3d::Identity()) && 2 * turned >= std::ssize(cameras);
}

void add_missing_pictures(TexturedModel& model) {
  std::vector<Texture>& textures = model.model.textures;
  textures.resize(std::max(textures.size(), model.texture_sizes.size()));
  for (std::size_t k = 0; k < model.texture_sizes.size(); ++k) {
    if (!textures[k].pixels.empty()) continue;
    textures[k].pixels =
        Image<float>(model.texture_sizes[k].width, model.texture_sizes[k].height, 3);
    textures[k].format.file_format = "png";
  }
}

int side_for_photographs(const Surface& surface, std::span<const Photograph> photographs, double occupancy) {
  struct Seen {
    double pixel;  ///< model units
    double area;
  };
  std::vector<Seen> seen;
  double all = 0;
  for (int t = 0; t < int(surface.mesh.triangles.size()); ++t) {
    const Mesh& mesh = surface.mesh;
    const Vector3 a = mesh.position(t, 0), b = mesh.position(t, 1), c = mesh.position(t, 2);
    const Vector3 normal = (b - a).cross(c - a), middle = (a + b + c) / 3;
    double pixel = 0;
    for (const Photograph& photograph : photographs) {
      const PinholeCamera& camera = photograph.camera;
      if (!(normal.dot(camera.center() - middle) > 0) || !camera.project(middle)) continue;
      const double size = (camera.rotation * middle + camera.translation).z() / camera.fx;
      if (pixel == 0 || size < pixel) pixel = size;
    }
    if (pixel > 0) seen.push_back({pixel, normal.norm() / 2});
    if (pixel > 0) all += normal.norm() / 2;
  }
  constexpr int least = 256, most = 8192, usual = 1024;
  if (!(all > 0)) return usual;
  std::ranges::sort(seen, {}, &Seen::pixel);
  double below = 0, pixel = seen.back().pixel;
  for (const Seen& one : seen) {
    below += one.area;
    if (below >= all / 2) {
      pixel = one.pixel;
      break;
    }
  }
  const double side = std::sqrt(surface.area / occupancy) / pixel;
  const double nearest = std::exp2(std::round(std::log2(std::clamp(side, 1.0, 1e6))));
  return std::clamp(int(nearest), least, most);
}

}  // namespace mq
