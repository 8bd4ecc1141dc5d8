// What files that move say beside their meshes: units, time, what is hidden, and what is not read.
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "io/animations.h"
#include "mq/base/error.h"
#include "mq/image/image.h"
#include "mq/io/animation.h"
#include "mq/io/bytes.h"
#include "mq/io/detail/stored_zip.h"
#include "mq/io/film.h"
#include "mq/io/image_file.h"

namespace mq {
namespace {

/// The square at these time codes.
std::string square_at(const std::vector<std::string>& codes) {
  std::string samples;
  for (std::size_t i = 0; i < codes.size(); ++i)
    samples += codes[i] + ": [(0, 0, 0), (1, 0, 0), (1, 1, " + std::to_string(i) + "), (0, 1, 0)],\n";
  return samples;
}

class AnimationDetails : public AnimationTest {
 protected:
  static std::vector<int> numbers(const OpenAnimation& opened) {
    std::vector<int> found;
    for (const StoredFrame& frame : opened.reader.frames()) found.push_back(frame.number);
    return found;
  }

  /// Seconds from the first frame to each.
  static std::vector<double> seconds(const OpenAnimation& opened) {
    std::vector<double> found;
    for (const int number : numbers(opened))
      found.push_back((number - numbers(opened).front()) / opened.numbers_per_second);
    return found;
  }
};

MATCHER_P(IsNear, wanted, "") { return std::abs(arg - wanted) < 1e-9; }

TEST_F(AnimationDetails, SaysNothingOfWhatIsOrdinary) {
  const OpenAnimation found = open({});
  EXPECT_THAT(found.notes, IsEmpty());
  EXPECT_THAT(found.remarks, IsEmpty());
}

TEST_F(AnimationDetails, KeepsTheUnitInUsdAndWritesMetresInGltf) {
  const OpenAnimation found = open({.head = "metersPerUnit = 0.25\n"});
  EXPECT_EQ(found.reader.metres_per_unit(), 0.25);
  EXPECT_EQ(found.reader.positions(1)[2], Vector3(1, 1, 1));
  write_animation(folder / "again.usda", found.reader, {0, 1, 24});
  const OpenAnimation again = open_animation(folder / "again.usda");
  EXPECT_EQ(again.reader.metres_per_unit(), 0.25);
  EXPECT_EQ(again.reader.positions(1)[2], Vector3(1, 1, 1));
  write_animation(folder / "metres.glb", found.reader, {0, 1, 24});
  const OpenAnimation metres = open_animation(folder / "metres.glb");
  EXPECT_EQ(metres.reader.metres_per_unit(), 1);
  EXPECT_THAT(metres.reader.positions(1), Contains(Vector3(0.25, 0.25, 0.25)));
  EXPECT_EQ(open({.head = ""}).reader.metres_per_unit(), 0.01);  // what USD means by nothing
  EXPECT_THAT(refusal({.head = "metersPerUnit = 0\n"}),
              AllOf(HasSubstr("square.usda, line 3"), HasSubstr("metersPerUnit is \"0\", wanted a number above 0")));
}

TEST_F(AnimationDetails, SaysThatACageIsShown) {
  const std::string said = "subdivisionScheme \"catmullClark\"";
  const auto of = [&](const std::string& inside) { return open({.inside = inside}).remarks; };
  EXPECT_THAT(of(""), ElementsAre(AllOf(HasSubstr("/root/square"), HasSubstr(said), HasSubstr("where none is set"))));
  EXPECT_THAT(of("uniform token subdivisionScheme = \"loop\"\n"), ElementsAre(HasSubstr("\"loop\"")));
}

TEST_F(AnimationDetails, LeavesHolesOut) {
  const std::string none = "uniform token subdivisionScheme = \"none\"\n";
  const OpenAnimation found = open({.inside = none + "int[] holeIndices = [0]\n"});
  EXPECT_THAT(found.reader.segment(0).triangles, ElementsAre(Triangle{0, 2, 3}));
  EXPECT_THAT(found.remarks, ElementsAre(HasSubstr("1 of 2 faces of /root/square are holes")));
  EXPECT_THAT(refusal({.inside = none + "int[] holeIndices = [2]\n"}),
              AllOf(HasSubstr("line 11"), HasSubstr("names face 2, and it has 2 faces")));
}

TEST_F(AnimationDetails, LeavesOutWhatHasNoSurface) {
  const std::string moves =
      "double3 xformOp:translate.timeSamples = { 1: (0, 0, 0), 2: (1, 0, 0) }\n"
      "uniform token[] xformOpOrder = [\"xformOp:translate\"]\n";
  const OpenAnimation found = open({.beside = "def Camera \"eye\" {\n" + moves + "}\ndef DistantLight \"sun\" {\n" +
                                              moves + "}\ndef Xform \"empty\" {\n" + moves + "}\n"});
  EXPECT_EQ(found.reader.frames().size(), 2U);
  EXPECT_THAT(found.notes, IsEmpty());
  EXPECT_THAT(found.remarks, ElementsAre(HasSubstr("1 camera"), HasSubstr("1 light")));
  EXPECT_THAT(open({.beside = "def Sphere \"ball\" {\n" + moves + "}\n"}).notes, ElementsAre(HasSubstr("Sphere")));
  EXPECT_THAT(
      open({.beside = "def Mesh \"other\" {\nint[] faceVertexCounts = [3]\nint[] faceVertexIndices = [0, 1, 2]\n"
                      "point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]\n" +
                      moves + "}\n"})
          .notes,
      ElementsAre(HasSubstr("1 mesh whose points do not move")));
  EXPECT_THAT(open({.beside = "variantSet \"look\" = {\n\"red\" { }\n}\n"}).notes,
              ElementsAre(HasSubstr("variants")));
  EXPECT_THAT(open({.beside = "def Mesh \"hull\" {\nuniform token purpose = \"proxy\"\n"
                              "point3f[] points.timeSamples = { 1: [(0, 0, 0)] }\n}\n"})
                  .remarks,
              ElementsAre(AllOf(HasSubstr("/root/hull"), HasSubstr("proxy"))));
  // What moves the surface itself is refused still, a spline too.
  EXPECT_THAT(refusal({.inside = moves}), AllOf(HasSubstr("square.usda, /root/square"),
                                                HasSubstr("xformOp:translate"), HasSubstr("bake what moves it")));
  EXPECT_THAT(
      refusal({.inside = "double xformOp:rotateZ = 0\ndouble xformOp:rotateZ.spline = { bezier, 1: 0, 2: 9 }\n"
                         "uniform token[] xformOpOrder = [\"xformOp:rotateZ\"]\n"}),
      HasSubstr("xformOp:rotateZ changes over time"));
}

TEST_F(AnimationDetails, SkipsCommentsOfAllKindsAndAByteOrderMark) {
  const UsdSquare odd{.head = "timeCodesPerSecond = /* frames */ 24 // a second }\nmetersPerUnit = 1 /* metre\n*/\n",
                      .samples =
                          "1: [(0, 0, 0), /* ( */ (1, 0, 0), (1, 1, 0), # (\n (0, 1, 0)], // [\n"
                          "2: [(0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)] /* , 3: */",
                      .beside = "/* def Mesh \"other\" { */\n",
                      .first = "\xef\xbb\xbf#usda 1.0\n"};
  EXPECT_EQ(open(odd).reader.read().frames[1].positions, open({}).reader.read().frames[1].positions);
  EXPECT_EQ(open(odd).frames_per_second, 24);
  UsdSquare endless;
  endless.beside = "/* def\n";
  EXPECT_THAT(refusal(endless), AllOf(HasSubstr("line 7"), HasSubstr("wanted '*/'")));
}

TEST_F(AnimationDetails, TakesBlockedValuesForNone) {
  const UsdSquare blocked{
      .samples = square_at({"1", "2"}) + "3: None,\n" + "4: [(0, 0, 0), (1, 0, 0), (1, 1, 9), (0, 1, 0)]",
      .inside =
          "uniform token subdivisionScheme = \"none\"\ntoken visibility = None\n"
          "point3f[] points = None\nint[] holeIndices.timeSamples = { 1: None }\n"};
  const OpenAnimation found = open(blocked);
  EXPECT_THAT(numbers(found), ElementsAre(1, 2, 4));
  EXPECT_THAT(found.notes, ElementsAre(HasSubstr("1 of 4 frames show nothing"), HasSubstr("not equally far apart")));
  EXPECT_THAT(refusal({.samples = "1: None"}), AllOf(HasSubstr("no mesh"), HasSubstr("time samples")));
}

TEST_F(AnimationDetails, SaysWhichFramesAreInvisible) {
  const UsdSquare square{.samples = square_at({"1", "2", "3", "4", "5"}),
                         .inside =
                             "uniform token subdivisionScheme = \"none\"\ntoken visibility.timeSamples = { 1: "
                             "\"inherited\", 4: \"invisible\" }\n"};
  const OpenAnimation found = open(square);
  EXPECT_THAT(numbers(found), ElementsAre(1, 2, 3));
  EXPECT_THAT(found.notes,
              ElementsAre(AllOf(HasSubstr("2 of 5 frames"), HasSubstr("the first at time code 4, the last at 5"))));
}

TEST_F(AnimationDetails, KeepsSecondsWhateverTimeCodesAre) {
  const auto at = [&](const std::vector<std::string>& codes) { return open({.samples = square_at(codes)}); };
  // Every second code: frames come 12 a second, and numbers stay.
  OpenAnimation found = at({"10", "12", "14"});
  EXPECT_THAT(numbers(found), ElementsAre(10, 12, 14));
  EXPECT_THAT(seconds(found), ElementsAre(IsNear(0), IsNear(2 / 24.0), IsNear(4 / 24.0)));
  EXPECT_EQ(found.frames_per_second, 12);
  EXPECT_THAT(found.remarks, IsEmpty());
  found = at({"-5", "-4", "-2"});
  EXPECT_THAT(numbers(found), ElementsAre(0, 1, 3));
  EXPECT_THAT(seconds(found), ElementsAre(IsNear(0), IsNear(1 / 24.0), IsNear(3 / 24.0)));
  EXPECT_THAT(found.remarks, ElementsAre(AllOf(HasSubstr("begin at -5"), HasSubstr("numbered from 0"))));
  found = at({"0.5", "0.9", "1.3"});  // even, and not whole
  EXPECT_THAT(numbers(found), ElementsAre(0, 1, 2));
  EXPECT_THAT(seconds(found), ElementsAre(IsNear(0), IsNear(0.4 / 24), IsNear(0.8 / 24)));
  EXPECT_THAT(found.remarks, ElementsAre(AllOf(HasSubstr("numbered 0, 1, 2"), HasSubstr("60 a second"))));
  found = at({"0.5", "1", "2"});
  EXPECT_THAT(numbers(found), ElementsAre(1, 2, 4));
  EXPECT_THAT(seconds(found), ElementsAre(IsNear(0), IsNear(0.5 / 24), IsNear(1.5 / 24)));
  EXPECT_THAT(found.remarks, ElementsAre(HasSubstr("1/2")));
  found = at({"0", "1.4142135", "2.7182818", "3.1415927"});
  const std::vector<double> codes{0, 1.4142135, 2.7182818, 3.1415927};
  for (std::size_t f = 0; f < codes.size(); ++f) EXPECT_NEAR(seconds(found)[f], codes[f] / 24, 0.0005 / 24);
  EXPECT_THAT(found.remarks, ElementsAre(HasSubstr("1/1000 of one, rounded")));
  found = at({"0", "1", "1.00001"});
  EXPECT_THAT(found.notes, Contains(HasSubstr("too close to each other")));
}

TEST_F(AnimationDetails, NamesWhatFloatsDoNotHold) {
  UsdSquare far;
  far.samples =
      "1: [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], 7: [(0, 0, 1), (2.5e39, 0, 1), (1, 1, 1), (0, 1, 1)]";
  const OpenAnimation found = open(far);
  const auto said = [&](const auto& action) -> std::string {
    try {
      action();
    } catch (const Unsupported& error) {
      return error.what();
    }
    return "";
  };
  const auto names_it = AllOf(HasSubstr("square.usda, frame 7"), HasSubstr("2.5e+39"), HasSubstr("scale it down"));
  for (const char* name : {"far.usda", "far.glb"}) {
    EXPECT_THAT(said([&] { write_animation(folder / name, found.reader, {0, 1, 24}); }), names_it) << name;
    EXPECT_FALSE(there(name));
  }
  const LifeColour grey = [](int, int, int) { return std::array{0.5F, 0.5F, 0.5F}; };
  EXPECT_THAT(said([&] { make_film(found.reader, {0, 1}, grey); }), names_it);
  far.samples = "1: [(0, 0, 0), (1e61, 0, 0), (1, 1, 0), (0, 1, 0)]";
  EXPECT_THAT(refusal(far), AllOf(HasSubstr("square.usda, frame 1"), HasSubstr("1e+61"), HasSubstr("scale it down")));
}

TEST_F(AnimationDetails, WritesPicturesOfSomeSegmentsAlone) {
  const OpenAnimation found = open({});
  const auto none = [](int) { return Image<float>(); };
  write_animation(folder / "bare.usda", found.reader, {0, 1, 24}, none);
  EXPECT_THAT(get("bare.usda"), Not(HasSubstr("Material")));
  EXPECT_FALSE(there("bare_0.png"));
  EXPECT_THAT(animation_files(folder / "bare.usda", found.reader, {0, 1, 24}, [](int) { return false; }),
              ElementsAre(folder / "bare.usda"));
  write_animation(folder / "bare.glb", found.reader, {0, 1, 24}, none);
  EXPECT_TRUE(open_animation(folder / "bare.glb").pictures[0].values().empty());
}

TEST_F(AnimationDetails, RepeatsPicturesThatTextureCoordinatesGoBeyond) {
  std::string text = UsdSquare().text();
  const auto grey = [](int) { return Image<float>(4, 4, 3, 0.5F); };
  write_animation(folder / "once.usda", open({}).reader, {0, 1, 24}, grey);
  EXPECT_THAT(get("once.usda"), HasSubstr("inputs:wrapS = \"clamp\""));
  const std::string corner = "(1, 1), (0, 1)] (";
  text.replace(text.find(corner), corner.size(), "(3, 1), (0, 1)] (");
  write_animation(folder / "often.usda", open_animation(put("wide.usda", text)).reader, {0, 1, 24}, grey);
  EXPECT_THAT(get("often.usda"), HasSubstr("inputs:wrapS = \"repeat\""));
}

TEST_F(AnimationDetails, ShowsLightAsADisplayDoes) {
  Texture light;
  light.pixels = Image<float>(4, 4, 3, 0.5F);
  light.format.depth = Depth::half;
  write_texture(folder / "light.exr", light);
  const UsdSquare lit{.inside = "rel material:binding = </root/look>\n",
                      .beside =
                          "def Material \"look\" {\ndef Shader \"s\" {\nuniform token info:id = "
                          "\"UsdPreviewSurface\"\ncolor3f inputs:diffuseColor.connect = </root/look/p.rgb>\n}\n"
                          "def Shader \"p\" { asset inputs:file = @./light.exr@ }\n}\n"};
  EXPECT_NEAR(open(lit).pictures[0](1, 1, 0), 0.7354, 1e-3);  // sRGB's curve at 0.5
}

TEST_F(AnimationDetails, NamesTheFirstFileOfAPackageThatIsNoLayer) {
  const auto said = [&](const std::vector<OutputFile>& files) -> std::string {
    const Bytes zip = stored_zip(files);
    try {
      open_animation(put("odd.usdz", std::string(text_of(zip))));
    } catch (const IoError& error) {
      return error.what();
    }
    return "";
  };
  const std::string png = "\x89PNG\r\n\x1a\n", layer = UsdSquare().text();
  EXPECT_THAT(said({{"skin.png", to_bytes(png)}, {"square.usda", to_bytes(layer)}}),
              AllOf(HasSubstr("odd.usdz: its first file, \"skin.png\", is no layer"), HasSubstr("usdzip")));
  EXPECT_THAT(said({{"square.usda", {}}}), HasSubstr("\"square.usda\", is empty"));
  // A picture that is called a layer: its bytes are not shown as they are.
  EXPECT_THAT(said({{"skin.usda", to_bytes(png)}}), HasSubstr("found \"?PNG????\", wanted #usda"));
  EXPECT_EQ(said({{"square.usda", to_bytes(layer)}}), "");
}

TEST_F(AnimationDetails, RefusesAnAxisThatUsdDoesNotHave) {
  EXPECT_THAT(refusal({.head = "upAxis = \"X\"\n"}), HasSubstr("upAxis is \"X\", wanted"));
}

}  // namespace
}  // namespace mq
