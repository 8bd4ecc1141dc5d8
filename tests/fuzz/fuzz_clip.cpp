// Triangles with corners anywhere on a coarse part of the integers of texel_point.h: the pieces
// must tile each of them; and the texel space of all of them together must keep its identities.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "mq/atlas/clip.h"
#include "mq/base/error.h"
#include "mq/fem/texel_space.h"

namespace {

using namespace mq;

void demand(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "%s\n", what);
  std::abort();
}

/// A coordinate from 5 bytes: a whole texel, and a fraction with few or many bits.
std::int64_t coordinate(const unsigned char* bytes) {
  const std::int64_t whole = bytes[0] % 24 - 4;
  std::uint32_t fraction;
  std::memcpy(&fraction, bytes + 1, 4);
  const int kind = bytes[0] / 24 % 3;
  const std::int64_t low = kind == 0   ? 0
                           : kind == 1 ? std::int64_t(fraction % 5) - 2
                                       : std::int64_t(fraction) << 4;
  return whole * TexelPoint::one + low;
}

void check_pieces(const std::array<TexelPoint, 3>& corners) {
  const double area = std::abs(double(orientation(corners[0], corners[1], corners[2]))) / 2 /
                      std::pow(double(TexelPoint::one), 2);
  if (area == 0) return;
  double sum = 0;
  const auto [first, end] = rows_of(corners);
  for (int row = first; row < end; ++row)
    clip_row(
        corners, row,
        [&](const Piece& piece) {
          demand(piece.count >= 3 && piece.count <= 7, "a piece has 3 to 7 vertices");
          for (int k = 0; k < piece.count; ++k) {
            const Piece::Vertex& v = piece.vertices[k];
            demand(v.x >= 0 && v.x <= 1 && v.y >= 0 && v.y <= 1, "a piece stays in its cell");
          }
          sum += piece.area();
        },
        [&](int, int from, int to) {
          demand(from <= to, "a run has cells");
          sum += to - from + 1;
        });
  demand(std::abs(sum - area) <= 1e-12 * std::max(1.0, area), "pieces tile their triangle");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  constexpr std::size_t corner_bytes = 10;
  constexpr int width = 16, height = 12;
  Mesh mesh;
  for (int t = 0; t < 4 && size >= 3 * corner_bytes;
       ++t, data += 3 * corner_bytes, size -= 3 * corner_bytes) {
    std::array<TexelPoint, 3> corners;
    Triangle uvs;
    for (int k = 0; k < 3; ++k) {
      corners[k] = {coordinate(data + corner_bytes * k), coordinate(data + corner_bytes * k + 5)};
      uvs[k] = int(mesh.uvs.size());
      mesh.uvs.emplace_back((corners[k].column() + 0.5) / width,
                            1 - (corners[k].row() + 0.5) / height);
    }
    check_pieces(corners);
    mesh.corner_uvs.push_back(uvs);
    mesh.triangles.push_back({t, t + 1, t + 2});
    if (t % 2) std::swap(mesh.triangles.back()[0], mesh.triangles.back()[1]);
  }
  if (mesh.triangles.empty()) return 0;
  for (int v = 0; v < mesh.triangle_count() + 2; ++v)  // a strip
    mesh.positions.emplace_back(v, v % 2, 0.1 * v * v);
  const Surface surface = make_surface(mesh);
  const Atlas atlas = make_atlas(surface, {{width, height}}, {AtlasOptions::Flipped::keep});
  try {
    const TexelSpace space(surface, atlas);
    const SparseMatrix A = space.system(1, 1);
    double trace = 0;
    for (int i = 0; i < A.rows(); ++i) {
      demand(A.coeff(i, i) > 0, "no row is zero");
      trace += A.coeff(i, i);
    }
    demand(std::isfinite(trace), "entries are finite");
    const Signal ones = Signal::Ones(space.size(), 1);
    // Needles one unit of 2^-36 texel wide are cut to about five digits of their width.
    demand(std::abs((space.mass() * ones).sum() - atlas.surface_area) <= 1e-3 * atlas.surface_area,
           "mass sums to the area");
    demand((space.stiffness() * ones).cwiseAbs().maxCoeff() <= 1e-6 * trace,
           "constants have no slope");
  } catch (const InvalidInput&) {  // nothing with area
  }
  return 0;
}
