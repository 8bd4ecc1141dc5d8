#include "sequence.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "mq/base/error.h"
#include "mq/draw/lifespans.h"
#include "mq/io/evolving_file.h"
#include "mq/io/frame_files.h"
#include "mq/io/path_status.h"
#include "mq/model/stored_frames.h"

namespace mq::view {
namespace {

/// The pictures of a frame: those that are named, with its number where they have a place for one.
std::vector<std::string> pictures_of(const std::vector<std::string>& names, int number) {
  std::vector<std::string> pictures;
  for (const std::string& name : names)
    pictures.push_back(has_frame_place(name) ? frame_name(name, number) : name);
  return pictures;
}

void require_pictures(const std::vector<std::string>& names, int number) {
  for (const std::string& picture : pictures_of(names, number))
    if (!is_there(picture))
      throw IoError(fmt::format("{}: is not there, the picture of frame {}: check the name",
                                picture, number));
}

class Evolving : public Sequence {
 public:
  /// What is broken is left out, with a warning.
  Evolving(const EvolvingReader& reader, const std::filesystem::path& path,
           std::vector<std::string> textures)
      : path_(path), textures_(std::move(textures)), evolving_(reader.read()) {
    if (evolving_.frames.empty()) throw IoError(path.string() + ": it holds no frame");
    require(textures_.size() <= 1, fmt::format("{}: has one texture, and {} pictures were given",
                                               path_.string(), textures_.size()));
    for (int frame = 0; frame < count(); ++frame) require_pictures(textures_, number(frame));
    for (const Lifespan& life : triangle_lifespans(evolving_)) lives_[life.id] = life;
  }

  int count() const override { return int(evolving_.frames.size()); }
  int number(int frame) const override { return evolving_.frames[std::size_t(frame)].number; }

  TexturedModel scene(int frame, const Progress& progress) const override {
    TexturedModel scene;
    scene.model.path = path_;
    scene.model.mesh = evolving_.mesh(frame);
    scene.surface =
        make_surface(scene.model.mesh, {WeldOptions::Kind::none}, progress.step("join", 0.3));
    if (!scene.model.mesh.has_uvs()) return scene;
    const Progress reading = progress.step("read pictures", 0.4);
    for (const std::string& picture : pictures_of(textures_, number(frame)))
      scene.model.textures.push_back(read_texture(picture, reading));
    for (const Texture& texture : scene.model.textures)
      scene.texture_sizes.push_back({texture.pixels.width(), texture.pixels.height()});
    if (textures_.empty())
      scene.texture_sizes = {{assumed_texture_side, assumed_texture_side}};
    scene.atlas = make_atlas(scene.surface, scene.texture_sizes, {AtlasOptions::Flipped::keep},
                             progress.step("find charts", 0.3));
    return scene;
  }

  void name(int frame, OptionValues& options) const override {
    options.set("mesh", {path_.string()});
    if (!textures_.empty()) options.set("texture", pictures_of(textures_, number(frame)));
  }

  bool has_lifespans() const override { return true; }
  std::vector<Colour> lifespans(int frame) const override {
    std::vector<Colour> colours;
    for (const int id :
         evolving_.segments[std::size_t(evolving_.frames[std::size_t(frame)].segment)]
             .triangle_ids) {
      const Lifespan& life = lives_.at(id);
      colours.push_back(lifespan_colour(life.first, life.last, count()));
    }
    return colours;
  }

 private:
  std::filesystem::path path_;
  std::vector<std::string> textures_;
  EvolvingMesh evolving_;
  std::map<int, Lifespan> lives_;
};

class Files : public Sequence {
 public:
  explicit Files(const OptionValues& options)
      : options_(options), files_(find_frames(options.text("mesh"))) {
    for (const FrameFile& file : files_) require_pictures(options.texts("texture"), file.number);
  }

  int count() const override { return int(files_.size()); }
  int number(int frame) const override { return files_[std::size_t(frame)].number; }

  TexturedModel scene(int frame, const Progress& progress) const override {
    OptionValues options = options_;
    name(frame, options);
    app::Terminal silence("view");
    silence.set_voice(app::Terminal::Voice::quiet);
    app::Run reading(options, silence, progress);
    return app::read_textured_model(reading, MissingPictures::assume, 1);
  }

  void name(int frame, OptionValues& options) const override {
    options.set("mesh", {files_[std::size_t(frame)].path.string()});
    if (options_.given("texture"))
      options.set("texture", pictures_of(options_.texts("texture"), number(frame)));
  }

  bool has_lifespans() const override { return false; }
  std::vector<Colour> lifespans(int) const override { return {}; }

 private:
  OptionValues options_;  ///< of the verb view
  std::vector<FrameFile> files_;
};

}  // namespace

bool names_sequence(const std::string& name) {
  std::error_code ignored;
  return name.ends_with(".evolving") || has_frame_place(name) ||
         std::filesystem::is_directory(name, ignored);
}

std::shared_ptr<Sequence> open_sequence(app::Run& run) {
  const std::string name = run.options().text("mesh");
  if (!name.ends_with(".evolving")) return std::make_shared<Files>(run.options());
  run.will_read(name);
  const EvolvingReader reader(name);
  warn_of_broken(run.terminal(), reader);
  return std::make_shared<Evolving>(reader, name, run.options().texts("texture"));
}

}  // namespace mq::view
