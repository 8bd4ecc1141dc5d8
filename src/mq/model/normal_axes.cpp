#include "mq/model/normal_axes.h"

#include <algorithm>
#include <cmath>

#include "mq/io/document.h"
#include "mq/io/normals.h"

namespace mq {
namespace {

/// Normals within 60° of an axis.
constexpr float upright_above = 0.5F;
/// In a map in tangent space at least so many are.
constexpr double mostly = 0.9;

bool is_gltf(const Model& model) {
  return model.document && model.document->is_gltf();
}

template <class Vectors>
bool any_known(const Vectors& vectors) {
  return std::ranges::any_of(vectors, [](const auto& v) { return !v.isZero(0); });
}

}  // namespace

NormalMapShares normal_map_shares(const TexturedModel& model, std::span<const Coverage> coverage) {
  std::int64_t all = 0, upright = 0, below = 0, far_off = 0;
  float bluest = 0;
  for (std::size_t i = 0; i < coverage.size() && i < model.model.textures.size(); ++i) {
    const Image<float>& pixels = model.model.textures[i].pixels;
    if (pixels.channels() < 3) continue;
    for (int y = 0; y < pixels.height(); ++y)
      for (int x = 0; x < pixels.width(); ++x) {
        if (coverage[i].triangle(x, y) < 0) continue;
        const auto pixel = pixels.pixel(x, y);
        const Vector3 n(2 * double(pixel[0]) - 1, 2 * double(pixel[1]) - 1, 2 * double(pixel[2]) - 1);
        ++all;
        upright += n.z() > upright_above;
        below += n.z() < 0;
        far_off += std::abs(n.norm() - 1) > 0.25;
        bluest = std::max(bluest, pixel[2]);
      }
  }
  if (all == 0) return {};
  const auto share = [&](std::int64_t count) { return double(count) / double(all); };
  return {share(upright), share(below), share(far_off), bluest <= 1.0F / 255};
}

NormalAxes found_axes(const TexturedModel& model, NormalAxes asked, const NormalMapShares& shares) {
  if (asked != NormalAxes::as_found) return asked;
  const bool by_format = is_gltf(model.model) && !model.model.textures.empty() &&
                         model.model.textures.front().meaning == TextureMeaning::normals;
  return by_format || shares.upright >= mostly ? NormalAxes::tangent : NormalAxes::object;
}

bool charts_overlap(std::span<const Coverage> coverage) {
  constexpr double few = 1e-3;  // of their texels
  std::int64_t covered = 0;
  for (const Coverage& picture : coverage)
    for (const int triangle : picture.triangle.values()) covered += triangle >= 0;
  return double(overlapping_texels(coverage)) > few * double(covered);
}

ShadingFrames::ShadingFrames(const TexturedModel& model, NormalAxes axes)
    : up_(axes == NormalAxes::tangent_down ? -1 : 1) {
  CornerFrames given = file_frames(model.model);
  source_ = any_known(given.normals) ? "normals of the file, " : "computed normals, ";
  source_ += any_known(given.tangents) ? "tangents of the file" : "tangents as MikkTSpace has them";
  frames_ = tangent_frames(model.model.mesh, std::move(given));
}

TangentFrame ShadingFrames::at(const SurfacePoint& point) const {
  TangentFrame frame = frame_at(frames_, point);
  frame.bitangent *= up_;
  return frame;
}

}  // namespace mq
