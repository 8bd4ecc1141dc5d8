#include "sequence.h"

#include <algorithm>
#include <map>

#include "mq/base/error.h"
#include "mq/draw/lifespans.h"
#include "mq/io/evolving_file.h"
#include "mq/io/frame_files.h"

namespace mq::view {
namespace {

class Evolving : public Sequence {
 public:
  explicit Evolving(const std::filesystem::path& path)
      : path_(path), evolving_(EvolvingReader(path).read()) {
    if (evolving_.frames.empty()) throw IoError(path.string() + ": it holds no frame");
    for (const Lifespan& life : triangle_lifespans(evolving_)) lives_[life.id] = life;
  }

  int count() const override { return int(evolving_.frames.size()); }
  int number(int frame) const override { return evolving_.frames[std::size_t(frame)].number; }

  app::Scene scene(int frame, const Progress& progress) const override {
    app::Scene scene;
    scene.model.path = path_;
    scene.model.mesh = evolving_.mesh(frame);
    scene.surface =
        make_surface(scene.model.mesh, {WeldOptions::Kind::none}, progress.step("join", 0.5));
    if (scene.model.mesh.has_uvs()) {
      scene.texture_sizes = {{app::assumed_texture_side, app::assumed_texture_side}};
      scene.atlas = make_atlas(scene.surface, scene.texture_sizes, {AtlasOptions::Flipped::keep},
                               progress.step("find charts", 0.5));
    }
    return scene;
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
  EvolvingMesh evolving_;
  std::map<int, Lifespan> lives_;
};

class Files : public Sequence {
 public:
  explicit Files(const OptionValues& options)
      : options_(options), files_(find_frames(options.text("mesh"))) {}

  int count() const override { return int(files_.size()); }
  int number(int frame) const override { return files_[std::size_t(frame)].number; }

  app::Scene scene(int frame, const Progress& progress) const override {
    OptionValues options = options_;
    options.set("mesh", {files_[std::size_t(frame)].path.string()});
    app::Terminal silence("view");
    silence.set_voice(app::Terminal::Voice::quiet);
    app::Run reading(options, silence, progress);
    return app::read_scene(reading, app::MissingPictures::assume, 1);
  }

  bool has_lifespans() const override { return false; }
  std::vector<Colour> lifespans(int) const override { return {}; }

 private:
  OptionValues options_;  ///< of the verb view
  std::vector<FrameFile> files_;
};

}  // namespace

bool names_sequence(const std::string& name) {
  return name.ends_with(".evolving") || has_frame_place(name);
}

std::shared_ptr<Sequence> open_sequence(app::Run& run) {
  const std::string name = run.options().text("mesh");
  if (!name.ends_with(".evolving")) return std::make_shared<Files>(run.options());
  run.will_read(name);
  return std::make_shared<Evolving>(name);
}

}  // namespace mq::view
