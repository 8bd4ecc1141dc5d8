#pragma once
/// Models that the program makes itself: for demonstrations, tests and measurements.

#include <cstdint>
#include <string>
#include <vector>

#include "mq/atlas/atlas.h"
#include "mq/base/progress.h"
#include "mq/sample/paint.h"

namespace mq {

struct SampleInfo {
  std::string name;
  std::string description;  ///< one line
};

/// All samples, in the order in which they are best listed.
const std::vector<SampleInfo>& sample_names();

struct SampleOptions {
  int texture_size = 1024;  ///< texels a side; the gutter between charts is a few texels
  int triangles = 0;        ///< about as many are made; 0: the sample's own number
  std::uint64_t seed = 1;   ///< of everything left to chance
};

struct Sample {
  std::string name;
  Mesh mesh;  ///< with UVs for a texture of this size
  TextureSize texture;
  ColorField colors;  ///< what to paint on it
};

/// Makes a sample. Equal options give equal bits. Throws `InvalidInput` for an unknown name (naming
/// the nearest) and for options out of range (texture 1 to 32768, triangles up to 20 million).
///
/// Every mesh is manifold and oriented, without defects; no chart is folded or overlaps another.
/// `cube`, `cylinder` and `flat_torus` are isometric in their charts.
Sample make_sample(const std::string& name, const SampleOptions& options = {},
                   const Progress& progress = {});

/// A sample's picture, painted at its texture size with its own colours: as the true signal, or as
/// badly joined photographs show it (exposure and white balance differ from chart to chart, and the
/// picture is shifted by up to two texels), so that seams show.
enum class Alignment { aligned, misaligned };
Image<float> paint(const Sample& sample, Alignment alignment = Alignment::aligned,
                   std::uint64_t seed = 1, const Progress& progress = {});

}  // namespace mq
