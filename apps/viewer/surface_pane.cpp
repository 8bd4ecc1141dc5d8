#include "surface_pane.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <compare>
#include <map>
#include <memory>
#include <numeric>

#include "mq/base/parallel.h"
#include "mq/draw/corner_normals.h"
#include "mq/draw/render.h"
#include "mq/draw/samples.h"
#include "mq/mesh/geometry.h"
#include "shaders.h"

namespace mq::view {
namespace {

constexpr float tint = 0.4F;  // of charts, over what is shown

/// As a file of 8 bits holds it.
std::uint8_t byte(float value) {
  return std::uint8_t(std::lround(std::clamp(double(value), 0.0, 1.0) * 255));
}

/// The value that 99 of 100 do not exceed.
float high_of(std::vector<float> values) {
  std::erase_if(values, [](float v) { return !std::isfinite(v); });
  if (values.empty()) return 1;
  const auto at = values.begin() + std::ptrdiff_t(double(values.size() - 1) * 0.99);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

const Eigen::Vector4f seam_colour(1.F, 0.45F, 0.05F, 1.F), end_colour(0.25F, 0.65F, 1.F, 1.F);

/// The branches that a picture takes in the shaders of textures.
struct Branches {
  Look::Paint paint;
  bool textured, lit, wires, wipes, light, tinted, repeats;
  auto operator<=>(const Branches&) const = default;

  std::string fragment(const char* rest) const {
    return fmt::format(
                 "#version 330 core\n#define PAINT {}\n#define TEXTURED {}\n#define LIT {}\n#define WIRES {}\n"
                       "#define WIPES {}\n#define LIGHT {}\n#define TINTED {}\n#define REPEATS {}\n",
                       int(paint), textured, lit, wires, wipes, light, tinted, repeats) +
           shaders::lookups + rest;
  }
};

/// The programs of both panes, each compiled once.
class PaneShaders {
 public:
  Shader atlas_tint{shaders::tint_vertex, shaders::tint_fragment};
  Shader plain{shaders::whole_vertex, shaders::backdrop_fragment};

  const Shader& surface(const Branches& branches) {
    return compiled(surfaces_, branches, shaders::surface_vertex, shaders::surface_fragment);
  }
  const Shader& atlas(const Branches& branches) {
    return compiled(atlases_, branches, shaders::whole_vertex, shaders::atlas_fragment);
  }

 private:
  using Compiled = std::map<Branches, std::unique_ptr<const Shader>>;
  static const Shader& compiled(Compiled& all, const Branches& branches, const char* vertex, const char* fragment) {
    std::unique_ptr<const Shader>& shader = all[branches];
    if (!shader) shader = std::make_unique<const Shader>(vertex, branches.fragment(fragment));
    return *shader;
  }
  Compiled surfaces_, atlases_;
};

/// Of the one context there is, whose end is theirs.
PaneShaders& pane_shaders() {
  static thread_local PaneShaders* shaders = new PaneShaders();
  return *shaders;
}

}  // namespace

DrawnModel::DrawnModel(const TexturedModel& scene, const Progress& progress) {
  const Mesh& mesh = scene.surface.mesh;
  const Box box = bounding_box(mesh);
  middle = (box.low + box.high) / 2;
  radius = std::max(box.diagonal() / 2, 1e-30);
  for (int t = 0; t < scene.surface.triangle_count(); ++t)
    if (scene.surface.degenerate[std::size_t(t)] == 0) order.push_back(t);
  std::ranges::stable_sort(order, {}, [&](int t) { return mesh.texture(t); });
  for (std::size_t i = 0; i < order.size(); ++i) {
    const int texture = mesh.texture(order[i]);
    if (groups.empty() || groups.back().texture != texture)
      groups.push_back({texture, int(3 * i), 0});
    groups.back().count += 3;
  }
  find_metrics(scene);
  progress.at(0.3);
  find_corners(scene);
  progress.at(0.7);
  find_lines(scene);
  progress.at(1);
}

void DrawnModel::find_metrics(const TexturedModel& scene) {
  const int count = scene.surface.triangle_count();
  stretch.assign(std::size_t(count), 1);
  density.assign(std::size_t(count), 0);
  if (!scene.atlas) return;
  const double mean = scene.atlas->surface_area / std::max(scene.atlas->texel_area, 1e-300);
  parallel_for(count, [&](std::int64_t t) {
    if (scene.atlas->chart[std::size_t(t)] < 0) return;
    const TexelMetric metric = texel_metric(scene.surface, *scene.atlas, int(t));
    stretch[std::size_t(t)] = float(metric.stretch);
    density[std::size_t(t)] = float(std::log2(metric.density / mean));
  });
  stretch_high = high_of(stretch);
  std::vector<float> sizes = density;
  for (float& size : sizes) size = std::abs(size);
  density_high = high_of(std::move(sizes));
}

void DrawnModel::find_corners(const TexturedModel& scene) {
  const Mesh& mesh = scene.surface.mesh;
  const std::vector<Eigen::Vector3f> normals = corner_normals(mesh);
  corners.resize(order.size() * 3);
  parallel_for(std::ssize(order), [&](std::int64_t i) {
    const int t = order[std::size_t(i)];
    for (int k = 0; k < 3; ++k) {
      Corner& corner = corners[std::size_t(3 * i + k)];
      corner.position = (mesh.position(t, k) - middle).cast<float>();
      corner.normal = normals[std::size_t(3 * t + k)];
      corner.texel.setZero();
      if (scene.atlas && scene.atlas->chart[std::size_t(t)] >= 0) {
        const TexelPoint& at = scene.atlas->corners[std::size_t(t)][std::size_t(k)];
        corner.texel = {float(at.column()), float(at.row())};
      }
    }
  });
}

void DrawnModel::find_lines(const TexturedModel& scene) {
  const Surface& surface = scene.surface;
  const auto place = [&](HalfEdge h) {
    const TexelPoint& p = scene.atlas->corners[std::size_t(h / 3)][std::size_t(h % 3)];
    return Eigen::Vector3f(float(p.column()), float(p.row()), 0);
  };
  for (const int t : order)
    for (HalfEdge h = 3 * t; h < 3 * t + 3; ++h) {
      const int twin = surface.twins[std::size_t(h)];
      const bool charted = scene.atlas && scene.atlas->chart[std::size_t(t)] >= 0;
      const EdgeKind kind = charted ? scene.atlas->edges[std::size_t(h)] : EdgeKind::inside;
      const auto add = [&](Ends& lines) {
        lines.push_back((surface.mesh.position(t, h % 3) - middle).cast<float>());
        lines.push_back((surface.mesh.position(t, next(h) % 3) - middle).cast<float>());
      };
      if (charted && kind == EdgeKind::seam && h < twin) add(seams);
      if (charted ? kind == EdgeKind::boundary : twin < 0) add(ends);
      if (!charted) continue;
      auto& lines = kind == EdgeKind::inside ? atlas_wires : atlas_seams;
      if (kind == EdgeKind::inside && h > twin && twin >= 0) continue;
      lines[surface.mesh.texture(t)].push_back(place(h));
      lines[surface.mesh.texture(t)].push_back(place(next(h)));
    }
}

ModelPictures::ModelPictures(const TexturedModel& scene, DrawnModel model)
    : scene_(scene), model_(std::move(model)) {
  using Corner = DrawnModel::Corner;
  none_.allocate(1, 1, Picture::Kind::bytes);
  corners_.fill(std::span<const Corner>(model_.corners));
  triangles_.attribute(0, corners_, {3, GL_FLOAT, sizeof(Corner), offsetof(Corner, position)});
  triangles_.attribute(1, corners_, {3, GL_FLOAT, sizeof(Corner), offsetof(Corner, normal)});
  triangles_.attribute(2, corners_, {2, GL_FLOAT, sizeof(Corner), offsetof(Corner, texel)});
  seams_.fill(model_.seams);
  ends_.fill(model_.ends);
  const auto fill = [](auto& all, const auto& found) {
    for (const auto& [texture, points] : found) {
      all[texture] = std::make_unique<Lines>();
      all[texture]->fill(points);
    }
  };
  fill(atlas_seams_, model_.atlas_seams);
  fill(atlas_wires_, model_.atlas_wires);
  // The graphics card has them now.
  model_.corners = {};
  model_.seams = {}, model_.ends = {};
  model_.atlas_seams.clear(), model_.atlas_wires.clear();
}

FalseColour ModelPictures::scale_of(const Look& look, const TextureSet* textures) const {
  FalseColour scale = look.scale;
  if (!look.automatic_scale) return scale;
  if (look.paint == Look::Paint::stretch) {
    scale.map = FalseColour::Map::sequential;
    scale.low = 1, scale.high = std::max(1.1F, model_.stretch_high);
  } else if (look.paint == Look::Paint::density) {
    scale.map = FalseColour::Map::diverging;
    scale.high = std::max(0.1F, model_.density_high), scale.low = -scale.high;
  } else if (textures != nullptr) {
    const auto [low, high] = textures->range(look.channel);
    scale.low = low, scale.high = high;
  }
  return scale;
}

/// Of vertices two sets, for both sides of the wipe.
void ModelPictures::paint_with(const Shown& shown) {
  const Look::Paint paint = shown.look.paint;
  const Painted now{paint, {shown.scale.low, shown.scale.high}, shown.colours};
  if (painted_ == now) return;
  const bool has_before = painted_ && painted_->paint == paint && painted_->colours;
  painted_ = now;
  const VertexSignal& own = scene_.model.colors;
  const auto fill = [&](int attribute, Buffer& buffer, const VertexSignal& at_vertices) {
    const std::vector<std::uint8_t> colours = colours_of(paint, shown.scale, at_vertices);
    buffer.fill(std::span<const std::uint8_t>(colours));
    triangles_.attribute(attribute, buffer, {4, GL_UNSIGNED_BYTE, 4, 0});
  };
  fill(3, colours_, shown.colours ? *shown.colours : own);
  if (paint == Look::Paint::vertex_colours && shown.colours) {
    if (!has_before) fill(4, colours_before_, own);  // which stay while a brush changes the others
  } else {
    triangles_.attribute(4, colours_, {4, GL_UNSIGNED_BYTE, 4, 0});
  }
}

/// Colours of the triangles, three corners each; alpha 0 where there is no chart.
std::vector<std::uint8_t> ModelPictures::colours_of(Look::Paint paint, const FalseColour& scale,
                                                    const VertexSignal& at_vertices) const {
  std::vector<std::uint8_t> colours(model_.order.size() * 12);
  parallel_for(std::ssize(model_.order), [&](std::int64_t i) {
    const int t = model_.order[std::size_t(i)];
    const int chart = scene_.atlas ? scene_.atlas->chart[std::size_t(t)] : -1;
    for (int k = 0; k < 3; ++k) {
      Colour colour = {0.8F, 0.79F, 0.765F};
      const bool lives = paint == Look::Paint::lifespans && !model_.triangle_colours.empty();
      if (lives) colour = model_.triangle_colours[std::size_t(t)];
      if (paint == Look::Paint::stretch)
        colour = false_colour(model_.stretch[std::size_t(t)], scale);
      if (paint == Look::Paint::density)
        colour = false_colour(model_.density[std::size_t(t)], scale);
      if (paint == Look::Paint::vertex_colours && at_vertices.channels > 0) {
        const int v = scene_.surface.source_from_vertex[std::size_t(
            scene_.surface.mesh.triangles[std::size_t(t)][std::size_t(k)])];
        for (int c = 0; c < 3; ++c)
          colour[std::size_t(c)] = at_vertices.values[std::size_t(v) * at_vertices.channels +
                                                      (at_vertices.channels < 3 ? 0 : c)];
      } else if (chart >= 0 && !lives && paint != Look::Paint::vertex_colours &&
                 paint != Look::Paint::stretch && paint != Look::Paint::density) {
        colour = chart_colour(chart);
      }
      std::uint8_t* const out = &colours[std::size_t(12 * i + 4 * k)];
      for (int c = 0; c < 3; ++c) out[c] = byte(colour[std::size_t(c)]);
      out[3] = chart >= 0 ? 255 : 0;
    }
  });
  return colours;
}

void ModelPictures::show_scale(const FalseColour& scale) {
  const std::vector<double> now = {double(scale.map), scale.low, scale.high};
  if (now == shown_scale_) return;
  shown_scale_ = now;
  Image<float> colours(1024, 1, 3);
  for (int i = 0; i < 1024; ++i)
    std::ranges::copy(false_colour(scale.low + (scale.high - scale.low) * i / 1023, scale),
                      colours.pixel(i, 0).begin());
  colours_of_scale_.show(colours);
}

void ModelPictures::draw_backdrop(int width, int height) {
  if (backdrop_.width() != width || backdrop_.height() != height) {
    Image<float> picture(width, height, 3);
    const Backdrop backdrop;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        std::ranges::copy(backdrop.at(x, y, width, height), picture.pixel(x, y).begin());
    backdrop_.show(picture);
  }
  pane_shaders().plain.use();
  backdrop_.bind(0);
  pane_shaders().plain.set("picture", 0);
  nothing_.bind();
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

namespace {

struct BothTextures {
  const TextureSet *before, *after;  ///< null: there are none
};

/// What is shown of a texture of the model.
BothTextures textures_of(const ModelPictures::Shown& shown, int texture) {
  const TextureSet* const before = shown.before != nullptr ? shown.before : shown.after;
  const TextureSet* const after = shown.after != nullptr ? shown.after : shown.before;
  if (before == nullptr || texture < 0 || texture >= std::min(before->size(), after->size())) return {};
  return {before, after};
}

Branches branches_of(const ModelPictures::Shown& shown, int texture, const TexturedModel& scene) {
  const BothTextures both = textures_of(shown, texture);
  const bool there = both.before != nullptr;
  return {.paint = shown.look.paint,
          .textured = there,
          .lit = shown.look.lit,
          .wires = shown.look.wires,
          .wipes = shown.look.wipe >= 0,
          .light = there && (both.before->holds_light(texture) || both.after->holds_light(texture)),
          .tinted = shown.look.chart_tint,
          .repeats = scene.atlas && there && scene.atlas->textures[std::size_t(texture)].wrap == Wrap::repeat};
}

/// What both panes say of textures and numbers.
void set_values(const Shader& shader, const ModelPictures::Shown& shown, int texture,
                const Picture& none, const Picture& scale) {
  const auto [before, after] = textures_of(shown, texture);
  const bool there = before != nullptr;
  (there ? before->picture(texture) : none).bind(0);
  (there ? after->picture(texture) : none).bind(1);
  scale.bind(2);
  shader.set("before", 0);
  shader.set("after", 1);
  shader.set("scale_colours", 2);
  shader.set("scale_range", Eigen::Vector2f(float(shown.scale.low), float(shown.scale.high)));
  shader.set("isolines", shown.scale.isolines);
  const auto both = [&](const auto& value) {
    return there ? Eigen::Vector2f(float(value(*before)), float(value(*after)))
                 : Eigen::Vector2f(0, 0);
  };
  shader.set("channels", both([&](const TextureSet& set) { return set.channels(texture); }));
  shader.set("light_values", both([&](const TextureSet& set) { return set.holds_light(texture); }));
  shader.set("channel", std::min(shown.look.channel, 3));
  shader.set("exposure", float(std::exp2(shown.look.exposure)));
}

/// What holds of the surface, whatever its textures are.
void set_view(const Shader& shader, const Eigen::Matrix4f& clip, const Turntable& camera, const Vector3& middle,
              const Look& look, int width) {
  shader.set("clip", clip);
  shader.set("chart_tint", look.chart_tint ? tint : 0.F);
  shader.set("eye", Eigen::Vector3f((camera.eye() - middle).cast<float>()));
  shader.set("up", Eigen::Vector3f(camera.up().cast<float>()));
  const Vector3 key = -0.5 * camera.right() + 0.65 * camera.up() + 0.57 * camera.backward();
  shader.set("key_light", Eigen::Vector3f(key.normalized().cast<float>()));
  shader.set("wires", look.wires ? 1.F : 0.F);
  shader.set("wipe", look.wipe < 0 ? -1.F : float(look.wipe * width));
}

}  // namespace

void ModelPictures::draw_surface(const Turntable& camera, const Shown& shown,
                                 const Canvas& canvas) {
  const int width = canvas.width(), height = canvas.height();
  paint_with(shown);
  show_scale(shown.scale);
  canvas.begin();
  glClear(GL_DEPTH_BUFFER_BIT);
  glDisable(GL_DEPTH_TEST);
  draw_backdrop(width, height);
  glEnable(GL_DEPTH_TEST);
  const Eigen::Matrix4f clip = camera.clip(model_.middle, model_.radius);
  for (const DrawnModel::Group& group : model_.groups) {
    const Shader& shader = pane_shaders().surface(branches_of(shown, group.texture, scene_));
    shader.use();
    set_view(shader, clip, camera, model_.middle, shown.look, width);
    set_values(shader, shown, group.texture, none_, colours_of_scale_);
    triangles_.bind();
    glDrawArrays(GL_TRIANGLES, group.first, group.count);
  }
  if (shown.look.seams) {
    glDepthMask(GL_FALSE);
    const Eigen::Vector2f viewport{float(width), float(height)};
    ends_.draw({clip, viewport, end_colour, 2, 1e-3F});
    seams_.draw({clip, viewport, seam_colour, 2, 1e-3F});
    glDepthMask(GL_TRUE);
  }
  glDisable(GL_DEPTH_TEST);
  canvas.resolve();
}

void ModelPictures::draw_atlas(const AtlasView& view, const Shown& shown, const Canvas& canvas) {
  const float width = float(canvas.width()), height = float(canvas.height());
  paint_with(shown);
  show_scale(shown.scale);
  canvas.begin();
  glDisable(GL_DEPTH_TEST);
  if (!scene_.atlas) {
    draw_backdrop(canvas.width(), canvas.height());
    canvas.resolve();
    return;
  }
  const TextureSize& size = scene_.atlas->textures[std::size_t(view.texture)];
  const Eigen::Vector2f corner{float(view.column), float(view.row)};
  const Shader& shader = pane_shaders().atlas(branches_of(shown, view.texture, scene_));
  shader.use();
  set_values(shader, shown, view.texture, none_, colours_of_scale_);
  shader.set("corner", corner);
  shader.set("size", Eigen::Vector2f(float(size.width), float(size.height)));
  shader.set("zoom", float(view.zoom));
  shader.set("height", height);
  shader.set("wipe", shown.look.wipe < 0 ? -1.F : float(shown.look.wipe * width));
  nothing_.bind();
  glDrawArrays(GL_TRIANGLES, 0, 3);

  using enum Look::Paint;
  const Look::Paint paint = shown.look.paint;
  const bool painted =
      paint == charts || paint == stretch || paint == density || paint == lifespans;
  if (painted || shown.look.chart_tint) {
    glEnable(GL_BLEND);
    glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    pane_shaders().atlas_tint.use();
    pane_shaders().atlas_tint.set("corner", corner);
    pane_shaders().atlas_tint.set("pane", Eigen::Vector2f(width, height));
    pane_shaders().atlas_tint.set("zoom", float(view.zoom));
    pane_shaders().atlas_tint.set("strength", painted ? 1.F : tint);
    triangles_.bind();
    for (const DrawnModel::Group& group : model_.groups)
      if (group.texture == view.texture) glDrawArrays(GL_TRIANGLES, group.first, group.count);
    glDisable(GL_BLEND);
  }
  Eigen::Matrix4f clip = Eigen::Matrix4f::Identity();
  clip(0, 0) = 2 * float(view.zoom) / width;
  clip(1, 1) = -2 * float(view.zoom) / height;
  clip(0, 3) = -corner.x() * clip(0, 0) - 1;
  clip(1, 3) = -corner.y() * clip(1, 1) + 1;
  const auto draw = [&](const auto& lines, const Eigen::Vector4f& colour, float pixels) {
    const auto found = lines.find(view.texture);
    if (found != lines.end()) found->second->draw({clip, {width, height}, colour, pixels, 0});
  };
  if (shown.look.wires) draw(atlas_wires_, {0.05F, 0.05F, 0.07F, 0.4F}, 1);
  if (shown.look.seams) draw(atlas_seams_, seam_colour, 1.5F);
  canvas.resolve();
}

}  // namespace mq::view
