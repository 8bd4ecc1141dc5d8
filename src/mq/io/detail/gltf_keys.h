#pragma once
/// What an animation of glTF says of one property over time.

#include <string>
#include <vector>

#include "mq/io/detail/gltf_file.h"

namespace mq {

struct GltfKeys {
  std::vector<double> times, values;
  std::size_t size = 0;  ///< values to a key
  bool steps = false;

  /// The key at or before a time, or the first.
  std::size_t before(double time) const;

  std::vector<double> at(double time) const;
};

/// The keys of a channel, `components` values to each; 0: as many as there are. Throws `IoError`
/// with the place where they are damaged, and `Unsupported` for splines.
GltfKeys gltf_keys(const GltfFile& file, const Json& animation, const Json& channel,
                   const std::string& place, int components);

}  // namespace mq
