// The equation is linear in β − 1, which is (beta − 1)·mask where the mask sharpens and the mask
// itself where it is below 0 and smooths. What is solved for is therefore β − 1 = mask, or mask /
// (beta − 1) below 0, and what is shown, ψ + (beta − 1)·δ, follows the slider of beta at once where
// nothing is below.
//
// The mask is held in 65535ths, which pictures of 16 bits and of floats keep: a saved mask is the
// painted one.
#include "filter_tool.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "shell/arguments.h"
#include "shell/command_words.h"
#include "controls.h"
#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/base/stopwatch.h"
#include "mq/filter/modulation.h"
#include "mq/image/resample.h"
#include "options/signal_options.h"

namespace mq::view {
namespace {

namespace fs = std::filesystem;

constexpr int full = 65535;

/// The verb has no default: it sharpens clearly.
constexpr const char* first_beta = "3";

/// A change of more texels than this share of all is solved for everywhere at once.
constexpr double most_to_follow = 0.25;

/// What is seen of an error in a texture of 8 bits: half a step.
constexpr double seen = 0.5 / 255;

/// Cycles between two looks at a solution on its way.
constexpr SettleOptions settling{.tolerance = 1e-6, .max_cycles = 2};

/// A residual that is small does not say that the error is where charts are stretched; the steps of
/// more cycles do.
constexpr SettleOptions settling_to_the_end{.tolerance = 1e-6, .least_cycles = 4};

}  // namespace

FilterTool::FilterTool(Session& session)
    : session_(session), options_(options_for("filter", session)) {
  const TexturedModel& scene = *session.scene;
  require_usable(scene.defects(), scene.model.path.string());
  options_.set("beta", {first_beta});
  const auto kind = at_vertices() ? Outputs::Kind::model : Outputs::Kind::pictures;
  const std::string each = session.before && session.before->size() > 1 ? "_%s" : "";
  mask_name_ = session.free_name("mask" + each + (at_vertices() ? ".ply" : ".png"), kind);
  texture_name_ = session.free_name("filtered" + each +
                                        (at_vertices()                ? ".ply"
                                         : holds_numbers(scene.model) ? ".exr"
                                                                      : ".png"),
                                    kind);
  options_.set("output", {texture_name_});
}

// ---- what a person does

void FilterTool::panel() {
  const bool is_ready = ready_;
  if (!is_ready) {
    ImGui::TextUnformatted("preparing ...");
    return;
  }
  const auto tried = [&](const auto& what) { view::tried(session_, what); };
  const std::string reach = options_.given("length") ? "length" : "alpha";
  for (const std::string& name : {std::string("beta"), reach})
    tried([&] {
      OptionValues edited = options_;
      if (!edit(edited, name)) return;
      if (!edited.given("beta")) edited.set("beta", {first_beta});
      take(edited);
    });
  if (reach == "alpha" && ImGui::SmallButton("as a length"))
    tried([&] {
      set("length", fmt::format("{:.3g}tx", std::sqrt(options_.number("alpha") * scale_.area) /
                                                scale_.texel_spacing));
    });
  int brush = int(brush_);
  ImGui::RadioButton("sharpen", &brush, 0);
  ImGui::SameLine();
  ImGui::RadioButton("smooth", &brush, 1);
  ImGui::SameLine();
  ImGui::RadioButton("erase", &brush, 2);
  if (brush != int(brush_)) tried([&] { choose(Brush(brush)); });
  edit_brush(size_, brush_radius(), scale_.area);
  auto strength = float(strength_);
  if (ImGui::SliderFloat("strength", &strength, 0.01F, 1, "%.2f", ImGuiSliderFlags_AlwaysClamp))
    strength_ = strength;
  if (ImGui::Button("undo")) tried([&] { undo(); });
  ImGui::SameLine();
  if (ImGui::Button("redo")) tried([&] { redo(); });
  ImGui::SameLine();
  if (ImGui::Button("everywhere")) fill(full);
  ImGui::SameLine();
  if (ImGui::Button("nowhere")) fill(0);
  if (ask_to_save("mask", mask_name_)) tried([&] { save_mask(mask_name_); });
  if (ask_to_save(at_vertices() ? "model" : "texture", texture_name_))
    tried([&] { save_texture(texture_name_); });
  copy_button(session_, [&] { return as_command(); });
  ImGui::TextUnformatted(fmt::format("{} {} painted{}", painted_, paint_target_->unknowns(),
                                     settled_ ? "" : ", solving")
                             .c_str());
}

void FilterTool::press(const Pick& pick) {
  if (!ready_) return;
  begin_stroke();
  last_dab_.reset();
  brushing_ = true;
  if (pick) dabs_to(pick.point);
}

void FilterTool::drag(const Pick& pick) {
  if (ready_ && pick) dabs_to(pick.point);
}

void FilterTool::release() {
  brushing_ = false;
  end_stroke();
}

std::optional<Look::Paint> FilterTool::shown_as() const {
  if (at_vertices()) return Look::Paint::vertex_colours;
  return {};
}

double FilterTool::brush_radius() const {
  return ready_ ? std::sqrt(weight_from_length(size_, scale_)) : 0;
}

/// Along a straight line from the last one, a third of the radius apart; a thousand at most, which
/// a brush much smaller than its way takes.
void FilterTool::dabs_to(const Vector3& place) {
  if (!last_dab_) {
    dab(place);
    last_dab_ = place;
    return;
  }
  const double way = (place - *last_dab_).norm(), apart = std::max(brush_radius() / 3, way / 1000);
  if (!(apart > 0) || !std::isfinite(way)) return;
  const Vector3 start = *last_dab_;
  for (double at = apart; at <= way; at += apart) {
    last_dab_ = start + at / way * (place - start);
    dab(*last_dab_);
  }
}

void FilterTool::dab(const Vector3& place) {
  const Stopwatch watch;
  const double radius = brush_radius();
  const std::vector<int> unknowns = paint_target_->reach(place, radius);
  const Spot spot{place, radius, strength_};
  std::vector<int> after;
  for (const int k : unknowns)
    after.push_back(painted_with(mask_[std::size_t(k)], paint_at(spot, paint_target_->place(k))));
  change(unknowns, after);
  touches_.push_back(watch.seconds());
}

/// A value of the mask under so much paint. What is erased goes to 0 from either side.
int FilterTool::painted_with(int before, double paint) const {
  const double now = double(before) / full;
  double after = 0;
  if (brush_ == Brush::erase)
    after = now < 0 ? std::min(0.0, now + paint) : std::max(0.0, now - paint);
  else if (brush_ == Brush::smooth && options_.number("beta") > 1)
    after = std::max(-1.0, now - paint);
  else
    after = std::min(1.0, now + paint);
  return int(std::lround(after * full));
}

void FilterTool::fill(int value) {
  if (!ready_) return;
  begin_stroke();
  std::vector<int> unknowns;
  for (std::size_t k = 0; k < mask_.size(); ++k)
    if (mask_[k] != value) unknowns.push_back(int(k));
  change(unknowns, std::vector<int>(unknowns.size(), value));
  end_stroke();
}

/// Part of a stroke.
void FilterTool::change(const std::vector<int>& unknowns, const std::vector<int>& values) {
  if (unknowns.empty()) return;
  const std::lock_guard lock(mutex_);
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    int& mask = mask_[std::size_t(unknowns[i])];
    if (mask == values[i]) continue;
    stroke_.unknowns.push_back(unknowns[i]);
    stroke_.before.push_back(mask);
    stroke_.after.push_back(values[i]);
    painted_ += int(values[i] != 0) - int(mask != 0);
    smoothed_ += int(values[i] < 0) - int(mask < 0);
    mask = values[i];
    wanted_.mask.emplace_back(unknowns[i], values[i]);
    settled_ = false;
  }
  stopped_ = false;
  hurry_ = true;
  ++wanted_.version;
  ++changes_;
  saved_mask_.clear();
}

void FilterTool::end_stroke() {
  last_dab_.reset();
  if (stroke_.unknowns.empty()) return;
  undo_.push_back(std::move(stroke_));
  redo_.clear();
  begin_stroke();
}

void FilterTool::undo() {
  if (undo_.empty()) return;
  require_beta_for(undo_.back().before);
  Stroke stroke = std::move(undo_.back());
  undo_.pop_back();
  begin_stroke();
  // The last change of a texel is taken back first: a stroke may meet it several times.
  std::ranges::reverse(stroke.unknowns);
  std::ranges::reverse(stroke.before);
  change(stroke.unknowns, stroke.before);
  std::ranges::reverse(stroke.unknowns);
  std::ranges::reverse(stroke.before);
  begin_stroke();
  redo_.push_back(std::move(stroke));
}

void FilterTool::redo() {
  if (redo_.empty()) return;
  require_beta_for(redo_.back().after);
  Stroke stroke = std::move(redo_.back());
  redo_.pop_back();
  begin_stroke();
  change(stroke.unknowns, stroke.after);
  begin_stroke();
  undo_.push_back(std::move(stroke));
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

void FilterTool::set(const std::string& name, const std::string& value) {
  require(name == "beta" || name == "alpha" || name == "length",
          fmt::format("the tool filter has beta, alpha and length to set; found '{}'", name));
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

bool FilterTool::command(const std::vector<std::string>& words) {
  const std::string& what = words[0];
  const auto numbers = [&](const std::string& word, std::size_t count) {
    const auto parsed = app::parse_numbers(word, count);
    require(parsed.has_value(), fmt::format("found '{}', wanted {} numbers", word, count));
    return *parsed;
  };
  require_ready();
  if (what == "set") {
    require(words.size() == 3,
            fmt::format("set {}: found {} values, wanted one", words[1], words.size() - 2));
    set(words[1], words[2]);
  } else if (what == "brush") {
    require(words[1] == "sharpen" || words[1] == "smooth" || words[1] == "erase",
            fmt::format("found '{}', wanted sharpen, smooth or erase", words[1]));
    choose(words[1] == "sharpen"  ? Brush::sharpen
           : words[1] == "smooth" ? Brush::smooth
                                  : Brush::erase);
  } else if (what == "size") {
    const Length size = parse_length(words[1]);
    require(size.value > 0, fmt::format("found '{}', wanted a length above 0", words[1]));
    size_ = size;
  } else if (what == "strength") {
    const double strength = numbers(words[1], 1)[0];
    require(strength > 0 && strength <= 1,
            fmt::format("found '{}', wanted above 0, at most 1", words[1]));
    strength_ = strength;
  } else if (what == "stroke") {
    std::vector<Vector3> places;
    for (std::size_t i = 1; i < words.size(); ++i) {
      const auto place = numbers(words[i], 3);
      places.emplace_back(place[0], place[1], place[2]);
    }
    begin_stroke();
    last_dab_.reset();
    const int before = changes_;
    for (const Vector3& place : places) dabs_to(place);
    end_stroke();
    if (changes_ == before) session_.say("the stroke touches nothing");
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

/// A command that reads the mask and writes the texture can only be repeated where they are two
/// files.
void FilterTool::require_other_files(const std::vector<fs::path>& files,
                                     const std::vector<fs::path>& others) {
  for (const fs::path& file : files)
    for (const fs::path& other : others)
      require(
          fs::weakly_canonical(file) != fs::weakly_canonical(other),
          fmt::format("{}: mask and texture need files of their own: name another", file.string()));
}

Outputs FilterTool::outputs(const std::string& path) const {
  return {path, session_.scene->model, paint_target_->kind()};
}

void FilterTool::save_texture(const std::string& path) {
  require_ready();
  const Outputs outputs = this->outputs(path);
  require_other_files(outputs.paths(), mask_files_);
  session_.run.will_write(outputs.paths(), outputs.folder());
  texture_name_ = path;
  texture_files_ = outputs.paths();
  const std::lock_guard lock(mutex_);
  saves_.emplace_back().path = path;
  stopped_ = false;
}

void FilterTool::save_mask(const std::string& path) {
  require_ready();
  const Outputs outputs = this->outputs(path);
  for (const auto& file : outputs.paths()) paint_target_->require_mask_name(file, smoothed_ > 0);
  require_other_files(outputs.paths(), texture_files_);
  session_.run.will_write(outputs.paths(), outputs.folder());
  mask_files_ = outputs.paths();
  mask_name_ = path;
  const std::lock_guard lock(mutex_);
  saves_.push_back({.path = path,
                    .masks = outputs.paths(),
                    .mask = mask_,
                    .smooths = smoothed_ > 0,
                    .changes = changes_});
  stopped_ = false;
}

/// What was painted since is not in the file.
void FilterTool::take_note_of_written() {
  std::vector<Save> written;
  {
    const std::lock_guard lock(mutex_);
    written.swap(written_);
  }
  for (const Save& save : written) {
    std::vector<std::string> names;
    for (const auto& file : save.masks) names.push_back(file.string());
    options_.set("mask", names);
    if (save.changes == changes_) saved_mask_ = save.path;
    session_.say("wrote " + save.path);
  }
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

void FilterTool::give_up_saving() {
  const std::lock_guard lock(mutex_);
  std::string paths;
  for (const Save& save : saves_) paths += (paths.empty() ? "" : ", ") + save.path;
  saves_.clear();
  if (!paths.empty()) session_.say("not saved: " + paths);
}

std::string FilterTool::saving() const {
  const std::lock_guard lock(mutex_);
  return saves_.empty() ? "" : saves_.front().path;
}

std::string FilterTool::unsaved() const {
  const std::lock_guard lock(mutex_);
  const bool kept = !saved_mask_.empty() || saved_version_ == wanted_.version;
  return nothing_painted() || kept ? "" : "what was painted with the filter";
}

nlohmann::ordered_json FilterTool::report() const {
  nlohmann::ordered_json strokes = nlohmann::ordered_json::array();
  for (const Timing& t : timings_)
    strokes.push_back({{at_vertices() ? "vertices" : "texels", t.unknowns},
                       {"update", t.update},
                       {"solve", t.solve},
                       {"cycles", t.cycles},
                       {"show", t.show}});
  return {{"name", name()},
          {"unknowns", mask_.size()},
          {"painted", painted_},
          {"settled", is_settled() && !brushing_},
          {"prepare_seconds", preparing_},
          {"settle_seconds", settling_},
          {"settle_rounds", rounds_},
          {"touches", touches_},
          {"strokes", strokes}};
}

// ---- the work behind it

void FilterTool::prepare(const Progress& progress) {
  const Stopwatch watch;
  run_ = std::make_unique<app::Run>(options_, session_.run.terminal(), progress);
  about(session_.scene->model, [&] {
    paint_target_ = make_paint_target(session_, *run_, progress.step("assemble", 0.8));
    before_ = paint_target_->target().values();
  });
  scale_ = paint_target_->target().scale();
  want();
  mask_.assign(std::size_t(before_.rows()), 0);
  followed_ = mask_;
  preparing_ = watch.seconds();
  settled_ = true;
  ready_ = true;
}

void FilterTool::work(const Progress& progress) {
  if (!ready_) prepare(progress);
  const Progress solving = progress.step("solve", 1);
  for (;;) {
    solving.at(0);
    while (write_mask()) progress.check();
    Wanted wanted;
    {
      const std::lock_guard lock(mutex_);
      wanted = wanted_;
      wanted_.mask.clear();
      hurry_ = false;
    }
    if (!step_on(std::move(wanted), progress)) return;
  }
}

/// Does the most urgent thing; false where there is nothing to do.
bool FilterTool::step_on(Wanted wanted, const Progress& progress) {
  const bool other_gain = std::exchange(gain_, wanted.gain) != wanted.gain;
  if (other_gain && live_) {
    // Where it smooths, β − 1 is not beta's affair: what is solved for there is another.
    Wanted all;
    for (std::size_t k = 0; k < followed_.size(); ++k)
      if (followed_[k] < 0) all.mask.emplace_back(int(k), followed_[k]);
    if (!all.mask.empty()) settled_ = false;
    wanted.mask.insert(wanted.mask.begin(), all.mask.begin(), all.mask.end());
  }
  if (!live_ || weight_ != wanted.weight) {
    const Stopwatch watch;
    for (const auto& [unknown, value] : wanted.mask) followed_[std::size_t(unknown)] = value;
    live_.reset();
    try {
      const Progress either([&](const ProgressEvent&) { progress.check(); }, &hurry_);
      live_.emplace(paint_target_->live(wanted.weight, before_, either));
    } catch (const Cancelled&) {
      progress.check();
      return true;  // another weight is wanted by now, perhaps
    }
    weight_ = wanted.weight;
    Wanted all;
    for (std::size_t k = 0; k < followed_.size(); ++k)
      if (followed_[k] != 0) all.mask.emplace_back(int(k), followed_[k]);
    settled_ = all.mask.empty();
    if (!all.mask.empty()) follow(all);
    show(Extent::all);
    preparing_ += watch.seconds();
    return true;
  }
  if (!wanted.mask.empty()) {
    follow(wanted);
    if (other_gain) show(Extent::all);
    return true;
  }
  if (other_gain) {
    show(Extent::all);
    return true;
  }
  if (!settled_ && brushing_) return false;  // the next touch comes soon
  if (!settled_) {
    if (std::ranges::all_of(followed_, [](int m) { return m == 0; })) {
      settled_ = true;
      show(Extent::all);
      return true;
    }
    const Stopwatch watch;
    try {
      const SolveReport report = live_->settle(settling, Progress({}, &hurry_));
      progress.check();
      if (report.converged) live_->settle(settling_to_the_end, Progress({}, &hurry_));
      progress.check();
      ++rounds_;
      const std::lock_guard lock(mutex_);
      if (wanted_.mask.empty()) settled_ = report.converged;
    } catch (const Cancelled&) {
      progress.check();
    }
    show(Extent::all);
    settling_ += watch.seconds();
    return true;
  }
  return write_texture(wanted.version, progress);
}

/// Whether there was one to be written: nothing need be solved for it.
bool FilterTool::write_mask() {
  Save save;
  {
    const std::lock_guard lock(mutex_);
    if (saves_.empty() || saves_.front().masks.empty()) return false;
    save = saves_.front();
  }
  paint_target_->write_mask(save.mask, full, save.smooths, save.masks);
  save.mask.clear();
  const std::lock_guard lock(mutex_);
  saves_.pop_front();
  written_.push_back(std::move(save));
  return true;
}

bool FilterTool::write_texture(int version, const Progress& progress) {
  std::string path;
  {
    const std::lock_guard lock(mutex_);
    if (saves_.empty()) return false;
    path = saves_.front().path;
  }
  Model model = session_.scene->model;
  const bool nothing = std::ranges::all_of(followed_, [](int m) { return m == 0; });
  if (!nothing)
    paint_target_->target().put(before_, before_ + gain_ * (live_->signal() - before_), model);
  const Outputs outputs = this->outputs(path);
  for (const std::string& note : outputs.write(std::move(model), progress.step("write", 0)))
    session_.run.terminal().remark(note);
  saved_version_ = version;
  {
    const std::lock_guard lock(mutex_);
    saves_.pop_front();
  }
  session_.run.terminal().remark("wrote " + path);
  return true;
}

void FilterTool::follow(const Wanted& wanted) {
  Timing timing{.unknowns = wanted.mask.size()};
  std::vector<int> unknowns;
  std::vector<double> beta;
  for (const auto& [unknown, value] : wanted.mask) {
    followed_[std::size_t(unknown)] = value;
    unknowns.push_back(unknown);
  }
  std::ranges::sort(unknowns);
  unknowns.erase(std::unique(unknowns.begin(), unknowns.end()), unknowns.end());
  for (const int k : unknowns) {
    const double mask = double(followed_[std::size_t(k)]) / full;
    beta.push_back(1 + (mask < 0 ? mask / gain_ : mask));
  }
  {
    const Stopwatch watch;
    live_->modulate(unknowns, beta);
    timing.update = watch.seconds();
  }
  const bool small = double(unknowns.size()) < most_to_follow * double(followed_.size());
  if (small) {
    const Stopwatch watch;
    timing.cycles = live_->follow({.error = seen / std::max(std::abs(gain_), seen)}).cycles;
    timing.solve = watch.seconds();
  }
  const Stopwatch watch;
  show(small ? Extent::followed : Extent::all);
  timing.show = watch.seconds();
  timings_.push_back(timing);
}

void FilterTool::show(Extent extent) {
  const bool nothing = settled_ && std::ranges::all_of(followed_, [](int m) { return m == 0; });
  const ShownSignal values{before_, live_->signal(), nothing ? 0 : gain_};
  if (extent == Extent::followed)
    paint_target_->show(values, live_->followed());
  else
    paint_target_->show(values, std::nullopt);
}

}  // namespace mq::view
