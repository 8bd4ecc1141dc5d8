#pragma once
/// What a signal is to change by from place to place, from a table.

#include <array>
#include <filesystem>
#include <string>
#include <vector>

namespace mq {

/// Pairs of texels or of vertices, and by how much values at the second are to be above those at the first.
struct EdgeDifferences {
  enum class At { texels, vertices } at = At::texels;
  bool names_textures = true;  ///< of texels; else all are of texture 0

  using Place = std::array<int, 3>;  ///< texture, column, row (0 on top); or vertex, 0, 0
  struct Pair {
    Place from{}, to{};
    int line = 0;  ///< of the file, from 1
  };
  std::vector<Pair> pairs;
  int channels = 1;
  std::vector<double> values;  ///< `channels` of each pair

  /// "column 3, row 5" or "vertex 7".
  std::string words(const Place& place) const;
};

/// Reads a table of numbers with commas between them, one pair a line, below a line that names the columns:
///
///     column,row,to_column,to_row,value
///     texture,column,row,to_texture,to_column,to_row,red,green,blue
///     vertex,to_vertex,value
///
/// Columns after those of places are values, named as one likes. Throws `IoError` with the line, what was found and what
/// was wanted.
EdgeDifferences read_edge_differences(const std::filesystem::path& path);

}  // namespace mq
