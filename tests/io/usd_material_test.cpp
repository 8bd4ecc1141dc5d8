// Materials of USD: the picture and the texture coordinates that a mesh is shown with, and what binds it to them.
#include <algorithm>
#include <string>

#include "io/animations.h"
#include "mq/image/image.h"
#include "mq/io/image_file.h"

namespace mq {
namespace {

/// A square that a material paints: what `texture` and what lies beside it say more.
UsdSquare painted(const std::string& texture, const std::string& beside = "", const std::string& sets = "") {
  return {.inside = "uniform token subdivisionScheme = \"none\"\nrel material:binding = </root/look>\n" + sets,
          .beside = "def Material \"look\" {\ntoken inputs:set = \"map1\"\nasset inputs:picture = @dot.png@\n"
                    "def Shader \"s\" {\nuniform token info:id = \"UsdPreviewSurface\"\n"
                    "color3f inputs:diffuseColor.connect = </root/look/p.outputs:rgb>\n}\n"
                    "def Shader \"p\" {\nuniform token info:id = \"UsdUVTexture\"\n" +
                    texture + "}\n" + beside + "}\n"};
}

/// Texture coordinates that are half of st.
const std::string half_map =
    "texCoord2f[] primvars:map1 = [(0, 0), (0.5, 0), (0.5, 0.5), (0, 0.5)] ( interpolation = \"vertex\" )\n";

class UsdMaterials : public AnimationTest {
 protected:
  void SetUp() override {
    Texture dot;
    dot.pixels = Image<float>(2, 2, 3, 0.25F);
    write_texture(folder / "dot.png", dot);
  }

  static double largest_u(const OpenAnimation& opened) {
    double most = 0;
    for (const Vector2& uv : opened.reader.segment(0).uvs) most = std::max(most, uv.x());
    return most;
  }
};

TEST_F(UsdMaterials, TakesTheCoordinatesThatTheMaterialReads) {
  const std::string file = "asset inputs:file = @dot.png@\n";
  const std::string from = "float2 inputs:st.connect = </root/look/r.outputs:result>\n";
  const auto reader = [](const std::string& varname) {
    return "def Shader \"r\" {\nuniform token info:id = \"UsdPrimvarReader_float2\"\n" + varname + "}\n";
  };
  const std::string named = reader("string inputs:varname = \"map1\"\n");
  const std::string led = reader("string inputs:varname.connect = </root/look.inputs:set>\n");
  for (const std::string& beside : {named, led}) {
    const OpenAnimation opened = open(painted(file + from, beside, half_map));
    EXPECT_DOUBLE_EQ(largest_u(opened), 0.5);
    EXPECT_THAT(opened.notes, IsEmpty());
    EXPECT_FALSE(opened.pictures[0].values().empty());
  }
  EXPECT_DOUBLE_EQ(largest_u(open(painted(file, "", half_map))), 1) << "st, where no reader says another";
  const OpenAnimation lacking = open(painted(file + from, named));
  EXPECT_DOUBLE_EQ(largest_u(lacking), 1);
  EXPECT_THAT(lacking.notes, ElementsAre(HasSubstr("has no texture coordinates \"map1\"")));
}

TEST_F(UsdMaterials, FollowsThePictureToWhereItIsNamed) {
  const OpenAnimation led = open(painted("asset inputs:file.connect = </root/look.inputs:picture>\n"));
  EXPECT_FALSE(led.pictures[0].values().empty());
  EXPECT_THAT(led.notes, IsEmpty());
  const OpenAnimation changing = open(painted("asset inputs:file.timeSamples = { 1: @dot.png@, 2: @two.png@ }\n"));
  EXPECT_FALSE(changing.pictures[0].values().empty());
  EXPECT_THAT(changing.notes, ElementsAre(HasSubstr("another picture at other times; the first, \"dot.png\"")));
  const OpenAnimation circle = open(painted("asset inputs:file.connect = </root/look/p.inputs:file>\n"));
  EXPECT_TRUE(circle.pictures[0].values().empty());
}

TEST_F(UsdMaterials, TakesPathsInLists) {
  const std::string text =
      painted("asset inputs:file = @dot.png@\nfloat2 inputs:st.connect = [</root/look/r.outputs:result>]\n",
              "def Shader \"r\" {\nuniform token info:id = \"UsdPrimvarReader_float2\"\n"
              "string inputs:varname = \"map1\"\n}\n",
              half_map)
          .text();
  for (const std::string path : {"</root/look>", "</root/look/p.outputs:rgb>"}) {
    std::string listed = text;
    listed.replace(listed.find(path), path.size(), "[" + path + "]");
    const OpenAnimation opened = open_animation(put("listed.usda", listed));
    EXPECT_FALSE(opened.pictures[0].values().empty()) << path;
    EXPECT_DOUBLE_EQ(largest_u(opened), 0.5);
    EXPECT_THAT(opened.notes, IsEmpty());
  }
}

TEST_F(UsdMaterials, HeedsWhichBindingIsStronger) {
  const UsdSquare own = painted("asset inputs:file = @dot.png@\n");
  const auto opened = [&](const std::string& of_root) {
    std::string text = own.text();
    const std::string root = "def Xform \"root\" {\n";
    text.replace(text.find(root), root.size(), root + of_root);
    return open_animation(put("bound.usda", text));
  };
  EXPECT_FALSE(opened("rel material:binding = </root/none>\n").pictures[0].values().empty()) << "the inner one";
  const OpenAnimation stronger =
      opened("rel material:binding = </root/none> ( bindMaterialAs = \"strongerThanDescendants\" )\n");
  EXPECT_TRUE(stronger.pictures[0].values().empty());
  EXPECT_THAT(stronger.notes, ElementsAre(HasSubstr("the material /root/none is not there")));
  EXPECT_TRUE(open(painted("", "")).pictures[0].values().empty());
}

TEST_F(UsdMaterials, PrefersWhatIsBoundForPreviewsWhereverItIs) {
  const std::string direct = "rel material:binding = </root/look>\n", none = "rel material:binding = </root/none>\n";
  const std::string strong = " ( bindMaterialAs = \"strongerThanDescendants\" )\n";
  const auto has_picture = [&](const std::string& of_root, const std::string& of_mesh) {
    std::string text = painted("asset inputs:file = @dot.png@\n").text();
    const std::string root = "def Xform \"root\" {\n";
    text.replace(text.find(direct), direct.size(), of_mesh);
    text.replace(text.find(root), root.size(), root + of_root);
    return !open_animation(put("purposes.usda", text)).pictures[0].values().empty();
  };
  const std::string preview = "rel material:binding:preview = </root/look>\n",
                    full = "rel material:binding:full = </root/look>\n",
                    no_preview = "rel material:binding:preview = </root/none>\n";
  EXPECT_TRUE(has_picture(preview, none)) << "an ancestor's for previews goes before the mesh's own for all";
  EXPECT_TRUE(has_picture(preview, "rel material:binding = </root/none>" + strong));
  EXPECT_TRUE(has_picture("rel material:binding = </root/none>" + strong, preview)) << "strong for all alone";
  EXPECT_FALSE(has_picture("rel material:binding:preview = </root/none>" + strong, preview));
  EXPECT_FALSE(has_picture(preview, no_preview)) << "of one purpose the inner one";
  EXPECT_FALSE(has_picture(full, none)) << "for full renders where nothing else is bound";
  EXPECT_TRUE(has_picture(full, ""));
  EXPECT_TRUE(has_picture(direct, full)) << "an ancestor's for all before the mesh's own for full renders";
  EXPECT_TRUE(has_picture("", preview + "rel material:binding:full = </root/none>\n"));
}

TEST_F(UsdMaterials, HeedsThePurposesOfCollections) {
  const auto has_picture = [&](const std::string& of_root, const std::string& of_mesh) {
    std::string text = painted("asset inputs:file = @dot.png@\n").text();
    const std::string direct = "rel material:binding = </root/look>\n", root = "def Xform \"root\" {\n";
    text.replace(text.find(direct), direct.size(), of_mesh);
    text.replace(text.find(root), root.size(), root + "rel collection:all:includes = </root>\n" + of_root);
    return !open_animation(put("purposes.usda", text)).pictures[0].values().empty();
  };
  const std::string to_look = " = [</root.collection:all>, </root/look>]", to_none = " = [</root.collection:all>, "
                                                                                     "</root/none>]";
  const std::string named = "rel material:binding:collection:", none = "rel material:binding = </root/none>\n";
  const std::string strong = " ( bindMaterialAs = \"strongerThanDescendants\" )\n";
  EXPECT_TRUE(has_picture(named + "preview:a" + to_look + "\n", none));
  EXPECT_FALSE(has_picture(named + "full:a" + to_look + "\n", none));
  EXPECT_TRUE(has_picture(named + "full:a" + to_look + "\n", ""));
  EXPECT_TRUE(has_picture(named + "full:a" + to_none + "\n" + named + "a" + to_look + "\n", ""));
  EXPECT_FALSE(has_picture(named + "a" + to_look + "\n", none)) << "the mesh's own is nearer";
  EXPECT_TRUE(has_picture(named + "a" + to_look + strong, none));
  EXPECT_TRUE(has_picture("rel material:binding = </root/none>" + strong + named + "a" + to_look + "\n", none))
      << "a collection goes before what is bound directly to the prim that won";
}

TEST_F(UsdMaterials, FollowsPathsFromThePrimThatNamesThem) {
  std::string text = painted("asset inputs:file.connect = <../.inputs:picture>\nfloat2 inputs:st.connect = "
                             "<../r.outputs:result>\n",
                             "def Shader \"r\" {\nuniform token info:id = \"UsdPrimvarReader_float2\"\n"
                             "string inputs:varname.connect = <../.inputs:set>\n}\n",
                             half_map)
                         .text();
  for (const auto& [whole, relative] : {std::pair{"binding = </root/look>", "binding = <../look>"},
                                        {"</root/look/p.outputs:rgb>", "<../p.outputs:rgb>"}})
    text.replace(text.find(whole), std::string(whole).size(), relative);
  const OpenAnimation opened = open_animation(put("relative.usda", text));
  EXPECT_FALSE(opened.pictures[0].values().empty());
  EXPECT_DOUBLE_EQ(largest_u(opened), 0.5);
  EXPECT_THAT(opened.notes, IsEmpty());
}

TEST_F(UsdMaterials, FindsMeshesInCollections) {
  const auto opened = [&](const std::string& of_root) {
    std::string text = painted("asset inputs:file = @dot.png@\n").text();
    const std::string direct = "rel material:binding = </root/look>\n", root = "def Xform \"root\" {\n";
    text.erase(text.find(direct), direct.size());
    text.replace(text.find(root), root.size(), root + of_root);
    return open_animation(put("collected.usda", text));
  };
  const auto has_picture = [&](const std::string& of_root) {
    const OpenAnimation found = opened(of_root);
    EXPECT_THAT(found.notes, IsEmpty()) << of_root;
    return !found.pictures[0].values().empty();
  };
  const std::string binding = "rel material:binding:collection:skin = [</root.collection:skin>, <look>]\n";
  const std::string none = "rel material:binding = </root/none>\n";
  EXPECT_TRUE(has_picture(binding + "rel collection:skin:includes = </root/square>\n"));
  EXPECT_TRUE(has_picture(binding + "rel collection:skin:includes = [</other>, </root>]\n"));
  EXPECT_TRUE(has_picture(none + binding + "bool collection:skin:includeRoot = true\n")) << "before a direct one";
  EXPECT_FALSE(has_picture(binding + "rel collection:skin:includes = </roo>\n"));
  EXPECT_FALSE(has_picture(binding + "rel collection:skin:includes = </root>\nrel collection:skin:excludes = "
                                     "<square>\n"));
  EXPECT_FALSE(has_picture(binding + "rel collection:skin:includes = </root>\nuniform token "
                                     "collection:skin:expansionRule = \"explicitOnly\"\n"));
  EXPECT_THAT(opened(binding + "rel collection:skin:includes = </root.collection:other>\n").notes,
              ElementsAre(AllOf(HasSubstr("\"/root.collection:skin\""), HasSubstr("includes another collection"))));
  EXPECT_THAT(opened(binding + "pathExpression collection:skin:membershipExpression = \"//square\"\n").notes,
              ElementsAre(HasSubstr("membershipExpression")));
  EXPECT_THAT(opened(binding).notes, ElementsAre(HasSubstr("is not there")));
}

TEST_F(UsdMaterials, TakesTwoOfThreeCoordinates) {
  std::string text = UsdSquare().text();
  const auto put_in = [&](const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
  };
  put_in("texCoord2f[]", "texCoord3f[]");
  put_in("[(0, 0), (1, 0), (1, 1), (0, 1)] (", "[(0, 0, 9), (0.5, 0, 9), (0.5, 1, 9), (0, 1, 9)] (");
  const OpenAnimation opened = open_animation(put("three.usda", text));
  EXPECT_DOUBLE_EQ(largest_u(opened), 0.5);
  EXPECT_THAT(opened.remarks, ElementsAre(AllOf(HasSubstr("primvars:st of /root/square"), HasSubstr("first two"))));
  put_in("texCoord3f[]", "color4f[]");
  EXPECT_THAT(open_animation(put("four.usda", text)).notes,
              ElementsAre(AllOf(HasSubstr("primvars:st of /root/square"), HasSubstr("\"color4f[]\""))));
}

TEST_F(UsdMaterials, SaysWhatOfThemIsNotFollowed) {
  const std::string file = "asset inputs:file = @dot.png@\n";
  const auto notes = [&](const std::string& more, const std::string& beside = "") {
    return open(painted(file + more, beside)).notes;
  };
  EXPECT_THAT(notes("float4 inputs:scale = (1, 1, 1, 1)\nfloat4 inputs:bias = (0, 0, 0, 0)\n"
                    "token inputs:sourceColorSpace = \"auto\"\n"),
              IsEmpty());
  EXPECT_THAT(notes("float4 inputs:scale.timeSamples = { 1: (1, 1, 1, 1), 2: (2, 2, 2, 1) }\n"),
              ElementsAre(HasSubstr("changes the values of its picture")));
  EXPECT_THAT(notes("float4 inputs:scale = (0.5, 1, 1, 1)\n"), ElementsAre(HasSubstr("(scale (0.5, 1, 1, 1))")));
  EXPECT_THAT(notes("float4 inputs:bias = (0, 0, 0.1, 0)\n"), ElementsAre(HasSubstr("(bias (0, 0, 0.1, 0))")));
  EXPECT_THAT(notes("token inputs:sourceColorSpace = \"raw\"\n"), ElementsAre(HasSubstr("raw")));
  EXPECT_THAT(notes("float2 inputs:st.connect = </root/look/t.outputs:result>\n",
                    "def Shader \"t\" {\nuniform token info:id = \"UsdTransform2d\"\n"
                    "float2 inputs:scale = (2, 2)\n}\n"),
              ElementsAre(HasSubstr("UsdTransform2d")));
}

}  // namespace
}  // namespace mq
