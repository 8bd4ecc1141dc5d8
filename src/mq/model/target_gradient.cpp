#include "mq/model/target_gradient.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/fem/texel_vector_calculus.h"

namespace mq {
namespace {

using Edge = std::array<int, 2>;

/// The unknowns of a place of a table; none where it is none of the signal's.
std::vector<int> unknowns_of(const TexturedModel& model, const ModelSignal& signal, const EdgeDifferences& table,
                             const EdgeDifferences::Place& place) {
  if (table.at == EdgeDifferences::At::texels) {
    const auto& [texture, column, row] = place;
    if (texture >= std::ssize(model.texture_sizes)) return {};
    const TextureSize& size = model.texture_sizes[std::size_t(texture)];
    if (column >= size.width || row >= size.height) return {};
    return signal.unknowns_at({.texture = texture, .x = column, .y = row});
  }
  const std::vector<int>& vertices = model.surface.vertex_from_source;
  if (place[0] >= std::ssize(vertices) || vertices[std::size_t(place[0])] < 0) return {};
  return {vertices[std::size_t(place[0])]};
}

/// What is wrong with lines of a table, as one message that names the first few.
class Complaints {
 public:
  void add(int line, const std::string& what) {
    if (++count_ <= most) text_ += fmt::format("\n  line {}: {}", line, what);
  }
  void refuse_any() const {
    if (count_ > 0)
      throw InvalidInput(fmt::format("the table of differences: {} cannot be used{}{}", counted(count_, "line"), text_,
                                     count_ > most ? "\n  ..." : ""));
  }

 private:
  static constexpr std::int64_t most = 5;
  std::int64_t count_ = 0;
  std::string text_;
};

/// The row of the table for an edge, and whether it runs the other way.
struct Entry {
  Edge edge;
  std::size_t row;
  double sign;
};

/// In the order of edges. Where texels have several unknowns, all pairs of them that are next to each other are meant.
std::vector<Entry> entries_of(const TexturedModel& model, const ModelSignal& signal, const EdgeDifferences& table) {
  const SparseMatrix pattern = signal.space().stiffness();
  const auto are_coupled = [&](int i, int j) {
    const int* begin = pattern.innerIndexPtr() + pattern.outerIndexPtr()[i];
    const int* end = pattern.innerIndexPtr() + pattern.outerIndexPtr()[i + 1];
    return i != j && std::binary_search(begin, end, j);
  };
  std::vector<Entry> entries;
  Complaints complaints;
  for (std::size_t row = 0; row < table.pairs.size(); ++row) {
    const EdgeDifferences::Pair& pair = table.pairs[row];
    const std::vector<int> from = unknowns_of(model, signal, table, pair.from), to = unknowns_of(model, signal, table, pair.to);
    if (from.empty() || to.empty()) {
      complaints.add(pair.line, fmt::format("found {}, wanted one that the surface uses", table.words(from.empty() ? pair.from : pair.to)));
      continue;
    }
    bool any = false;
    for (const int i : from)
      for (const int j : to)
        if (are_coupled(i, j)) {
          any = true;
          entries.push_back({{std::min(i, j), std::max(i, j)}, row, i < j ? 1.0 : -1.0});
        }
    if (!any)
      complaints.add(pair.line, fmt::format("{} and {} are not next to each other on the surface", table.words(pair.from),
                                            table.words(pair.to)));
  }
  std::ranges::stable_sort(entries, {}, &Entry::edge);
  for (std::size_t k = 1; k < entries.size(); ++k)
    if (entries[k].edge == entries[k - 1].edge)
      complaints.add(table.pairs[entries[k].row].line,
                     fmt::format("the same two as in line {}", table.pairs[entries[k - 1].row].line));
  complaints.refuse_any();
  return entries;
}

}  // namespace

Vector gradient_moments(const TexturedModel& model, const ModelSignal& signal, const ModelField& field) {
  if (const VertexSpace* vertices = signal.vertex_space())
    return vertices->gradient_moments(field_in_frames(model.surface, field.field));
  const TexelSpace& space = *signal.texel_space();
  if (field.texels.size() > 0)
    return divergence_moments(TexelVectorSpace(model.surface, *signal.texel_atlas(), space), field.texels);
  return space.divergence({field.field});
}

Signal gradient_moments(const TexturedModel& model, const ModelSignal& signal, const Signal& psi, double beta,
                        const EdgeDifferences& table) {
  const bool of_texels = table.at == EdgeDifferences::At::texels;
  require(of_texels == (signal.texel_space() != nullptr),
          fmt::format("the table of differences names {}, and what is worked on are {}", of_texels ? "texels" : "vertices",
                      of_texels ? "vertices" : "texels"));
  require(table.names_textures || !of_texels || model.texture_sizes.size() == 1,
          fmt::format("the table of differences names no textures, and the model has {}: wanted the columns "
                      "texture,column,row,to_texture,to_column,to_row", model.texture_sizes.size()));
  require(table.channels == 1 || table.channels == psi.cols(),
          fmt::format("the table of differences has {}, wanted one, or one for each of {}", counted(table.channels, "value"),
                      counted(psi.cols(), "channel")));
  const std::vector<Entry> entries = entries_of(model, signal, table);
  std::vector<Edge> edges;
  Signal z(Eigen::Index(entries.size()), psi.cols());
  for (std::size_t k = 0; k < entries.size(); ++k) {
    const auto& [edge, row, sign] = entries[k];
    edges.push_back(edge);
    for (Eigen::Index c = 0; c < psi.cols(); ++c)
      z(Eigen::Index(k), c) = sign * table.values[row * std::size_t(table.channels) + (table.channels == 1 ? 0 : std::size_t(c))] -
                              beta * (psi(edge[1], c) - psi(edge[0], c));
  }
  return beta * signal.space().stiffness_times(psi) + signal.space().edge_divergence(edges, z);
}

}  // namespace mq
