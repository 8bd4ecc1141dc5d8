// With x the logarithms of colours, evened out, and x̃ the median of the views of a patch:
//
//   1. seeds: |x − x̃| beyond a limit, of at least three views;
//   2. what goes on from them in the same photograph: its colour, or its difference from the others, changes from one
//      patch to the next by less than half of that difference. So two views suffice beside a place where three tell;
//   3. where two alone show a place and disagree over a part that is enclosed: the one that changes at the border of
//      that part, while the other goes on, or that has white light in addition;
//   4. what goes on where no other view shows a place, if it has another hue than light and shadow would give it;
//   5. patches around, a part of which may show the same.

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <deque>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/views/detail/neighbours.h"
#include "mq/views/detail/places.h"
#include "mq/views/detail/readings.h"
#include "mq/views/view_choice.h"

namespace mq {
namespace {

using Logarithms = Eigen::Array3f;

constexpr float floor_of_logarithms = 0.02F;  // differences between dark colours are noise
constexpr float touching = 0.1F;              // of a side, in which patches touch: corners do not

Logarithms logarithms(const LightColour& colour) {
  return (Eigen::Map<const Logarithms>(colour.data()).max(0) + floor_of_logarithms).log();
}

/// The largest of the channels.
float apart(const Logarithms& a, const Logarithms& b) { return (a - b).abs().maxCoeff(); }

float hue_apart(const Logarithms& a, const Logarithms& b) { return (a - b).maxCoeff() - (a - b).minCoeff(); }

/// What a view shows by less than a tenth as well as it mostly does: steeply, or beside outlines, where what is behind
/// them may be in it.
std::vector<char> hardly_shown(const Observations& observations) {
  constexpr double tenth = 0.1;
  std::vector<std::vector<double>> qualities;
  for (const Observation& o : observations.all) {
    if (std::size_t(o.view) >= qualities.size()) qualities.resize(std::size_t(o.view) + 1);
    qualities[std::size_t(o.view)].push_back(o.quality);
  }
  std::vector<double> least;
  for (std::vector<double>& of_view : qualities) least.push_back(of_view.empty() ? 0 : tenth * median_of(of_view));
  std::vector<char> hardly;
  for (const Observation& o : observations.all) hardly.push_back(o.quality < least[std::size_t(o.view)]);
  return hardly;
}

class Rejection {
 public:
  Rejection(const Patches& patches, const RejectOptions& options, const Observations& observations)
      : patches_(patches),
        options_(options),
        observations_(observations),
        beside_(patches),
        patch_of_(observations.all.size()),
        x_(observations.all.size()),
        distance_(observations.all.size(), 0.0F),
        excess_(observations.all.size(), 0.0F),
        carried_(observations.all.size(), Logarithms::Zero()),
        hardly_shown_(hardly_shown(observations)),
        marked_(observations.all.size(), 0) {
    for (int p = 0; p < patches.count(); ++p)
      for (std::int64_t k = begin(p); k < end(p); ++k) patch_of_[std::size_t(k)] = p;
    for (std::size_t k = 0; k < x_.size(); ++k) x_[k] = logarithms(observations.all[k].colour);
  }

  std::vector<char> find() {
    parallel_for(patches_.count(), [&](std::int64_t p) { find_excess(int(p)); }, 256);
    for (std::size_t k = 0; k < marked_.size(); ++k) marked_[k] = excess_[k] > 1;
    find_usual();
    const std::vector<char> none(marked_.size(), 0);
    for (int p = 0; p < patches_.count(); ++p) spare_most(p, none);
    grow();
    part_pairs();
    grow();
    mark_mixtures();
    const std::vector<char> inside = marked_;
    add_borders(inside);
    for (int p = 0; p < patches_.count(); ++p) spare_most(p, inside);
    return std::move(marked_);
  }

 private:
  std::int64_t begin(int patch) const { return observations_.offsets[patch]; }
  std::int64_t end(int patch) const { return observations_.offsets[patch + 1]; }

  /// Of the views of a patch that do not hardly show it; of all where these are too few to tell.
  std::vector<double> values_that_tell(int patch, const std::vector<double>& values) const {
    std::vector<double> telling;
    for (std::size_t k = 0; k < values.size(); ++k)
      if (!hardly_shown_[std::size_t(begin(patch)) + k]) telling.push_back(values[k]);
    return telling.size() < fewest_ ? values : telling;
  }

  /// Distances from the median of the views of a patch over their limit.
  void find_excess(int patch) {
    const std::size_t count = observations_.of(patch).size();
    if (count < fewest_) return;
    std::vector<double> values(count), distances(count, 0.0);
    for (int c = 0; c < 3; ++c) {
      for (std::size_t k = 0; k < count; ++k) values[k] = x_[std::size_t(begin(patch)) + k][c];
      std::vector<double> sorted = values_that_tell(patch, values);
      const double middle = median_of(sorted);
      for (std::size_t k = 0; k < count; ++k) distances[k] = std::max(distances[k], std::abs(values[k] - middle));
    }
    std::vector<double> sorted = values_that_tell(patch, distances);
    const double limit = std::max(options_.least, options_.times * 1.4826 * median_of(sorted));
    for (std::size_t k = 0; k < count; ++k) {
      distance_[std::size_t(begin(patch)) + k] = float(distances[k]);
      const bool tells = !(distances[k] > limit) || !is_of_other_places(patch, k, distances[k]);
      excess_[std::size_t(begin(patch)) + k] = tells ? float(distances[k] / limit) : 0;
    }
  }

  /// Whether most of what the k-th view of a patch is off by is brightness, which places that it shows explain.
  bool is_of_other_places(int patch, std::size_t k, double distance) const {
    const std::span<const Observation> views = observations_.of(patch);
    std::vector<const Observation*> others;
    std::vector<double> values;
    for (std::size_t i = 0; i < views.size(); ++i)
      if (i != k) others.push_back(&views[i]), values.push_back(brightness_of(views[i]));
    return 2 * std::abs(brightness_of(views[k]) - median_of(values)) > distance && shows_other_places(views[k], others);
  }

  /// Of each view how far it is to be off before it shows something else: by its usual distance from the median of
  /// three views or more, which is larger for those that are blurred, or of another contrast.
  void find_usual() {
    std::vector<std::vector<double>> distances;
    for (std::size_t k = 0; k < distance_.size(); ++k) {
      const auto view = std::size_t(observations_.all[k].view);
      if (view >= distances.size()) distances.resize(view + 1);
      if (observations_.of(patch_of_[k]).size() > 2) distances[view].push_back(distance_[k]);
    }
    for (std::vector<double>& of_view : distances)
      limits_.push_back(float(std::max(2 * options_.least,
                                       of_view.empty() ? 0 : options_.times * 1.4826 * median_of(of_view))));
  }

  /// visit(k) for the observations of the same view on patches that touch that of k.
  void for_beside(std::size_t k, float least, const auto& visit) const {
    for (const Neighbours::Side& side : beside_.of(patch_of_[k]))
      if (side.weight >= least)
        if (const auto other = observations_.number_of(side.patch, observations_.all[k].view); other >= 0)
          visit(std::size_t(other));
  }

  int marked_beside(std::size_t k) const {
    int count = 0;
    for_beside(k, touching, [&](std::size_t other) { count += marked_[other]; });
    return count;
  }

  /// What the views of a patch but one show, that are not marked.
  struct Others {
    int count = 0;
    float nearest = 0;                       ///< how far that one is from the nearest of them
    float spread = 0;                        ///< how far they are from each other, the median
    Logarithms mean = Logarithms::Zero();
  };
  Others others_of(std::size_t k) const {
    Others others;
    std::vector<double> between;
    const auto patch = patch_of_[k];
    for (auto i = std::size_t(begin(patch)); i < std::size_t(end(patch)); ++i) {
      if (i == k || marked_[i]) continue;
      const float distance = apart(x_[k], x_[i]);
      others.nearest = others.count == 0 ? distance : std::min(others.nearest, distance);
      for (auto j = std::size_t(begin(patch)); j < i; ++j)
        if (j != k && !marked_[j]) between.push_back(apart(x_[j], x_[i]));
      others.mean += x_[i];
      ++others.count;
    }
    if (others.count > 0) others.mean /= float(others.count);
    if (!between.empty()) others.spread = float(median_of(between));
    return others;
  }

  void grow() {
    std::deque<std::size_t> open;
    for (std::size_t k = 0; k < marked_.size(); ++k)
      if (marked_[k] && marked_beside(k) > 0) open.push_back(k);
    for (; !open.empty(); open.pop_front()) {
      const std::size_t k = open.front();
      if (hardly_shown_[k]) continue;
      const Others here = others_of(k);
      for_beside(k, touching, [&](std::size_t next) {
        if (marked_[next] || !goes_on(k, here, next)) return;
        carried_[next] = reference(k, here);
        marked_[next] = 1;
        open.push_back(next);
      });
      for_beyond(k, [&](std::size_t next) {
        if (marked_[next] || others_of(next).count > 0 || !goes_on(k, here, next)) return;
        carried_[next] = reference(k, here);
        marked_[next] = 1;
        open.push_back(next);
      });
    }
  }

  /// visit(k) for the observations of the same view beyond patches that it does not show, a few at most.
  void for_beyond(std::size_t k, const auto& visit) const {
    constexpr int widest = 6;
    const int view = observations_.all[k].view;
    std::vector<int> passed{patch_of_[k]};
    for (std::size_t begin_of_round = 0, round = 0; round <= widest && begin_of_round < passed.size(); ++round) {
      const std::size_t end_of_round = passed.size();
      for (std::size_t at = begin_of_round; at < end_of_round; ++at)
        for (const Neighbours::Side& side : beside_.of(passed[at])) {
          if (std::ranges::find(passed, side.patch) != passed.end()) continue;
          if (const auto other = observations_.number_of(side.patch, view); other < 0)
            passed.push_back(side.patch);
          else if (round > 0)
            visit(std::size_t(other));
        }
      begin_of_round = end_of_round;
    }
  }

  /// What the surface has at k, or had where another view showed it last.
  const Logarithms& reference(std::size_t k, const Others& here) const {
    return here.count > 0 ? here.mean : carried_[k];
  }

  float limit_of(std::size_t k) const { return limits_[std::size_t(observations_.all[k].view)]; }

  /// Whether the next patch shows what disagrees at k still.
  bool goes_on(std::size_t k, const Others& here, std::size_t next) const {
    const Others there = others_of(next);
    const float limit = limit_of(next), change = apart(x_[k], x_[next]);
    if (there.count == 0) {
      const Logarithms& surface = reference(k, here);
      return hue_apart(x_[next], surface) > limit && change < float(options_.least) &&
             2 * change < apart(x_[next], surface);
    }
    if (!(there.nearest > std::max(limit, there.spread))) return is_against_witnesses(k, next);
    if (there.count == 1 && doubtful_other(next)) return false;
    const float change_of_difference = here.count > 0 ? apart(x_[k] - here.mean, x_[next] - there.mean) : change;
    return 2 * std::min(change, change_of_difference) < there.nearest;
  }

  /// Whether more of the others disagree with the next patch that go on from the one at k themselves, than agree.
  bool is_against_witnesses(std::size_t k, std::size_t next) const {
    const int patch = patch_of_[next];
    const float limit = limit_of(next), change = apart(x_[k], x_[next]);
    int against = 0, in_favour = 0;
    for (auto i = std::size_t(begin(patch)); i < std::size_t(end(patch)); ++i) {
      if (i == next || marked_[i]) continue;
      const float distance = apart(x_[i], x_[next]);
      const std::int64_t before = observations_.number_of(patch_of_[k], observations_.all[i].view);
      if (distance < limit)
        ++in_favour;
      else if (before >= 0 && !marked_[std::size_t(before)] && 2 * change < distance &&
               2 * apart(x_[i], x_[std::size_t(before)]) < distance)
        ++against;
    }
    return against > in_favour;
  }

  /// Beside what one view alone shows, and of that alone: what is partly what disagrees, partly what the surface has.
  void mark_mixtures() {
    const std::vector<char> inside = marked_;
    for (std::size_t k = 0; k < inside.size(); ++k) {
      if (!inside[k]) continue;
      const Others here = others_of(k);
      if (here.count > 0) continue;
      const Logarithms surface = reference(k, here);
      const auto mark = [&](std::size_t next) {
        if (marked_[next] || others_of(next).count > 0) return;
        const float least = limit_of(next) / 2;
        const Logarithms low = surface.min(x_[k]) - least, high = surface.max(x_[k]) + least;
        const bool between = (x_[next] > low).all() && (x_[next] < high).all();
        if (between && hue_apart(x_[next], surface) > least) marked_[next] = 1;
      };
      for_beside(k, 0, mark);
      for_beyond(k, mark);
    }
  }

  /// Whether the only other view of a patch is marked on more of the patches around than this one.
  bool doubtful_other(std::size_t k) const {
    const int patch = patch_of_[k];
    for (auto i = std::size_t(begin(patch)); i < std::size_t(end(patch)); ++i)
      if (i != k && !marked_[i] && marked_beside(i) >= marked_beside(k)) return true;
    return false;
  }

  /// The only two that are not marked; nothing where there are others or less.
  struct Pair {
    std::int64_t a = -1, b = -1;
    explicit operator bool() const { return b >= 0; }
  };
  Pair pair_of(int patch) const {
    Pair pair;
    for (std::int64_t k = begin(patch); k < end(patch); ++k) {
      if (marked_[std::size_t(k)]) continue;
      if (pair.b >= 0) return {};
      (pair.a < 0 ? pair.a : pair.b) = k;
    }
    return pair;
  }
  float distance(const Pair& pair) const { return apart(x_[std::size_t(pair.a)], x_[std::size_t(pair.b)]); }
  int view(std::int64_t k) const { return observations_.all[std::size_t(k)].view; }
  float limit_of(const Pair& pair) const {
    return std::max(limit_of(std::size_t(pair.a)), limit_of(std::size_t(pair.b)));
  }

  /// Parts in which two views, the only ones, disagree.
  void part_pairs() {
    std::vector<char> visited(std::size_t(patches_.count()), 0);
    for (int p = 0; p < patches_.count(); ++p) {
      const Pair pair = visited[std::size_t(p)] ? Pair() : pair_of(p);
      if (!pair || !(distance(pair) > limit_of(pair))) continue;
      std::vector<int> part{p};
      visited[std::size_t(p)] = 1;
      for (std::size_t at = 0; at < part.size(); ++at)
        for (const Neighbours::Side& side : beside_.of(part[at])) {
          if (side.weight < touching || visited[std::size_t(side.patch)]) continue;
          const Pair other = same_views(pair, side.patch);
          if (!other || !(2 * distance(other) > limit_of(pair))) continue;
          visited[std::size_t(side.patch)] = 1;
          part.push_back(side.patch);
        }
      if (const int wrong = wrong_of(part); wrong >= 0 && shows_enough_of(part, wrong))
        for (const int q : part) marked_[std::size_t(observations_.number_of(q, wrong))] = 1;
    }
  }

  /// Whether a view shows as many patches as make a part by more than hardly.
  bool shows_enough_of(const std::vector<int>& part, int view) const {
    return std::ranges::count_if(part, [&](int p) {
             return !hardly_shown_[std::size_t(observations_.number_of(p, view))];
           }) >= std::ptrdiff_t(fewest_);
  }

  /// Of the only two of a patch, where they are these views.
  Pair same_views(const Pair& pair, int patch) const {
    const Pair other = pair_of(patch);
    return other && view(other.a) == view(pair.a) && view(other.b) == view(pair.b) ? other : Pair();
  }

  /// The view that shows something else there; −1 where that is not told.
  int wrong_of(const std::vector<int>& part) const {
    constexpr float one_way = 0.7F, clearly = 2;
    if (part.size() < fewest_) return -1;
    const Pair first = pair_of(part.front());
    const int a = view(first.a), b = view(first.b);
    Logarithms sum = Logarithms::Zero(), sizes = Logarithms::Zero();
    float jumps_of_a = 0, jumps_of_b = 0;
    int sides = 0;
    std::vector<int> inside = part;
    std::ranges::sort(inside);
    for (const int p : part) {
      const Pair pair = pair_of(p);
      const Logarithms& at_a = x_[std::size_t(pair.a)];
      const Logarithms& at_b = x_[std::size_t(pair.b)];
      sum += at_a - at_b, sizes += (at_a - at_b).abs();
      for (const Neighbours::Side& side : beside_.of(p)) {
        if (side.weight < touching || std::ranges::binary_search(inside, side.patch)) continue;
        const auto other_a = observations_.number_of(side.patch, a), other_b = observations_.number_of(side.patch, b);
        if (other_a < 0 || other_b < 0 || marked_[std::size_t(other_a)] || marked_[std::size_t(other_b)]) continue;
        jumps_of_a += apart(at_a, x_[std::size_t(other_a)]), jumps_of_b += apart(at_b, x_[std::size_t(other_b)]);
        ++sides;
      }
    }
    // Else it is detail, sharper in one of them.
    const bool of_one_kind = (sum.abs() / sizes.max(1e-6F)).maxCoeff() > one_way;
    if (!of_one_kind || sides < int(fewest_)) return -1;
    const float least = float(options_.least) * float(sides);
    if (jumps_of_a > least && jumps_of_a > clearly * jumps_of_b) return a;
    if (jumps_of_b > least && jumps_of_b > clearly * jumps_of_a) return b;
    const bool is_a = sum.minCoeff() > 0, is_b = sum.maxCoeff() < 0;
    return (is_a || is_b) && is_highlight(part) ? (is_a ? a : b) : -1;
  }

  /// Whether it is light of no colour that one shows in addition, as a highlight is, where the channels' differences are
  /// alike; a shadow is where their ratios are.
  bool is_highlight(const std::vector<int>& part) const {
    constexpr float clearly = 0.6F;
    float differences = 0, of_differences = 0, ratios = 0, of_ratios = 0;
    for (const int p : part) {
      const Pair pair = pair_of(p);
      const auto light = [&](std::int64_t k) {
        return Logarithms(Eigen::Map<const Logarithms>(observations_.all[std::size_t(k)].colour.data()));
      };
      const Logarithms difference = light(pair.a) - light(pair.b);
      const Logarithms ratio = x_[std::size_t(pair.a)] - x_[std::size_t(pair.b)];
      differences += std::abs(difference.mean()), of_differences += difference.maxCoeff() - difference.minCoeff();
      ratios += std::abs(ratio.mean()), of_ratios += ratio.maxCoeff() - ratio.minCoeff();
    }
    return of_differences * ratios < clearly * of_ratios * differences;
  }

  /// All around one that has two more beside it, as a passer-by has, whose border a patch may show without being much
  /// changed; else those half as far.
  void add_borders(const std::vector<char>& inside) {
    for (std::size_t k = 0; k < inside.size(); ++k) {
      if (!inside[k] || hardly_shown_[k]) continue;
      int beside = 0;
      for_beside(k, touching, [&](std::size_t other) { beside += inside[other]; });
      for_beside(k, 0, [&](std::size_t other) {
        if (beside >= 2 || excess_[other] > 0.5F) marked_[other] = 1;
      });
    }
  }

  /// Of each patch what is `held` stays, and of the rest those that are farthest, half of all views at most.
  void spare_most(int patch, const std::vector<char>& held) {
    std::vector<std::size_t> spared;
    std::int64_t left = (end(patch) - begin(patch)) / 2;
    for (auto k = std::size_t(begin(patch)); k < std::size_t(end(patch)); ++k)
      if (held[k])
        --left;
      else if (marked_[k])
        spared.push_back(k);
    left = std::max<std::int64_t>(left, 0);
    if (std::ssize(spared) <= left) return;
    std::ranges::stable_sort(spared, [&](std::size_t k, std::size_t m) { return excess_[k] > excess_[m]; });
    for (auto k = spared.begin() + left; k != spared.end(); ++k) marked_[*k] = 0;
  }

  const Patches& patches_;
  const RejectOptions& options_;
  const Observations& observations_;
  Neighbours beside_;
  std::vector<int> patch_of_;
  std::vector<Logarithms> x_;
  std::vector<float> distance_, excess_;  ///< from the median, and over its limit
  std::vector<float> limits_;             ///< of each view
  std::vector<Logarithms> carried_;       ///< of what no other view shows: what the surface had beside it
  std::vector<char> hardly_shown_;
  std::vector<char> marked_;
  static constexpr std::size_t fewest_ = 3;  ///< of views of which a median tells, and of patches that make a part
};

}  // namespace

float hue_difference(const LightColour& a, const LightColour& b) { return hue_apart(logarithms(a), logarithms(b)); }

std::vector<char> undecided(const Patches& patches, const Observations& observations, const RejectOptions& options) {
  constexpr int fewest_beside = 2;
  const std::vector<char> hardly = hardly_shown(observations);
  std::vector<char> disagree(std::size_t(observations.patches()), 0);
  for (int p = 0; p < observations.patches(); ++p) {
    std::vector<const Observation*> left;
    for (std::int64_t k = observations.offsets[p]; k < observations.offsets[p + 1]; ++k)
      if (const Observation& o = observations.all[std::size_t(k)]; !o.rejected && !hardly[std::size_t(k)])
        left.push_back(&o);
    if (left.size() == 2)
      disagree[std::size_t(p)] = apart(logarithms(left[0]->colour), logarithms(left[1]->colour)) > 2 * options.least &&
                                 !shows_other_places(*left[0], std::span(left).last(1));
  }
  std::vector<int> beside(disagree.size(), 0);
  for (const Patches::Link& link : patches.links) {
    if (link.weight < touching) continue;
    beside[std::size_t(link.a)] += disagree[std::size_t(link.b)];
    beside[std::size_t(link.b)] += disagree[std::size_t(link.a)];
  }
  for (std::size_t p = 0; p < disagree.size(); ++p) disagree[p] = disagree[p] && beside[p] >= fewest_beside;
  return disagree;
}

void reject(const Patches& patches, const RejectOptions& options, Observations& observations) {
  require(patches.count() == observations.patches(), "observations of these patches are needed");
  const std::vector<char> marked = Rejection(patches, options, observations).find();
  for (std::size_t k = 0; k < marked.size(); ++k) observations.all[k].rejected = marked[k];
}

}  // namespace mq
