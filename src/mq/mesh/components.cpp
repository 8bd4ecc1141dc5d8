#include "mq/mesh/components.h"

#include "mq/mesh/weld.h"

namespace mq {

std::vector<int> triangle_components(const Surface& surface) {
  DisjointSets sets(surface.mesh.triangles.size());
  for (std::size_t h = 0; h < surface.twins.size(); ++h)
    if (surface.twins[h] >= 0) sets.join(int(h / 3), surface.twins[h] / 3);
  std::vector<int> component(surface.mesh.triangles.size());
  for (std::size_t t = 0; t < component.size(); ++t) component[t] = sets.root(int(t));
  return component;
}

}  // namespace mq
