#pragma once
/// Sequences: `--frames 1-100x2` and file names with the frame's number in them.

#include <string>
#include <vector>

namespace mq::app {

/// The numbers that "5", "1-100" or "1-100x2" (every second) stands for; empty when `text` is none
/// of these, or more than a million.
std::vector<int> parse_frames(const std::string& text);

/// Whether `name` holds a place for a number: %d or %04d.
bool has_frame_place(const std::string& name);

/// `name` with the number in that place: frame_%04d.png becomes frame_0012.png.
std::string frame_name(const std::string& name, int frame);

}  // namespace mq::app
