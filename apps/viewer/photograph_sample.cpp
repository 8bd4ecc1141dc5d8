#include "photograph_sample.h"

#include <fmt/format.h>

#include <iterator>
#include <vector>

#include "mq/draw/pinhole.h"
#include "mq/io/cameras.h"
#include "mq/io/image_file.h"
#include "mq/model/model_picture.h"

namespace mq::view {
namespace {

/// From where, and how bright beside the texture.
struct Shot {
  double azimuth, elevation;  ///< degrees
  float exposure;
};

constexpr Shot shots[] = {{0, 10, 1.F},    {60, 20, 0.8F},  {120, 5, 0.95F},
                          {180, 15, 0.75F}, {240, 5, 0.9F}, {300, 25, 0.7F}};

}  // namespace

std::filesystem::path make_photographs(const TexturedModel& model, const std::filesystem::path& folder,
                                       const Progress& progress) {
  std::filesystem::create_directories(folder);
  const ModelRenderer renderer(model);
  std::vector<Photograph> photographs;
  for (const Shot& shot : shots) {
    ModelPictureOptions options;
    options.render.light = RenderOptions::Light::none;
    options.render.view.azimuth = shot.azimuth;
    options.render.view.elevation = shot.elevation;
    Image<float> picture = renderer.draw(options, {}, progress.step("photograph", 1.0 / double(std::size(shots))));
    for (float& value : picture.values()) value *= shot.exposure;
    const std::string name = fmt::format("photograph_{}.png", photographs.size());
    write_image(folder / name, picture);
    const Camera camera(model.surface.mesh, options.render.view, picture.width(), picture.height());
    photographs.push_back({name, pinhole_of(camera)});
  }
  const std::filesystem::path cameras = folder / "cameras.json";
  write_cameras(cameras, photographs, CameraFormat::json);
  return cameras;
}

}  // namespace mq::view
