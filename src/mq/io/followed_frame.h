#pragma once
/// What is known of a frame of a sequence that was followed, and how its store remembers it.

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "mq/io/file_print.h"
#include "mq/track/track_truth.h"
#include "mq/track/tracking.h"

namespace mq {

/// A frame that was left out.
struct SkippedFrame {
  int number = 0;
  std::string why;
};

/// A file that a frame was read from.
struct KnownFile {
  std::string name;  ///< relative to the folder of the frame's first file
  FilePrint print;
};

/// Numbers are NaN, and counts −1, where a store does not say them.
struct FollowedFrame {
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

  int number = 0;                     ///< as its file was called
  int turned = 0;                     ///< triangles that faced the wrong way
  std::vector<SkippedFrame> skipped;  ///< since the frame before
  SurfaceDistance distance{unknown, unknown, unknown};
  Distortion distortion{unknown, unknown};
  int kept = -1, added = -1, removed = -1;  ///< triangles, against the frame before

  /// Of a frame that the template of the frame before was deformed to.
  struct Match {
    double matched = unknown;  ///< see `TrackedFrame`
    bool predicted = false;
    bool recognised = false;
    bool known = false;
    TrackedFrame::Seconds seconds;
    std::optional<double> remesh_seconds;  ///< where remeshing was asked for
  };
  std::optional<Match> match;

  /// Why triangles were replaced, where some were and others kept: see `Remeshed`.
  struct Replacement {
    int distorted = 0, template_seeds = 0, target_seeds = 0, reached = 0, rounds = 0;
  };
  std::optional<Replacement> replaced;

  /// Vertices of the template and of the frame that would have had something replaced, were it not that it passes.
  int passing = 0;

  std::optional<bool> manifold;  ///< whether what shows the frame is
  int folded = -1;               ///< triangles of it

  /// Against a truth, model units; `mean_edges` in mean edges of the segment's first frame.
  struct Drift : DriftSummary {
    double mean_edges = 0;
  };
  std::optional<Drift> drift;

  std::vector<KnownFile> files;
  double seconds = unknown;  ///< in all

  /// Whether all of the template is the frame's own mesh.
  bool is_own() const { return kept == 0 && !replaced; }
};

/// As a JSON object without line breaks, for `EvolvingWriter::add_frame`.
std::string followed_text(const FollowedFrame& frame);

/// What such a text says of the frame of this number. Nothing is wrong with a text: what it does
/// not say, or not in this way, is unknown. A file that it names in another way is no file's print.
FollowedFrame followed_frame(int number, const std::string& text);

}  // namespace mq
