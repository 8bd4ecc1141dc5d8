// The equation is linear in β − 1, which is (beta − 1)·mask where the mask sharpens and the mask
// itself where it is below 0 and smooths. What is solved for is therefore β − 1 = mask, or mask /
// (beta − 1) below 0, and what is shown, ψ + (beta − 1)·δ, follows the slider of beta at once where
// nothing is below.
//
// The mask is held in 65535ths, which pictures of 16 bits and of floats keep: a saved mask is the
// painted one.
#include "filter_tool.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "shell/arguments.h"
#include "shell/command_words.h"
#include "controls.h"
#include "mq/base/error.h"
#include "options/signal_options.h"

namespace mq::view {
namespace {

/// The verb has no default: detail of this size comes out twice as clearly.
constexpr const char* first_beta = "2";
constexpr const char* first_length = "3tx";
constexpr const char* first_length_at_vertices = "1%";

}  // namespace

FilterTool::FilterTool(Session& session, Begins begins)
    : session_(session), begins_(begins), options_(options_for("filter", session)) {
  if (begins == Begins::everywhere) brush_ = Brush::erase;
  const TexturedModel& scene = *session.scene;
  require_usable(scene.defects(), scene.model.path.string());
  options_.set("beta", {first_beta});
  options_.set("length", {at_vertices() ? first_length_at_vertices : first_length});
  const auto kind = at_vertices() ? Outputs::Kind::model : Outputs::Kind::pictures;
  const std::string each = scene.model.textures.size() > 1 ? "_%s" : "";
  mask_name_ = session.free_name("mask" + each + (at_vertices() ? ".ply" : ".png"), kind);
  texture_name_ = session.free_name(at_vertices() ? "filtered.ply" : session.texture_file("filtered"), kind);
  options_.set("output", {texture_name_});
}

std::optional<Look::Paint> FilterTool::shown_as() const {
  if (at_vertices()) return Look::Paint::vertex_colours;
  return {};
}

/// A beta below 1 has no way to sharpen.
void FilterTool::choose(Brush brush) {
  const bool cannot = brush == Brush::sharpen && options_.number("beta") < 1;
  require(
      !cannot || nothing_painted(),
      fmt::format("what is painted smooths (beta is {:g}): with a beta above 1 one brush sharpens "
                  "and the other smooths",
                  options_.number("beta")));
  brush_ = brush;
  if (!cannot) return;
  set("beta", first_beta);
  session_.say(fmt::format("beta is {} now: below 1 nothing sharpens", first_beta));
}

/// strength and radius say what beta and length do.
void FilterTool::set(const std::string& name, const std::string& value) {
  if (name == "strength" || name == "radius") {
    OptionValues asked(options_.table());
    asked.set(name, {value});
    return name == "radius" ? set("length", value)
                            : set("beta", fmt::format("{:g}", 1 + asked.number(name) / 100));
  }
  require(name == "beta" || name == "alpha" || name == "length",
          fmt::format("the tool filter has strength and radius, or beta, alpha and length, to set; "
                      "found '{}'",
                      name));
  OptionValues changed = options_;
  if (name != "beta")  // the other way of saying it is forgotten
    for (const char* way : {"alpha", "length"}) changed.reset(way);
  changed.set(name, {value});
  take(changed);
}

namespace {

void refuse_beta(double beta) {
  throw InvalidInput(
      fmt::format("beta: found {:g}, and where the mask is below 0 it smooths while beta sharpens "
                  "elsewhere: wanted "
                  "above 1, or a mask without such places",
                  beta));
}

}  // namespace

/// Options in place of those there are.
void FilterTool::take(const OptionValues& options) {
  if (smoothed_ > 0 && options.number("beta") <= 1) refuse_beta(options.number("beta"));
  require_weight(options);
  options_ = options;
  want();
}

/// What is taken back or done again may have been painted with another one.
void FilterTool::require_beta_for(const std::vector<int>& mask) const {
  const double beta = options_.number("beta");
  if (beta <= 1 && std::ranges::any_of(mask, [](int m) { return m < 0; })) refuse_beta(beta);
}

double FilterTool::require_weight(const OptionValues& options) const {
  const double weight = app::spread_weight(options, scale_);
  require(weight > 0 && std::isfinite(weight),
          "the tool filter wants an alpha or a length above 0 and below infinity: with 0 nothing "
          "would change");
  return weight;
}

void FilterTool::want() {
  const std::lock_guard lock(mutex_);
  wanted_.weight = require_weight(options_);
  wanted_.gain = options_.number("beta") - 1;
  ++wanted_.version;
  stopped_ = false;
  hurry_ = true;
}

namespace {

std::vector<double> numbers(const std::string& word, std::size_t count) {
  const auto parsed = app::parse_numbers(word, count);
  require(parsed.has_value(), fmt::format("found '{}', wanted {} numbers", word, count));
  return *parsed;
}

}  // namespace

std::vector<Vector3> FilterTool::places_of(const std::vector<std::string>& words) const {
  std::vector<Vector3> places;
  for (std::size_t i = 1; i < words.size(); ++i) {
    const auto place = numbers(words[i], 3);
    places.emplace_back(place[0], place[1], place[2]);
  }
  return places;
}

/// Which brush it is.
bool FilterTool::brush_command(const std::vector<std::string>& words) {
  if (words[0] == "brush") {
    require(words[1] == "sharpen" || words[1] == "smooth" || words[1] == "erase",
            fmt::format("found '{}', wanted sharpen, smooth or erase", words[1]));
    choose(words[1] == "sharpen"  ? Brush::sharpen
           : words[1] == "smooth" ? Brush::smooth
                                  : Brush::erase);
  } else if (words[0] == "size") {
    const Length size = parse_length(words[1]);
    require(size.value > 0, fmt::format("found '{}', wanted a length above 0", words[1]));
    size_ = size;
  } else if (words[0] == "strength") {
    const double strength = numbers(words[1], 1)[0];
    require(strength > 0 && strength <= 1,
            fmt::format("found '{}', wanted above 0, at most 1", words[1]));
    strength_ = strength;
  } else if (words[0] == "hardness") {
    const double hardness = numbers(words[1], 1)[0];
    require(hardness >= 0 && hardness <= 1, fmt::format("found '{}', wanted from 0 to 1", words[1]));
    hardness_ = hardness;
  } else {
    return false;
  }
  return true;
}

bool FilterTool::command(const std::vector<std::string>& words) {
  const std::string& what = words[0];
  require_ready();
  if (brush_command(words)) return true;
  if (what == "run" && begins_ == Begins::everywhere) {
    fill(full);
    return true;
  }
  if (what == "set") {
    require(words.size() == 3,
            fmt::format("set {}: found {} values, wanted one", words[1], words.size() - 2));
    set(words[1], words[2]);
  } else if (what == "stroke") {
    const std::vector<Vector3> places = places_of(words);
    begin_stroke();
    last_dab_.reset();
    for (const Vector3& place : places) dabs_to(place);
    end_brush_stroke();
  } else if (what == "fill") {
    require(words[1] == "everywhere" || words[1] == "nowhere",
            fmt::format("fill: found '{}', wanted everywhere or nowhere", words[1]));
    fill(words[1] == "everywhere" ? full : 0);
  } else if (what == "undo") {
    undo();
  } else if (what == "redo") {
    redo();
  } else if (what == "save-texture") {
    save_texture(words[1]);
  } else if (what == "save-mask") {
    save_mask(words[1]);
  } else if (what == "copy-command") {
    copy_command(session_, words, as_command());
  } else {
    return false;
  }
  return true;
}

std::string FilterTool::as_command() {
  const bool whole = painted_ == std::ssize(mask_);
  const bool everywhere = whole && std::ranges::all_of(mask_, [](int m) { return m == full; });
  require(!nothing_painted(), "nothing is painted: there is nothing to do again");
  require(
      everywhere || !saved_mask_.empty(),
      "the command names the mask's file, and the mask is not saved as it is now: save it first");
  options_.set("output", {texture_name_});
  if (!everywhere) return app::command_line(options_);
  OptionValues without = options_;
  without.reset("mask");
  return app::command_line(without);
}

void FilterTool::require_ready() const {
  require(ready_, "the tool filter is still being prepared: wait");
}

/// Of what the work behind has not seen or not ended; while it goes on only it knows.
bool FilterTool::is_settled() const {
  const std::lock_guard lock(mutex_);
  return ready_ && (settled_ || brushing_) && wanted_.mask.empty() && wanted_.gain == gain_ &&
         wanted_.weight == weight_ && saves_.empty();
}

bool FilterTool::has_work() const { return !stopped_ && !is_settled(); }

void FilterTool::frame() {
  take_note_of_written();
  if (ready_) paint_target_->present();
  if (background_.busy()) return;
  if (const std::string error = background_.error(); !error.empty()) {
    stopped_ = true;
    give_up_saving();
    throw SolverError(error);
  }
  if (stopped_) give_up_saving();
  if (has_work()) background_.start([this](const Progress& progress) { work(progress); });
}

void FilterTool::stop() {
  background_.stop();
  stopped_ = true;
  give_up_saving();
}

nlohmann::ordered_json FilterTool::report() const {
  const bool settled = is_settled() && !brushing_;
  nlohmann::ordered_json strokes = nlohmann::ordered_json::array();
  for (const Timing& t : timings_)
    strokes.push_back({{at_vertices() ? "vertices" : "texels", t.unknowns},
                       {"update", t.update},
                       {"solve", t.solve},
                       {"cycles", t.cycles},
                       {"show", t.show}});
  const std::lock_guard lock(mutex_);
  return {{"name", name()},
          {"unknowns", mask_.size()},
          {"painted", painted_},
          {"settled", settled},
          {"values", {{"below", values_after_.below}, {"above", values_after_.above}, {"count", values_after_.count}}},
          {"prepare_seconds", preparing_},
          {"settle_seconds", settling_},
          {"settle_rounds", rounds_},
          {"touches", touches_},
          {"strokes", strokes}};
}

}  // namespace mq::view
