/// A half-edge that is halved becomes two, of which its twin's halves are the twins the other way
/// round.

#include "mq/mesh/refine.h"

#include <cmath>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

constexpr std::int64_t most_triangles = std::int64_t(1) << 27;

/// A corner of a part: a vertex, and its weights in the source.
struct Corner {
  int vertex;
  float u, v;
};

Corner middle(const Corner& a, const Corner& b, int vertex) {
  return {vertex, 0.5F * (a.u + b.u), 0.5F * (a.v + b.v)};
}

using Corners = std::array<Corner, 3>;

/// The parts of a triangle whose edge k has the middle vertex middles[k], −1 where it stays whole.
int cut(const Corners& whole, const std::array<int, 3>& middles, const std::vector<Vector3>& positions,
        std::array<Corners, 4>& parts) {
  const int count = (middles[0] >= 0) + (middles[1] >= 0) + (middles[2] >= 0);
  std::array<Corner, 3> m{};
  for (int k = 0; k < 3; ++k)
    if (middles[k] >= 0) m[k] = middle(whole[k], whole[(k + 1) % 3], middles[k]);
  if (count == 0) {
    parts[0] = whole;
  } else if (count == 1) {
    const int k = middles[0] >= 0 ? 0 : middles[1] >= 0 ? 1 : 2;
    const Corner &a = whole[k], &b = whole[(k + 1) % 3], &c = whole[(k + 2) % 3];
    parts[0] = {a, m[k], c};
    parts[1] = {m[k], b, c};
  } else if (count == 2) {
    const int k = middles[0] < 0 ? 0 : middles[1] < 0 ? 1 : 2;
    const Corner &a = whole[k], &b = whole[(k + 1) % 3], &c = whole[(k + 2) % 3];
    const Corner &bc = m[(k + 1) % 3], &ca = m[(k + 2) % 3];
    parts[0] = {c, ca, bc};
    const double first = (positions[a.vertex] - positions[bc.vertex]).squaredNorm();
    const double second = (positions[b.vertex] - positions[ca.vertex]).squaredNorm();
    if (first <= second) {
      parts[1] = {a, b, bc};
      parts[2] = {a, bc, ca};
    } else {
      parts[1] = {a, b, ca};
      parts[2] = {b, bc, ca};
    }
  } else {
    parts[0] = {whole[0], m[0], m[2]};
    parts[1] = {m[0], whole[1], m[1]};
    parts[2] = {m[2], m[1], whole[2]};
    parts[3] = {m[0], m[1], m[2]};
  }
  return count + 1;
}

/// The triangles that stay, as parts of themselves.
RefinedSurface kept(const Surface& surface, std::span<const char> keep) {
  RefinedSurface fine;
  std::vector<int> number(keep.size(), -1);
  for (int t = 0; t < surface.triangle_count(); ++t)
    if (keep[t]) {
      number[t] = int(fine.source.size());
      fine.source.push_back(t);
    }
  Surface& s = fine.surface;
  s.mesh.positions = surface.mesh.positions;
  for (const int t : fine.source) {
    s.mesh.triangles.push_back(surface.mesh.triangles[t]);
    s.degenerate.push_back(surface.degenerate[t]);
    s.area += triangle_area(surface.mesh, t);
    fine.corners.push_back({0, 0, 1, 0, 0, 1});
    for (int k = 0; k < 3; ++k) {
      const HalfEdge twin = surface.twins[3 * t + k];
      const bool ends = twin < 0 || number[twin / 3] < 0;
      s.twins.push_back(ends ? -1 : 3 * number[twin / 3] + twin % 3);
    }
  }
  return fine;
}

/// One round: per half-edge the vertex in its middle, −1 where it stays whole.
std::vector<int> find_middles(RefinedSurface& fine, const LineLength& length, double most) {
  Surface& s = fine.surface;
  std::vector<char> longer(s.twins.size());
  parallel_for(s.triangle_count(), [&](std::int64_t t) {
    const std::array<float, 6>& c = fine.corners[t];
    for (int k = 0; k < 3; ++k) {
      const int l = (k + 1) % 3;
      longer[3 * t + k] = length(fine.source[t], Vector2(c[2 * k], c[2 * k + 1]),
                                 Vector2(c[2 * l], c[2 * l + 1])) > most;
    }
  });
  std::vector<int> middles(s.twins.size(), -1);
  for (HalfEdge h = 0; h < int(s.twins.size()); ++h) {
    const HalfEdge twin = s.twins[h];
    if (middles[h] >= 0 || !(longer[h] || (twin >= 0 && longer[twin]))) continue;
    middles[h] = s.mesh.vertex_count();
    if (twin >= 0) middles[twin] = middles[h];
    s.mesh.positions.push_back(0.5 * (s.mesh.positions[s.mesh.triangles[h / 3][h % 3]] +
                                      s.mesh.positions[s.mesh.triangles[h / 3][(h + 1) % 3]]));
  }
  return middles;
}

/// The parts after one round.
RefinedSurface halved(RefinedSurface fine, const std::vector<int>& middles) {
  const Surface& s = fine.surface;
  const int count = s.triangle_count();
  std::vector<std::int64_t> first(std::size_t(count) + 1, 0);
  for (int t = 0; t < count; ++t)
    first[t + 1] = first[t] + 1 + (middles[3 * t] >= 0) + (middles[3 * t + 1] >= 0) +
                   (middles[3 * t + 2] >= 0);
  require(
      first.back() <= most_triangles,
      fmt::format("cutting triangles to the size of texels would give {} of them; at most {} are "
                  "possible",
                  first.back(), most_triangles));
  RefinedSurface next;
  Surface& to = next.surface;
  const auto parts_count = std::size_t(first.back());
  next.source.resize(parts_count);
  next.corners.resize(parts_count);
  to.mesh.triangles.resize(parts_count);
  to.degenerate.resize(parts_count);
  to.twins.assign(3 * parts_count, -1);
  to.area = s.area;
  std::vector<std::array<HalfEdge, 2>> halves(s.twins.size());
  parallel_for(count, [&](std::int64_t t) {
    Corners whole;
    for (int k = 0; k < 3; ++k)
      whole[k] = {s.mesh.triangles[t][k], fine.corners[t][2 * k], fine.corners[t][2 * k + 1]};
    const std::array<int, 3> m = {middles[3 * t], middles[3 * t + 1], middles[3 * t + 2]};
    std::array<Corners, 4> parts;
    const int pieces = cut(whole, m, s.mesh.positions, parts);
    const auto vertex = [&](int h) { return parts[h / 3][h % 3].vertex; };
    const auto end = [&](int h) { return parts[h / 3][(h % 3 + 1) % 3].vertex; };
    const HalfEdge base = 3 * HalfEdge(first[t]);
    for (int p = 0; p < pieces; ++p) {
      const std::int64_t i = first[t] + p;
      next.source[i] = fine.source[t];
      to.degenerate[i] = s.degenerate[t];
      for (int k = 0; k < 3; ++k) {
        to.mesh.triangles[i][k] = parts[p][k].vertex;
        next.corners[i][2 * k] = parts[p][k].u;
        next.corners[i][2 * k + 1] = parts[p][k].v;
      }
    }
    for (int h = 0; h < 3 * pieces; ++h) {
      for (int g = 0; g < h; ++g)
        if (vertex(g) == end(h) && end(g) == vertex(h)) {
          to.twins[base + h] = base + g;
          to.twins[base + g] = base + h;
        }
      for (int k = 0; k < 3; ++k) {
        const int a = whole[k].vertex, b = whole[(k + 1) % 3].vertex;
        if (vertex(h) == a && (end(h) == b || (m[k] >= 0 && end(h) == m[k])))
          halves[3 * t + k][0] = base + h;
        if (end(h) == b && (vertex(h) == a || (m[k] >= 0 && vertex(h) == m[k])))
          halves[3 * t + k][1] = base + h;
      }
    }
  });
  parallel_for(std::ssize(s.twins), [&](std::int64_t h) {
    const HalfEdge twin = s.twins[h];
    if (twin < 0) return;
    to.twins[halves[h][0]] = halves[twin][1];
    to.twins[halves[h][1]] = halves[twin][0];
  });
  to.mesh.positions = std::move(fine.surface.mesh.positions);
  return next;
}

}  // namespace

Vector3 RefinedSurface::in_source(int t, const Vector3& b) const {
  const std::array<float, 6>& c = corners[t];
  const double u = b[0] * c[0] + b[1] * c[2] + b[2] * c[4];
  const double v = b[0] * c[1] + b[1] * c[3] + b[2] * c[5];
  const double w = std::max(0.0, 1 - u - v);
  return {w, u, v};
}

RefinedSurface refine(const Surface& surface, std::span<const char> keep, const LineLength& length,
                      double most, const Progress& progress) {
  require(most > 0, fmt::format("edges cannot be shorter than {}", most));
  require(std::ssize(keep) == surface.triangle_count(), "one mark per triangle is needed");
  RefinedSurface fine = kept(surface, keep);
  for (int round = 0;; ++round) {
    progress.at(1 - std::pow(0.5, round));
    const std::size_t before = fine.surface.mesh.positions.size();
    const std::vector<int> middles = find_middles(fine, length, most);
    if (fine.surface.mesh.positions.size() == before) return fine;
    fine = halved(std::move(fine), middles);
  }
}

RefinedMesh refined(const Mesh& mesh, double most) {
  const Surface surface = make_surface(mesh, {.kind = WeldOptions::Kind::none});
  std::vector<char> keep;
  for (const Triangle& t : mesh.triangles)
    keep.push_back(t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
  const auto length = [&](int t, const Vector2& from, const Vector2& to) {
    const Vector2 d = to - from;
    return (d[0] * (mesh.position(t, 1) - mesh.position(t, 0)) +
            d[1] * (mesh.position(t, 2) - mesh.position(t, 0)))
        .norm();
  };
  RefinedSurface fine = refine(surface, keep, length, most);

  RefinedMesh result{std::move(fine.surface.mesh), std::move(fine.source), {}};
  result.places.resize(std::size_t(result.mesh.vertex_count()));
  result.mesh.uvs = mesh.uvs;
  for (int t = 0; t < result.mesh.triangle_count(); ++t) {
    const int source = result.source[t];
    if (!mesh.textures.empty()) result.mesh.textures.push_back(mesh.textures[source]);
    Triangle corners{-1, -1, -1};
    for (int k = 0; k < 3; ++k) {
      const std::array<float, 6>& c = fine.corners[t];
      const Vector3 b(1 - double(c[2 * k]) - c[2 * k + 1], c[2 * k], c[2 * k + 1]);
      result.places[result.mesh.triangles[t][k]] = {source, b};
      if (!mesh.textured(source)) continue;
      int corner = 0;
      if (b.maxCoeff(&corner) == 1) {
        corners[k] = mesh.corner_uvs[source][corner];
      } else {
        corners[k] = int(result.mesh.uvs.size());
        result.mesh.uvs.push_back(interpolate(b, [&](int at) { return mesh.uv(source, at); }));
      }
    }
    if (mesh.has_uvs()) result.mesh.corner_uvs.push_back(corners);
  }
  return result;
}

}  // namespace mq
