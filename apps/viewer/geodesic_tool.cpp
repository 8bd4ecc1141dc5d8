// What the verb geodesic does, with its equations kept between one source and the next.
#include <fmt/format.h>

#include <optional>

#include "shell/arguments.h"
#include "options/signal_options.h"
#include "mq/base/error.h"
#include "mq/base/stopwatch.h"
#include "mq/draw/false_colour.h"
#include "mq/filter/geodesic.h"
#include "mq/linear/direct_solver.h"
#include "options/source_options.h"
#include "verb_tool.h"

namespace mq::view {
namespace {

class GeodesicTool : public VerbTool {
 public:
  explicit GeodesicTool(Session& session) : VerbTool("geodesic", session) {}
  ~GeodesicTool() override { background_.stop(); }

  void press(const Pick& pick) override {
    if (at_vertices() ? bool(pick) : pick.chart >= 0) from(pick.point);
  }
  void drag(const Pick& pick) override { press(pick); }
  bool takes_mouse() const override { return true; }

  bool command(const std::vector<std::string>& words) override {
    if (words[0] != "source") return VerbTool::command(words);
    const auto place = app::parse_numbers(words[1], 3);
    require(place.has_value(), fmt::format("found '{}', wanted X,Y,Z", words[1]));
    from({(*place)[0], (*place)[1], (*place)[2]});
    return true;
  }

  nlohmann::ordered_json report() const override {
    nlohmann::ordered_json report = VerbTool::report();
    report["prepare_seconds"] = preparing_;
    report["solve_seconds"] = solving_;
    return report;
  }

 private:
  void from(const Vector3& place) {
    change("from", {fmt::format("{},{},{}", place.x(), place.y(), place.z())});
  }

  bool complete() const override {
    return !options_.texts("from").empty() || !options_.texts("from-mask").empty();
  }

  void prepare(const OptionValues& options, const Progress& progress) {
    const std::vector<std::string> asked = {options.text("time"), options.text("solver"),
                                            options.text("tolerance")};
    if (geodesic_ && asked == prepared_for_) return;
    const Stopwatch watch;
    app::Run run(options, session_.run.terminal(), progress);
    if (!domain_)
      domain_ = app::make_field_signal(run, *session_.scene, progress.step("assemble", 0.3),
                                 TextureSignalOptions::SharedTexels::one_for_each);
    if (!closest_) closest_ = std::make_unique<ClosestPointFinder>(session_.scene->surface.mesh);
    const SolverFactory solver =
        options.text("solver") == "direct"
            ? direct_solver()
            : domain_->space().solver({.tolerance = options.number("tolerance")});
    geodesic_.emplace(domain_->space(), solver, GeodesicOptions{.time = options.number("time")},
                      progress.step("prepare", 0.4));
    prepared_for_ = asked;
    preparing_ = watch.seconds();
  }

  void make(const OptionValues& options, const Progress& progress) override {
    prepare(options, progress);
    const Stopwatch watch;
    app::Terminal silence("view");
    silence.set_voice(app::Terminal::Voice::quiet);
    app::Run run(options, silence, progress);
    const auto places = app::source_places(run, *session_.scene, closest_.get());
    const Geodesic found = geodesic_->from(app::sources_at(run, *session_.scene, *domain_, places),
                                           progress.step("distances", 0.3));
    const double most = domain_->space().largest_shown(found.distance);
    const DistanceColours scale{.most = most,
                                .lines = int(options.integer("isolines")),
                                .line_width = 1.5 * domain_->scale().texel_spacing};
    Model result;
    if (at_vertices()) result.mesh = session_.scene->model.mesh;
    domain_->replace(distance_colours(found.distance, scale), Depth::u8, result);
    found_ = {{"max", most}};
    solving_.push_back(watch.seconds());
    show(result);
  }

  std::unique_ptr<ModelSignal> domain_;
  std::unique_ptr<ClosestPointFinder> closest_;
  std::optional<GeodesicDistance> geodesic_;
  std::vector<std::string> prepared_for_;
  double preparing_ = 0;
  std::vector<double> solving_;
};

}  // namespace

std::unique_ptr<Tool> make_geodesic_tool(Session& session) {
  return std::make_unique<GeodesicTool>(session);
}

}  // namespace mq::view
