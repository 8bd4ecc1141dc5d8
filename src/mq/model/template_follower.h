#pragma once
/// What follows a sequence at the moment: a template, where it is, and when it is replaced.

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "mq/base/progress.h"
#include "mq/evolving/evolving_mesh.h"
#include "mq/io/followed_frame.h"
#include "mq/mesh/surface.h"
#include "mq/model/captured_frame.h"
#include "mq/model/confirmed_changes.h"
#include "mq/model/known_motion.h"
#include "mq/track/track_template.h"
#include "mq/track/tracking.h"

namespace mq {

/// Whether what of a template does not show a frame is replaced, and by how much.
enum class Remeshing {
  none,
  parts,     ///< by the frame's triangles there
  keyframes  ///< wherever a part would be: all of it, by the frame's own mesh
};

/// Distances are fractions of the diagonal of a frame's box.
struct TemplateFollowerOptions {
  TrackOptions track = {};  ///< but for colours: `colours` says whether they are used
  Remeshing remeshing = Remeshing::none;
  /// How far 95 % of the points of a frame that is remeshed may be. Where more are, smaller
  /// differences are replaced too; what is five times as far is replaced wherever it is.
  double within = 0.002;
  /// The frame's own mesh is the template where 95 % are not within this; nothing: never.
  std::optional<double> restart = {};
  /// How many frames after one must ask for a change as well, where it is made: holes and handles that
  /// a capture shows for no longer are not followed. None are asked where the next frame is the same
  /// mesh, moved: nothing comes and goes then. 0: none are read ahead.
  int confirming_frames = 3;
  Truth truth = Truth::none;
  enum class Colours {
    left,
    used  ///< they correct what slides along the surface
  } colours = Colours::left;
  int colour_cycles = 2;  ///< of registration by colour in each frame, where they are used
  /// How the surface moves, as far as that is known: frames for which it is need no graph. Null: nothing is known.
  std::shared_ptr<const KnownMotion> motion = {};

  /// Triangles that are longer on the mean are cut, in √area: a graph can follow, and be pulled by,
  /// vertices alone.
  double longest_edge() const;
};

/// How far points may be that are the farthest, and are in flat and open places, in the distance
/// that 95 % of them are to keep.
inline constexpr double farthest_in_within = 5;

/// The frame so many after the one that is followed, from 1 on, of those that can be; null: there is
/// none. `before` is what follows the frame before it. Frames stay until they are followed.
using FrameAhead = std::function<CapturedFrame*(int, const Mesh& before)>;

class TemplateFollower {
 public:
  explicit TemplateFollower(TemplateFollowerOptions options);
  ~TemplateFollower();

  /// Whether there is a template yet.
  bool follows() const { return template_ != nullptr; }

  const EvolvingSegment& segment() const;
  const std::vector<Vector3>& positions() const { return positions_; }  ///< in the last frame

  /// What follows the last frame.
  Mesh mesh() const;

  /// Follows the next frame, with positions that are multiples of `step`, or begins with it.
  /// Says in `found` all that it measures. Returns whether `segment` is another one now.
  enum class Segment { same, begun };
  Segment follow(CapturedFrame& frame, const FrameAhead& ahead, double step, FollowedFrame& found,
                 const Progress& progress = {});

  /// As after the frame of this number of a store; `previous` are the positions of the frame before it in the same
  /// segment, empty where there is none.
  void take_up(int number, std::vector<Vector3> positions, std::vector<Vector3> previous);

  /// Counts a frame of a store that was followed with remeshing, for what is done in the last frames of a sequence.
  void count_passing(const FollowedFrame& frame);

  /// As after the first frame of a segment of a store, which is there at `positions`. Returns false
  /// where the segment was not made of this frame.
  [[nodiscard]] bool take_up(CapturedFrame& frame, double step, const EvolvingSegment& next,
                             const std::vector<Vector3>& positions);

 private:
  struct Template;

  /// A frame that the template was deformed to before its turn.
  struct Tracked {
    CapturedFrame* frame;
    TrackedFrame tracked;  ///< with positions as in a store
    Surface surface;
  };

  /// Whether in half of the frames so far something passed.
  bool is_noisy() const { return noisy_frames_ > 0 && 2 * noisy_frames_ >= remeshed_frames_; }
  void begin(CapturedFrame& frame, double step, FollowedFrame& found);
  TrackedFrame track(CapturedFrame& frame, int before, double step, const Progress& progress);
  TrackedFrame deformed(const CapturedFrame& frame, int before, std::span<const Vector3> current,
                        std::span<const Vector3> previous, double step, const Progress& progress) const;
  const Tracked* track_ahead(int after, const FrameAhead& ahead, double step);
  bool remesh_frame(CapturedFrame& frame, const FrameAhead& ahead, double step,
                    FollowedFrame& found, const Progress& progress);
  std::optional<Remeshed> remeshed_within(CapturedFrame& frame, const FrameAhead& ahead,
                                          double step, const Progress& progress);
  PassingPlaces passing(const CapturedFrame& frame, const SearchedSurface& from, const SearchedSurface& to,
                        const FrameAhead& ahead, double step, RemeshOptions how);
  void replace_parts(CapturedFrame& frame, double step, const Remeshed& remeshed,
                     FollowedFrame& found);
  TrackTemplate carried_on(CapturedFrame& frame, const EvolvingSegment& segment,
                           const std::vector<Vector3>& positions) const;
  void set_template(TrackTemplate next);
  void count_ids(const EvolvingSegment& of);
  void measure(CapturedFrame& frame, FollowedFrame& found) const;

  TemplateFollowerOptions options_;
  std::unique_ptr<Template> template_;
  std::vector<Vector3> positions_, previous_;
  Surface surface_;  ///< at these positions
  int remeshed_frames_ = 0, noisy_frames_ = 0, passing_now_ = 0;
  std::deque<Tracked> ahead_;  ///< from the next frame on, while the template stays
  int last_ = 0;               ///< number of the last frame
  int next_vertex_ = 0, next_triangle_ = 0;
};

}  // namespace mq
