// What the verb geodesic does, with its equations kept between one source and the next.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "shell/arguments.h"
#include "options/signal_options.h"
#include "mq/base/error.h"
#include "mq/base/stopwatch.h"
#include "mq/draw/false_colour.h"
#include "controls.h"
#include "mq/fem/texel_lookup.h"
#include "mq/filter/geodesic.h"
#include "mq/linear/direct_solver.h"
#include "options/source_options.h"
#include "theme.h"
#include "verb_tool.h"

namespace mq::view {
namespace {

class GeodesicTool : public VerbTool {
 public:
  explicit GeodesicTool(Session& session) : VerbTool("geodesic", session) {}
  ~GeodesicTool() override { background_.stop(); }

  void panel() override {
    remark(is_on_its_way()             ? "The distances from there are being calculated."
           : !is_current() || !has_found() ? "Press on the model, and drag: distances from there."
                                       : fmt::format("The farthest place is {} away. Move the mouse over the model: "
                                                     "below stands how far each place is.",
                                                     plain(found_["max"].get<double>())));
    VerbTool::panel();
  }

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

  /// Along the surface, and through the air; of no other place than the one that was pressed last.
  std::string reading(const Pick& pick) const override {
    if (!is_current()) {
      read_.reset();
      return is_on_its_way() || !complete() ? "" : "distance not calculated: it was stopped";
    }
    const std::lock_guard lock(measured_mutex_);
    const std::optional<double> distance = distance_at(pick);
    read_ = distance;
    if (!distance) return {};
    std::string words = fmt::format("distance {}", plain(*distance));
    if (source_) words += fmt::format(", straight {}", plain((pick.point - *source_).norm()));
    return words;
  }

  nlohmann::ordered_json report() const override {
    nlohmann::ordered_json report = VerbTool::report();
    report["prepare_seconds"] = preparing_;
    report["solve_seconds"] = solving_;
    if (read_) report["reading"] = *read_;
    return report;
  }

 private:
  void from(const Vector3& place) {
    // To a millionth of the model, which nobody points at more closely.
    const double size = std::sqrt(session_.scene->surface.area);
    const int decimals = size > 0 ? std::clamp(6 - int(std::floor(std::log10(size))), 0, 17) : 6;
    change("from", {fmt::format("{0:.{3}f},{1:.{3}f},{2:.{3}f}", place.x(), place.y(), place.z(), decimals)});
  }

  std::string work_words() const override { return "the distance is being calculated"; }

  bool has_found() const { return found_.contains("max"); }

  bool complete() const override {
    return !options_.texts("from").empty() || !options_.texts("from-mask").empty();
  }

  /// Whether that was still to be done.
  bool prepare(const OptionValues& options, const Progress& progress) {
    const std::vector<std::string> asked = {options.text("time"), options.text("solver"),
                                            options.text("tolerance")};
    if (geodesic_ && asked == prepared_for_) return false;
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
    return true;
  }

  void make(const OptionValues& options, const Progress& progress) override {
    const double share = prepare(options, progress) ? 0.3 : 1;
    const Stopwatch watch;
    app::Terminal silence("view");
    silence.set_voice(app::Terminal::Voice::quiet);
    app::Run run(options, silence, progress);
    const auto places = app::source_places(run, *session_.scene, closest_.get());
    const Geodesic found = geodesic_->from(app::sources_at(run, *session_.scene, *domain_, places),
                                           progress.step("distances", share));
    const double most = domain_->space().largest_shown(found.distance);
    {
      const std::lock_guard lock(measured_mutex_);
      measured_ = found.distance;
      source_.reset();
      if (const auto place = app::parse_numbers(options.has("from") ? options.texts("from").front() : "", 3))
        source_ = Vector3((*place)[0], (*place)[1], (*place)[2]);
    }
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

  /// Of a place of the surface, by its texel, or in its triangle; nothing where none was found.
  std::optional<double> distance_at(const Pick& pick) const {
    if (measured_.size() == 0) return {};
    double distance = 0;
    if (at_vertices()) {
      const auto& corners = session_.scene->surface.mesh.triangles[std::size_t(pick.triangle)];
      for (int k = 0; k < 3; ++k) distance += pick.barycentric[k] * measured_[corners[std::size_t(k)]];
    } else {
      const auto* const texels = dynamic_cast<const TextureSignal*>(domain_.get());
      if (texels == nullptr || pick.chart < 0) return {};
      const int unknown =
          unknown_of(texels->space().texels(), {pick.texture, pick.x, pick.y});
      if (unknown < 0) return {};
      distance = measured_[unknown];
    }
    if (!std::isfinite(distance)) return {};
    return distance;
  }

  mutable std::mutex measured_mutex_;
  mutable std::optional<double> read_;  ///< guarded; under the mouse, last
  Vector measured_;                ///< guarded, as the source; per unknown
  std::optional<Vector3> source_;
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
