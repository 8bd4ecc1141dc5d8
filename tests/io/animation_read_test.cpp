// Files that move, read as evolving meshes: those that were written here, and those of other programs.
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <random>

#include "io/animations.h"
#include "mq/io/animation.h"
#include "mq/io/bytes.h"
#include "mq/io/film.h"

namespace mq {
namespace {

/// A strip of six quads in two charts that waves over six frames, 10, 12, ..., 20; from the fourth on its last quad
/// is gone.
EvolvingMesh two_chart_strip() {
  constexpr int quads = 6;
  Mesh mesh;
  for (int i = 0; i <= quads; ++i)
    for (int j = 0; j < 2; ++j) mesh.positions.emplace_back(i, j, 0);
  for (int chart = 0; chart < 2; ++chart)
    for (int i = 0; i <= quads / 2; ++i)
      for (int j = 0; j < 2; ++j) mesh.uvs.emplace_back(0.5 * chart + 0.15 * i, 0.9 * j);
  for (int i = 0; i < quads; ++i)
    for (const Triangle& t : {Triangle{0, 2, 3}, Triangle{0, 3, 1}}) {
      const int uv = 2 * i + (i < quads / 2 ? 0 : 2);
      mesh.triangles.push_back({2 * i + t[0], 2 * i + t[1], 2 * i + t[2]});
      mesh.corner_uvs.push_back({uv + t[0], uv + t[1], uv + t[2]});
    }
  Mesh shorter = mesh;
  for (int i = 0; i < 2; ++i) shorter.triangles.pop_back(), shorter.corner_uvs.pop_back();
  for (int i = 0; i < 2; ++i) shorter.positions.pop_back();
  EvolvingMesh evolving;
  evolving.segments = {segment_of(mesh), segment_of(shorter)};
  for (int f = 0; f < 6; ++f) {
    EvolvingFrame frame{10 + 2 * f, f < 3 ? 0 : 1, f < 3 ? mesh.positions : shorter.positions};
    for (Vector3& p : frame.positions) p.z() = std::sin(p.x() + 0.3 * f);
    evolving.frames.push_back(std::move(frame));
  }
  return evolving;
}

class AnimationRead : public AnimationTest {
 protected:
  AnimationRead() { write_evolving(folder / "strip.evolving", two_chart_strip(), step); }

  EvolvingReader store() const { return EvolvingReader(folder / "strip.evolving"); }
  static Image<float> picture(int frame) { return Image<float>(4, 4, 3, float(frame) / 10); }

  static constexpr double step = 0x1p-20;
};

/// Every corner of every frame is where the other has it, on the surface and in the texture.
void expect_same(const EvolvingReader& found, const EvolvingReader& wanted, int first, double tolerance) {
  ASSERT_EQ(found.segments().size(), wanted.segments().size());
  for (int f = 0; f < int(found.frames().size()); ++f) {
    const StoredFrame& frame = found.frames()[std::size_t(f)];
    EXPECT_EQ(frame.number, wanted.frames()[std::size_t(first + f)].number);
    const EvolvingSegment a = found.segment(frame.segment),
                          b = wanted.segment(wanted.frames()[std::size_t(first + f)].segment);
    const auto p = found.positions(f), q = wanted.positions(first + f);
    ASSERT_EQ(a.triangles.size(), b.triangles.size());
    for (std::size_t t = 0; t < a.triangles.size(); ++t) {
      // The first corner may be another, which meshopt does not keep.
      double nearest = 1e9;
      for (std::size_t turn = 0; turn < 3; ++turn) {
        double farthest = 0;
        for (std::size_t k = 0; k < 3; ++k) {
          const std::size_t l = (k + turn) % 3;
          farthest =
              std::max(farthest, (p[std::size_t(a.triangles[t][l])] - q[std::size_t(b.triangles[t][k])]).norm());
          farthest = std::max(
              farthest, (a.uvs[std::size_t(a.corner_uvs[t][l])] - b.uvs[std::size_t(b.corner_uvs[t][k])]).norm());
        }
        nearest = std::min(nearest, farthest);
      }
      EXPECT_LE(nearest, tolerance) << "frame " << f << ", triangle " << t;
    }
  }
}

TEST_F(AnimationRead, GivesBackWhatWasWritten) {
  for (const char* name : {"strip.usda", "strip.usdz", "strip.glb", "packed.glb"}) {
    SCOPED_TRACE(name);
    const bool packed = name == std::string("packed.glb");
    write_animation(folder / name, store(), {0, 5, 24, packed ? Compression::meshopt : Compression::none}, picture);
    const OpenAnimation found = open_animation(folder / name);
    ASSERT_EQ(found.reader.frames().size(), 6U);
    expect_same(found.reader, store(), 0, step);
    EXPECT_NEAR(found.frames_per_second, 12, 1e-5);  // numbers go up by two
    EXPECT_THAT(found.notes, IsEmpty());
    ASSERT_EQ(found.pictures.size(), 2U);
    for (const int s : {0, 1}) EXPECT_NEAR(found.pictures[std::size_t(s)](1, 1, 0), 0.3 * s, 0.51 / 255);
    EXPECT_FALSE(found.reader.is_store());
    EXPECT_THAT(found.reader.damaged(), IsEmpty());
  }
}

TEST_F(AnimationRead, GivesBackAPart) {
  for (const char* name : {"part.usda", "part.glb", "one.usda", "one.glb"}) {
    SCOPED_TRACE(name);
    const bool one = std::string(name).starts_with("one");
    write_animation(folder / name, store(), {2, one ? 2 : 4, 30});
    const OpenAnimation found = open_animation(folder / name);
    ASSERT_EQ(found.reader.frames().size(), one ? 1U : 3U);
    EXPECT_EQ(found.reader.frames()[0].number, 14);
    EXPECT_TRUE(found.pictures[0].values().empty());
    const auto p = found.reader.positions(0);
    const auto segment = found.reader.segment(0), wanted = store().segment(0);
    for (std::size_t t = 0; t < wanted.triangles.size(); ++t)
      EXPECT_LE(
          (p[std::size_t(segment.triangles[t][0])] - store().positions(2)[std::size_t(wanted.triangles[t][0])])
              .norm(),
          step);
  }
}

TEST_F(AnimationRead, PlaysAsTheStoreDoes) {
  const LifeColour colour = [](int first, int last, int) {
    return std::array{float(first) / 9, float(last) / 9, 0.F};
  };
  const std::vector<int> frames{0, 1, 2, 3, 4, 5};
  const Film wanted = make_film(store(), frames, colour);
  write_animation(folder / "strip.usda", store(), {0, 5, 24});
  const Film found = make_film(open_animation(folder / "strip.usda").reader, frames, colour);
  const auto says = [](const Film& film) { return nlohmann::json::parse(film.description); };
  EXPECT_EQ(says(found)["frames"], says(wanted)["frames"]);
  EXPECT_EQ(says(found)["segments"], says(wanted)["segments"]);
}

TEST_F(AnimationRead, KnowsTrianglesByTheirTextureCoordinates) {
  for (const char* name : {"strip.usda", "packed.glb"}) {
    SCOPED_TRACE(name);
    const bool packed = name == std::string("packed.glb");
    write_animation(folder / name, store(), {0, 5, 24, packed ? Compression::meshopt : Compression::none});
    const EvolvingMesh found = open_animation(folder / name).reader.read();
    const EvolvingMesh wanted = store().read();
    EXPECT_EQ(change(found.segments[0], found.segments[1]).kept,
              change(wanted.segments[0], wanted.segments[1]).kept);
    EXPECT_NO_THROW(triangle_lifespans(found));
  }
}

// ---- Files of other programs ----

/// A square of two frames, as USD of some other program has it: polygons, Z up, transforms, defaults beside
/// samples.
std::string foreign_usda(const std::string& inside = "", const std::string& outside = "") {
  return R"(#usda 1.0
(
    "A comment, with (brackets"
    defaultPrim = "root"
    endTimeCode = 2
    metersPerUnit = 0.01
    timeCodesPerSecond = 25
    upAxis = "Z"
    customLayerData = { string note = "a } and a \" in it" }
)

def Xform "root" (
    prepend references = []
    customData = { dictionary Blender = { bool generated = 1 } }
)
{
    double3 xformOp:translate = (0, 0, 10)  # up
    float3 xformOp:rotateXYZ:turn = (0, 0, 90)
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateXYZ:turn"]

    def Mesh "square" ( prepend apiSchemas = ["MaterialBindingAPI"] )
    {
        int[] faceVertexCounts = [4]
        int[] faceVertexIndices = [0, 1, 2, 3,]
        normal3f[] normals = [(0, 0, 1), (0, 0, 1), (0, 0, 1), (0, 0, 1)] ( interpolation = "vertex" )
        point3f[] points = [(9, 9, 9), (9, 9, 9), (9, 9, 9), (9, 9, 9)]
        point3f[] points.timeSamples = {
            2: [(0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)],
            1: [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)],
        }
        texCoord2f[] primvars:UVMap.timeSamples = { 1: [(0, 0), (1, 0), (1, 1), (0, 1)] } ( interpolation = "vertex" )
)" + inside +
         "    }\n" + outside + "}\n";
}

TEST_F(AnimationRead, TakesUsdOfOtherPrograms) {
  const OpenAnimation found = open_animation(put("square.usda", foreign_usda()));
  ASSERT_EQ(found.reader.frames().size(), 2U);
  EXPECT_EQ(found.frames_per_second, 25);
  EXPECT_EQ(found.reader.frames()[1].number, 2);
  const EvolvingSegment segment = found.reader.segment(0);
  ASSERT_EQ(segment.triangle_count(), 2);
  // (1, 0, 1) is turned to (0, 1, 1), moved to (0, 1, 11), and Z becomes Y.
  const auto p = found.reader.positions(1);
  ASSERT_EQ(p.size(), 4U);
  EXPECT_NEAR((p[1] - Vector3(0, 11, -1)).norm(), 0, 1e-12);
  const int corner = segment.triangles[0][1];
  EXPECT_EQ(segment.uvs[std::size_t(segment.corner_uvs[0][1])], (corner == 1 ? Vector2(1, 0) : Vector2(1, 1)));
}

TEST_F(AnimationRead, TurnsWhatIsMirroredOrLeftHanded) {
  const auto first = [&](const std::string& inside) {
    const auto found = open_animation(put("square.usda", foreign_usda(inside)));
    return std::pair(found.reader.segment(0).triangles[0], found.reader.positions(0)[2].x());
  };
  const auto plain = first("");
  const Triangle turned{plain.first[0], plain.first[2], plain.first[1]};
  EXPECT_EQ(first("uniform token orientation = \"leftHanded\"\n").first, turned);
  const auto mirrored =
      first("float3 xformOp:scale = (1, -1, 1)\nuniform token[] xformOpOrder = [\"xformOp:scale\"]\n");
  EXPECT_EQ(mirrored.first, turned);
  EXPECT_NEAR(mirrored.second, -plain.second, 1e-12);
  EXPECT_NEAR(first("matrix4d xformOp:transform = ( (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (7, 5, 3, 1) )\n"
                    "uniform token[] xformOpOrder = [\"!resetXformStack!\", \"xformOp:transform\"]\n")
                  .second,
              8, 1e-12);
  EXPECT_NEAR(first("quatf xformOp:orient = (0, 0, 0, 1)\nfloat3 xformOp:translate = (1, 0, 0)\n"
                    "uniform token[] xformOpOrder = [\"!invert!xformOp:translate\", \"xformOp:orient\"]\n")
                  .second,
              1, 1e-12);
}

TEST_F(AnimationRead, SaysWhatOfUsdItDoesNotTake) {
  const std::string other =
      "def Mesh \"other\" { int[] faceVertexCounts = [3]\nint[] faceVertexIndices = [0, 1, 2]\n"
      "point3f[] points.timeSamples = { 1: [(0, 0, 0), (1, 0, 0), (0, 1, 0)] } }\n";
  EXPECT_THAT(refusal("a.usda", foreign_usda("", other)),
              AllOf(HasSubstr("/root/square"), HasSubstr("/root/other"), HasSubstr("join them")));
  EXPECT_THAT(refusal("a.usda",
                      foreign_usda("int[] faceVertexIndices.timeSamples = { 1: [0, 1, 2, 3], 2: [1, 2, 3, 0] }\n")),
              AllOf(HasSubstr("changes over time"), HasSubstr("frame_%04d.ply")));
  EXPECT_THAT(
      refusal("a.usda", foreign_usda("double3 xformOp:translate.timeSamples = { 1: (0, 0, 0), 2: (1, 0, 0) }\n"
                                     "token[] xformOpOrder = [\"xformOp:translate\"]\n")),
      AllOf(HasSubstr("xformOp:translate"), HasSubstr("bake")));
  EXPECT_THAT(refusal("a.usda", "#usda 1.0\ndef \"model\" ( prepend payload = @body.usd@ ) {}\n"),
              AllOf(HasSubstr("no mesh"), HasSubstr("usdcat")));
  EXPECT_THAT(refusal("a.usdc", "PXR-USDC and more"), AllOf(HasSubstr("binary USD"), HasSubstr("usdcat -o")));
  EXPECT_THAT(refusal("a.usda", foreign_usda("token visibility = \"invisible\"\n")), HasSubstr("is invisible"));
  EXPECT_THAT(refusal("a.usda", ""), HasSubstr("is empty"));
  EXPECT_THAT(refusal("a.usda", "hello"), HasSubstr("#usda 1.0"));
}

TEST_F(AnimationRead, NamesTheLineOfWhatIsWrong) {
  const auto with = [](std::string from, const std::string& to) {
    std::string text = foreign_usda();
    return text.replace(text.find(from), from.size(), to);
  };
  EXPECT_THAT(refusal("a.usda", with("[0, 1, 2, 3,]", "[0, 1, 2, 4]")),
              AllOf(HasSubstr("4 points"), HasSubstr("names 4")));
  EXPECT_THAT(refusal("a.usda", with("[4]", "[5]")), AllOf(HasSubstr("face 0 has 5 corners"), HasSubstr("line 21")));
  EXPECT_THAT(refusal("a.usda", with("[4]", "[3]")), HasSubstr("faceVertexCounts wants 3"));
  EXPECT_THAT(refusal("a.usda", with("(1, 1, 1)", "(1, 1, what)")),
              AllOf(HasSubstr("line 28"), HasSubstr("\"what\""), HasSubstr("a finite number")));
  EXPECT_THAT(refusal("a.usda", with("(1, 1, 1)", "(1, 1, inf)")),
              AllOf(HasSubstr("inf"), HasSubstr("wanted a finite number")));
  EXPECT_THAT(refusal("a.usda", with("(1, 1, 1), (0, 1, 1)", "(1, 1, 1)")),
              AllOf(HasSubstr("frame 2"), HasSubstr("3 vertices")));
  EXPECT_THAT(refusal("a.usda", with("2: [(0", "1: [(0")), HasSubstr("time code 1"));
  EXPECT_THAT(refusal("a.usda", with("[(0, 0), (1, 0), (1, 1), (0, 1)]", "[(0, 0), (1, 0), (1, 1)]")),
              HasSubstr("3 texture coordinates"));
  std::string deep = "#usda 1.0\n";
  for (int i = 0; i < 100000; ++i) deep += "def \"x\" {";
  EXPECT_THAT(refusal("a.usda", deep), HasSubstr("256 deep"));
  EXPECT_THAT(refusal("a.usda", "#usda 1.0\ndef Mesh \"m\" { int[] x = " + std::string(1000000, '[')),
              HasSubstr("no end"));
}

// ---- What is damaged ----

/// Opens what a change made of a file, and counts what is taken and what is refused; anything else ends the test.
void survive(const std::filesystem::path& path, const std::string& text, int count,
             const std::function<std::string(std::string, std::mt19937&)>& change) {
  std::mt19937 random(7);
  int refused = 0;
  for (int i = 0; i < count; ++i) {
    std::ofstream(path, std::ios::binary) << change(text, random);
    try {
      const OpenAnimation found = open_animation(path);
      for (int f = 0; f < int(found.reader.frames().size()); ++f)
        EXPECT_EQ(
            found.reader.positions(f).size(),
            std::size_t(
                found.reader.segments()[std::size_t(found.reader.frames()[std::size_t(f)].segment)].vertices));
      EXPECT_NO_THROW(check(found.reader.read()));
    } catch (const Error& error) {
      ++refused;
      EXPECT_STRNE(error.what(), "");
    }
  }
  EXPECT_GT(refused, count / 8);
}

TEST_F(AnimationRead, SurvivesWhatIsDamaged) {
  const auto cut = [](std::string text, std::mt19937& random) { return text.substr(0, random() % text.size()); };
  const auto changed = [](std::string text, std::mt19937& random) {
    for (int n = 1 + int(random() % 4); n > 0; --n) text[random() % text.size()] = char(random());
    return text;
  };
  // A mark of the language in place of another, a piece twice, a piece gone.
  const auto edited_text = [](std::string text, std::mt19937& random) {
    constexpr std::string_view marks = "[](){}\"'@<>#=,:;.0-\n";
    const std::size_t at = random() % text.size(), size = random() % 40;
    switch (random() % 3) {
      case 0:
        text[at] = marks[random() % marks.size()];
        break;
      case 1:
        text.insert(random() % text.size(), text.substr(at, size));
        break;
      default:
        text.erase(at, size);
    }
    return text;
  };
  for (const char* name : {"strip.usda", "strip.usdz", "strip.glb", "packed.glb"}) {
    SCOPED_TRACE(name);
    const bool packed = name == std::string("packed.glb");
    write_animation(folder / name, store(), {0, 5, 24, packed ? Compression::meshopt : Compression::none});
    for (const auto& change :
         {std::function<std::string(std::string, std::mt19937&)>(cut), {changed}, {edited_text}})
      survive(folder / ("bad" + std::filesystem::path(name).extension().string()), get(name), 100, change);
  }
  survive(folder / "foreign.usda", foreign_usda(), 200, edited_text);
}

}  // namespace
}  // namespace mq
