#include "field.h"

#include "mq/base/error.h"

namespace mq::app {
namespace {

void put_pictures(const Scene& scene, const TexelDomain& domain, const Signal& values, Depth depth,
                  Model& model) {
  std::vector<Image<float>> pictures;
  for (const TextureSize& size : scene.texture_sizes)
    pictures.emplace_back(size.width, size.height, int(values.cols()));
  domain.put(values, pictures);
  model.textures.resize(pictures.size());
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    model.textures[i].pixels = std::move(pictures[i]);
    model.textures[i].format = {
        .depth = depth, .file_format = model.textures[i].format.file_format, .tags = nullptr};
  }
}

void put_colours(const Scene& scene, const Signal& values, Depth depth, Model& model) {
  VertexSignal& colors = model.colors;
  colors.channels = int(values.cols());
  colors.depth = depth;
  colors.values.assign(std::size_t(model.mesh.vertex_count()) * colors.channels, 0.0F);
  for (int v = 0; v < model.mesh.vertex_count(); ++v) {
    const int unknown = scene.surface.vertex_from_source[std::size_t(v)];
    if (unknown < 0) continue;
    for (int c = 0; c < colors.channels; ++c)
      colors.values[std::size_t(v) * colors.channels + c] = float(values(unknown, c));
  }
}

}  // namespace

bool works_at_vertices(const OptionValues& options, const Scene& scene) {
  return options.flag("vertices") || !scene.atlas;
}

bool holds_numbers(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  return extension == ".exr" || extension == ".tif" || extension == ".tiff";
}

std::unique_ptr<Domain> make_domain(Run& run, const Scene& scene, const Progress& progress,
                                    TexelDomain::SharedTexels shared) {
  std::unique_ptr<Domain> domain;
  about(scene.model, [&] {
    if (works_at_vertices(run.options(), scene))
      domain = std::make_unique<VertexDomain>(scene);
    else
      domain = std::make_unique<TexelDomain>(run, scene, TexelSpaceOptions{}, progress, shared);
  });
  return domain;
}

void put_field(const Scene& scene, const Domain& domain, const Signal& values, Depth depth,
               Model& model) {
  if (const auto* texels = dynamic_cast<const TexelDomain*>(&domain))
    put_pictures(scene, *texels, values, depth, model);
  else
    put_colours(scene, values, depth, model);
}

}  // namespace mq::app
