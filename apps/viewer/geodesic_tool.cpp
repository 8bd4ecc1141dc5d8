// What the verb geodesic does, with its equations kept between one source and the next. While the source is
// dragged, and until they are solved, `LiveGeodesic` has distances for every picture.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>

#include "shell/arguments.h"
#include "options/signal_options.h"
#include "mq/base/error.h"
#include "mq/base/stopwatch.h"
#include "mq/draw/false_colour.h"
#include "controls.h"
#include "live_colours.h"
#include "mq/fem/texel_lookup.h"
#include "mq/filter/geodesic.h"
#include "mq/filter/live_geodesic.h"
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
    remark(is_on_its_way()             ? (live_shown_ ? "The distances from there become more exact."
                                                      : "The distances from there are being calculated.")
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
    if (!is_current() && !(live_shown_ && is_on_its_way())) {
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
    report["live_seconds"] = live_seconds_;
    report["front_seconds"] = front_seconds_;
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

  /// A press is all that it wants, and makes it again.
  bool begins_by(const std::string&) const override { return true; }
  bool is_worth_asking() const override { return false; }

  bool has_found() const { return found_.contains("max"); }

  bool complete() const override {
    return !options_.texts("from").empty() || !options_.texts("from-mask").empty();
  }

  /// A place is taken over by the run in progress, unless that has just ended; other options end it.
  bool follows(const std::string& option) override {
    const std::lock_guard lock(wanted_mutex_);
    live_shown_ = false;
    newer_ = true;
    if (option != "from" || finished_) return false;
    wanted_ = options_;
    return true;
  }

  void before_make(const OptionValues& options) override {
    const std::lock_guard lock(wanted_mutex_);
    wanted_ = options;
    live_shown_ = newer_ = finished_ = false;
  }

  /// The place that the run in progress has not taken over yet; nothing: it is to end, for other options.
  std::optional<OptionValues> take_wanted() {
    const std::lock_guard lock(wanted_mutex_);
    if (wanted_) newer_ = false;
    return std::exchange(wanted_, std::nullopt);
  }

  /// Whether it is at its end: it has what is wanted, or is to give way to another.
  bool finish() {
    const std::lock_guard lock(wanted_mutex_);
    return finished_ = !wanted_;
  }

  void prepare_domain(const OptionValues& options, const Progress& progress) {
    if (domain_) return;
    app::Run run(options, session_.run.terminal(), progress);
    domain_ = app::make_field_signal(run, *session_.scene, progress, TextureSignalOptions::SharedTexels::one_for_each);
    closest_ = std::make_unique<ClosestPointFinder>(session_.scene->surface.mesh);
  }

  void prepare_live(const OptionValues& options, const Progress& progress) {
    if (live_time_ == options.text("time") || domain_->space().size() > most_live_unknowns) return;
    const LiveGeodesicOptions how{.geodesic = {.time = options.number("time")}};
    live_.reset();
    live_ = domain_->texel_space() != nullptr
                ? std::make_unique<LiveGeodesic>(*domain_->texel_space(), how, progress)
                : std::make_unique<LiveGeodesic>(*domain_->vertex_space(), how, progress);
    live_time_ = options.text("time");
  }

  void prepare_exact(const OptionValues& options, const Progress& progress) {
    const std::vector<std::string> asked = {options.text("time"), options.text("solver"),
                                            options.text("tolerance")};
    if (geodesic_ && asked == prepared_for_) return;
    const Stopwatch watch;
    const SolverFactory solver =
        options.text("solver") == "direct"
            ? direct_solver()
            : domain_->space().solver({.tolerance = options.number("tolerance")});
    geodesic_.emplace(domain_->space(), solver, GeodesicOptions{.time = options.number("time")}, progress);
    prepared_for_ = asked;
    preparing_ += watch.seconds();
  }

  void make(const OptionValues& options, const Progress& progress) override {
    const Stopwatch watch;
    const double share = domain_ && live_time_ == options.text("time") ? 0 : 0.4;
    prepare_domain(options, progress.step("assemble", share / 2));
    prepare_live(options, progress.step("prepare", share / 2));
    preparing_ += watch.seconds();
    try {
      do {
        const Progress at_source = progress.step("distances", 1 - share);
        if (const std::optional<OptionValues> now = take_wanted(); now && follow(*now, at_source.step("front", 0.3)))
          solve(*now, at_source.step("solve", 0.7));
      } while (!finish());
    } catch (...) {
      const std::lock_guard lock(wanted_mutex_);
      finished_ = true;
      throw;
    }
  }

  std::vector<GeodesicSource> sources(const OptionValues& options, const Progress& progress) const {
    app::Terminal silence("view");
    silence.set_voice(app::Terminal::Voice::quiet);
    app::Run run(options, silence, progress);
    return app::sources_at(run, *session_.scene, *domain_, app::source_places(run, *session_.scene, closest_.get()));
  }

  /// Shows distances from there picture by picture until they are as good as they become. Returns whether nothing
  /// newer is wanted.
  bool follow(const OptionValues& options, const Progress& progress) {
    if (!live_) return true;
    const Stopwatch watch;
    live_->move(sources(options, {}));
    for (int steps = 1; !live_->rests(); ++steps) {
      const Stopwatch stepping;
      const LiveGeodesicStep did = live_->step(progress);
      if (did.part == LiveGeodesicStep::Part::front) front_seconds_.push_back(stepping.seconds());
      if (did.shown == LiveGeodesicStep::Shown::anew) show_distances(options, live_->distance(), Precision::live);
      if (did.part == LiveGeodesicStep::Part::front) live_seconds_.push_back(watch.seconds());
      progress.at(steps / (steps + 15.0));
      if (newer_) return false;
      live_shown_ = true;
    }
    return true;
  }

  /// The same as the verb does it, unless something newer is wanted before it is done.
  void solve(const OptionValues& options, const Progress& progress) {
    const Progress until_newer([&](const ProgressEvent& event) { progress.at(event.fraction); }, &newer_);
    try {
      prepare_exact(options, until_newer.step("prepare", 0.3));
      const Stopwatch watch;
      const Geodesic found = geodesic_->from(sources(options, until_newer), until_newer.step("distances", 0.7));
      show_distances(options, found.distance, Precision::of_the_verb);
      solving_.push_back(watch.seconds());
    } catch (const Cancelled&) {
      if (!newer_) throw;
    }
  }

  enum class Precision { live, of_the_verb };

  void show_distances(const OptionValues& options, const Vector& distance, Precision precision) {
    {
      const std::lock_guard lock(measured_mutex_);
      measured_ = distance;
      source_.reset();
      if (const auto place = app::parse_numbers(options.has("from") ? options.texts("from").front() : "", 3))
        source_ = Vector3((*place)[0], (*place)[1], (*place)[2]);
    }
    if (!at_vertices() && !colours_) {
      Model blank;
      domain_->replace(Signal::Zero(distance.size(), 3), Depth::u8, blank);
      colours_.emplace(*domain_, pictures_of(blank));
    }
    const bool is_live = precision == Precision::live && colours_;
    DistanceColours scale{.most = is_live ? colours_->most(distance) : domain_->space().largest_shown(distance),
                          .lines = int(options.integer("isolines")),
                          .line_width = 1.5 * domain_->scale().texel_spacing};
    if (precision == Precision::of_the_verb) found_ = {{"max", scale.most}};
    if (colours_) {
      colours_->show(distance, scale, is_live ? LiveColours::Colours::nearly : LiveColours::Colours::exactly);
      show(colours_->pictures());
      return;
    }
    Model result;
    result.mesh = session_.scene->model.mesh;
    domain_->replace(distance_colours(distance, scale), Depth::u8, result);
    forget_stages();
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
  std::unique_ptr<LiveGeodesic> live_;
  std::string live_time_;
  std::optional<LiveColours> colours_;
  double preparing_ = 0;
  std::vector<double> solving_;
  std::vector<double> live_seconds_, front_seconds_;  ///< from place to picture; of that the front

  /// Beyond, a picture of distances that are on their way would take longer than one waits for it, and more memory.
  static constexpr int most_live_unknowns = 6'000'000;

  mutable std::mutex wanted_mutex_;
  std::optional<OptionValues> wanted_;  ///< guarded; with the place where distances are to begin
  bool finished_ = false;               ///< guarded; the run in progress takes nothing over any more
  std::atomic<bool> newer_ = false;     ///< something is wanted that the run in progress does not work on
  std::atomic<bool> live_shown_ = false;
};

}  // namespace

std::unique_ptr<Tool> make_geodesic_tool(Session& session) {
  return std::make_unique<GeodesicTool>(session);
}

}  // namespace mq::view
