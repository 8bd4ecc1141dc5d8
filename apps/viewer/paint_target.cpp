#include "paint_target.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <mutex>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/fem/surface_ball.h"
#include "mq/io/image_file.h"
#include "mq/io/picture_check.h"
#include "mq/mesh/closest_point.h"

namespace mq::view {
namespace {

namespace fs = std::filesystem;

class PaintedTextures : public PaintTarget {
 public:
  PaintedTextures(Session& session, app::Run& run, const Progress& progress)
      : session_(session),
        target_(app::make_texture_signal(run, *session.scene, {}, progress)),
        ball_(target_->space()),
        closest_(session.scene->surface.mesh) {}

  std::string unknowns() const override { return "texels"; }
  const ModelSignal& target() const override { return *target_; }
  Vector3 place(int unknown) const override { return texels().position(unknown); }
  Outputs::Kind kind() const override { return Outputs::Kind::pictures; }

  std::vector<int> reach(const Vector3& place, double radius) override {
    const ClosestPoint at = closest_(place);
    if (session_.scene->atlas->chart[std::size_t(at.triangle)] < 0) return {};
    return ball_.reach(at.triangle, at.barycentric, place, radius);
  }

  LiveModulation live(double weight, const Signal& before, const LiveOptions& options,
                      const Progress& progress) const override {
    return {target_->space(), weight, before, options, progress};
  }

  void show(const ShownSignal& values, std::optional<std::span<const int>> some) override {
    const auto lock = session_.after->lock();
    if (some)
      session_.after->change(texels(), *some, values);
    else
      session_.after->change(texels(), values);
  }

  void require_mask_name(const fs::path& file, bool smooths) const override {
    const std::string extension = lower_extension(file);
    const bool floats = extension == ".tif" || extension == ".tiff" || extension == ".exr";
    require(!smooths || floats,
            fmt::format("{}: where it smooths the mask is below 0, which wants floating point: "
                        "name a .exr or a .tif",
                        file.string()));
    require(
        floats || extension == ".png",
        fmt::format("{}: a mask wants 16 bits and no loss: name a .png or a .tif", file.string()));
  }

  void write_mask(std::span<const int> mask, int full, bool smooths,
                  const std::vector<fs::path>& files) const override {
    std::vector<Image<float>> pictures;
    for (const TextureSize& size : session_.scene->texture_sizes)
      pictures.emplace_back(size.width, size.height, 1);
    for (int k = 0; k < texels().size(); ++k) {
      const Texels::Place& at = texels().places[std::size_t(k)];
      pictures[std::size_t(at.texture)](at.x, at.y) = float(mask[std::size_t(k)]) / float(full);
    }
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      const bool floats = smooths || lower_extension(files[i]) == ".exr";
      write_image(files[i], pictures[i], floats ? Depth::f32 : Depth::u16);
    }
  }

 private:
  const Texels& texels() const { return target_->space().texels(); }

  Session& session_;
  std::unique_ptr<TextureSignal> target_;
  SurfaceBall ball_;
  ClosestPointFinder closest_;
};

class PaintedVertices : public PaintTarget {
 public:
  explicit PaintedVertices(Session& session)
      : session_(session),
        scene_(*session.scene),
        target_(scene_),
        ball_(target_.space(), scene_.surface.mesh.positions),
        closest_(scene_.surface.mesh) {
    std::vector<int> parts(std::size_t(scene_.model.mesh.vertex_count()), 0);
    for (int u = 0; u < scene_.surface.mesh.vertex_count(); ++u) ++parts[std::size_t(source(u))];
    for (int u = 0; u < scene_.surface.mesh.vertex_count(); ++u)
      if (parts[std::size_t(source(u))] > 1) parted_[source(u)].push_back(u);
  }

  std::string unknowns() const override { return "vertices"; }
  const ModelSignal& target() const override { return target_; }
  Vector3 place(int unknown) const override {
    return scene_.surface.mesh.positions[std::size_t(unknown)];
  }
  Outputs::Kind kind() const override { return Outputs::Kind::model; }

  /// With the other parts of vertices that the surface was parted at: a file has one mask for all.
  std::vector<int> reach(const Vector3& place, double radius) override {
    std::vector<int> found = ball_.reach(closest_(place).triangle, place, radius);
    const std::size_t count = found.size();
    for (std::size_t i = 0; i < count && !parted_.empty(); ++i)
      if (const auto at = parted_.find(source(found[i])); at != parted_.end())
        found.insert(found.end(), at->second.begin(), at->second.end());
    std::ranges::sort(found);
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
  }

  LiveModulation live(double weight, const Signal& before, const LiveOptions& options,
                      const Progress& progress) const override {
    return {target_.space(), weight, before, options, progress};
  }

  /// What is as it was keeps the bits of the file, copies of a vertex their own.
  void show(const ShownSignal& values, std::optional<std::span<const int>>) override {
    auto colours = std::make_shared<VertexSignal>(scene_.model.colors);
    const int channels = colours->channels;
    parallel_for(scene_.model.mesh.vertex_count(), [&](std::int64_t v) {
      const int unknown = scene_.surface.vertex_from_source[std::size_t(v)];
      if (unknown < 0) return;
      for (int c = 0; c < channels; ++c)
        if (const double now = values(unknown, c); now != values.before(unknown, c))
          colours->values[std::size_t(v) * std::size_t(channels) + std::size_t(c)] = float(now);
    });
    const std::lock_guard lock(mutex_);
    shown_ = std::move(colours);
  }

  void present() override {
    std::shared_ptr<const VertexSignal> shown;
    {
      const std::lock_guard lock(mutex_);
      shown = std::move(shown_);
    }
    if (shown) session_.show(nullptr, std::move(shown));
  }

  void require_mask_name(const fs::path& file, bool) const override {
    require(lower_extension(file) == ".ply",
            fmt::format("{}: a mask at vertices is a model's colours, with 16 bits or more: name a "
                        ".ply",
                        file.string()));
  }

  void write_mask(std::span<const int> mask, int full, bool smooths,
                  const std::vector<fs::path>& files) const override {
    Model model;
    model.mesh.positions = scene_.model.mesh.positions;
    model.mesh.triangles = scene_.model.mesh.triangles;
    model.colors = {3, {}, smooths ? Depth::f32 : Depth::u16};
    for (int v = 0; v < model.mesh.vertex_count(); ++v) {
      const int unknown = scene_.surface.vertex_from_source[std::size_t(v)];
      const float value = unknown < 0 ? 0 : float(mask[std::size_t(unknown)]) / float(full);
      model.colors.values.insert(model.colors.values.end(), 3, value);
    }
    write_model(files.front(), model, {});
  }

 private:
  int source(int unknown) const { return scene_.surface.source_from_vertex[std::size_t(unknown)]; }

  Session& session_;
  const TexturedModel& scene_;
  VertexColourSignal target_;
  VertexBall ball_;
  ClosestPointFinder closest_;
  std::map<int, std::vector<int>> parted_;  ///< vertices of the file that are several unknowns
  std::mutex mutex_;
  std::shared_ptr<const VertexSignal> shown_;  ///< guarded; not presented yet
};

}  // namespace

bool can_be_painted(const Session& session) {
  return session.before || (!session.scene->atlas && session.scene->model.colors.channels > 0);
}

std::unique_ptr<PaintTarget> make_paint_target(Session& session, app::Run& run,
                                               const Progress& progress) {
  if (session.before) return std::make_unique<PaintedTextures>(session, run, progress);
  return std::make_unique<PaintedVertices>(session);
}

}  // namespace mq::view
