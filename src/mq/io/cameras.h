#pragma once
/// Cameras of photographs as files: COLMAP's text export, and a JSON of our own.

#include <filesystem>
#include <vector>

#include "mq/draw/pinhole.h"

namespace mq {

/// A photograph's file and its camera.
struct Photograph {
  std::filesystem::path picture;
  PinholeCamera camera;
};

/// Reads `path`:
/// - a folder, or a file cameras.txt or images.txt in it: COLMAP's text export, both files beside
///   each other, in the folder or its sparse/0 or sparse; camera models SIMPLE_PINHOLE, PINHOLE,
///   SIMPLE_RADIAL, RADIAL, OPENCV and FULL_OPENCV (with k4 = k5 = k6 = 0);
/// - any other file: JSON, {"cameras": [{"image", "width", "height", "fx", "fy", "cx", "cy",
///   "k1", "k2", "k3", "p1", "p2" (0 where left out), "rotation" (three rows) or "quaternion" (w,
///   x, y, z), "translation"}, ...]}, in the conventions of `PinholeCamera`.
/// Pictures are looked for beside the file, in a folder "images" there or up to two folders further
/// up, and in the folder above, so that COLMAP's projects are read as they lie.
/// Throws `IoError` naming the file, the place and what was wanted, `Unsupported` for other lenses
/// and for COLMAP's binary format.
std::vector<Photograph> read_cameras(const std::filesystem::path& path);

/// Writes that JSON.
void write_cameras(const std::filesystem::path& path, const std::vector<Photograph>& photographs);

}  // namespace mq
