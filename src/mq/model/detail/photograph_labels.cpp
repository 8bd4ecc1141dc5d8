#include "mq/model/detail/photograph_labels.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <optional>

#include "mq/base/error.h"

namespace mq {
namespace {

/// The views of a patch in the order in which its texels ask them: the chosen one, then the best, at last those that
/// are rejected.
std::vector<int> order_of_views(std::span<const Observation> views, int chosen) {
  const std::vector<float> qualities = relative_qualities(views);
  std::vector<int> order(views.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, [&](int a, int b) {
    if ((a == chosen) != (b == chosen)) return a == chosen;
    if (views[std::size_t(a)].rejected != views[std::size_t(b)].rejected) return views[std::size_t(b)].rejected;
    return qualities[std::size_t(a)] > qualities[std::size_t(b)];
  });
  for (int& k : order) k = views[std::size_t(k)].view;
  return order;
}

/// Patches of which all that is shown is rejected, and those beside them.
std::vector<char> around_rejected(const Patches& patches, const Observations& observations) {
  std::vector<char> rejected(std::size_t(patches.count()), 0);
  for (int p = 0; p < patches.count(); ++p) rejected[std::size_t(p)] = observations.all_rejected(p);
  std::vector<char> around = rejected;
  for (const Patches::Link& link : patches.links) {
    if (rejected[std::size_t(link.a)]) around[std::size_t(link.b)] = 1;
    if (rejected[std::size_t(link.b)]) around[std::size_t(link.a)] = 1;
  }
  return around;
}

}  // namespace

std::vector<std::vector<int>> views_to_ask(const Patches& patches, const Observations& observations,
                                           std::span<const int> chosen) {
  std::vector<std::vector<int>> orders(std::size_t(patches.count()));
  constexpr float other_hue = 0.15F;
  const std::vector<char> around = around_rejected(patches, observations);
  const std::vector<std::optional<LightColour>> agreed = agreed_colours(observations);
  for (int p = 0; p < patches.count(); ++p) {
    orders[std::size_t(p)] = order_of_views(observations.of(p), chosen[p]);
    const std::optional<LightColour>& colour = agreed[std::size_t(p)];
    std::erase_if(orders[std::size_t(p)], [&](int view) {
      const Observation& o = observations.all[std::size_t(observations.number_of(p, view))];
      return o.rejected && (around[std::size_t(p)] || (colour && hue_difference(o.colour, *colour) > other_hue));
    });
  }
  std::vector<std::vector<int>> result = orders;
  const auto lend = [&](int from, int to) {
    if (!orders[std::size_t(to)].empty()) return;
    for (const int view : orders[std::size_t(from)])
      if (observations.number_of(to, view) < 0 &&
          std::ranges::find(result[std::size_t(to)], view) == result[std::size_t(to)].end())
        result[std::size_t(to)].push_back(view);
  };
  for (const Patches::Link& link : patches.links) lend(link.a, link.b), lend(link.b, link.a);
  return result;
}

void find_labels(const Projector& projector, const Patches& patches, const std::vector<std::vector<int>>& asked,
                 std::span<const int> wanted, std::span<const PinholeCamera> cameras, const PhotographOptions& options,
                 std::vector<int> open, std::vector<int>& labels, const Progress& progress) {
  constexpr int most_rounds = 16;
  for (const int i : open) labels[std::size_t(i)] = unseen;
  const auto view_asked = [&](int texel, int round) {
    if (round < 0) return wanted.empty() ? unseen : wanted[std::size_t(texel)];
    const std::vector<int>& views = asked[std::size_t(patches.of[texel])];
    return round < std::ssize(views) ? views[std::size_t(round)] : unseen;
  };
  for (int round = wanted.empty() ? 0 : -1; round < most_rounds && !open.empty(); ++round) {
    std::vector<std::vector<int>> of_view(cameras.size());
    std::vector<int> still_open;
    for (const int i : open)
      if (const int view = view_asked(i, round); view != unseen)
        of_view[std::size_t(view)].push_back(i);
      else if (round < 0)
        still_open.push_back(i);
    open = std::move(still_open);
    for (std::size_t v = 0; v < cameras.size(); ++v) {
      const std::vector<double> confidences = projector.confidences(cameras[v], of_view[v], options, progress);
      for (std::size_t k = 0; k < of_view[v].size(); ++k)
        if (confidences[k] > 0)
          labels[std::size_t(of_view[v][k])] = int(v);
        else
          open.push_back(of_view[v][k]);
    }
    std::ranges::sort(open);
    progress.at(double(round + 1) / most_rounds);
  }
}

std::vector<int> views_before(const Patches& patches, std::span<const int> before, int photographs) {
  require(before.size() == patches.of.size(),
          fmt::format("a photograph of the frame before is wanted for each of {} unknowns, found {}", patches.of.size(),
                      before.size()));
  std::vector<int> views(std::size_t(patches.count()), unseen), times(std::size_t(photographs), 0);
  for (int p = 0; p < patches.count(); ++p) {
    std::ranges::fill(times, 0);
    for (auto k = patches.offsets[std::size_t(p)]; k < patches.offsets[std::size_t(p) + 1]; ++k) {
      const int view = before[std::size_t(patches.members[std::size_t(k)])];
      require(view < photographs, fmt::format("found photograph {} of {} in the frame before", view, photographs));
      if (view != unseen) ++times[std::size_t(view)];
    }
    const auto most = std::ranges::max_element(times);
    if (most != times.end() && *most > 0) views[std::size_t(p)] = int(most - times.begin());
  }
  return views;
}

std::vector<int> beside_unseen(const Patches& patches, std::span<const int> labels) {
  std::vector<char> holds(std::size_t(patches.count()), 0);
  for (std::size_t i = 0; i < labels.size(); ++i)
    if (labels[i] == unseen) holds[std::size_t(patches.of[i])] = 1;
  std::vector<char> near = holds;
  for (const Patches::Link& link : patches.links) {
    if (holds[std::size_t(link.a)]) near[std::size_t(link.b)] = 1;
    if (holds[std::size_t(link.b)]) near[std::size_t(link.a)] = 1;
  }
  std::vector<int> texels;
  for (std::size_t i = 0; i < labels.size(); ++i)
    if (near[std::size_t(patches.of[i])] && labels[i] != unseen) texels.push_back(int(i));
  return texels;
}

void take_surer(const Patches& patches, std::span<const int> texels, std::span<const int> surer,
                std::vector<int>& labels) {
  std::vector<std::int64_t> left(std::size_t(patches.count()), 0);
  for (std::size_t i = 0; i < labels.size(); ++i) left[std::size_t(patches.of[i])] += surer[i] != unseen;
  std::vector<char> keeps(left.size(), 0);
  for (std::size_t p = 0; p < left.size(); ++p) keeps[p] = left[p] > 0;
  for (const Patches::Link& link : patches.links) {
    if (left[std::size_t(link.a)] > 0) keeps[std::size_t(link.b)] = 1;
    if (left[std::size_t(link.b)] > 0) keeps[std::size_t(link.a)] = 1;
  }
  for (const int i : texels)
    if (keeps[std::size_t(patches.of[i])]) labels[std::size_t(i)] = surer[std::size_t(i)];
}

}  // namespace mq
