// Schemas: UsdGeomMesh, UsdGeomImageable (visibility), UsdPreviewSurface and its readers, as Pixar's
// documentation of USD has them. A value without time samples holds for all times; tokens are held between
// samples, points are interpolated.
#include "mq/io/detail/animation_usd.h"

#include <Eigen/Geometry>

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "mq/io/detail/animation_floats.h"

namespace mq {
namespace {

/// A file's name as a value; three marks around one that has the mark itself.
std::string asset(const std::string& name) {
  const char* mark = name.find('@') == std::string::npos ? "@" : "@@@";
  return mark + name + mark;
}

class UsdLayer {
 public:
  UsdLayer(const EvolvingReader& reader, const AnimationPart& part, const std::vector<std::string>& pictures)
      : reader_(reader), part_(part), pictures_(pictures) {}

  std::string text(const Progress& progress) {
    const std::vector<FrameRange> segments = ranges_of_segments(reader_, part_);
    add("#usda 1.0\n(\n    defaultPrim = \"evolving\"\n    doc = \"Marquetry\"\n    endTimeCode = {}\n"
        "    framesPerSecond = {}\n    metersPerUnit = {}\n    startTimeCode = {}\n    timeCodesPerSecond = {}\n"
        "    upAxis = \"Y\"\n)\n\ndef Xform \"evolving\" (\n    kind = \"component\"\n)\n{{\n",
        number(part_.last), part_.frames_per_second, reader_.metres_per_unit(), number(part_.first),
        part_.frames_per_second);
    for (std::size_t s = 0; s < segments.size(); ++s) {
      add_segment(segments[s], s, progress);
      if (has_picture(s)) add_material(s);
    }
    add("}}\n");
    return std::move(text_);
  }

 private:
  template <class... Values>
  void add(fmt::format_string<Values...> format, Values&&... values) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Values>(values)...);
  }

  bool has_picture(std::size_t place) const { return place < pictures_.size() && !pictures_[place].empty(); }
  int number(int frame) const { return reader_.frames()[std::size_t(frame)].number; }

  /// "[a, b, c]" of what `one` adds for each of `count`.
  void add_list(std::size_t count, const auto& one) {
    text_ += '[';
    for (std::size_t i = 0; i < count; ++i) {
      if (i > 0) text_ += ", ";
      one(i);
    }
    text_ += ']';
  }

  void add_point(const Vector3& p, int frame) {
    const Eigen::Vector3f x = as_floats(p, reader_, frame, "USD");
    add("({}, {}, {})", x.x(), x.y(), x.z());
  }

  void add_segment(const FrameRange& frames, std::size_t place, const Progress& progress) {
    const EvolvingSegment segment = reader_.segment(reader_.frames()[std::size_t(frames.begin)].segment);
    add("    def Mesh \"segment_{}\"", place);
    if (has_picture(place)) add(" (\n        prepend apiSchemas = [\"MaterialBindingAPI\"]\n    )");
    add("\n    {{\n        uniform bool doubleSided = 1\n");
    repeats_ =
        std::ranges::any_of(segment.uvs, [](const Vector2& uv) { return uv.minCoeff() < 0 || uv.maxCoeff() > 1; });
    add_topology(segment);
    if (!segment.corner_uvs.empty()) add_uvs(segment);
    if (has_picture(place)) add("        rel material:binding = </evolving/material_{}>\n", place);
    add_visibility(frames);
    std::string extents;
    add("        point3f[] points.timeSamples = {{\n");
    for (int f = frames.begin; f < frames.end; ++f) {
      const std::vector<Vector3> points = reader_.positions(f);
      add("            {}: ", number(f));
      add_list(points.size(), [&](std::size_t v) { add_point(points[v], f); });
      add(",\n");
      Eigen::AlignedBox3d box;
      for (const Vector3& p : points) box.extend(p);
      const Eigen::Vector3f least = box.min().cast<float>(), most = box.max().cast<float>();
      extents += fmt::format("            {}: [({}, {}, {}), ({}, {}, {})],\n", number(f), least.x(), least.y(),
                             least.z(), most.x(), most.y(), most.z());
      progress.at(double(f + 1 - part_.first) / (part_.last + 1 - part_.first));
    }
    add("        }}\n        float3[] extent.timeSamples = {{\n{}        }}\n    }}\n\n", extents);
  }

  void add_topology(const EvolvingSegment& segment) {
    add("        int[] faceVertexCounts = ");
    add_list(segment.triangles.size(), [&](std::size_t) { text_ += '3'; });
    add("\n        int[] faceVertexIndices = ");
    add_list(segment.triangles.size(), [&](std::size_t t) {
      const Triangle& corners = segment.triangles[t];
      add("{}, {}, {}", corners[0], corners[1], corners[2]);
    });
    add("\n        uniform token subdivisionScheme = \"none\"\n");
  }

  /// A corner without any has the first.
  void add_uvs(const EvolvingSegment& segment) {
    add("        texCoord2f[] primvars:st = ");
    add_list(segment.uvs.size(), [&](std::size_t i) {
      add("({}, {})", float(segment.uvs[i].x()), float(segment.uvs[i].y()));
    });
    add(" (\n            interpolation = \"faceVarying\"\n        )\n        int[] primvars:st:indices = ");
    add_list(segment.corner_uvs.size(), [&](std::size_t t) {
      const Triangle& corners = segment.corner_uvs[t];
      add("{}, {}, {}", std::max(0, corners[0]), std::max(0, corners[1]), std::max(0, corners[2]));
    });
    add("\n");
  }

  void add_visibility(const FrameRange& frames) {
    const bool begins_later = frames.begin > part_.first, ends_before = frames.end <= part_.last;
    if (!begins_later && !ends_before) return;
    add("        token visibility.timeSamples = {{\n");
    if (begins_later) add("            {}: \"invisible\",\n", number(part_.first));
    add("            {}: \"inherited\",\n", number(frames.begin));
    if (ends_before) add("            {}: \"invisible\",\n", number(frames.end));
    add("        }}\n");
  }

  void add_material(std::size_t place) {
    const std::string self = fmt::format("/evolving/material_{}", place);
    const char* wrap = repeats_ ? "repeat" : "clamp";
    add("    def Material \"material_{}\"\n    {{\n"
        "        token outputs:surface.connect = <{}/surface.outputs:surface>\n\n",
        place, self);
    add("        def Shader \"surface\"\n        {{\n"
        "            uniform token info:id = \"UsdPreviewSurface\"\n"
        "            color3f inputs:diffuseColor.connect = <{}/picture.outputs:rgb>\n"
        "            float inputs:metallic = 0\n            float inputs:roughness = 1\n"
        "            token outputs:surface\n        }}\n\n",
        self);
    add("        def Shader \"picture\"\n        {{\n"
        "            uniform token info:id = \"UsdUVTexture\"\n"
        "            asset inputs:file = {}\n            token inputs:sourceColorSpace = \"sRGB\"\n"
        "            float2 inputs:st.connect = <{}/coordinates.outputs:result>\n"
        "            token inputs:wrapS = \"{}\"\n            token inputs:wrapT = \"{}\"\n"
        "            float3 outputs:rgb\n        }}\n\n",
        asset(pictures_[place]), self, wrap, wrap);
    add("        def Shader \"coordinates\"\n        {{\n"
        "            uniform token info:id = \"UsdPrimvarReader_float2\"\n"
        "            string inputs:varname = \"st\"\n            float2 outputs:result\n        }}\n    }}\n\n");
  }

  const EvolvingReader& reader_;
  const AnimationPart& part_;
  const std::vector<std::string>& pictures_;
  bool repeats_ = false;  ///< the picture of the segment added last, which its texture coordinates go beyond
  std::string text_;
};

}  // namespace

std::string animation_usda(const EvolvingReader& reader, const AnimationPart& part,
                           const std::vector<std::string>& pictures, const Progress& progress) {
  return UsdLayer(reader, part, pictures).text(progress);
}

}  // namespace mq
