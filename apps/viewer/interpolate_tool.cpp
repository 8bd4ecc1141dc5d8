// What the verb interpolate does, with the flow kept between one moment and the next.
#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include <memory>
#include <optional>

#include "controls.h"
#include "options/flow_options.h"
#include "verbs/shared/flow_pair.h"
#include "mq/base/error.h"
#include "mq/base/stopwatch.h"
#include "verb_tool.h"

namespace mq::view {
namespace {

/// Two sets of textures and their flow, with the run that reads and aligns them.
struct Aligned {
  Aligned(const OptionValues& options, const Progress& progress) : run(options, silence, progress) {
    silence.set_voice(app::Terminal::Voice::quiet);
    asked = std::make_unique<app::AskedModels>(run);
    const app::Step step(run, "align", 0.6);
    flow.emplace(asked->align(run, app::model_flow_options(options), step));
  }

  app::Terminal silence{"view"};
  app::Run run;
  std::unique_ptr<app::AskedModels> asked;
  std::optional<ModelPairFlow> flow;
};

class InterpolateTool : public VerbTool {
 public:
  explicit InterpolateTool(Session& session) : VerbTool("interpolate", session) {}
  ~InterpolateTool() override { background_.stop(); }

  void panel() override {
    if (ImGui::InputTextWithHint("with", "another texture", &with_,
                                 ImGuiInputTextFlags_EnterReturnsTrue))
      tried(session_, [&] { with(parted(with_)); });
    if (with_.empty() && ImGui::Button("choose another texture ...", {-1, 0}))
      tried(session_, [&] {
        session_.ask_for_files(FileKind::pictures, [this](const std::vector<std::string>& files) { with(files); });
      });
    VerbTool::panel();
  }

  bool command(const std::vector<std::string>& words) override {
    if (words[0] != "with") return VerbTool::command(words);
    with({words.begin() + 1, words.end()});
    make_again();
    return true;
  }

  nlohmann::ordered_json report() const override {
    nlohmann::ordered_json report = VerbTool::report();
    report["align_seconds"] = aligning_;
    report["between_seconds"] = between_;
    return report;
  }

 private:
  /// The second pictures, one for each texture.
  void with(const std::vector<std::string>& second) {
    const std::vector<Texture>& textures = session_.scene->model.textures;
    require(second.size() == textures.size(),
            fmt::format("with: found {} pictures, wanted one for each of the {} textures",
                        second.size(), textures.size()));
    std::vector<std::string> both = session_.opened.texts("texture");
    if (both.empty())
      for (const Texture& texture : textures) {
        require(
            !texture.path.empty(),
            fmt::format("{}: its pictures are inside the model: open it with pictures beside it",
                        session_.scene->model.path.string()));
        both.push_back(texture.path.string());
      }
    both.insert(both.end(), second.begin(), second.end());
    change("texture", both);
    with_ = joined(second);
  }

  bool complete() const override {
    return options_.texts("texture").size() == 2 * session_.scene->model.textures.size();
  }

  std::string missing() const override { return "Another texture is missing: choose it above."; }

  bool shows(const Option& option) const override {
    return option.name != "frames" && option.name != "rate";
  }

  /// What the flow depends on: everything but the moment.
  std::vector<std::string> asked(const OptionValues& options) const {
    std::vector<std::string> words;
    for (const Option& option : options.table().options())
      if (option.name != "time")
        for (const std::string& text : options.texts(option.name))
          words.push_back(option.name + "=" + text);
    return words;
  }

  void make(const OptionValues& options, const Progress& progress) override {
    Stopwatch watch;
    if (!aligned_ || asked(options) != aligned_for_) {
      aligned_.reset();
      OptionValues quiet = options;
      quiet.set("json", {"true"});
      aligned_ = std::make_unique<Aligned>(quiet, progress.step("align", 0.8));
      aligned_for_ = asked(options);
      found_ = aligned_->run.result;
      aligning_ = watch.seconds();
      watch = {};
    }
    const double time = options.number("time");
    const Signal values = aligned_->flow->between(time, progress.step("meet", 0.2));
    show(aligned_->asked->pair().with(values, time));
    between_.push_back(watch.seconds());
  }

  std::string with_;
  std::unique_ptr<Aligned> aligned_;
  std::vector<std::string> aligned_for_;
  double aligning_ = 0;
  std::vector<double> between_;
};

}  // namespace

std::unique_ptr<Tool> make_interpolate_tool(Session& session) {
  return std::make_unique<InterpolateTool>(session);
}

}  // namespace mq::view
