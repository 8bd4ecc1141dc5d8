#pragma once
/// Triangles in the order and rotation they have, each by an edge of those before it and the vertex across.

#include <array>
#include <vector>

#include "mq/io/detail/symbol_streams.h"
#include "mq/mesh/mesh.h"

namespace mq {

/// What is known of a mesh while its triangles are coded one after the other.
class TriangleCoder {
 public:
  static constexpr int stream_count = 18;

  /// Uses as many streams from `first_stream` on.
  TriangleCoder(int first_stream, int vertices);

  /// Takes note of a triangle that is known otherwise.
  void know(const Triangle& triangle);

  void put(SymbolWriter& to, const Triangle& triangle);
  Triangle get(SymbolReader& from);

 private:
  struct Edge {
    int begin = -1, end = -1;  ///< as in the triangle that is beside it
  };
  static constexpr int edges_kept = 32, vertices_kept = 16;

  int stream(int kind) const { return first_ + kind; }
  int across_stream(const Edge& edge, int place) const;
  int next_new();
  void see(int vertex);
  void remember(const Triangle& triangle);
  int known_edge(int place) const { return (newest_edge_ + edges_kept - place) % edges_kept; }
  int known_vertex(int place) const { return (newest_vertex_ + vertices_kept - place) % vertices_kept; }
  void put_vertex(SymbolWriter& to, int vertex, int near);
  int get_vertex(SymbolReader& from, int near);
  void put_across(SymbolWriter& to, const Edge& edge, int place, int vertex);
  int get_across(SymbolReader& from, const Edge& edge, int place);

  int first_, vertices_;
  std::vector<char> seen_;
  int newest_ = -1, first_new_ = 0;  ///< seen for the first time last; every vertex before it was seen
  std::vector<int> next_, last_;  ///< along the border of what is known; -1: not at it
  std::array<Edge, edges_kept> edges_;
  std::array<int, vertices_kept> recent_;
  int newest_edge_ = 0, newest_vertex_ = 0, before_ = 0, rotation_ = 0;
};

}  // namespace mq
