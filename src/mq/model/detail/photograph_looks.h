#pragma once
/// What photographs show of patches, and what is told of them as a whole.

#include <span>
#include <vector>

#include "mq/draw/align_photographs.h"
#include "mq/draw/photograph.h"
#include "mq/io/cameras.h"
#include "mq/model/messages.h"
#include "mq/model/photograph_texture.h"
#include "mq/views/view_choice.h"

namespace mq {

/// Patches with the texels at which photographs are looked at.
struct Looks {
  std::vector<int> offsets{0};
  std::vector<int> places;

  explicit Looks(const Patches& patches);
};

/// Of one photograph on each patch, from what it shows (`picture_to_look_at`) at their places.
std::vector<Observations::OfPatch> observe(const Looks& looks, const Partial& shown, std::span<const Vector3> points,
                                           const PinholeCamera& camera, int view);

/// Weights times the squares of how sharp places are: root mean squares of gradients against the median of those
/// that show the place, 0.05 to 1. `details`: of the places of each photograph |∇|² in brightness per texel.
void weigh_by_sharpness(std::span<const std::vector<float>> details, std::size_t places,
                        std::vector<AlignedPhotograph>& photographs);

/// Per photograph whether it disagrees with the others nearly everywhere; the messages say which do.
std::vector<char> strangers(std::span<const Photograph> photographs, const Observations& observations, Messages& messages);

/// The observations without those of some views, and where each of them is among all.
struct ObservationsOfOthers {
  Observations observations;
  std::vector<std::size_t> places;

  ObservationsOfOthers(const Observations& all, std::span<const char> left_out);
};

/// What these alone show is not rejected.
void take_strangers_alone(std::span<const char> strange, Observations& observations);

/// Fills in `patches`, `seen_by`, `undecided`, `shown_by`, `rejected_by` and of each view `patches` and `rejected`.
void count_views(const Patches& patches, const Observations& observations, const RejectOptions& options,
                 PhotographTexture& result);

}  // namespace mq
