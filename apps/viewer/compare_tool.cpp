#include "compare_tool.h"

#include <fmt/format.h>
#include <imgui.h>

#include <cmath>
#include <mutex>

#include "background.h"
#include "controls.h"
#include "mq/base/error.h"
#include "mq/image/compare.h"
#include "theme.h"

namespace mq::view {
namespace {

class CompareTool : public Tool {
 public:
  explicit CompareTool(Session& session) : session_(session) {
    require(session.before != nullptr, fmt::format("{}: has no textures to compare others with",
                                                   session.scene->model.path.string()));
  }
  ~CompareTool() override { background_.stop(); }

  std::string name() const override { return "compare"; }
  void press(const Pick&) override {}
  void drag(const Pick&) override {}
  void release() override {}

  void panel() override {
    for (std::size_t i = 0; i < found_.size(); ++i) {
      const Comparison& c = found_[i];
      remark(fmt::format("{}: {:.1f} of 255 apart (root mean square), at most {:.0f}, at texel {}, {}.",
                         files_[i], 255 * c.rms, 255 * c.largest, c.x, c.y));
    }
  }

  bool command(const std::vector<std::string>& words) override {
    if (words[0] != "with") return false;
    std::vector<std::string> files(words.begin() + 1, words.end());
    for (std::string& file : files) file = session_.found(file);
    const auto count = session_.scene->model.textures.size();
    require(files.size() == count,
            fmt::format("with: found {} pictures, wanted one for each of the {} textures",
                        files.size(), count));
    background_.stop();
    files_ = files;
    found_.clear();
    session_.show(nullptr, nullptr);
    background_.start([this, files, options = options_with(files)](const Progress& progress) {
      read(options, progress);
    });
    return true;
  }

  void frame() override {
    if (background_.busy()) return;
    background_.rethrow();
    if (!read_) return;
    session_.show(std::move(read_), nullptr);
    found_ = std::move(compared_);
  }
  bool busy() const override { return background_.busy() || read_; }
  bool has_changed() const override { return session_.result != nullptr; }
  double fraction() const override { return background_.fraction(); }
  std::string step() const override { return background_.step(); }
  void stop() override { background_.stop(); }
  void cancel() override { background_.cancel(); }

  nlohmann::ordered_json report() const override {
    nlohmann::ordered_json found = nlohmann::ordered_json::array();
    for (const Comparison& c : found_)
      found.push_back({{"rms", c.rms}, {"largest", c.largest}, {"texel", {c.x, c.y}}});
    return {{"name", name()}, {"with", files_}, {"found", found}};
  }

 private:
  /// Those of the model that is open, with these pictures.
  OptionValues options_with(const std::vector<std::string>& files) const {
    OptionValues options = session_.opened;
    if (session_.sequence) session_.sequence->name(session_.frame, options);
    options.set("texture", files);
    return options;
  }

  /// On the other thread: as the verb view reads them.
  void read(const OptionValues& options, const Progress& progress) {
    app::Terminal silence("view");
    silence.set_voice(app::Terminal::Voice::quiet);
    app::Run run(options, silence, progress);
    const TexturedModel other = app::read_textured_model(run, MissingPictures::refuse, 0.8);
    const std::vector<Texture>& own = session_.scene->model.textures;
    compared_.clear();
    for (std::size_t i = 0; i < own.size(); ++i)
      compared_.push_back(compare(own[i].pixels, other.model.textures[i].pixels));
    read_ = std::make_shared<TextureSet>(other.model.textures, largest_side_);
  }

  Session& session_;
  std::vector<std::string> files_;
  std::vector<Comparison> found_;
  std::vector<Comparison> compared_;  ///< the other thread's while it works
  std::shared_ptr<TextureSet> read_;  ///< the same
  int largest_side_ = TextureSet::largest_side();
  Background background_;  ///< last: it ends before what it works on
};

}  // namespace

std::unique_ptr<Tool> make_compare_tool(Session& session) {
  return std::make_unique<CompareTool>(session);
}

}  // namespace mq::view
