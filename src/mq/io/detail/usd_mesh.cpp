// A value before the first time sample is that of the first. Without a subdivisionScheme a mesh is the cage of a
// surface of Catmull and Clark (UsdGeomMesh).
#include "mq/io/detail/usd_mesh.h"

#include <Eigen/LU>

#include <fmt/format.h>

#include <algorithm>

#include "mq/base/words.h"
#include "mq/io/bytes.h"
#include "mq/io/detail/animation_found.h"
#include "mq/io/detail/polygon.h"
#include "mq/io/detail/usd_matrix.h"

namespace mq {
namespace {

/// The sample that holds at a time; there is one.
const UsdSample& held(const std::vector<UsdSample>& samples, double time) {
  const auto next = std::ranges::upper_bound(samples, time, {}, &UsdSample::time);
  return next == samples.begin() ? *next : *std::prev(next);
}

/// Texture coordinates of corners; none: `corners` is empty.
struct UsdUvs {
  std::vector<Vector2> pool;
  std::vector<int> corners;
};

class SurfaceReader {
 public:
  SurfaceReader(const UsdText& text, const UsdMesh& mesh, const std::vector<Vector3>& positions,
                std::string_view uv_set)
      : text_(text), mesh_(mesh), prim_(mesh.prim()), positions_(positions), wanted_set_(uv_set) {}

  UsdSurface read() {
    counts_ = listed("faceVertexCounts");
    corners_ = listed("faceVertexIndices");
    for (const int corner : corners_)
      if (corner < 0 || corner >= std::ssize(positions_))
        fail(fmt::format("it has {}, and faceVertexIndices names {}; wanted 0 to {}",
                         counted(std::ssize(positions_), "point"), corner, std::ssize(positions_) - 1));
    find_uvs();
    find_holes();
    say_scheme();
    const bool mirrored = mesh_.matrix.topLeftCorner<3, 3>().determinant() < 0;
    const UsdProperty* orientation = prim_.property("orientation");
    turned_ = mirrored != (orientation && usd_unquoted(orientation->value) == "leftHanded");
    result_.segment.uvs = uvs_.pool;
    std::size_t begin = 0;
    for (std::size_t face = 0; face < counts_.size(); ++face) {
      const int count = counts_[face];
      if (count < 3 || count > max_polygon || std::size_t(count) > corners_.size() - begin)
        fail(fmt::format("face {} has {} corners, with {} of faceVertexIndices left; wanted 3 to {}", face, count,
                         corners_.size() - begin, max_polygon));
      if (!is_hole_[face]) add_polygon(begin, count);
      begin += std::size_t(count);
    }
    if (begin != corners_.size())
      fail(fmt::format("faceVertexIndices has {} corners, and faceVertexCounts wants {}", corners_.size(), begin));
    EvolvingSegment& segment = result_.segment;
    for (int v = 0; v < int(positions_.size()); ++v) segment.vertex_ids.push_back(v);
    for (int t = 0; t < int(segment.triangles.size()); ++t) segment.triangle_ids.push_back(t);
    return std::move(result_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    text_.fail(prim_.name, fmt::format("{}: {}", mesh_.path, what));
  }

  std::string_view constant(std::string_view name) const {
    return usd_constant(text_, prim_, mesh_.path, name,
                        std::string("wanted is one connectivity for all frames: ") + frames_instead);
  }

  std::vector<int> listed(std::string_view name) const {
    const std::string_view value = constant(name);
    if (value.empty()) fail(fmt::format("it has no {}; wanted a mesh with faces", name));
    return text_.integers(value);
  }

  void find_holes() {
    is_hole_.assign(counts_.size(), 0);
    const std::string_view value = constant("holeIndices");
    if (value.empty()) return;
    for (const int hole : text_.integers(value)) {
      if (hole < 0 || hole >= std::ssize(counts_))
        text_.fail(value, fmt::format("{}: holeIndices names face {}, and it has {}", mesh_.path, hole,
                                      counted(std::ssize(counts_), "face")));
      is_hole_[std::size_t(hole)] = 1;
    }
    if (const auto count = std::ranges::count(is_hole_, 1); count > 0)
      result_.remarks.push_back(fmt::format("{} of {} faces of {} are holes (holeIndices), and are left out", count,
                                            counts_.size(), mesh_.path));
  }

  void say_scheme() {
    const UsdProperty* property = prim_.property("subdivisionScheme");
    const bool is_set = property && !property->value.empty();
    const std::string_view scheme = is_set ? usd_unquoted(property->value) : "catmullClark";
    if (scheme != "none")
      result_.remarks.push_back(fmt::format(
          "{} is to be subdivided (subdivisionScheme {}{}): its cage is taken, as it is; subdivide it where "
          "it was made for more",
          mesh_.path, shown(scheme), is_set ? "" : ", which USD means where none is set"));
  }

  void add_polygon(std::size_t begin, int count) {
    std::vector<Vector3> polygon;
    for (int k = 0; k < count; ++k) polygon.push_back(positions_[std::size_t(corners_[begin + std::size_t(k)])]);
    for (Triangle t : triangulate(polygon)) {
      if (turned_) std::swap(t[1], t[2]);
      Triangle& of_corners = result_.segment.triangles.emplace_back();
      for (std::size_t k = 0; k < 3; ++k) of_corners[k] = corners_[begin + std::size_t(t[k])];
      if (uvs_.corners.empty()) continue;
      Triangle& of_uvs = result_.segment.corner_uvs.emplace_back();
      for (std::size_t k = 0; k < 3; ++k) of_uvs[k] = uvs_.corners[begin + std::size_t(t[k])];
    }
  }

  /// How many numbers each has; 0: they are no texture coordinates.
  static int uv_size(const UsdProperty& property) {
    for (const auto& [begin, size] : {std::pair{"texCoord2", 2}, {"float2", 2}, {"double2", 2}, {"half2", 2},
                                      {"texCoord3", 3}, {"float3", 3}, {"double3", 3}, {"half3", 3}})
      if (property.type.starts_with(begin)) return size;
    return 0;
  }

  const UsdProperty* uv_set() const {
    if (!wanted_set_.empty())
      if (const UsdProperty* wanted = prim_.property(fmt::format("primvars:{}", wanted_set_))) return wanted;
    if (const UsdProperty* st = prim_.property("primvars:st")) return st;
    for (const char* type : {"texCoord2", "texCoord3"})
      for (const UsdProperty& property : prim_.properties)
        if (property.type.starts_with(type) && property.name.starts_with("primvars:")) return &property;
    return nullptr;
  }

  void find_uvs() {
    const UsdProperty* set = uv_set();
    const std::string_view value = set ? constant(set->name) : "";
    if (value.empty()) return;
    if (!wanted_set_.empty() && set->name != fmt::format("primvars:{}", wanted_set_))
      result_.notes.push_back(fmt::format("{} has no texture coordinates {}, by which its material places the picture: "
                                          "{} are taken",
                                          mesh_.path, shown(wanted_set_), shown(set->name)));
    const std::string_view how = usd_unquoted(text_.member(set->metadata, "interpolation"));
    const bool of_vertices = how == "vertex" || how == "varying";
    if (!of_vertices && how != "faceVarying") {
      result_.notes.push_back(
          fmt::format("{} of {} are texture coordinates of neither corners nor vertices "
                      "(interpolation {}), and are left out",
                      set->name, mesh_.path, how.empty() ? "not set" : shown(how)));
      return;
    }
    const std::size_t size = std::size_t(uv_size(*set));
    if (size == 0) {
      result_.notes.push_back(fmt::format("{} of {} is of the type {}, wanted texCoord2f[], and is left out", set->name,
                                          mesh_.path, shown(set->type)));
      return;
    }
    if (size == 3)
      result_.remarks.push_back(fmt::format("{} of {} has three numbers a corner ({}): the first two are taken",
                                            set->name, mesh_.path, set->type));
    const std::vector<double> numbers = text_.tuples(value, int(size));
    for (std::size_t i = 0; i < numbers.size(); i += size) uvs_.pool.emplace_back(numbers[i], numbers[i + 1]);
    const std::string_view indices = constant(std::string(set->name) + ":indices");
    std::vector<int> places;
    if (indices.empty())
      for (std::size_t i = 0; i < uvs_.pool.size(); ++i) places.push_back(int(i));
    else
      places = text_.integers(indices);
    const std::size_t wanted = of_vertices ? positions_.size() : corners_.size();
    if (places.size() != wanted)
      text_.fail(value,
                 fmt::format("{}: found {} texture coordinates in {}, wanted one for each of {} {}", mesh_.path,
                             places.size(), set->name, wanted, of_vertices ? "vertices" : "corners"));
    for (std::size_t c = 0; c < corners_.size(); ++c) {
      const int place = places[of_vertices ? std::size_t(corners_[c]) : c];
      if (place < 0 || place >= std::ssize(uvs_.pool))
        text_.fail(indices, fmt::format("{}: {}:indices names {}, and there are {} texture coordinates", mesh_.path,
                                        set->name, place, uvs_.pool.size()));
      uvs_.corners.push_back(place);
    }
  }

  const UsdText& text_;
  const UsdMesh& mesh_;
  const UsdPrim& prim_;
  const std::vector<Vector3>& positions_;
  std::string_view wanted_set_;
  std::vector<int> counts_, corners_;
  std::vector<char> is_hole_;
  UsdUvs uvs_;
  bool turned_ = false;
  UsdSurface result_;
};

}  // namespace

bool UsdMesh::shown(double time) const {
  for (const UsdPrim* prim : line) {
    const UsdProperty* property = prim->property("visibility");
    if (!property) continue;
    const auto& samples = property->samples;
    if (usd_unquoted(samples.empty() ? property->value : held(samples, time).value) == "invisible") return false;
  }
  return !moves() || !held(points->samples, time).value.empty();
}

void UsdMesh::place(const UsdText& text, const Eigen::Matrix4d& world) {
  matrix = world;
  std::string so_far;
  for (const UsdPrim* prim : line) {
    so_far += fmt::format("/{}", prim->name);
    if (!prim->property("xformOpOrder")) continue;
    const UsdTransform own = usd_transform(text, *prim, so_far);
    matrix = (own.resets ? world : matrix) * own.matrix;
  }
}

const UsdProperty* UsdMesh::inherited(std::string_view name) const {
  for (std::size_t i = line.size(); i-- > 0;)
    if (const UsdProperty* property = line[i]->property(name); property && !property->value.empty()) return property;
  return nullptr;
}

std::vector<Vector3> UsdMesh::positions(const UsdText& text, std::string_view value) const {
  const std::vector<double> numbers = text.tuples(value, 3);
  std::vector<Vector3> result(numbers.size() / 3);
  const bool stands = matrix == Eigen::Matrix4d::Identity();
  for (std::size_t i = 0; i < result.size(); ++i) {
    result[i] = Vector3::Map(&numbers[3 * i]);
    if (!stands) result[i] = matrix.topLeftCorner<3, 3>() * result[i] + matrix.topRightCorner<3, 1>();
  }
  return result;
}

UsdSurface usd_surface(const UsdText& text, const UsdMesh& mesh, const std::vector<Vector3>& positions,
                       std::string_view uv_set) {
  return SurfaceReader(text, mesh, positions, uv_set).read();
}

}  // namespace mq
