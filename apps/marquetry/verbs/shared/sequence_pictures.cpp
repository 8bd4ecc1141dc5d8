#include "verbs/shared/sequence_pictures.h"

#include "mq/base/error.h"
#include "mq/io/file_names.h"
#include "mq/io/image_file.h"
#include "mq/model/sequence_pictures.h"
#include "shell/results.h"
#include "verbs/shared/render_request.h"

namespace mq::app {
namespace {

constexpr const char* wanted_picture = "a picture: .png, .jpg, .webp, .tif, .exr, .bmp or .tga";

}  // namespace

void add_plot_option(OptionTable& table) {
  table.add({.name = "plot",
             .type = Option::Type::text,
             .accepts = [](const std::string& name) { return names_picture(name); },
             .wanted = wanted_picture,
             .metavar = "FILE",
             .group = "Pictures",
             .help = "draw distances, triangles, distortion and time over the frames"});
}

void add_sequence_picture_options(OptionTable& table) {
  add_plot_option(table);
  table.add({.name = "strip",
             .type = Option::Type::text,
             .accepts = [](const std::string& name) { return names_picture(name); },
             .wanted = wanted_picture,
             .metavar = "FILE",
             .group = "Pictures",
             .help = "draw some frames, what follows them, and how far it is from them",
             .details = "In the colours of the first frame, or of places in it where it has none; "
                        "grey where it was added later."});
}

std::vector<std::filesystem::path> sequence_picture_paths(const OptionValues& options) {
  std::vector<std::filesystem::path> paths;
  for (const char* name : {"plot", "strip"})
    if (options.has(name)) paths.emplace_back(options.text(name));
  return paths;
}

void write_plot(const Run& run, const std::vector<FollowedFrame>& frames) {
  if (!run.options().has("plot")) return;
  const Image<float> plot = frames.empty() ? Image<float>() : sequence_plot(frames);
  require(!plot.empty(), "--plot: nothing was measured of these frames; follow them anew");
  write_image(run.options().text("plot"), plot);
}

void write_strip(const Run& run, const EvolvingReader& reader,
                 const std::function<Model(int frame)>& captured, const Progress& progress) {
  if (!run.options().has("strip")) return;
  write_image(run.options().text("strip"),
              sequence_strip(reader, captured, parse_view(run.options().text("view")), progress));
}

}  // namespace mq::app
