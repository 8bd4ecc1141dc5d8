#include "mq/evolving/detail/parts_of.h"

#include <map>
#include <unordered_map>

#include "mq/mesh/weld.h"

namespace mq {

std::vector<std::vector<int>> parts_of(const std::vector<int>& triangles,
                                       const std::vector<HalfEdge>& twins) {
  std::unordered_map<int, int> index;
  for (std::size_t i = 0; i < triangles.size(); ++i) index[triangles[i]] = int(i);
  DisjointSets sets(triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i)
    for (int k = 0; k < 3; ++k)
      if (const HalfEdge across = twins[3 * triangles[i] + k]; across >= 0)
        if (const auto other = index.find(across / 3); other != index.end())
          sets.join(int(i), other->second);
  std::map<int, std::vector<int>> parts;
  for (std::size_t i = 0; i < triangles.size(); ++i)
    parts[sets.root(int(i))].push_back(triangles[i]);
  std::vector<std::vector<int>> result;
  for (auto& [root, part] : parts) result.push_back(std::move(part));
  return result;
}

}  // namespace mq
