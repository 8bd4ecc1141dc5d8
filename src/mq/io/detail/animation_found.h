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
  std::vector<std::filesystem::path> files = {};  ///< that were read beside it
  std::vector<int> segment_of;            ///< of each frame, never decreasing
  std::vector<int> numbers;               ///< of frames, from 0 on or later, increasing
  double frames_per_second = 0;           ///< their mean
  double numbers_per_second = 0;          ///< frame n is seen (n − n_first) / this seconds after the first
  double metres_per_unit = 1;
  std::function<std::vector<Vector3>(int frame)> positions;  ///< read when they are asked for
  std::vector<std::string> notes;                            ///< what was left out, each once
  std::vector<std::string> remarks;                          ///< what was done otherwise than one may think

  void add_note(const std::string& text) { add(notes, text); }
  void add_remark(const std::string& text) { add(remarks, text); }

 private:
  static void add(std::vector<std::string>& all, const std::string& text);
};

/// Says that of so many frames some are not there, as nothing is seen then: from `first` to `last`, of what `word`
/// counts.
std::string unseen_frames(std::size_t count, std::size_t all, const std::string& word, double first, double last);

/// When frames are seen.
struct FrameTimes {
  std::vector<double> times;   ///< increasing
  double step = 1, unit = 1;   ///< of times: between two numbers, and in a second
  double first = 0;            ///< the number at the first time, where it is whole and not below 0
  std::string word = "times";  ///< what they are
};

/// Numbers and rates of frames, so that the seconds between them stay what they were: by the step where all are at
/// multiples of it; one after the other where they are equally far apart; by the largest fraction of the step
/// otherwise, thousandths at least. Remarks say which but for the first, and a note that one rate is a mean.
void set_frame_times(FoundAnimation& found, const FrameTimes& when);

/// What a text of USD, and a package of it, hold. `bytes` are the file's. Throws `IoError` with the line where it
/// is damaged or cut short, `Unsupported` for what is none of one mesh at a time whose points move.
FoundAnimation find_usda_animation(const std::string& name, Bytes bytes);
FoundAnimation find_usdz_animation(const std::string& name, Bytes bytes);

/// The same of glTF, in either container, whose buffers beside it are in `folder`: one mesh at a time that morphs.
FoundAnimation find_gltf_animation(const std::string& name, Bytes bytes, const std::filesystem::path& folder);

}  // namespace mq
