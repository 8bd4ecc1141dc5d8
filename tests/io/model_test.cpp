// Models as files: what is read, what comes back, what is refused.
#include "mq/io/model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>

#include "io/folder.h"
#include "io/models.h"
#include "mq/io/image_file.h"
#include "mq/io/model_watch.h"

namespace mq {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
namespace fs = std::filesystem;

class ModelFile : public FolderTest {
 protected:
  void put_picture(const std::string& name, int width = 4, int height = 3) const {
    fs::create_directories((folder / name).parent_path());
    write_texture(folder / name, ramp_texture(name, width, height));
  }
  std::string refusal(const std::string& name, const ReadModelOptions& options = {}) const {
    return io_error_of([&] { read_model(folder / name, options); });
  }
  static ReadModelOptions given(std::vector<fs::path> pictures) {
    return {std::move(pictures), {}};
  }
  static constexpr auto skip = ReadModelOptions::Pictures::skip;
};

const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n";
const std::string face = "f 1/1 2/2 3/3\n";

void expect_same(const Model& a, const Model& b) {
  ASSERT_EQ(a.mesh.triangles, b.mesh.triangles);
  EXPECT_EQ(a.mesh.positions, b.mesh.positions);
  ASSERT_EQ(a.mesh.has_uvs(), b.mesh.has_uvs());
  ASSERT_EQ(a.textures.size(), b.textures.size());
  for (int t = 0; t < a.mesh.triangle_count(); ++t) {
    EXPECT_EQ(a.mesh.texture(t), b.mesh.texture(t));
    for (int k = 0; k < 3 && a.mesh.textured(t); ++k) EXPECT_EQ(a.mesh.uv(t, k), b.mesh.uv(t, k));
  }
  for (std::size_t i = 0; i < a.textures.size(); ++i) {
    EXPECT_EQ(a.textures[i].name, b.textures[i].name);
    EXPECT_EQ(a.textures[i].pixels, b.textures[i].pixels);
  }
  EXPECT_EQ(a.colors.channels, b.colors.channels);
  EXPECT_EQ(a.colors.values, b.colors.values);
}

TEST_F(ModelFile, IsSeenAsItsShapeAndThenWithItsPictures) {
  put_picture("skin.png");
  put("a.mtl", "newmtl skin\nmap_Kd skin.png\n");
  put("a.obj", "mtllib a.mtl\nusemtl skin\n" + triangle + face);
  std::vector<int> triangles, widths;
  const Model read = read_model(folder / "a.obj", {}, {}, [&](const Model& model) {
    triangles.push_back(model.mesh.triangle_count());
    widths.push_back(model.textures.empty() ? 0 : model.textures[0].pixels.width());
  });
  EXPECT_THAT(triangles, ElementsAre(1, 1));
  EXPECT_THAT(widths, ElementsAre(0, 4));
  expect_same(read, read_model(folder / "a.obj"));
  EXPECT_THROW(read_model(folder / "a.obj", {}, {}, [](const Model&) { throw Cancelled(); }), Cancelled);
}

// ---- Models made in memory, and conversions ----

TEST_F(ModelFile, ComesBackFromObjAndPlyAsItWasMade) {
  for (const std::string extension : {".obj", ".ply"})
    for (const Model& model : {two_chart_square(), two_texture_square()}) {
      EXPECT_THAT(write_model(folder / ("m" + extension), model), IsEmpty());
      expect_same(read_model(folder / ("m" + extension)), model);
    }
}

TEST_F(ModelFile, KeepsTrianglesWithoutTexture) {
  Model model = two_texture_square();
  model.mesh.textures = {-1, 1};
  model.mesh.corner_uvs[0] = {-1, -1, -1};
  write_model(folder / "m.ply", model);
  expect_same(read_model(folder / "m.ply"), model);
  write_model(folder / "m.obj", model);
  const Model back = read_model(folder / "m.obj");  // the unused picture is no texture of it
  EXPECT_THAT(back.mesh.textures, ElementsAre(-1, 0));
  EXPECT_EQ(back.textures.at(0).name, "right side.png");
}

TEST_F(ModelFile, KeepsEverythingFromObjOverPlyToObj) {
  write_model(folder / "a.obj", two_texture_square());
  write_model(folder / "b.ply", read_model(folder / "a.obj"));
  write_model(folder / "c.obj", read_model(folder / "b.ply"));
  expect_same(read_model(folder / "c.obj"), read_model(folder / "a.obj"));
}

// ---- What was not to change does not change ----

const std::string odd_mtl =
    "# hand made\nnewmtl  skin\n\tmap_Kd -s 1 1 .\\tex ture.png  \nillum 2\n";
const std::string odd_obj =
    "# \xc3\xa4 remark\r\nmtllib ./odd lib.mtl\r\no thing\r\nv  0.10 0.0 0e0\r\nv 1 0 0\r\nv\t0 1 "
    "-0\r\nvn 0 0 1\r\nvt 0 0 0\r\nvt 1.0 0\r\nvt 0 1\r\ng part\r\ns off\r\nusemtl skin\r\n"
    "f 1/1/1 2/2/1 3/3/1  # last\r\ncurv 0 1";

TEST_F(ModelFile, UnchangedObjComesBackByteForByte) {
  put("odd.obj", odd_obj);
  put("odd lib.mtl", odd_mtl);
  put_picture("tex ture.png");
  const std::string picture = get("tex ture.png");
  const Model model = read_model(folder / "odd.obj");
  EXPECT_EQ(model.textures.at(0).name, "tex ture.png");
  fs::create_directories(folder / "out");
  write_model(folder / "out/odd.obj", model);
  EXPECT_EQ(get("out/odd.obj"), odd_obj);
  EXPECT_EQ(get("out/odd lib.mtl"), odd_mtl);
  EXPECT_EQ(get("out/tex ture.png"), picture);
}

TEST_F(ModelFile, AnotherTextureNameChangesOnlyThatName) {
  put("odd.obj", odd_obj);
  put("odd lib.mtl", odd_mtl);
  put_picture("tex ture.png");
  Model model = read_model(folder / "odd.obj");
  model.textures[0].name = "sharp.png";
  model.textures[0].pixels(0, 0, 0) = 1;
  write_model(folder / "sharp.obj", model);
  std::string obj = odd_obj, mtl = odd_mtl;
  obj.replace(obj.find("./odd lib.mtl"), 13, "sharp.mtl");
  mtl.replace(mtl.find(".\\tex ture.png"), 14, "sharp.png");
  EXPECT_EQ(get("sharp.obj"), obj);
  EXPECT_EQ(get("sharp.mtl"), mtl);
  EXPECT_EQ(get("odd lib.mtl"), odd_mtl);
  EXPECT_EQ(read_model(folder / "sharp.obj").textures[0].pixels, model.textures[0].pixels);
}

TEST_F(ModelFile, MovedVerticesChangeOnlyTheirNumbers) {
  put("odd.obj", odd_obj);
  Model model = read_model(folder / "odd.obj", {{}, skip});
  model.mesh.positions[0] = {0.1, 0.25, 0};
  model.mesh.uvs[1] = {0.5, 0};
  write_model(folder / "moved.obj", model);
  std::string expected = odd_obj;
  expected.replace(expected.find("0.10 0.0 0e0"), 12, "0.10 0.25 0e0");
  expected.replace(expected.find("1.0 0\r"), 3, "0.5");
  EXPECT_EQ(get("moved.obj"), expected);
}

TEST_F(ModelFile, AddsReplacesAndRemovesColoursInAnObj) {
  put("m.obj", "v 0 0 0 # a\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  Model model = read_model(folder / "m.obj");
  model.colors = {1, {0, 0.5f, 1}, Depth::f32};
  write_model(folder / "c.obj", model);
  EXPECT_EQ(get("c.obj"), "v 0 0 0 0 0 0 # a\nv 1 0 0 0.5 0.5 0.5\nv 0 1 0 1 1 1\nf 1 2 3\n");
  model = read_model(folder / "c.obj");
  model.colors.values[0] = 0.25f;
  write_model(folder / "d.obj", model);
  EXPECT_EQ(get("d.obj").substr(0, 24), "v 0 0 0 0.25 0 0 # a\nv 1");
  model.colors = {};
  write_model(folder / "e.obj", model);
  EXPECT_EQ(get("e.obj"), get("m.obj"));
}

const std::string odd_ply_head =
    "ply\r\nformat ascii 1.0\r\ncomment TextureFile t.png\r\ncomment kept\r\nelement vertex 3\r\n"
    "property float x\r\nproperty float y\r\nproperty float z\r\nproperty int id\r\n";
const std::string odd_ply_body =
    "element face 1\r\nproperty list uchar int vertex_indices\r\nproperty list uchar float texcoord"
    "\r\nproperty uchar red\r\nend_header\r\n0.10 0 0 7\r\n1 0 0  8\r\n0 1 0 9\r\n"
    "3 0 1 2 6 0 0 1.0 0 0 1 255\r\nmore";

TEST_F(ModelFile, PlyComesBackByteForByteButForWhatChanged) {
  put("m.ply", odd_ply_head + odd_ply_body);
  put_picture("t.png");
  Model model = read_model(folder / "m.ply");
  fs::create_directories(folder / "out");
  write_model(folder / "out/m.ply", model);
  EXPECT_EQ(get("out/m.ply"), odd_ply_head + odd_ply_body);

  model.textures[0].name = "new name.png";
  model.mesh.positions[1].y() = -0.5;
  model.mesh.uvs[1].x() = 0.75;
  write_model(folder / "out/n.ply", model);
  std::string expected = odd_ply_head + odd_ply_body;
  expected.replace(expected.find("t.png"), 5, "new name.png");
  expected.replace(expected.find("1 0 0  8"), 5, "1 -0.5 0");
  expected.replace(expected.find("1.0 0 0 1"), 3, "0.75");
  EXPECT_EQ(get("out/n.ply"), expected);
}

TEST_F(ModelFile, AddsColoursToAPlyThatHasNone) {
  put("m.ply", odd_ply_head + odd_ply_body);
  Model model = read_model(folder / "m.ply", {{}, skip});
  model.colors = {3, {0, 0, 0, 1, 1, 1, 0.5f, 0, 1}, Depth::u8};
  write_model(folder / "c.ply", model);
  EXPECT_THAT(get("c.ply"),
              HasSubstr("property int id\r\nproperty uchar red\r\nproperty uchar green"
                        "\r\nproperty uchar blue\r\nelement face"));
  EXPECT_THAT(get("c.ply"),
              HasSubstr("0.10 0 0 7 0 0 0\r\n1 0 0  8 255 255 255\r\n0 1 0 9 128 0 255"));
  const Model back = read_model(folder / "c.ply", {{}, skip});
  EXPECT_EQ(back.mesh.triangles, model.mesh.triangles);
  EXPECT_EQ(back.colors.values[6], 128.0f / 255);
}

TEST_F(ModelFile, BinaryPlyKeepsItsTypes) {
  Model made = two_texture_square();
  made.mesh.positions[3].z() = 0.5;
  made.mesh.positions[1].z() = 0.25;
  write_model(folder / "a.ply", made);
  const std::string before = get("a.ply");
  EXPECT_THAT(before, HasSubstr("property float x"));
  Model model = read_model(folder / "a.ply");
  model.mesh.positions[0].x() = 0.1;
  model.colors.values[0] = 1;
  write_model(folder / "b.ply", model);
  ASSERT_EQ(get("b.ply").size(), before.size());
  int different = 0;
  for (std::size_t i = 0; i < before.size(); ++i) different += before[i] != get("b.ply")[i];
  EXPECT_LE(different, 4 + 1);
  const Model back = read_model(folder / "b.ply");
  EXPECT_EQ(back.mesh.positions[0].x(), double(0.1f));
  EXPECT_EQ(back.colors.values[0], 1);
}

TEST_F(ModelFile, FloatsGiveWayToDoublesForWhatTheyCannotHold) {
  Model made = two_texture_square();
  for (Vector3& p : made.mesh.positions) p = p.cast<float>().cast<double>();
  write_model(folder / "a.ply", made);
  Model model = read_model(folder / "a.ply");
  model.mesh.positions[0].x() = 1e50;
  write_model(folder / "b.ply", model);
  EXPECT_EQ(read_model(folder / "b.ply").mesh.positions, model.mesh.positions);
  EXPECT_THROW(write_model(folder / "b.glb", model), Unsupported);
}

TEST_F(ModelFile, OtherConnectivityIsWrittenAnew) {
  put("odd.obj", odd_obj);
  put("odd lib.mtl", odd_mtl);
  put_picture("tex ture.png");
  Model model = read_model(folder / "odd.obj");
  model.mesh.triangles.push_back({0, 2, 1});
  model.mesh.corner_uvs.push_back({0, 2, 1});
  model.mesh.textures.push_back(0);
  write_model(folder / "more.obj", model);
  expect_same(read_model(folder / "more.obj"), model);
}

// ---- Pictures given beside the model, and libraries that are missing ----

TEST_F(ModelFile, IsPaintedByOnePictureWhenItNamesNone) {
  put_picture("paint.png");
  for (const std::string& text :
       {triangle + face, "usemtl a\n" + triangle + face + "usemtl b\n" + face,
        "mtllib no.mtl\n" + triangle + face + "usemtl b\n" + face}) {
    put("m.obj", text);
    const Model model = read_model(folder / "m.obj", given({folder / "paint.png"}));
    ASSERT_EQ(model.textures.size(), 1u);
    EXPECT_THAT(model.mesh.textures, IsEmpty());
    write_model(folder / "painted.obj", model);
    const Model back = read_model(folder / "painted.obj");
    EXPECT_EQ(back.textures.at(0).name, "paint.png");
    for (int t = 0; t < back.mesh.triangle_count(); ++t) EXPECT_EQ(back.mesh.texture(t), 0);
    EXPECT_THAT(get("painted.obj"), HasSubstr(triangle));
  }
}

TEST_F(ModelFile, GivesEachMaterialWithoutPictureItsOwn) {
  put_picture("a.png");
  put_picture("b.png", 5, 5);
  put("m.obj", "usemtl x\n" + triangle + face + "usemtl y\n" + face);
  const Model model = read_model(folder / "m.obj", given({folder / "a.png", folder / "b.png"}));
  EXPECT_THAT(model.mesh.textures, ElementsAre(0, 1));
  write_model(folder / "painted.obj", model);
  expect_same(read_model(folder / "painted.obj"), model);
  try {
    read_model(folder / "m.obj", given({folder / "a.png", folder / "b.png", folder / "a.png"}));
    ADD_FAILURE();
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), HasSubstr("has 2 textures, but 3 pictures are given"));
  }
}

TEST_F(ModelFile, PaintsAMaterialOfALibraryWithoutAPicture) {
  put_picture("a.png");
  put("m.mtl", "newmtl x\nKd 1 0 0");
  put("m.obj", "mtllib m.mtl\nusemtl x\n" + triangle + face);
  const Model model = read_model(folder / "m.obj", given({folder / "a.png"}));
  write_model(folder / "n.obj", model);
  EXPECT_EQ(get("n.mtl"), "newmtl x\nmap_Kd a.png\nKd 1 0 0");
  EXPECT_EQ(get("n.obj"), "mtllib n.mtl\nusemtl x\n" + triangle + face);
}

TEST_F(ModelFile, PaintsAPly) {
  put_picture("a.png");
  Model made = two_chart_square();
  made.textures.clear();
  write_model(folder / "m.ply", made);
  const Model model = read_model(folder / "m.ply", given({folder / "a.png"}));
  write_model(folder / "n.ply", model);
  expect_same(read_model(folder / "n.ply"), model);
}

TEST_F(ModelFile, TakesAGivenPictureInPlaceOfOneThatIsMissing) {
  put_picture("sub/other.png");
  put("m.obj", "mtllib m.mtl\nusemtl x\n" + triangle + face);
  EXPECT_THAT(refusal("m.obj"), HasSubstr("names the material library \"m.mtl\", which is not in"));
  EXPECT_THAT(read_model(folder / "m.obj", given({folder / "sub/other.png"})).notes,
              Contains(HasSubstr("names the material library \"m.mtl\"")));
  put("m.mtl", "newmtl x\nmap_Kd gone.png\n");
  put_picture("here.png");
  EXPECT_THAT(refusal("m.obj"), HasSubstr("names the picture \"gone.png\", which is not in"));
  EXPECT_THAT(refusal("m.obj"), HasSubstr("(there are here.png)"));
  const Model model = read_model(folder / "m.obj", given({folder / "sub/other.png"}));
  EXPECT_EQ(model.textures.at(0).name, "other.png");
  EXPECT_THAT(read_model(folder / "m.obj", {{}, skip}).notes, Contains(HasSubstr("gone.png")));
}

TEST_F(ModelFile, FindsPicturesByForeignNames) {
  put_picture("maps/a.png");
  put_picture("b.png", 2, 2);
  put("lib/m.mtl", "newmtl x\nmap_Kd ..\\maps\\a.png\nnewmtl y\nmap_Kd C:\\Users\\me\\b.png\n");
  put("m.obj", "mtllib lib\\m.mtl\n" + triangle + "usemtl x\n" + face + "usemtl y\n" + face);
  const Model model = read_model(folder / "m.obj");
  EXPECT_EQ(model.textures.at(0).pixels.width(), 4);
  EXPECT_EQ(model.textures.at(1).pixels.width(), 2);
}

TEST_F(ModelFile, MayHaveBlanksAndUnicodeInItsNames) {
  Model model = two_chart_square();
  model.textures[0].name = "b\xc3\xbcste \xe2\x98\xba.png";
  for (const std::string extension : {".obj", ".ply", ".gltf", ".glb"}) {
    const fs::path path = folder / ("meine b\xc3\xbcste" + extension);
    write_model(path, model);
    const Model back = read_model(path);
    ASSERT_EQ(back.textures.size(), 1u) << extension;
    EXPECT_EQ(back.textures[0].name, model.textures[0].name);
    EXPECT_EQ(back.textures[0].pixels, model.textures[0].pixels);
  }
}

TEST_F(ModelFile, ReadsSeveralLibrariesOfOneLine) {
  put_picture("a.png");
  put("one.mtl", "newmtl x\n");
  put("two.mtl", "newmtl y\nmap_Kd a.png\n");
  put("m.obj", "mtllib one.mtl two.mtl\n" + triangle + "usemtl y\n" + face);
  Model model = read_model(folder / "m.obj");
  ASSERT_EQ(model.textures.size(), 1u);
  model.textures[0].name = "n.png";
  write_model(folder / "n.obj", model);
  EXPECT_THAT(get("n.obj"), HasSubstr("mtllib one.mtl n.mtl\n"));
}

TEST_F(ModelFile, CopiesAPictureThatDidNotChange) {
  write_texture(folder / "a.jpg", ramp_texture("a.jpg", 16, 16));
  put("m.mtl", "newmtl x\nmap_Kd a.jpg\n");
  put("m.obj", "mtllib m.mtl\nusemtl x\n" + triangle + face);
  for (const auto pictures : {ReadModelOptions::Pictures::read, skip}) {
    const Model model = read_model(folder / "m.obj", {{}, pictures});
    fs::create_directories(folder / "out");
    EXPECT_THAT(write_model(folder / "out/m.obj", model), IsEmpty());
    EXPECT_EQ(get("out/a.jpg"), get("a.jpg"));
    fs::remove_all(folder / "out");
  }
}

TEST_F(ModelFile, NeverReplacesThePictureItWasMadeFrom) {
  write_model(folder / "m.obj", two_chart_square());
  Model model = read_model(folder / "m.obj");
  const std::string before = get("square.png");
  model.textures[0].pixels(0, 0, 0) = 1;
  EXPECT_THAT(io_error_of([&] { write_model(folder / "n.obj", model); }),
              HasSubstr("would replace the picture"));
  EXPECT_EQ(get("square.png"), before);
  EXPECT_FALSE(there("n.obj"));
  write_model(folder / "m.obj", model);  // in its own place
  EXPECT_EQ(read_model(folder / "m.obj").textures[0].pixels, model.textures[0].pixels);
}

TEST_F(ModelFile, KeepsNamesBelowTheFolderOfTheMesh) {
  fs::create_directories(folder / "x");
  Model model = two_chart_square();
  for (const std::string name :
       {"../../evil.png", "/tmp/mq_evil.png", "maps/fine.png", "a\nb.png"}) {
    model.textures[0].name = name;
    write_model(folder / "x/m.obj", model, {});
  }
  EXPECT_FALSE(fs::exists(folder / "../evil.png"));
  EXPECT_FALSE(fs::exists("/tmp/mq_evil.png"));
}

// ---- Files that are not models ----

TEST_F(ModelFile, IsRefusedInWordsWhenTheFileCannotBeRead) {
  EXPECT_THAT(refusal("no.obj"), HasSubstr("No such file"));
  EXPECT_THAT(refusal(""), HasSubstr("it is a directory"));
  put("empty.obj", "");
  EXPECT_THAT(refusal("empty.obj"), HasSubstr("is empty"));
  fs::create_symlink("/dev/zero", folder / "zero.obj");
  EXPECT_THAT(refusal("zero.obj"), HasSubstr("not an ordinary file"));
  if (::geteuid() == 0) return;  // who may read everything
  put("locked.obj", triangle + face);
  ::chmod((folder / "locked.obj").c_str(), 0);
  EXPECT_THAT(refusal("locked.obj"), HasSubstr("Permission denied"));
}

TEST_F(ModelFile, IsKnownByItsContentNotItsExtension) {
  put("obj.ply", triangle + face);
  EXPECT_EQ(read_model(folder / "obj.ply").mesh.triangle_count(), 1);
  put("ply.obj", odd_ply_head + odd_ply_body);
  EXPECT_EQ(read_model(folder / "ply.obj", {{}, skip}).mesh.triangle_count(), 1);
  put("picture.obj", "\x89PNG\r\n");
  EXPECT_THAT(refusal("picture.obj"), HasSubstr("is a PNG picture; convert it"));
  put("stl.obj", "solid cube\nfacet normal\n");
  EXPECT_THAT(refusal("stl.obj"), HasSubstr("is an STL mesh"));
  put("a.usd", "#usda 1.0\n");
  EXPECT_THAT(refusal("a.usd"), HasSubstr("is a USD scene; convert it"));
  EXPECT_THAT(refusal("a.usd"), HasSubstr("by export where it moves"));
  put("a.usdz", std::string("PK\x03\x04", 4));
  EXPECT_THAT(refusal("a.usdz"), HasSubstr("by export where it moves"));
  put("m.mtl", "newmtl x\n");
  EXPECT_THAT(refusal("m.mtl"), HasSubstr("a material library, not the mesh"));
  for (const std::string name : {"x.obj", "x.ply", "x.glb", "x.gltf", "x"}) {
    put(name, std::string("\x01\x7f\x80garbage\0\xff\xfe", 14));
    EXPECT_THAT(refusal(name), HasSubstr("is not ")) << name;
  }
}

TEST_F(ModelFile, IsRefusedWhenCutAnywhereOrReadAsFarAsItGoes) {
  write_model(folder / "m.ply", two_texture_square());
  write_model(folder / "m.obj", two_texture_square());
  for (const std::string name : {"m.ply", "m.obj"}) {
    const std::string whole = get(name);
    for (std::size_t size = 0; size < whole.size(); size += 3) {
      put("cut.x", whole.substr(0, size));
      const std::string error = refusal("cut.x", {{}, skip});
      EXPECT_TRUE(name == "m.obj" || !error.empty()) << size;
    }
  }
}

TEST_F(ModelFile, IsRefusedForWritingInWords) {
  EXPECT_THAT(io_error_of([&] { write_model(folder / "m.stl", two_chart_square()); }),
              HasSubstr("its extension is none of .obj, .ply, .gltf, .glb"));
  EXPECT_THAT(io_error_of([&] { write_model(folder / "no/ne/m.obj", two_chart_square()); }),
              HasSubstr("make the folder around its folder first"));
  EXPECT_EQ(files(), 0);
  Model model = two_chart_square();
  model.mesh.triangles[1][2] = 4;
  EXPECT_THROW(write_model(folder / "m.obj", model), InvalidInput);
  model = two_chart_square();
  model.mesh.positions[0].x() = NAN;
  EXPECT_THROW(write_model(folder / "m.obj", model), InvalidInput);
  model = two_chart_square();
  model.colors = {2, std::vector<float>(8), Depth::u8};
  EXPECT_THROW(write_model(folder / "m.ply", model), Unsupported);
  EXPECT_EQ(files(), 0);
}

// ---- Size ----

TEST_F(ModelFile, OfAHundredThousandTrianglesIsReadAtOnce) {
  write_model(folder / "w.obj", wave(250, 200));
  write_model(folder / "w.ply", wave(250, 200));
  for (const std::string name : {"w.obj", "w.ply"}) {
    const auto start = std::chrono::steady_clock::now();
    const Model model = read_model(folder / name);
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
    EXPECT_EQ(model.mesh.triangle_count(), 100000);
    RecordProperty(name, std::to_string(time.count()));
#ifdef NDEBUG
    EXPECT_LT(time.count(), 1) << name;
#endif
  }
}

}  // namespace
}  // namespace mq
