// The work behind the window: the equation is solved for the mask as it is.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>
#include <utility>

#include "filter_tool.h"
#include "mq/base/error.h"
#include "mq/base/stopwatch.h"
#include "mq/image/colour.h"
#include "shell/duration.h"

namespace mq::view {
namespace {

/// A change of more texels than this share of all is solved for everywhere at once.
constexpr double most_to_follow = 0.25;

/// What is seen of an error in a texture of 8 bits: half a step.
constexpr double seen = 0.5 / 255;

/// Of solving for a change: what levels of another equation take, and where the last cycles begin.
constexpr double making_levels = 0.4, last_cycles = 0.8;

/// So many seconds a hand that moves takes from touch to touch, or less: what cycles left over waits for it to rest.
constexpr double next_touch = 0.15;

/// Cycles between two looks at a solution on its way.
constexpr SettleOptions settling{.tolerance = 1e-6, .max_cycles = 2};

/// A residual that is small does not say that the error is where charts are stretched; the steps of
/// more cycles do.
constexpr SettleOptions settling_to_the_end{.tolerance = 1e-6, .least_cycles = 4};

}  // namespace

void FilterTool::prepare(const Progress& progress) {
  const Stopwatch watch;
  run_ = std::make_unique<app::Run>(options_, session_.run.terminal(), progress);
  about(session_.scene->model, [&] {
    paint_target_ = make_paint_target(session_, *run_, progress.step("assemble", 0.8));
    before_ = paint_target_->target().values();
    const double halo = app::asked_halo(options_, session_.scene->model, app::largest_value(before_));
    if (std::isfinite(halo))
      limit_.emplace(paint_target_->target().space(), before_, HaloOptions{.fraction = halo},
                     progress.step("look around", 0.1));
  });
  scale_ = paint_target_->target().scale();
  want();
  mask_.assign(std::size_t(before_.rows()), 0);
  followed_ = mask_;
  of_touches_ = RowSet(before_.rows());
  preparing_ = watch.seconds();
  const Signal nothing_yet = before_;
  count_values({before_, nothing_yet, 0});
  values_before_ = values_after_;
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

void FilterTool::begin_solving() {
  solved_ = 0;
  reduction_ = 1;
  const std::lock_guard lock(mutex_);
  solving_since_ = Stopwatch();
}

Progress FilterTool::solving(double from, double to, const Progress& progress) {
  return Progress(
      [this, from, to, &progress](const ProgressEvent& event) {
        progress.check();
        solved_ = from + (to - from) * event.fraction;
      },
      &hurry_);
}

std::string FilterTool::working() const {
  constexpr double a_while = 0.5;  // seconds
  if (!ready_ && background_.busy() && background_.seconds() > a_while)
    return "the brush is being prepared: " + background_.how_far() + " (Escape stops it)";
  double seconds = 0;
  {
    const std::lock_guard lock(mutex_);
    seconds = solving_since_.seconds();
  }
  if (!ready_ || !background_.busy() || is_settled() || seconds < a_while) return {};
  if (settled_) return saving().empty() ? "" : saving() + " is being written";
  return fmt::format("what was painted is being worked out: {:.0f} %{} (Escape stops it)", std::floor(100 * solved_),
                     app::estimate(app::seconds_left(solved_, seconds)));
}

/// The equation with another weight.
void FilterTool::make_live(const Wanted& wanted, const Progress& progress) {
  const Stopwatch watch;
  for (const auto& [unknown, value] : wanted.mask) followed_[std::size_t(unknown)] = value;
  live_.reset();
  unfinished_ = 0;
  begin_solving();
  try {
    LiveOptions live;
    if (limit_) live.texture.assign(limit_->texture().begin(), limit_->texture().end());
    live_.emplace(paint_target_->live(wanted.weight, before_, live, solving(0, making_levels, progress)));
  } catch (const Cancelled&) {
    progress.check();
    return;  // another weight is wanted by now, perhaps
  }
  weight_ = wanted.weight;
  Wanted all;
  for (std::size_t k = 0; k < followed_.size(); ++k)
    if (followed_[k] != 0) all.mask.emplace_back(int(k), followed_[k]);
  settled_ = all.mask.empty();
  if (!all.mask.empty()) follow(all);
  show(Extent::all);
  preparing_ += watch.seconds();
}

/// A cycle first, for something to be seen soon, then two at a time; how far that is says the residual.
void FilterTool::settle(const Progress& progress) {
  const Stopwatch watch;
  const double from = solved_;
  SettleOptions few = settling;
  if (reduction_ == 1) few.max_cycles = 1;
  try {
    const SolveReport report = live_->settle(few, solving(from, from + 0.3 * (last_cycles - from), progress));
    progress.check();
    reduction_ *= std::clamp(report.residuals.empty() ? 0.5 : report.residuals.back(), 1e-12, 0.999);
    const double part = std::min(1.0, std::log(reduction_) / std::log(settling.tolerance));
    solved_ = std::max(solved_.load(), from + (last_cycles - from) * part);
    if (report.converged) live_->settle(settling_to_the_end, solving(last_cycles, 1, progress));
    progress.check();
    ++rounds_;
    const std::lock_guard lock(mutex_);
    if (wanted_.mask.empty()) settled_ = report.converged;
  } catch (const Cancelled&) {
    progress.check();
  }
  show(Extent::all);
  settling_ += watch.seconds();
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
    make_live(wanted, progress);
    return true;
  }
  if (!wanted.mask.empty()) {
    begin_solving();
    follow(wanted);
    if (other_gain) show(Extent::all);
    return true;
  }
  if (other_gain) {
    show(Extent::all);
    return true;
  }
  if (!settled_ && brushing_) {  // the next touch comes soon
    if (unfinished_ == 0) return false;
    if (since_followed_.seconds() < next_touch) {
      progress.check();
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      return true;
    }
    follow_on();
    show(Extent::followed);
    return true;
  }
  if (!settled_) {
    if (std::ranges::all_of(followed_, [](int m) { return m == 0; })) {
      settled_ = true;
      show(Extent::all);
      return true;
    }
    settle(progress);
    return true;
  }
  return write_texture(wanted.version, progress);
}

void FilterTool::follow(const Wanted& wanted) {
  Timing timing{.unknowns = wanted.mask.size()};
  for (const auto& [unknown, value] : wanted.mask) {
    followed_[std::size_t(unknown)] = value;
    of_touches_.add(unknown);
  }
  const std::vector<int> unknowns = of_touches_.rows();
  of_touches_.clear();
  std::vector<double> beta(unknowns.size());
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    const double mask = double(followed_[std::size_t(unknowns[i])]) / full;
    beta[i] = 1 + (mask < 0 ? mask / gain_ : mask);
  }
  {
    const Stopwatch watch;
    live_->modulate(unknowns, beta);
    timing.update = watch.seconds();
  }
  const bool small = double(unknowns.size()) < most_to_follow * double(followed_.size());
  if (small) {
    const Stopwatch watch;
    timing.cycles = follow_on().cycles;
    timing.solve = watch.seconds();
  }
  const Stopwatch watch;
  show(small ? Extent::followed : Extent::all);
  timing.show = watch.seconds();
  timings_.push_back(timing);
  since_followed_ = Stopwatch();
}

/// As far as a picture can wait for it.
Followed FilterTool::follow_on() {
  const Followed followed = live_->follow(
      {.error = seen / std::max(std::abs(gain_), seen), .enough = FollowOptions::for_a_picture});
  unfinished_ = followed.unfinished;
  return followed;
}

void FilterTool::show(Extent extent) {
  const bool nothing = settled_ && std::ranges::all_of(followed_, [](int m) { return m == 0; });
  ShownSignal values = shown();
  if (nothing) values.gain = 0;
  if (extent == Extent::followed)
    return paint_target_->show(values, live_->followed());
  paint_target_->show(values, std::nullopt);
  count_values(values);
}

/// Of colours alone, which alpha is none of.
void FilterTool::count_values(const ShownSignal& values) {
  constexpr int bins = 64;
  constexpr double half_step = 0.5 / 255;  // of what is shown
  const int channels = colour_channels(int(before_.cols()));
  const Histogram now = histogram(before_.rows() * channels, bins, half_step, [&](std::int64_t i) {
    return values(i / channels, int(i % channels));
  });
  const std::lock_guard lock(mutex_);
  values_after_ = now;
}

}  // namespace mq::view
