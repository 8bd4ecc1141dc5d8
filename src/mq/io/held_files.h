#pragma once
/// Models and pictures that a caller holds in memory, under names that stand for them wherever this room
/// reads and writes files: what is done with files is done without them.
///
///     HeldFiles held;
///     held.put("skin.png", PictureView{...});
///     const Texture read = read_texture(held.path("skin.png"));
///     write_texture(held.path("out.png"), result);  // makes no file
///     held.pictures().at("out.png");
///
/// The names work in all threads while the object exists. Read in this way are pictures
/// (`read_texture`, `picture_info`) and models (`read_model`); written pictures, models, optical flow,
/// vector fields and files that are one piece of bytes. Anything else, such as a video, is refused.

#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "mq/io/model.h"

namespace mq {

/// What names of this kind begin with.
inline constexpr std::string_view held_scheme = "memory:";

/// Values of a picture that somebody else keeps, as a file has them: 8 and 16 bits as they are, anything
/// else as floats. Steps are in bytes and may be negative.
struct PictureView {
  const void* values = nullptr;
  int width = 0, height = 0, channels = 0;
  Depth depth = Depth::u8;
  std::ptrdiff_t row_step = 0, pixel_step = 0, channel_step = 0;
};

/// A picture that was written, row 0 on top: rounded as a file of its depth would be, `Depth::half` kept
/// as floats.
struct WrittenPicture {
  int width = 0, height = 0, channels = 0;
  Depth depth = Depth::u8;
  std::vector<std::byte> values = {};
};

/// A model that was written, without its pictures' pixels.
struct WrittenModel {
  Mesh mesh;
  VertexSignal colors;
  std::vector<std::string> pictures = {};  ///< per texture the name that it has among the written pictures;
                                      ///< empty: it has none
};

class HeldFiles {
 public:
  HeldFiles();
  ~HeldFiles();
  HeldFiles(const HeldFiles&) = delete;
  HeldFiles& operator=(const HeldFiles&) = delete;

  /// What to name where a file is named: "memory:3/skin.png". The extension of `name` says what it is.
  std::filesystem::path path(const std::string& name) const;

  /// The view must stay until the object is gone. Throws `InvalidInput` where it has no pixels, more
  /// than `max_picture_side` of them on a side, or more than four channels.
  void put(const std::string& name, const PictureView& picture);

  /// A model whose textures have no pixels: pictures are given beside it.
  void put(const std::string& name, Model model);

  /// What was written so far, by name. Not while anybody may still write.
  std::map<std::string, WrittenPicture>& pictures();
  std::map<std::string, WrittenModel>& models();
  std::map<std::string, std::vector<Vector3>>& fields();
  std::map<std::string, std::vector<std::byte>>& files();

  struct Data;

 private:
  std::shared_ptr<Data> data_;
};

/// Whether a path is of this kind.
bool names_held(const std::filesystem::path& path);

/// Where what goes to standard output lies first: a file of this stem, in a folder whose name begins so.
inline constexpr const char* standard_output_stem = "standard_output";
inline constexpr const char* pipe_folder_begin = "marquetry-pipe-";

/// Whether a path is such a file.
bool names_standard_output(const std::filesystem::path& path);

}  // namespace mq
