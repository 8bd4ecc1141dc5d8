#pragma once
/// Sequences that the program makes itself: bodies in motion, meshed anew in every frame, of which
/// is known where each point of the surface was at rest.

#include <cstdint>
#include <string>
#include <vector>

#include "mq/base/progress.h"
#include "mq/mesh/mesh.h"
#include "mq/sample/cheap_capture.h"
#include "mq/sample/sample.h"

namespace mq {

/// `bending` and `twisting`: a long body that bends to both sides, or twists both ways, and comes
/// back. `spinning`: a vase that turns about its axis, of which only colours tell. `merging`: two
/// balls that fuse and part, each of which carries its material along.
const std::vector<SampleInfo>& moving_names();

struct MovingOptions {
  int period = 100;       ///< frames of the whole motion, which then begins again
  int triangles = 12000;  ///< of each frame, about
  std::uint64_t seed = 1;
  /// How much darker than its own colour a place may be that faces away from a light which circles
  /// around the body in `light_period` frames: colours times 1 − light · ½(1 − ⟨n, l⟩).
  double light = 0;
  double noise = 0;  ///< standard deviation of what is added to every value of every frame
  /// Standard deviation of the logarithm of the exposure, another in every frame: a third of its variance is that of
  /// the whole, a third that of eight cameras around it, each of which has its own in every channel and sees what faces
  /// it, and a third changes from place to place, in waves of `flicker_wave`.
  double flicker = 0;
  CheapCapture capture = {};
};

/// Frames in which a light goes around.
inline constexpr int light_period = 16;

/// Length of the waves of exposure that differs from place to place; bodies are about 2 long.
inline constexpr double flicker_wave = 0.8;

struct MovingFrame {
  Mesh mesh;                      ///< without texture coordinates; closed, but for holes asked for
  std::vector<Vector3> material;  ///< per vertex where its material is at rest
  std::vector<Vector3> colors;    ///< per vertex, 0 to 1: those of its material, lit, with noise
};

/// One frame. No two frames have a vertex or a triangle in common but by chance. Equal options give
/// equal bits. Where vertices are off, colours and material are those of where they should be. A
/// handle that the frame's grid cannot show is left out. Throws `InvalidInput` for an unknown name
/// and for options out of range (period from 1, triangles from 500, light from 0 to 1, noise and flicker from 0;
/// vertices off by 0 to 1, 0 to 1000 holes and handles).
MovingFrame make_moving_frame(const std::string& name, int frame, const MovingOptions& options = {},
                              const Progress& progress = {});

/// Where the material at rest at `material` is in a frame: the map that the frames are made with.
Vector3 moved_material(const std::string& name, const Vector3& material, double frame,
                       const MovingOptions& options = {});

}  // namespace mq
