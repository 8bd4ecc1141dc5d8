// What the brush does to the mask, and how it is taken back.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "filter_tool.h"
#include "mq/base/parallel.h"
#include "mq/base/stopwatch.h"
#include "mq/filter/modulation.h"

namespace mq::view {

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
  if (brushing_.exchange(false)) end_brush_stroke();
}

/// A stroke that did nothing says so.
void FilterTool::end_brush_stroke() {
  if (!touched_)
    session_.say(fmt::format("the stroke touches nothing of the model: no {} is within the brush",
                             at_vertices() ? "vertex" : "texel"));
  else if (stroke_.unknowns.empty())
    session_.say("the stroke changes nothing: what it touches is so already");
  end_stroke(brush_name());
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
  touched_ = touched_ || !unknowns.empty();
  const Spot spot{place, radius, strength_, hardness_};
  std::vector<int> after(unknowns.size());
  parallel_for(std::ssize(unknowns), [&](std::int64_t i) {
    const int k = unknowns[std::size_t(i)];
    after[std::size_t(i)] = painted_with(mask_[std::size_t(k)], paint_at(spot, paint_target_->place(k)));
  });
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
  end_stroke(value == 0 ? "nowhere" : "everywhere");
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

std::string FilterTool::brush_name() const {
  return brush_ == Brush::sharpen ? "sharpen" : brush_ == Brush::smooth ? "smooth" : "erase";
}

/// Those of `redo_` come in the other order.
Tool::History FilterTool::history() const {
  History all{{}, undo_.size()};
  for (const Stroke& stroke : undo_) all.strokes.push_back(stroke.name);
  for (auto stroke = redo_.rbegin(); stroke != redo_.rend(); ++stroke)
    all.strokes.push_back(stroke->name);
  return all;
}

void FilterTool::scale_brush(double factor) {
  if (ready_)
    size_ = {std::clamp(100 * factor * brush_radius() / std::sqrt(scale_.area), 0.1, 50.0),
             Length::Unit::percent};
}

void FilterTool::end_stroke(const std::string& name) {
  last_dab_.reset();
  if (stroke_.unknowns.empty()) return;
  stroke_.name = name;
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

}  // namespace mq::view
