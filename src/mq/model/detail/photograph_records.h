#pragma once
/// What `PhotographTexturing` keeps in a `PhotographStore`.

#include <cstdint>
#include <span>
#include <vector>

#include "mq/draw/align_photographs.h"
#include "mq/model/photograph_store.h"
#include "mq/model/photograph_texture.h"

namespace mq {

/// Of all that what is found of any photograph depends on: the version of this library, the surface, the places on it,
/// the signal's values and options.
std::uint64_t print_of_setup(const Mesh& mesh, std::span<const Vector3> places, const TextureSignal& signal,
                             const PhotographTextureOptions& options);

/// Of photographs: their names, sizes, times and cameras. Throws `IoError` where one is not there any more.
std::uint64_t print_of_photographs(std::span<const Photograph> photographs);

/// The same of one as it is aligned.
std::uint64_t print_of_aligned(const Photograph& photograph, const PinholeCamera& camera);

/// A photograph as it is aligned, without its camera, and the details of its places.
StoredBytes record_to_align(const AlignedPhotograph& photograph, std::span<const float> details);
void read_to_align(std::span<const std::byte> record, AlignedPhotograph& photograph, std::vector<float>& details);

/// By how much alignment moved photographs, and where to.
StoredBytes record_of_poses(std::span<const PinholeCamera> cameras, std::span<const double> moved);
void read_poses(std::span<const std::byte> record, std::span<PinholeCamera> cameras, std::span<double> moved);

/// Colours taken from one photograph, and how well it shows those that lie beyond borders.
struct TakenColours {
  Signal own;
  Partial beyond;
};
/// `asked` tells for which places, and of what.
StoredBytes record_of_colours(std::uint64_t asked, const TakenColours& colours);
/// False where something else was asked.
bool read_colours(std::span<const std::byte> record, std::uint64_t asked, TakenColours& colours);

}  // namespace mq
