#pragma once
/// The textures of an evolving mesh filtered in time, from files to files: light that comes and
/// goes taken out, or all frames filtered at once.

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "mq/base/length.h"
#include "mq/base/progress.h"
#include "mq/io/evolving_file.h"
#include "mq/io/video.h"
#include "mq/model/messages.h"
#include "mq/model/value_space.h"
#include "mq/video/light_removal.h"
#include "mq/video/relight_meter.h"
#include "mq/video/temporal_poisson.h"

namespace mq {

struct RelightOptions {
  enum class Method {
    mean,    ///< `remove_lighting`
    poisson  ///< `temporal_poisson`
  } method = Method::mean;

  /// How far the weight w of gradients in space reaches, on the surface of the first frame.
  Length spread = {8e-4, Length::Unit::alpha};
  double tolerance = 1e-5;                    ///< relative residual at which iterations stop
  int radius = LightRemovalOptions{}.radius;  ///< frames to either side, of a mean
  LightRemovalOptions::Crossover crossover = LightRemovalOptions::Crossover::steep;  ///< of a mean

  /// What is done where the surface was not tracked exactly and slides under what frames show.
  enum class Drift {
    ignore,   ///< a texel is a point of the surface
    measure,  ///< the same, but flicker is measured along it as well
    follow    ///< its colours say where it slid to (`FrameDrift`)
  } drift = Drift::ignore;

  /// Of `poisson`; `weight` and the solver's tolerance are those above.
  TemporalOptions poisson = {.gamma = 4};

  ValueSpace values = {.space = ColourSpace::log};  ///< that are filtered: exposure is a factor

  /// Of the frames that are asked for, those that are written, counted from 0: those around them are read as far as
  /// they matter. A mean is that of the whole, bit for bit; `poisson` comes as near to it as its accuracy says.
  int first = 0, end = std::numeric_limits<int>::max();
};

/// Names with a place for the frame's number, as `frame_name` has it.
struct RelightFiles {
  std::string textures;    ///< pictures, one for each frame
  std::string output;      ///< models, pictures or a video: see `FrameTextures`
  std::string truth = {};  ///< what the textures should be, to compare with; empty: not known
  VideoOptions video = {};
};

/// How a frame that is written goes on from the one before, where drift is followed or measured.
struct FrameOnward {
  int frame = 0;                           ///< its number
  std::optional<FrameDrift::Fit> fit = {};  ///< none: charts changed, over which nothing is followed

  bool is_followed() const { return fit && fit->explained > 0; }
};

struct RelitSequence {
  double weight = 0;      ///< w, model units squared
  TemporalReport filter;  ///< how the frames were filtered
  RelightMeasures measures;
  std::vector<FrameOnward> onward = {};  ///< frames that have one before them; none without drift
};

class SequenceRelighter {
 public:
  /// Of the frames with these indices in the store, in their order. Reads nothing but the store.
  /// Throws `InvalidInput` where names have no place for a number or are of no such files, and
  /// where the store has no atlas. The reader and who hears the messages must stay.
  SequenceRelighter(const EvolvingReader& reader, std::vector<int> frames, RelightFiles files,
                    RelightOptions options, Messages& messages);

  /// The pictures that are read, and the files that are written.
  std::vector<std::filesystem::path> inputs() const;
  std::vector<std::filesystem::path> outputs() const;

  /// Throws what can be said before any work: `IoError` where pictures are not there,
  /// `InvalidInput` where they differ in size, where a video cannot hold them, and for an alpha
  /// that `poisson` cannot work with (1e5 at most); `OutOfMemory`.
  void rehearse();

  /// Reads frames as they are wanted and writes them as they are done; texels outside of charts
  /// have the value of the nearest one inside. Files have the depth of the texture that was read.
  /// Throws as `rehearse`, `AtlasFrame` and the filters do, and where pictures differ in their
  /// channels.
  RelitSequence run(const Progress& progress = {});

 private:
  struct FirstFrame {
    double weight = 0;  ///< of gradients, from its area
    double texels = 0;  ///< that charts cover
  };
  FirstFrame first_frame(int width, int height) const;
  int reach() const;
  std::vector<int> numbers(int first, int end) const;
  TemporalOptions poisson_options(double weight) const;
  FrameCosts costs(int first, int end) const;
  void require_room(const FirstFrame& first) const;

  const EvolvingReader& reader_;
  std::vector<int> frames_, numbers_;
  int read_ = 0, read_end_ = 0;  ///< of these frames those that are read
  RelightFiles files_;
  RelightOptions options_;
  Messages& messages_;
  std::optional<double> weight_;  ///< once it was rehearsed
};

}  // namespace mq
