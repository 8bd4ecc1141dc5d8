#pragma once
/// The files of a sequence: one per frame, with the frame's number in its name.

#include <filesystem>
#include <string>
#include <vector>

namespace mq {

/// The numbers that "5", "1-100" or "1-100x2" (every second) stands for; empty when `text` is none
/// of these, or more than a million.
std::vector<int> parse_frames(const std::string& text);

/// Whether `name` holds a place for a number: %d or %04d.
bool has_frame_place(const std::string& name);

/// `name` with the number in that place: frame_%04d.png becomes frame_0012.png.
std::string frame_name(const std::string& name, int frame);

struct FrameFile {
  int number = 0;
  std::filesystem::path path;
};

/// The meshes of a sequence by increasing number; nothing is read. `name` is a file with a place for
/// the number, frame_%04d.ply, or a folder: there every mesh (OBJ, PLY, glTF or GLB) is a frame,
/// the last digits of its name before the extension are its number, and what stands before them
/// must be the same for all. `numbers` are the frames wanted (`parse_frames`); empty: all there are.
///
/// Throws `IoError` where nothing is found, where frames that are wanted are missing (naming the
/// first and how many), where a folder holds meshes of several formats or of several sequences, and
/// where two files have one number; `InvalidInput` where `name` is neither.
std::vector<FrameFile> find_frames(const std::string& name, const std::vector<int>& numbers = {});

}  // namespace mq
