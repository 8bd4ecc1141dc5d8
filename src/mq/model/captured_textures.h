#pragma once
/// What captured frames, or photographs of them, show on the evolving mesh that follows them: as textures of its
/// atlas, or as colours at its vertices.

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "mq/base/defect.h"
#include "mq/base/progress.h"
#include "mq/io/evolving_file.h"
#include "mq/io/model.h"
#include "mq/model/messages.h"
#include "mq/model/photographed_frames.h"
#include "mq/video/texture_frame.h"

namespace mq {

struct CapturedTextureOptions {
  int side = 1024;                              ///< texels of a texture, both ways
  int samples = TextureFrameOptions().samples;  ///< per texel and direction
  /// Where texels come from different captured charts.
  enum class Steps { left, taken_out } steps = Steps::left;
  std::string textures = {};  ///< pictures instead of those the frames name, %04d for the number
  PhotographedOptions photographs = {};  ///< where frames are photographs with cameras
};

class CapturedTextures {
 public:
  /// The sequence of the frames of these indices, as `find_frames` finds it, or photographs with cameras, as
  /// `find_camera_frames` does (`names_camera_frames`). Throws as these do, where the picture of a frame is not there,
  /// and `InvalidInput` where a store without an atlas is to be photographed, or with options that are of meshes. The
  /// reader and who hears the messages must stay.
  CapturedTextures(const EvolvingReader& reader, const std::string& sequence,
                   const std::vector<int>& frames, CapturedTextureOptions options,
                   Messages& messages);

  const EvolvingReader& reader() const { return reader_; }
  const std::vector<int>& frames() const { return frames_; }  ///< indices, as they were given
  int side() const { return options_.side; }                  ///< texels of a texture, both ways

  struct Textured {
    int number = 0;
    Mesh mesh;
    TextureFrame texture;
    bool is_light = false;    ///< values are light, else what a display is given
    Depth depth = Depth::u8;  ///< of what was captured
    bool steps_were_taken_out = false;
    std::optional<double> changed = {};  ///< of photographs: `PhotographedFrames::changed`
  };

  /// Reads the frame with this index and resamples it. Throws `InvalidInput` where most of the
  /// store's mesh lies nowhere near it, as that of another sequence, where it has no colours, and
  /// where steps between charts are to be taken out and it has none.
  Textured texture(int frame, const Progress& progress = {});

  struct Coloured {
    int number = 0;
    Model model;
    std::int64_t unseen = 0;  ///< vertices that nothing was captured for
    double accuracy = 0;
  };
  Coloured at_vertices(int frame);

  /// Of what was read so far, of each kind the first: triangles that were turned.
  const Defects& defects() const { return defects_; }

 private:
  struct Captured {
    Model model;
    Mesh mesh;  ///< what follows it
  };
  Captured read(int frame);
  Textured photographed(int frame, const Progress& progress);
  void turn_back(const std::filesystem::path& path, Captured& captured);
  void require_near(int frame, const Captured& captured, double accuracy) const;
  std::vector<int> captured_charts(int frame, const Model& model) const;

  const EvolvingReader& reader_;
  std::vector<int> frames_;
  std::map<int, std::filesystem::path> files_;
  CapturedTextureOptions options_;
  Messages& messages_;
  std::set<std::string> said_;  ///< kinds of defects
  Defects defects_;
  std::optional<PhotographedFrames> photographed_;  ///< nothing where frames are meshes
};

}  // namespace mq
