#include "mq/model/stroke_wishes.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "mq/atlas/triangle_map.h"
#include "mq/atlas/triangles_at.h"
#include "mq/base/error.h"
#include "mq/mesh/closest_point.h"

namespace mq {
namespace {

constexpr double most_samples = 1e6;  // of a piece of a stroke

/// visit(share) at the middles of equal pieces of a length.
template <class Visit>
void for_each_sample(double length, double spacing, const Visit& visit) {
  const int count = int(std::clamp(std::ceil(length / spacing), 1.0, most_samples));
  for (int i = 0; i < count; ++i) visit((i + 0.5) / count);
}

class WishesAlong {
 public:
  WishesAlong(const TexturedModel& model, const Atlas* atlas, double spacing)
      : model_(model), atlas_(atlas), spacing_(spacing) {}

  void add(const FieldStroke& stroke) {
    const std::size_t before = wishes.size();
    if (stroke.uvs.empty())
      add_in_space(stroke);
    else
      add_in_texture(stroke);
    require(wishes.size() > before, stroke.place + ": lies nowhere on the textured surface: uv are from 0 to 1 as the model has them, (0, 0) is the lower left");
  }

  std::vector<WishedVector> wishes;

 private:
  void add_in_space(const FieldStroke& stroke) {
    if (!finder_) finder_.emplace(model_.surface.mesh);
    std::vector<Vector3> points, ways;
    std::vector<std::size_t> pieces;
    for (std::size_t i = 0; i + 1 < stroke.points.size(); ++i) {
      const Vector3 way = stroke.points[i + 1] - stroke.points[i];
      const double length = way.norm();
      if (!(length > 0)) continue;
      for_each_sample(length, spacing_, [&](double share) {
        points.push_back(stroke.points[i] + share * way);
        ways.push_back(stroke.strength / length * way);
        pieces.push_back(i);
      });
    }
    require(!points.empty(), stroke.place + ": all its points are one, and so it has no direction: wanted two that differ");
    const double far = 0.1 * std::sqrt(model_.surface.area);
    const std::vector<ClosestPoint> found = (*finder_)(points);
    for (std::size_t k = 0; k < found.size(); ++k) {
      const ClosestPoint& at = found[k];
      if (at.squared_distance > far * far)
        throw InvalidInput(fmt::format("{}: after point {} (the first is 0) it lies {:.3g} from the surface, wanted less than "
                                       "{:.3g}: is it of another model, or in other units?",
                                       stroke.place, pieces[k], std::sqrt(at.squared_distance), far));
      if (atlas_ && atlas_->chart[std::size_t(at.triangle)] < 0) continue;
      if (!model_.surface.degenerate[std::size_t(at.triangle)]) wishes.push_back({at, ways[k], 1});
    }
  }

  void add_in_texture(const FieldStroke& stroke) {
    const Atlas* const atlas = model_.atlas ? &*model_.atlas : nullptr;
    require(atlas != nullptr, stroke.place + ": is in a texture, and the model has no texture coordinates");
    const std::size_t textures = atlas->textures.size();
    if (std::size_t(stroke.texture) >= textures)
      throw InvalidInput(fmt::format("{}: texture: found {}, wanted one of {}, from 0", stroke.place, stroke.texture, textures));
    if (!triangles_) triangles_.emplace(model_.surface.mesh, *atlas);
    const TextureSize& size = atlas->textures[std::size_t(stroke.texture)];
    for (std::size_t i = 0; i + 1 < stroke.uvs.size(); ++i) {
      const Vector2 turn = stroke.uvs[i + 1] - stroke.uvs[i];
      const Vector2 way(turn.x() * size.width, -turn.y() * size.height);  // texels, down
      if (!(way.norm() > 0)) continue;
      for_each_sample(way.norm(), 0.5, [&](double share) {
        const Vector2 uv = stroke.uvs[i] + share * turn;
        const TrianglesAt::Found at = (*triangles_)(stroke.texture, texel_point(uv, size.width, size.height));
        if (at.triangle < 0) return;
        const Vector3 along = TriangleMap(model_.surface, *atlas, at.triangle).way(way);
        if (const double length = along.norm(); length > 0 && std::isfinite(length))
          wishes.push_back({{at.triangle, at.barycentric}, stroke.strength / length * along, 1});
      });
    }
  }

  const TexturedModel& model_;
  const Atlas* atlas_;
  double spacing_;
  std::optional<ClosestPointFinder> finder_;
  std::optional<TrianglesAt> triangles_;
};

}  // namespace

std::vector<WishedVector> stroke_wishes(const TexturedModel& model, const Atlas* atlas,
                                        std::span<const FieldStroke> strokes, double spacing) {
  WishesAlong along(model, atlas, spacing);
  for (const FieldStroke& stroke : strokes) along.add(stroke);
  return std::move(along.wishes);
}

}  // namespace mq
