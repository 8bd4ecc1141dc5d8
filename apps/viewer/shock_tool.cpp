// What the verb shock does to textures, with all that does not depend on the time kept between one time
// and the next.
#include <fmt/format.h>

#include <optional>

#include "mq/base/error.h"
#include "mq/base/stopwatch.h"
#include "outputs.h"
#include "shock_options.h"
#include "signal_options.h"
#include "signal_target.h"
#include "verb_tool.h"

namespace mq::view {
namespace {

class ShockTool : public VerbTool {
 public:
  explicit ShockTool(Session& session) : VerbTool("shock", session) {}
  ~ShockTool() override { background_.stop(); }

  nlohmann::ordered_json report() const override {
    nlohmann::ordered_json report = VerbTool::report();
    report["prepare_seconds"] = preparing_;
    report["path_seconds"] = following_;
    return report;
  }

 private:
  bool shows(const Option& option) const override { return option.group != "Pictures"; }

  /// What it is prepared for: all but the time.
  static nlohmann::ordered_json asked(const OptionValues& options) {
    nlohmann::ordered_json asked = app::options_json(options);
    for (const char* name : {"time", "absolute-time", "output"}) asked.erase(name);
    return asked;
  }

  /// Whether that was still to be done.
  bool prepare(const OptionValues& options, const Progress& progress) {
    if (shock_ && asked(options) == prepared_for_) return false;
    const Stopwatch watch;
    shock_.reset();
    app::Terminal silence("view");
    silence.set_voice(app::Terminal::Voice::quiet);
    app::Run run(options, silence, progress);
    app::about(session_.scene->model, [&] {
      target_ = std::make_unique<app::TextureTarget>(run, *session_.scene, app::value_space(options),
                                                     progress.step("assemble", 0.3));
      before_ = target_->values();
      const TexelSpace& space = target_->domain().space();
      shock_ = std::make_unique<TextureShock>(
          session_.scene->surface, *session_.scene->atlas, space, before_,
          TextureShockOptions{.weights = app::asked_weights(options, space.scale()),
                              .time = app::asked_time(options),
                              .longest_edge = app::asked_longest_edge(options, space.size()),
                              .solver = app::vertex_solver(options)},
          progress.step("prepare", 0.7));
    });
    prepared_for_ = asked(options);
    preparing_ = watch.seconds();
    return true;
  }

  std::vector<Texture> textures_at(const ShockTime& time, const OptionValues& options,
                                   const Progress& progress) {
    const ShockedTexture shocked = shock_->at(time, progress);
    found_ = {{"time", shocked.time}, {"rate", shocked.rate}, {"vertices", shocked.vertices}};
    following_.push_back(shocked.path_seconds);
    Model model;
    model.textures = session_.scene->model.textures;
    target_->put(before_, shocked.signal, model);
    app::set_depth(options, model);
    return std::move(model.textures);
  }

  /// Where paths are new they are seen growing, twice as far each time; where the time alone is another
  /// it is wanted at once.
  void make(const OptionValues& options, const Progress& progress) override {
    const ShockTime time = app::asked_time(options);
    if (prepare(options, progress.step("prepare", 0.7))) {
      constexpr int stages = 4;
      for (int k = stages; k > 0; --k) {
        const ShockTime early{time.unit, std::ldexp(time.value, -k)};
        show_stage(fmt::format("time {:.3g}", early.value),
                   textures_at(early, options, progress.step("follow paths", 0.05)));
      }
    }
    show(textures_at(time, options, progress.step("follow paths", 0.1)));
  }

  std::unique_ptr<app::TextureTarget> target_;
  Signal before_;
  std::unique_ptr<TextureShock> shock_;
  nlohmann::ordered_json prepared_for_;
  double preparing_ = 0;
  std::vector<double> following_;
};

}  // namespace

std::unique_ptr<Tool> make_shock_tool(Session& session) {
  return std::make_unique<ShockTool>(session);
}

}  // namespace mq::view
