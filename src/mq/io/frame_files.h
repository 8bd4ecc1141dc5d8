#pragma once
/// The files of a sequence: one per frame, with the frame's number in its name.

#include <filesystem>
#include <string>
#include <vector>

namespace mq {

/// The numbers that "5", "1-100" or "1-100x2" (every second) stands for; empty when `text` is none
/// of these, more than a million, or one is larger than 2147483647.
std::vector<int> parse_frames(const std::string& text);

/// Whether `name` holds a place for a number: %d or %04d. Throws `InvalidInput` where it holds two.
bool has_frame_place(const std::string& name);

/// `name` with the number in that place: frame_%04d.png becomes frame_0012.png.
std::string frame_name(const std::string& name, int frame);

struct FrameFile {
  int number = 0;
  std::filesystem::path path;
};

/// What becomes of frames that are wanted and not there.
enum class MissingFrames { refused, left_out };

/// The meshes of a sequence by increasing number; nothing is read. `name` is a file with a place
/// for the number, frame_%04d.ply, or a folder: there every mesh (OBJ, PLY, glTF or GLB) is a
/// frame, the last digits of its name before the extension are its number, and what stands before
/// them must be the same for all. `numbers` are the frames wanted (`parse_frames`); empty: all
/// there are.
///
/// Throws `IoError` where nothing is found, where frames that are wanted are missing (naming the
/// first and how many; all of them, where they may be left out), where a folder holds meshes of
/// several formats or of several sequences, where two files have one number, and where a number is
/// larger than 2147483647; `InvalidInput` where `name` is neither.
std::vector<FrameFile> find_frames(const std::string& name, const std::vector<int>& numbers = {},
                                   MissingFrames where_missing = MissingFrames::refused);

}  // namespace mq
