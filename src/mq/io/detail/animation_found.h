#pragma once
/// What a file that moves is found to hold, before it is opened as an evolving mesh (animation_read.h).

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "mq/evolving/evolving_mesh.h"
#include "mq/io/bytes.h"

namespace mq {

/// What helps where a file holds something else.
inline constexpr const char* frames_instead = "export a file a frame (frame_%04d.ply), which evolve follows";

/// A picture by its name or, where it is in the file, by its bytes too. Neither: there is none.
struct FoundPicture {
  std::string name;  ///< from the file's folder
  Bytes bytes = {};
};

struct FoundAnimation {
  std::vector<EvolvingSegment> segments;  ///< ids count from 0 in each
  std::vector<FoundPicture> pictures;     ///< of each
  std::vector<int> segment_of;            ///< of each frame, never decreasing
  std::vector<int> numbers;               ///< of frames, increasing
  double frames_per_second = 0;
  std::function<std::vector<Vector3>(int frame)> positions;  ///< read when they are asked for
  std::vector<std::string> notes;
};

/// Numbers and rate of frames at increasing `times`, `unit` of which make a second: `first` and on, by the
/// smallest step, where all are multiples of it; otherwise one after the other, which a note says.
void set_frame_times(FoundAnimation& found, const std::vector<double>& times, double step, double unit, double first);

/// What a text of USD, and a package of it, hold. `bytes` are the file's. Throws `IoError` with the line where it
/// is damaged or cut short, `Unsupported` for what is none of one mesh at a time whose points move.
FoundAnimation find_usda_animation(const std::string& name, Bytes bytes);
FoundAnimation find_usdz_animation(const std::string& name, Bytes bytes);

/// The same of glTF, in either container, whose buffers beside it are in `folder`: one mesh at a time that morphs.
FoundAnimation find_gltf_animation(const std::string& name, Bytes bytes, const std::filesystem::path& folder);

}  // namespace mq
