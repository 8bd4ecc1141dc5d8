#pragma once
/// What a photograph shows of a surface: the way back from a picture to texels or vertices.

#include <memory>
#include <span>
#include <vector>

#include "mq/base/progress.h"
#include "mq/draw/pinhole.h"
#include "mq/filter/stitch.h"
#include "mq/image/image.h"
#include "mq/mesh/surface.h"

namespace mq {

struct PhotographOptions {
  double steepest = 75;  ///< degrees between the line of sight and the normal; steeper is not shown
  double bias = 1e-3;    ///< of the surface's diagonal: what lies that close in front hides nothing
  double outline = 1.5;  ///< pixels: so near to an outline colours of both its sides mix
  double doubtful = 4;   ///< times that: nearer, confidence is a tenth, as the mesh may be off
  double border =
      0.05;  ///< of the picture's shorter side: confidence falls to 0 at the edge over it
};

/// Projects photographs onto places of one surface, which must outlive it.
class Projector {
 public:
  /// `places` are those of a space's unknowns, taken to the nearest point of the surface, and
  /// `spacing` the distance between them, model units. Throws `Unsupported` when Embree does not
  /// start, `InvalidInput` for a mesh without triangles.
  Projector(const Surface& surface, std::span<const Vector3> places, double spacing,
            const Progress& progress = {});
  ~Projector();
  Projector(const Projector&) = delete;
  Projector& operator=(const Projector&) = delete;

  /// The picture's values at the places it shows, interpolated, in its channels without alpha, and
  /// how well it shows them:
  ///
  ///     cos² θ · min(1, pixels per spacing) · border · alpha · (a tenth near outlines),
  ///
  /// θ between the line of sight and the normal, `border` rising from 0 at the picture's edge to 1.
  /// 0 where another part of the surface is in front, near its outline, where the back faces the
  /// camera, beyond `steepest` and outside the picture. The picture must have the camera's size, or
  /// `InvalidInput` is thrown. Equal bits for any number of threads.
  Partial project(const PinholeCamera& camera, const Image<float>& picture,
                  const PhotographOptions& options = {}, const Progress& progress = {}) const;

  /// The same of some of the places, by number, a row each. The picture may be the camera's at another
  /// size, of the same proportions: a photograph much finer than the spacing is better made smaller.
  Partial project(const PinholeCamera& camera, const Image<float>& picture,
                  std::span<const int> places, const PhotographOptions& options = {},
                  const Progress& progress = {}) const;

  /// How well they are shown by a picture of that camera that is not looked at: without alpha.
  std::vector<double> confidences(const PinholeCamera& camera, std::span<const int> places,
                                  const PhotographOptions& options = {},
                                  const Progress& progress = {}) const;

  /// The picture's values where the places lie in it, whatever else is in front of them; 0 for those that
  /// lie outside.
  Signal sampled(const PinholeCamera& camera, const Image<float>& picture, std::span<const int> places) const;

  /// The places on the surface.
  std::span<const Vector3> places() const;

  /// The camera's pixels per spacing, seen from the front, at the mean depth of these places; 0 where
  /// none lies in front of it.
  double pixels_per_spacing(const PinholeCamera& camera, std::span<const int> places) const;

 private:
  struct Shared;
  std::unique_ptr<Shared> shared_;
};

}  // namespace mq
