#include "textures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "mq/base/error.h"
#include "mq/base/memory.h"
#include "mq/io/image_file.h"
#include "mq/io/slots.h"
#include "mq/model/part_values.h"
#include "options/model_options.h"
#include "options/signal_options.h"
#include "options/solver_options.h"
#include "shell/results.h"

namespace mq::shared {

using app::Json;
using app::Run;
using app::Step;

namespace {

/// Up to this weight, in areas, constants are as well determined as all else (see `ScreenedPoisson`).
constexpr double largest_weight = 0.01;

Texture read_picture_of(const Run& run, const Texture& texture, const Progress& progress) {
  const OptionValues& options = run.options();
  const std::string layer = options.has("layer") ? options.text("layer") : "";
  Texture picture = read_texture(texture.path, progress, NotFinite::keep, layer);
  picture.meaning = texture.meaning;
  picture.name = texture.name;
  return picture;
}

/// A texel that changed, as it is sent to the process that writes its picture.
struct SentTexel {
  int texture, x, y;
};

/// Of what processes have of each picture, all where it is written.
std::vector<TexelValues> gather_texels(const Processes& processes, const std::vector<int>& writer, std::size_t channels,
                                       const std::function<TexelValues(int texture)>& of_texture) {
  const auto count = std::size_t(processes.count());
  std::vector<std::vector<SentTexel>> texels(count);
  std::vector<std::vector<float>> values(count);
  for (std::size_t k = 0; k < writer.size(); ++k) {
    const TexelValues here = of_texture(int(k));
    for (std::size_t n = 0; n < here.places.size(); ++n) {
      const Texels::Place& at = here.places[n];
      texels[std::size_t(writer[k])].push_back({int(k), at.x, at.y});
      for (std::size_t c = 0; c < channels; ++c)
        values[std::size_t(writer[k])].push_back(float(here.values(Eigen::Index(n), Eigen::Index(c))));
    }
  }
  const auto from = processes.exchange(texels);
  const auto their_values = processes.exchange(values);
  std::vector<TexelValues> all(writer.size());
  std::vector<Eigen::Index> rows(writer.size(), 0);
  for (const auto& part_of : from)
    for (const SentTexel& texel : part_of) ++rows[std::size_t(texel.texture)];
  for (std::size_t k = 0; k < all.size(); ++k) all[k].values.resize(rows[k], Eigen::Index(channels));
  for (std::size_t p = 0; p < count; ++p)
    for (std::size_t n = 0; n < from[p].size(); ++n) {
      TexelValues& to = all[std::size_t(from[p][n].texture)];
      const auto row = Eigen::Index(to.places.size());
      to.places.push_back({from[p][n].texture, from[p][n].x, from[p][n].y});
      for (std::size_t c = 0; c < channels; ++c)
        to.values(row, Eigen::Index(c)) = double(their_values[p][n * channels + c]);
    }
  return all;
}

}  // namespace

std::vector<int> writers(const Processes& processes, const TexelPart& part, std::size_t textures) {
  const auto count = std::size_t(processes.count());
  std::vector<double> texels(textures * count, 0);
  for (const int i : part.own())
    texels[std::size_t(part.places()[std::size_t(i)].texture) * count + std::size_t(processes.rank())] += 1;
  processes.sum(texels);
  std::vector<int> writer;
  for (std::size_t k = 0; k < textures; ++k) {
    const auto first = texels.begin() + std::ptrdiff_t(k * count);
    const auto most = std::max_element(first, first + std::ptrdiff_t(count));
    writer.push_back(int(most - first));
  }
  return writer;
}

std::string not_yet(const std::string& verb) {
  return "marquetry-mpi does not work on that yet: marquetry " + verb + " does, on one machine";
}

TexturedModel read_scene(Run& run, const Processes& processes, const std::string& verb,
                         std::optional<Outputs>& outputs, const std::function<void(const OptionValues&)>& check) {
  TexturedModel scene;
  processes.together([&] {
    check(run.options());
    scene = app::read_usable_model(run, MissingPictures::by_head, 0.05);
    for (Texture& texture : scene.model.textures) texture.format = picture_info(texture.path).format;
    const std::string file = scene.model.path.string();
    require(!scene.is_picture, file + ": is a picture; marquetry " + verb + " takes it, on one machine");
    require(scene.atlas.has_value(), file + ": has no texture coordinates, so no textures to work on; marquetry filter "
                                            "takes colours at vertices, on one machine");
    require(meaning_of_slot(scene.model.slot) != TextureMeaning::normals,
            fmt::format("{}: its pictures for {} are normals: {}", file, scene.model.slot, not_yet(verb)));
    outputs.emplace(run.options().text("output"), scene.model, Outputs::Kind::pictures);
    require(!outputs->is_model(),
            "--output: pictures are written, each by a process of its own: name a folder, such as out/, or with one "
            "texture a picture");
  });
  processes.in_turns([&] { run.will_write(outputs->paths(), outputs->folders()); });
  return scene;
}

std::unique_ptr<TexelPart> part_of(Run& run, const Processes& processes, const TexturedModel& scene,
                                   const TexelSpaceOptions& how) {
  return part_of(run, processes, scene, *scene.atlas, how);
}

std::unique_ptr<TexelPart> part_of(Run& run, const Processes& processes, const TexturedModel& scene, const Atlas& atlas,
                                   const TexelSpaceOptions& how) {
  std::unique_ptr<TexelPart> part;
  processes.together([&] {
    const Step step(run, "part", 0.1);
    about(scene.model, [&] {
      const Seams seams(scene.surface, atlas);
      const TexelBlocks blocks(scene.surface, atlas, seams, block_side(atlas, processes.count()));
      const BlockOwners owners{blocks, parted(blocks, processes.count())};
      part = std::make_unique<TexelPart>(scene.surface, atlas, seams, owners, processes.rank(), how, step);
    });
  });
  return part;
}

double checked_weight(const Processes& processes, const std::string& verb, const TexturedModel& scene,
                      const std::function<double(const SurfaceScale&)>& asked) {
  const SurfaceScale scale{scene.atlas->surface_area, scene.atlas->texel_spacing()};
  double weight = 0;
  processes.together([&] {
    weight = asked(scale);
    require(weight <= largest_weight * scale.area,
            fmt::format("the weight is {:g} of the area, which is a length of {:.0f} % of its root; marquetry-mpi "
                        "takes up to {:g} (--alpha {:g}): use marquetry {}, on one machine and with smaller textures, "
                        "for what is that smooth",
                        weight / scale.area, 100 * std::sqrt(weight / scale.area), largest_weight, largest_weight, verb));
  });
  return weight;
}

Signal read_values(Run& run, const Processes& processes, const TexturedModel& scene, const TexelPart& part) {
  const Step step(run, "read pictures", 0.15);
  const std::vector<Texture>& textures = scene.model.textures;
  int channels = 0;
  processes.together([&] {
    for (const Texture& texture : textures)
      channels = std::max(channels, int(picture_info(texture.path).channels.size()));
  });
  Signal values = Signal::Zero(Eigen::Index(part.places().size()), channels);
  processes.together([&] {
    for (std::size_t i = 0; i < textures.size(); ++i) {
      if (!part.has_texture(int(i))) continue;
      const Texture picture =
          read_picture_of(run, textures[i], step.progress().step(textures[i].name, 1 / double(textures.size())));
      take_values(part, int(i), scene.texture_sizes[i], picture, app::value_space(run.options()), values);
    }
  });
  return values;
}

std::unique_ptr<Numbering> numbered(const Processes& processes, const TexelPart& part, Signal& values) {
  std::unique_ptr<Numbering> numbering;
  processes.talking([&] {
    numbering = std::make_unique<Numbering>(processes, part);
    numbering->fill_halo(values);
  });
  return numbering;
}

std::int64_t count_own(const Processes& processes, const TexelPart& part, const std::vector<char>& marks) {
  double count = 0;
  for (const int i : part.own()) count += marks[std::size_t(i)];
  processes.sum({&count, 1});
  return std::int64_t(count);
}

Signal own_rows(const TexelPart& part, const Signal& all) {
  Signal own(std::ssize(part.own()), all.cols());
  for (std::size_t n = 0; n < part.own().size(); ++n) own.row(Eigen::Index(n)) = all.row(part.own()[n]);
  return own;
}

Signal with_own_changes(const TexelPart& part, Signal all, const Signal& change) {
  for (std::size_t n = 0; n < part.own().size(); ++n) all.row(part.own()[n]) += change.row(Eigen::Index(n));
  return all;
}

namespace {

/// Each process makes and writes its pictures.
void write_in_parts(Run& run, const Processes& processes, const TexturedModel& scene, const Outputs& outputs,
                    const std::vector<int>& writer, const Step& step,
                    const std::function<Texture(std::size_t texture)>& make) {
  std::vector<std::string> notes;
  processes.together([&] {
    for (std::size_t i = 0; i < scene.model.textures.size(); ++i) {
      if (writer[i] != processes.rank()) continue;
      std::ranges::copy(write_texture(outputs.paths()[i], make(i)), std::back_inserter(notes));
      step.progress().at(double(i + 1) / double(scene.model.textures.size()));
    }
  });
  for (const std::string& note : processes.gather_lines(notes)) run.terminal().remark(note);
  app::say_written(run, outputs.paths());
}

void write_pictures(Run& run, const Processes& processes, const TexturedModel& scene, const TexelPart& part,
                    const Outputs& outputs, const Signal& before, const Signal& after, const FinishPicture& finish) {
  const Step step(run, "write", 0.1);
  const std::vector<Texture>& textures = scene.model.textures;
  const std::vector<int> writer = writers(processes, part, textures.size());
  std::vector<TexelValues> changes;
  processes.talking([&] {
    changes = gather_texels(processes, writer, std::size_t(after.cols()),
                            [&](int k) { return changed_values(part, k, before, after); });
  });
  write_in_parts(run, processes, scene, outputs, writer, step, [&](std::size_t i) {
    Texture picture = read_picture_of(run, textures[i], {});
    put_values(changes[i], app::value_space(run.options()), picture);
    changes[i] = {};
    if (finish) finish(i, picture);
    if (const auto depth = app::asked_depth(run.options())) picture.format.depth = *depth;
    return picture;
  });
}

/// What the verb reports of the change, of all processes; rows are their own.
void report_change(Run& run, const Processes& processes, const Signal& before, const Signal& after) {
  const Json own = app::change_json(before, after, app::value_space(run.options()).space);
  const double values = double(before.size());
  double sums[] = {double(before.rows()), values, std::pow(own["rms_change"].get<double>(), 2) * values,
                   own["below_0"].get<double>(), own["above_1"].get<double>()};
  processes.sum(sums);
  const double count = std::max(1.0, sums[1]);
  run.result["unknowns"] = std::int64_t(sums[0]);
  run.result["channels"] = before.cols();
  run.result["rms_change"] = std::sqrt(sums[2] / count);
  run.result["largest_change"] = processes.largest(own["largest_change"].get<double>());
  run.result["below_0"] = std::int64_t(sums[3]);
  run.result["above_1"] = std::int64_t(sums[4]);
  run.result["beyond_percent"] = 100 * (sums[3] + sums[4]) / count;
}

/// Of each process what it had to do with.
void report_processes(Run& run, const Processes& processes, const TexturedModel& scene, const TexelPart& part) {
  int pictures = 0;
  for (std::size_t i = 0; i < scene.model.textures.size(); ++i) pictures += part.has_texture(int(i));
  const Json own{{"texels", part.own().size()},
                 {"halo", part.places().size() - part.own().size()},
                 {"pictures", pictures},
                 {"peak_bytes", peak_memory()}};
  run.result["processes"] = Json::array();
  for (const std::string& one : processes.gather(own.dump())) run.result["processes"].push_back(Json::parse(one));
}

}  // namespace

void write_result(Run& run, const Processes& processes, const TexturedModel& scene, const TexelPart& part,
                  const Outputs& outputs, const Signal& before, const Signal& after, const FinishPicture& finish) {
  report_change(run, processes, own_rows(part, before), own_rows(part, after));
  write_pictures(run, processes, scene, part, outputs, before, after, finish);
  report_processes(run, processes, scene, part);
}

void write_new_pictures(Run& run, const Processes& processes, const TexturedModel& scene, const TexelPart& part,
                        const Outputs& outputs, int channels, Depth depth,
                        const std::function<TexelValues(int texture)>& of_texture) {
  {
    const Step step(run, "write", 0.1);
    const std::vector<int> writer = writers(processes, part, scene.model.textures.size());
    std::vector<TexelValues> texels;
    processes.talking([&] { texels = gather_texels(processes, writer, std::size_t(channels), of_texture); });
    write_in_parts(run, processes, scene, outputs, writer, step, [&](std::size_t i) {
      const TextureSize& size = scene.texture_sizes[i];
      Texture picture = scene.model.textures[i];
      picture.pixels = Image<float>(size.width, size.height, channels);
      picture.format = {.depth = depth, .file_format = picture.format.file_format, .tags = nullptr};
      for (std::size_t n = 0; n < texels[i].places.size(); ++n) {
        const Texels::Place& at = texels[i].places[n];
        for (int c = 0; c < channels; ++c) picture.pixels(at.x, at.y, c) = float(texels[i].values(Eigen::Index(n), c));
      }
      texels[i] = {};
      return picture;
    });
  }
  report_processes(run, processes, scene, part);
}

void report_weight(Run& run, const TexturedModel& scene, double weight) {
  run.result["alpha"] = app::number_json(weight / scene.atlas->surface_area);
  run.result["length"] = app::number_json(std::sqrt(weight));
}

}  // namespace mq::shared
