#pragma once
/// A captured frame made ready to be followed: facing the right way, with triangles that a
/// deformation graph can follow, as a target, and with its material where that is known.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mq/io/model.h"
#include "mq/mesh/refine.h"
#include "mq/track/track_template.h"
#include "mq/track/track_truth.h"
#include "mq/track/tracking.h"

namespace mq {

class FrameLoader;

/// What says where the material of a frame is.
enum class Truth {
  none,
  uvs,      ///< texture coordinates are the same for the same material in all frames
  material  ///< `FrameLoader::material`
};

struct CaptureOptions {
  double longest_edge = 0.025;  ///< on the mean, that is not cut, in √area
  enum class Colours { left, used } colours = Colours::left;  ///< those of vertices
  Truth truth = Truth::none;
};

class CapturedFrame {
 public:
  /// Reads the frame. Triangles that face the wrong way are flipped, as `oriented` says with
  /// `before`, which is what followed the frame before, or null. A graph can only follow, and be
  /// pulled by, vertices, so triangles are cut where they are long beside the way from node to
  /// node. Throws what the loader throws, and `InvalidInput` where there is nothing to follow.
  CapturedFrame(const FrameLoader& loader, int frame, const Mesh* before,
                const CaptureOptions& options);
  CapturedFrame(const CapturedFrame&) = delete;
  CapturedFrame& operator=(const CapturedFrame&) = delete;

  int frame() const { return frame_; }                        ///< of the loader
  int number() const;                                         ///< as it is called
  const Model& model() const { return model_; }               ///< with its long triangles cut
  const std::vector<int>& turned() const { return turned_; }  ///< of the file's triangles
  const TrackTarget& target() const { return *target_; }

  /// Of the file, of turning, and what `make_surface` finds.
  Defects defects() const;

  /// Whether both are, by what is counted in their files, one mesh that moves: as many vertices and
  /// triangles. What was meshed anew has others.
  bool is_mesh_of(const CapturedFrame& other) const { return of_file_ == other.of_file_; }

  bool has_truth() const { return options_.truth != Truth::none; }

  /// Read when it is first asked for, once. Throws `InvalidInput` where the frame has none, or one
  /// of other triangles.
  const MaterialFrame& truth();

  /// Material that is farther than this from that of a vertex is not the same.
  double truth_tolerance();

  /// The frame's own mesh as a template, tidied, with ids from these on; positions are rounded to
  /// `step`. Throws `InvalidInput` where colours are used and there are none.
  TrackTemplate as_template(double step, int first_vertex_id, int first_triangle_id);

 private:
  struct Counts {
    std::size_t vertices, triangles;
    bool operator==(const Counts&) const = default;
  };

  void cut_long_triangles();
  std::vector<char> of_file() const;
  MaterialFrame read_truth() const;
  std::vector<Vector3> template_material(const Remeshed& tidy);

  const FrameLoader& loader_;
  int frame_;
  CaptureOptions options_;
  Model model_;
  Counts of_file_;
  std::vector<Triangle> uncut_;       ///< the file's triangles; empty: none were cut
  std::vector<SurfacePoint> places_;  ///< per vertex in the file's mesh; empty: none were cut
  std::vector<int> turned_;
  std::unique_ptr<const TrackTarget> target_;
  std::optional<MaterialFrame> truth_;
};

}  // namespace mq
