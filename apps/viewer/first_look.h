#pragma once
/// What there is to be seen of a model while the rest of it is read and prepared.

#include <memory>
#include <vector>

#include "mq/image/image.h"
#include "surface_pane.h"

namespace mq::view {

/// The shape in few triangles, which any graphics draw at once; its colours at vertices once pictures are read.
struct FirstLook {
  TexturedModel scene;  ///< without an atlas
  std::unique_ptr<DrawnModel> drawn;
  bool coloured = false;
  bool has_uvs = false;
  Image<float> picture;  ///< the first texture as displayed, in few texels; empty: not read yet

  /// How many triangles and texels there are of the model itself.
  std::int64_t triangles = 0;
};

/// Makes looks of a model that is read: vertices within a cube of space become one, their mean. Costs a walk over the
/// vertices and triangles; of textures it looks at some texels.
class FirstLooks {
 public:
  /// `model` as `ModelWatch` gives it, the same each time.
  std::unique_ptr<FirstLook> operator()(const Model& model);

 private:
  void join_vertices(const Mesh& mesh);

  std::vector<int> joined_;  ///< per vertex of the model one of the look
  Mesh few_;
  Surface surface_;  ///< of that
};

}  // namespace mq::view
