// With L = Dᵀ m̄ D and δ = φ − ψ:
//
//     (m + w·S + γ·L)·δ = w (β − 1) S·ψ + γ (η − 1) L·ψ.
//
// A window's first frame hangs on the last one that was kept, whose δ is known by then:
//
//     γ m̄ |δ(t) − Σ w δ_before(s) + (1 − η) Dψ(t)|²   adds γ m̄ to the diagonal
//     and γ m̄ (Σ w δ_before(s) + (η − 1) Dψ(t)) on the right.
//
// Sparse matrices are swapped: Eigen copies those that are moved.

#include "mq/video/temporal_poisson.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <utility>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "mq/base/parallel.h"
#include "mq/base/words.h"
#include "mq/video/detail/change_leaders.h"

namespace mq {
namespace {

/// A frame while it is held.
struct Held {
  TemporalFrame frame;
  std::weak_ptr<const SignalSpace> space;
  Vector mass, strength;
  SparseMatrix K;
  Signal right;              // of the spatial part
  Signal slid;               // of the change from the frame before what only slid; no rows: nothing
  TimeLinks links;           // of changes
  std::vector<int> leaders;  // see `change_leaders`
  std::vector<char> is_led;  // 1: it changes as its leader does, as it is another texel before or after
};

/// As `ScreenedPoisson` with a screen of ones.
Vector positive_mass(const SignalSpace& space) {
  const Vector mass = space.lumped_mass();
  return mass.cwiseMax(1e-12 * mass.mean());
}

SparseMatrix diagonal_matrix(const Vector& diagonal) {
  SparseMatrix D(diagonal.size(), diagonal.size());
  D.reserve(diagonal.size());
  for (int i = 0; i < diagonal.size(); ++i) {
    D.startVec(i);
    D.insertBack(i, i) = diagonal[i];
  }
  D.finalize();
  return D;
}

Vector strengths(const TimeLinks& links, const Vector& mass, const Vector& mass_before,
                 double gamma) {
  Vector result = Vector::Zero(links.rows());
  for (int t = 0; t < links.rows(); ++t) {
    if (!links.linked(t)) continue;
    const int same = links.same(t);
    result[t] = gamma * (same >= 0 ? 0.5 * (mass[t] + mass_before[same]) : mass[t]);
  }
  return result;
}

void check_frame(const TemporalFrame& frame, int number, int before) {
  const int size = frame.space->size();
  require(frame.psi.rows() == size, fmt::format("frame {} has a signal of {} rows and {} unknowns",
                                                number, frame.psi.rows(), size));
  require(frame.psi.allFinite(), fmt::format("frame {} has values that are not finite", number));
  if (number == 0) return;
  require(frame.links.rows() == size, fmt::format("frame {} has links of {} rows and {} unknowns",
                                                  number, frame.links.rows(), size));
  for (const TimeLinks::Entry& entry : frame.links.entries)
    require(entry.column >= 0 && entry.column < before,
            fmt::format("frame {} is linked to unknown {} of {}", number, entry.column, before));
}

/// Σ w v(s) over a row of links.
Eigen::RowVectorXd before(const TimeLinks& links, int t, const Signal& v) {
  Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(v.cols());
  for (int e = links.starts[t]; e < links.starts[t + 1]; ++e)
    sum += links.entries[e].weight * v.row(links.entries[e].column);
  return sum;
}

/// By how much texels differ from the frame before as the surface slid under them: half-way between what that one
/// shows where their points were, and what this one shows where its points went. No rows where nothing was followed.
Signal slid_change(const TemporalFrame& was, const TemporalFrame& is) {
  if (!was.drift || !is.drift || !is.drift->follows()) return {};
  const std::vector<ChartPlace> from = is.drift->before(is.drift->starts()),
                                to = is.drift->after(was.drift->starts());
  Signal slid = Signal::Zero(is.psi.rows(), is.psi.cols());
  parallel_for(is.psi.rows(), [&](std::int64_t t) {
    if (const int s = is.links.same(int(t)); s >= 0)
      slid.row(t) = 0.5 * (was.drift->change(was.psi, s, from[t]) - is.drift->change(is.psi, int(t), to[s]));
  });
  return slid;
}

class Stream {
 public:
  Stream(const FrameSource& load, const TemporalOptions& options) : load_(load), options_(options) {}

  /// Holds frames up to, not including, this one.
  void hold(int end, const Progress& progress) {
    const double work = options_.costs.loading(loaded_, end);
    for (; loaded_ < end; ++loaded_) {
      const double share = work > 0 ? options_.costs.loading(loaded_, loaded_ + 1) / work : 0;
      Held& held = held_.emplace_back();
      held.frame = load_(loaded_, progress.step("read", share));
      const TemporalFrame& frame = held.frame;
      check_frame(frame, loaded_, int(mass_before_.size()));
      held.mass = positive_mass(*frame.space);
      if (loaded_ > 0)
        held.strength = strengths(frame.links, held.mass, mass_before_, options_.gamma);
      diagonal_matrix(held.mass).swap(held.K);
      held.right = Signal::Zero(frame.psi.rows(), frame.psi.cols());
      if (options_.weight > 0) {
        SparseMatrix(frame.space->regularised_system(0, options_.weight) + held.K).swap(held.K);
        if (options_.beta != 1) {
          held.right = frame.space->stiffness_times(frame.psi);
          held.right *= options_.weight * (options_.beta - 1);
        }
      }
      held.links = frame.links;
      if (options_.gamma > 0)
        held.leaders = change_leaders(
            options_.weight > 0 ? held.K : frame.space->regularised_system(0, 1), held.mass);
      held.space = frame.space;
      held.frame.space.reset();
      mass_before_ = held.mass;
      if (options_.gamma > 0 && loaded_ > 0) lead_where_texels_change();
      if (held_.size() < 2) continue;
      TemporalFrame& last = held_[held_.size() - 2].frame;
      held.slid = slid_change(last, held.frame);
      last.drift.reset();
    }
  }

  int held() const { return int(held_.size()); }
  const TemporalFrame& frame(int i) const { return held_[i].frame; }

  /// A frame to be given back.
  const TemporalFrame& whole_frame(int i) {
    held_[i].frame.space = held_[i].space.lock();
    return held_[i].frame;
  }

  /// The system's; the first frames are not needed again, and hand their matrices over.
  std::vector<TimePlane> planes(int last_time) {
    std::vector<TimePlane> result(held_.size());
    for (std::size_t f = 0; f < held_.size(); ++f) {
      TimePlane& plane = result[f];
      plane.links = held_[f].links;
      plane.strength = held_[f].strength;
      if (int(f) < last_time)
        plane.K.swap(held_[f].K);
      else
        plane.K = held_[f].K;
      if (f == 0) {
        for (int t = 0; t < plane.strength.size(); ++t) plane.K.coeffRef(t, t) += plane.strength[t];
        plane.K.makeCompressed();
        plane.links = {};
        plane.strength = {};
      }
    }
    return result;
  }

  Signal right_hand_side(const TimeMultigrid& system) const {
    const int channels = int(held_[0].right.cols());
    Signal b(system.matrix().rows(), channels);
    for (int f = 0; f < held(); ++f) {
      require(held_[f].right.cols() == channels,
              fmt::format("frames have {} and {} channels", channels, held_[f].right.cols()));
      b.middleRows(system.offset(f), held_[f].right.rows()) = held_[f].right;
    }
    for (int f = 0; f < held(); ++f) {
      const TimeLinks &links = held_[f].links, &of_values = held_[f].frame.links;
      const Signal& was = f > 0 ? held_[f - 1].frame.psi : psi_before_;
      for (int t = 0; t < held_[f].strength.size(); ++t) {
        const double d = held_[f].strength[t];
        if (d == 0) continue;
        Eigen::RowVectorXd change = held_[f].frame.psi.row(t) - before(of_values, t, was);
        if (held_[f].slid.rows() > 0) change -= held_[f].slid.row(t);
        const Eigen::RowVectorXd force = d * (options_.change - 1) * change;
        b.row(system.offset(f) + t) += force;
        if (f == 0) {
          b.row(t) += d * before(links, t, delta_before_);
          continue;
        }
        for (int e = links.starts[t]; e < links.starts[t + 1]; ++e)
          b.row(system.offset(f - 1) + links.entries[e].column) -= links.entries[e].weight * force;
      }
    }
    return b;
  }

  /// The change of a frame, once all is solved for.
  Signal led(int f, Signal delta) const {
    const Held& held = held_[f];
    for (std::size_t t = 0; t < held.is_led.size(); ++t)
      if (held.is_led[t]) delta.row(Eigen::Index(t)) = delta.row(held.leaders[t]);
    return delta;
  }

  /// Lets the first frames go, the change of the last of which is this.
  void release(int count, const Signal& delta) {
    psi_before_ = std::move(held_[count - 1].frame.psi);
    delta_before_ = delta;
    held_.erase(held_.begin(), held_.begin() + count);
  }

 private:
  /// A texel at a border of a chart that moves meets the surface of the other frame in few points,
  /// if any, far outside of what it shows itself: led by squares over these alone it would take on
  /// √γ times what they differ by, and more.
  void lead_where_texels_change() {
    if (held_.size() < 2) return;  // a γ of nearly 0
    Held &last = held_.back(), &before = held_[held_.size() - 2];
    const TimeLinks& links = last.frame.links;
    fade_at_ends(links);
    last.is_led.assign(last.leaders.size(), 0);
    std::vector<char> ends(before.leaders.size(), 1);
    bool changes = false;
    for (int t = 0; t < links.rows(); ++t) {
      const int same = links.same(t);
      last.is_led[std::size_t(t)] = same < 0 && last.leaders[std::size_t(t)] >= 0;
      if (same >= 0) ends[std::size_t(same)] = 0;
      changes = changes || same < 0;
    }
    before.is_led.resize(ends.size(), 0);
    for (std::size_t s = 0; s < ends.size(); ++s)
      if (ends[s] && before.leaders[s] >= 0) before.is_led[s] = 1;
    if (!changes) return;
    last.links = led_links(links, last.leaders, before.leaders);
    for (int t = 0; t < links.rows(); ++t)
      if (!last.links.linked(t)) last.strength[t] = 0;
  }

  /// Where surface begins or ends between the last two frames it would stay as it is, beside what
  /// time has changed: what changes there goes on smoothly from what is beside it.
  void fade_at_ends(const TimeLinks& links) {
    if (options_.beta != 1 || links.entries.empty()) return;
    Held &last = held_.back(), &before = held_[held_.size() - 2];
    std::vector<char> begins(last.leaders.size()), ends(before.leaders.size(), 1);
    for (std::size_t t = 0; t < begins.size(); ++t) begins[t] = !links.linked(int(t));
    for (const TimeLinks::Entry& entry : links.entries) ends[std::size_t(entry.column)] = 0;
    add_differences(begins, last.mass, options_.gamma, last.K);
    add_differences(ends, before.mass, options_.gamma, before.K);
  }

  const FrameSource& load_;
  const TemporalOptions& options_;
  int loaded_ = 0;
  std::deque<Held> held_;
  Vector mass_before_;
  Signal psi_before_, delta_before_;
};

void check(const TemporalOptions& options) {
  for (const double value : {options.weight, options.gamma})
    require(value >= 0 && std::isfinite(value),
            fmt::format("weights of a screened Poisson equation in space and time are {} and {}; "
                        "they must be 0 or more, and finite",
                        options.weight, options.gamma));
  require(std::isfinite(options.beta) && std::isfinite(options.change),
          "gains of gradients and changes must be finite");
  require(
      options.accuracy > 0 && options.accuracy < 1,
      fmt::format("an accuracy of {} was asked for; it must be between 0 and 1", options.accuracy));
}

int window_for(const TemporalOptions& options) {
  return options.window > 0 ? options.window : 2 * look_ahead(options) + 8;
}

/// Frames that are solved for together, and as far as which they are kept.
struct Span {
  int begin = 0, kept = 0, end = 0;

  int solved() const { return end - begin; }
};

std::vector<Span> spans_of(int frames, int window, int look_ahead) {
  std::vector<Span> spans;
  for (int begin = 0; begin < frames; begin = spans.back().kept) {
    const int end = std::min(frames, begin + window);
    spans.push_back({begin, end == frames ? frames : end - look_ahead, end});
  }
  return spans;
}

/// What parts of the work take, by the time of filtering a frame.
struct Work {
  double read = 0, solve = 0, store = 0;

  double all() const { return read + solve + store; }
};

Work work_of(const Span& span, int loaded, const FrameCosts& costs) {
  return {.read = costs.loading(loaded, span.end),
          .solve = double(span.solved()),
          .store = (span.kept - span.begin) * costs.store};
}

double work_of(const std::vector<Span>& spans, const FrameCosts& costs) {
  double work = 0;
  int loaded = 0;
  for (const Span& span : spans) work += work_of(span, std::exchange(loaded, span.end), costs).all();
  return work;
}

double factor_of(const SolveReport& report) {
  if (report.cycles == 0 || report.residuals.empty()) return 0;
  return std::pow(report.residuals.back(), 1.0 / report.cycles);
}

}  // namespace

double FrameCosts::loading(int first, int end) const {
  double sum = load * std::max(0, end - first);
  for (int f = first; f < std::min(end, int(more.size())); ++f) sum += more[std::size_t(f)];
  return sum;
}

void TemporalReport::add(const SolveReport& window) {
  const double setup_before = solve.setup_seconds, solve_before = solve.solve_seconds;
  const bool converged = solve.converged && window.converged;
  if (windows == 0 || window.cycles > solve.cycles) solve = window;
  solve.setup_seconds = setup_before + window.setup_seconds;
  solve.solve_seconds = solve_before + window.solve_seconds;
  solve.converged = converged;
  factor = std::max(factor, factor_of(window));
  ++windows;
}

double decay_in_time(double gamma) {
  const double root = std::sqrt(1 + 4 * gamma);
  return 4 * gamma / ((1 + root) * (1 + root));  // = (1 + 2γ − √(1 + 4γ)) / 2γ
}

int look_ahead(const TemporalOptions& options) {
  if (options.gamma == 0) return 0;
  return int(std::ceil(std::log(options.accuracy) / std::log(decay_in_time(options.gamma))));
}

int frames_held(int frames, const TemporalOptions& options) {
  check(options);
  return std::min(frames, window_for(options));
}

TemporalReport temporal_poisson(int frames, const FrameSource& load,
                                const std::function<void(int, const TemporalFrame&, Signal)>& store,
                                const TemporalOptions& options, const Progress& progress) {
  check(options);
  TemporalReport report;
  report.look_ahead = look_ahead(options);
  const int window = window_for(options);
  require(window > report.look_ahead || window >= frames,
          fmt::format(
              "{}: found {}, and a gamma of {} looks {} ahead: wanted more than that, or 0, "
              "which holds as many as it takes",
              option_name("window"), window, options.gamma, counted(report.look_ahead, "frame")));
  Stream stream(load, options);
  const std::vector<Span> spans = spans_of(frames, window, report.look_ahead);
  const double all_work = work_of(spans, options.costs);
  int loaded = 0;
  for (const Span& span : spans) {
    const int keep = span.kept - span.begin;
    const Work work = work_of(span, std::exchange(loaded, span.end), options.costs);
    const Progress part = progress.step(fmt::format("frames {} to {}", span.begin, span.kept - 1), work.all() / all_work);
    stream.hold(span.end, part.step("read", work.read / work.all()));
    report.held = std::max(report.held, stream.held());
    const bool texels = bool(stream.frame(0).texels);
    const TimeMultigrid system(
        stream.planes(keep),
        texels ? texel_planes([&](int f) -> const Texels& { return *stream.frame(f).texels; })
               : factored_planes(),
        options.solver, part.step("prepare", 0.3 * work.solve / work.all()));
    const Signal b = stream.right_hand_side(system);
    Signal delta = Signal::Zero(b.rows(), b.cols());
    SolveReport solved = nothing_to_solve();
    const Progress solving = part.step("solve", 0.7 * work.solve / work.all());
    if (!b.isZero(0)) solved = system.solve(b, delta, solving);
    report.add(solved);
    const Progress storing = part.step("store", work.store / work.all());
    Signal last;
    for (int f = 0; f < keep; ++f) {
      storing.at(double(f) / keep);
      const TemporalFrame& frame = stream.whole_frame(f);
      last = stream.led(f, delta.middleRows(system.offset(f), frame.psi.rows()));
      store(span.begin + f, frame, frame.psi + last);
    }
    stream.release(keep, last);
  }
  return report;
}

}  // namespace mq
