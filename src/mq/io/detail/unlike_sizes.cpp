#include "mq/io/detail/unlike_sizes.h"

#include <algorithm>
#include <cmath>

namespace mq {
namespace {

bool same_size(const UnsizedPicture& a, int width, int height) { return a.width == width && a.height == height; }

std::ptrdiff_t count_of(std::span<const UnsizedPicture> pictures, int width, int height) {
  return std::ranges::count_if(pictures, [&](const UnsizedPicture& one) { return same_size(one, width, height); });
}

/// Whether one is the other made larger or smaller, to a pixel.
bool same_proportions(const UnsizedPicture& picture, const UsualSize& usual) {
  const double by = double(picture.width) / usual.width;
  return std::abs(by * usual.height - picture.height) <= std::max(1.0, by);
}

SizeVerdict judged(std::span<const UnsizedPicture> pictures, const UnsizedPicture& one, const UsualSize& usual) {
  constexpr double alike = 0.05, clearly = 0.1;
  if (same_size(one, usual.width, usual.height)) return SizeVerdict::as_stored;
  const bool turned = same_size(one, usual.height, usual.width);
  if (turned && one.lies) return SizeVerdict::upright;
  const bool same_focal = std::abs(one.focal / usual.focal - 1) < alike;
  if (same_proportions(one, usual)) {
    const bool resized = std::abs(double(one.width) / usual.width - 1) > clearly;
    return same_focal && resized ? SizeVerdict::scaled : SizeVerdict::as_stored;
  }
  const bool alone = std::ranges::count_if(pictures, [&](const UnsizedPicture& other) {
                       return same_size(other, one.width, one.height) && other.lies == one.lies;
                     }) == 1;
  if (!alone) return SizeVerdict::as_stored;
  if (turned) return SizeVerdict::on_its_side;
  return same_focal ? SizeVerdict::cropped : SizeVerdict::unlike;
}

}  // namespace

UsualSize::UsualSize(std::span<const UnsizedPicture> pictures) {
  for (const UnsizedPicture& one : pictures)
    if (2 * count_of(pictures, one.width, one.height) > std::ssize(pictures)) {
      width = one.width, height = one.height;
      break;
    }
  std::vector<double> focals;
  for (const UnsizedPicture& one : pictures)
    if (same_size(one, width, height)) focals.push_back(one.focal);
  if (focals.empty()) return;
  std::ranges::nth_element(focals, focals.begin() + std::ssize(focals) / 2);
  focal = focals[focals.size() / 2];
}

std::vector<SizeVerdict> judged_sizes(std::span<const UnsizedPicture> pictures, const UsualSize& usual) {
  std::vector<SizeVerdict> verdicts;
  for (const UnsizedPicture& one : pictures)
    verdicts.push_back(usual.width > 0 ? judged(pictures, one, usual) : SizeVerdict::as_stored);
  return verdicts;
}

}  // namespace mq
