#include "loader.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <future>
#include <optional>
#include <utility>

#include "mq/base/error.h"
#include "mq/io/temporary_folder.h"
#include "mq/model/model_paints.h"
#include "mq/sample/moving.h"
#include "photograph_sample.h"
#include "shell/verb.h"

namespace mq::view {
namespace {

/// Texels that are uploaded between two pictures of the window: about 10 ms (docs/measurements/brush.md).
constexpr std::int64_t texels_at_a_time = 1 << 22;

}  // namespace

LoadedModel::LoadedModel(TexturedModel read, int largest_side, const Progress& progress)
    : scene(std::make_unique<TexturedModel>(std::move(read))) {
  {
    const Progress step = progress.step("prepare textures", 0.4);
    if (has_pictures(*scene)) {
      before = std::make_unique<TextureSet>(scene->model.textures, largest_side);
      step.at(0.5);
      after = std::make_unique<TextureSet>(*before);
    }
    step.at(1);
  }
  const Progress step = progress.step("prepare triangles", 0.6);
  drawn = std::make_unique<DrawnModel>(*scene, step.step("draw", 0.5));
  rays = std::make_unique<mq::Scene>(scene->surface);
  step.at(0.8);
  if (scene->atlas)
    triangles_at = std::make_unique<TrianglesAt>(scene->surface.mesh, *scene->atlas);
  step.at(1);
}

std::unique_ptr<LoadedModel> load_frame(const std::shared_ptr<Sequence>& sequence, int frame,
                                        int largest_side, const Progress& progress) {
  TexturedModel scene = sequence->scene(frame, progress.step("read", 0.7));
  auto loaded =
      std::make_unique<LoadedModel>(std::move(scene), largest_side, progress.step("prepare", 0.3));
  loaded->drawn->triangle_colours = sequence->lifespans(frame);
  loaded->sequence = sequence;
  loaded->frame = frame;
  return loaded;
}

void warn_of(app::Run& run, const TexturedModel& scene) {
  run.warn(scene.defects());
  if (run.options().given("texture") && !scene.model.mesh.has_uvs())
    run.terminal().warning(scene.model.path.string() +
                           ": has no texture coordinates, so that the pictures are not shown");
}

std::unique_ptr<LoadedModel> load_files(const OptionValues& options, app::Terminal& terminal,
                                        int largest_side, const Progress& progress, const TakeLook& take_look,
                                        MissingPictures missing) {
  app::Run run(options, terminal, progress);
  // The shape is looked at while pictures are read.
  FirstLooks looks;
  std::optional<Model> shape;
  std::future<void> first;
  ModelWatch watch;
  if (take_look)
    watch = [&](const Model& model) {
      if (!shape) {
        shape.emplace();
        shape->path = model.path, shape->mesh = model.mesh, shape->colors = model.colors;
        first = std::async(std::launch::async, [&] { take_look(looks(*shape)); });
      } else {
        first.get();
        take_look(looks(model));
        shape->mesh = {};
      }
    };
  std::unique_ptr<LoadedModel> loaded;
  if (names_sequence(options.text("mesh"))) {
    loaded = load_frame(open_sequence(run), 0, largest_side, progress);
  } else {
    TexturedModel scene = app::read_textured_model(run, missing, 0.7, {}, ImageTriangles::two, {}, watch);
    loaded = std::make_unique<LoadedModel>(std::move(scene), largest_side,
                                           progress.step("prepare", 0.3));
  }
  warn_of(run, *loaded->scene);
  loaded->opened = options;
  return loaded;
}

namespace {

/// A second of a motion of four.
constexpr const char* frames_of_samples = "0-99x4";

constexpr const char* sample_of_photographs = "photographs";

/// $XDG_CACHE_HOME, or ~/.cache, or where there is no home the folder of temporary files.
std::filesystem::path cache() {
  if (const char* const named = std::getenv("XDG_CACHE_HOME"); named != nullptr && *named != 0)
    return named;
  const char* const home = std::getenv("HOME");
  return home != nullptr && *home != 0 ? std::filesystem::path(home) / ".cache"
                                       : temporary_place();
}

}  // namespace

std::filesystem::path sample_folder() { return cache() / "marquetry" / "samples"; }

std::unique_ptr<LoadedModel> load_sample(const std::string& asked, OptionValues options,
                                         app::Terminal& terminal, int largest_side,
                                         const Progress& progress) {
  const bool photographs = asked == sample_of_photographs;
  const std::string name = photographs ? "bust" : asked;
  const std::filesystem::path folder = sample_folder() / name;
  std::filesystem::create_directories(folder.parent_path());
  const bool moves = std::ranges::any_of(moving_names(),
                                         [&](const SampleInfo& info) { return info.name == name; });
  const app::Verb verb = app::find_verb(app::all_verbs(), "sample");
  OptionValues making(verb.table);
  making.set("name", {name});
  making.set("output", {folder.string() + "/"});
  if (moves) making.set("frames", {frames_of_samples});
  making.set("json", {"true"});
  app::Terminal silence("view");
  silence.set_voice(app::Terminal::Voice::quiet);
  app::Run run(making, silence, progress.step("make the sample", 0.6));
  verb.run(run);
  options.reset("texture");
  options.set("mesh", {(folder / (moves ? "frame_%04d.ply" : name + ".obj")).string()});
  auto loaded = load_files(options, terminal, largest_side, progress.step("open", photographs ? 0.2 : 0.4));
  if (photographs)
    loaded->cameras = make_photographs(*loaded->scene, sample_folder() / asked, progress.step("photographs", 0.2));
  return loaded;
}

void Loader::give(std::unique_ptr<FirstLook> look) {
  const std::lock_guard lock(mutex_);
  if (look) look_ = std::move(look);
}

std::unique_ptr<FirstLook> Loader::look() {
  const std::lock_guard lock(mutex_);
  return std::move(look_);
}

void Loader::ask(const std::string& name, Work work) { next_ = Asked{name, std::move(work)}; }

void Loader::cancel() {
  next_.reset();
  loaded_.reset();
  unwanted_ = begun_;
  background_.cancel();
}

bool Loader::ready() {
  if (background_.busy()) return false;
  begun_ = false;
  if (std::exchange(unwanted_, false)) {
    made_.reset();
    background_.error();
  }
  if (made_) loaded_ = std::move(made_);
  try {
    background_.rethrow();
  } catch (const Error&) {
    next_.reset();
    throw;
  } catch (const std::exception& error) {
    next_.reset();
    throw IoError(name_ + ": cannot be loaded: " + error.what());
  }
  if (loaded_) {
    for (TextureSet* set : {loaded_->before.get(), loaded_->after.get()})
      if (set != nullptr && set->upload(texels_at_a_time) >= texels_at_a_time) return false;
    return true;
  }
  if (!next_) return false;
  name_ = next_->name;
  begun_ = true;
  look();  // at what is not wanted any more
  background_.start(
      [this, work = std::move(next_->work)](const Progress& progress) { made_ = work(progress); });
  next_.reset();
  return false;
}

}  // namespace mq::view
