#pragma once
/// What photographs with cameras show of the frames of an evolving mesh, as textures of its atlas (thesis 6.5.1).

#include <span>
#include <string>
#include <vector>

#include "mq/base/progress.h"
#include "mq/image/image.h"
#include "mq/io/cameras.h"
#include "mq/io/frame_files.h"
#include "mq/mesh/mesh.h"
#include "mq/model/messages.h"
#include "mq/model/photograph_texture.h"
#include "mq/video/texture_frame.h"

namespace mq {

struct PhotographedOptions {
  /// Folders with the photographs (`CamerasOptions::images`), %04d for the frame's number.
  std::vector<std::string> images = {};
  PhotographTextureOptions texture = {};
};

/// Whether a sequence of this name is photographs with cameras, and not meshes: a file as cameras are read from, but
/// glTF, a name without extension and with a place for the number, or a folder with cameras in it (`read_camera_set`).
bool names_camera_frames(const std::string& name);

/// Per number what holds the cameras: `name` with the number in its place, or `name` for all of them, as where a rig
/// stands still. Throws `IoError` naming the first that is not there, and `InvalidInput` where several frames would be
/// seen in the same photographs: neither `name` nor one of `images` (`PhotographedOptions`) has a place for the number.
std::vector<FrameFile> find_camera_frames(const std::string& name, const std::vector<int>& numbers,
                                          const std::vector<std::string>& images);

/// The photographs of one frame, all of which are there. Throws what `read_camera_set` throws, and `IoError` where
/// there are none.
std::vector<Photograph> photographs_of_frame(const FrameFile& frame, const PhotographedOptions& options);

/// Makes the textures of frames, one after the other.
///
/// Each is made as the verb texture makes one: photographs are aligned, their exposures evened out, what disagrees is
/// left out, a photograph is chosen for each patch of texels, and steps are spread over `usual_photograph_length`.
/// Between frames a patch keeps its photograph unless another shows it better by more than
/// `ChooseOptions::steady`: cameras have the same order in all frames, and a texel is the same piece of the surface as
/// long as its chart lasts. A frame with another number of photographs than the one before is chosen for by itself.
class PhotographedFrames {
 public:
  /// Textures of `side`² texels. `messages` must stay.
  PhotographedFrames(int side, PhotographedOptions options, Messages& messages);

  /// What photographs show of a mesh with texture coordinates, whose positions are those of the frame. `name` is what
  /// errors call it. As `resample_texture` gives it: values are as a display is given them, texels that no photograph
  /// shows are filled over the surface. `before` and `after` of steps stay 0. Throws what `PhotographTexturing` throws,
  /// and `InvalidInput` where charts cannot be used or no photograph shows any of it.
  TextureFrame texture(const std::string& name, const Mesh& mesh, std::span<const Photograph> photographs,
                       const Progress& progress = {});

  /// The share of texels seen in this frame and the one before that come from another photograph than there.
  double changed() const { return changed_; }

  const PhotographedOptions& options() const { return options_; }

 private:
  std::vector<int> kept(const Texels& texels, std::size_t photographs) const;
  void keep(const Texels& texels, std::span<const int> labels, std::size_t photographs);

  int side_;
  PhotographedOptions options_;
  Messages& messages_;
  Image<int> labels_;              ///< of the frame before; `unseen` where it has none
  std::size_t photographs_ = 0;  ///< of the frame before; 0: there is none
  double changed_ = 0;
};

}  // namespace mq
