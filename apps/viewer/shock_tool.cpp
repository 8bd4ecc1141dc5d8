// What the verb shock does to textures, with all that does not depend on the time kept between one time
// and the next, and what was shown of each. (Paths are followed from their beginning each time: from where
// a shorter time left them they would end elsewhere by rounding, and preparing them takes fifty times as
// long.) At vertices the verb runs.
#include <fmt/format.h>

#include <optional>

#include "mq/base/error.h"
#include "mq/base/stopwatch.h"
#include "shell/results.h"
#include "options/shock_options.h"
#include "options/signal_options.h"
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
    report["prepared"] = prepared_;
    report["path_seconds"] = following_;
    return report;
  }

 private:
  bool shows(const Option& option) const override { return option.group != "Pictures"; }

  /// What it is prepared for: all but the time.
  static nlohmann::ordered_json asked(const OptionValues& options) {
    nlohmann::ordered_json asked = app::options_json(options);
    for (const char* name : {"time", "absolute-time", "output", "json", "depth"}) asked.erase(name);
    return asked;
  }
  /// What stages differ in beside the time itself.
  static nlohmann::ordered_json shown(const OptionValues& options) {
    nlohmann::ordered_json shown = asked(options);
    shown["depth"] = options.text("depth");
    shown["absolute"] = options.given("absolute-time");
    return shown;
  }

  /// Whether that was still to be done.
  bool prepare(const OptionValues& options, const Progress& progress) {
    if (shock_ && asked(options) == prepared_for_) return false;
    const Stopwatch watch;
    shock_.reset();
    app::Terminal silence("view");
    silence.set_voice(app::Terminal::Voice::quiet);
    app::Run run(options, silence, progress);
    about(session_.scene->model, [&] {
      target_ = app::make_texture_signal(run, *session_.scene, {.values = app::value_space(options)},
                                         progress.step("assemble", 0.3));
      before_ = target_->values();
      const TexelSpace& space = target_->space();
      shock_ = std::make_unique<TextureShock>(
          session_.scene->surface, *session_.scene->atlas, space, before_,
          TextureShockOptions{.weights = app::shock_request(options).weights(space.scale()),
                              .time = app::asked_time(options),
                              .solver = texel_solver(app::shock_request(options).solver, space)},
          progress.step("prepare", 0.7));
    });
    prepared_for_ = asked(options);
    preparing_ = watch.seconds();
    ++prepared_;
    return true;
  }

  /// The model with its textures at a time.
  Model at_time(const ShockTime& time, const OptionValues& options, const Progress& progress) {
    const ShockedTexture shocked = shock_->at(time, progress);
    found_ = {{"time", shocked.time}, {"rate", shocked.rate}};
    following_.push_back(shocked.path_seconds);
    Model model = session_.scene->model;
    target_->put(before_, shocked.signal, model);
    app::set_depth(options, model);
    return model;
  }

  /// Where paths are new they are seen growing, twice as far each time; where the time alone is another
  /// it is wanted at once, and stays beside those there were.
  void make(const OptionValues& options, const Progress& progress) override {
    if (at_vertices()) return VerbTool::make(options, progress);
    const ShockTime time = app::asked_time(options);
    const bool prepared = prepare(options, progress.step("prepare", 0.7));
    if (shown(options) != shown_for_) forget_stages();
    shown_for_ = shown(options);
    if (show_again(time.value)) return;
    constexpr int stages = 4;
    for (int k = prepared ? stages : 0; k >= 0; --k) {
      const ShockTime until{time.unit, std::ldexp(time.value, -k)};
      show_stage(until.value, at_time(until, options, progress.step("follow paths", 0.05)));
    }
  }

  /// With what is prepared, if it is for these options.
  void write(const OptionValues& options, const Progress& progress) override {
    if (at_vertices() || !shock_ || asked(options) != prepared_for_)
      return VerbTool::write(options, progress);
    const Outputs outputs(options.text("output"), session_.scene->model,
                               Outputs::Kind::pictures);
    Model model = at_time(app::asked_time(options), options, progress.step("follow paths", 0.5));
    for (const std::string& note : outputs.write(std::move(model), progress.step("write", 0.5)))
      session_.run.terminal().remark(note);
    for (const auto& path : outputs.paths())
      session_.run.terminal().remark("wrote " + path.string());
  }

  std::unique_ptr<TextureSignal> target_;
  Signal before_;
  std::unique_ptr<TextureShock> shock_;
  nlohmann::ordered_json prepared_for_, shown_for_;
  double preparing_ = 0;
  int prepared_ = 0;  ///< how often
  std::vector<double> following_;
};

}  // namespace

std::unique_ptr<Tool> make_shock_tool(Session& session) {
  return std::make_unique<ShockTool>(session);
}

}  // namespace mq::view
