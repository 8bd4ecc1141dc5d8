// marquetry shock, run as a user runs it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "cli/models.h"
#include "mq/base/memory.h"
#include "mq/fem/image_space.h"
#include "mq/io/vector_field.h"

namespace mq::test {
namespace {

using ::testing::HasSubstr;
using Words = std::vector<std::string>;

/// A blurred step from dark to bright, as wide as the picture.
Image<float> blurred_step(int width, int height, int channels = 3) {
  Image<float> image(width, height, channels);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (float& value : image.pixel(x, y))
        value = float(0.5 + 0.4 * std::tanh((y - 0.47 * height) / 5));
  return image;
}

int grey_rows(const Image<float>& image, int column) {
  int count = 0;
  for (int y = 0; y < image.height(); ++y)
    count += image(column, y) > 0.2F && image(column, y) < 0.8F;
  return count;
}

float steepest(const Image<float>& image, int column) {
  float most = 0;
  for (int y = 1; y < image.height(); ++y)
    most = std::max(most, std::abs(image(column, y) - image(column, y - 1)));
  return most;
}

TEST(Shock, SharpensPicturesOfAnyDepth) {
  const Folder folder;
  for (const auto& [name, depth] :
       {std::pair("a.png", Depth::u8), std::pair("b.png", Depth::u16),
        std::pair("c.exr", Depth::f32), std::pair("d.tif", Depth::f32)}) {
    write_image(folder / name, blurred_step(40, 60, 4), depth);
    const std::string out = std::string("sharp_") + name;
    const Result result = marquetry(folder, {"shock", name, "-o", out, "-t", "3", "--json"});
    ASSERT_EQ(result.status, 0) << result.error;
    const Texture before = read_texture(folder / name), after = read_texture(folder / out);
    EXPECT_EQ(after.format.depth, depth);
    EXPECT_EQ(after.pixels.channels(), 4);
    EXPECT_LT(grey_rows(after.pixels, 20), 0.6 * grey_rows(before.pixels, 20));
    const auto range = std::ranges::minmax(before.pixels.values());
    const auto now = std::ranges::minmax(after.pixels.values());
    EXPECT_GE(now.min, range.min);
    EXPECT_LE(now.max, range.max);
    EXPECT_EQ(result.json()["result"]["paths"]["count"], 2400);
    EXPECT_EQ(result.json()["result"]["paths"]["cut_short"], 0);
  }
}

TEST(Shock, KnowsTheOtherMethods) {
  const Folder folder;
  write_image(folder / "a.png", blurred_step(40, 60));
  const float before = steepest(read_texture(folder / "a.png").pixels, 20);
  for (const std::string method : {"composed", "iterated", "osher-rudin"})
    for (const std::string concavity : {"along-gradient", "laplacian"}) {
      std::vector<std::string> words = {"shock", "a.png", "-o", "o.png", "--method", method,
                                        "--concavity", concavity, "-t", "3"};
      if (method != "osher-rudin") words.insert(words.end(), {"--steps", "5"});
      const Result result = marquetry(folder, words);
      ASSERT_EQ(result.status, 0) << result.error;
      EXPECT_GT(steepest(read_texture(folder / "o.png").pixels, 20), 3 * before) << method;
    }
}

TEST(Shock, SaysBeforehandHowManyStepsTheExplicitSchemeTakes) {
  const Folder folder;
  write_image(folder / "a.png", blurred_step(40, 60));
  const Result result = marquetry(
      folder, {"shock", "a.png", "-o", "o.png", "--method", "osher-rudin", "-t", "3", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_THAT(result.error, HasSubstr("osher-rudin takes about"));
  const auto found = result.json()["result"];
  EXPECT_LE(found["steps"].get<double>(), 2 * found["expected_steps"].get<double>());
  EXPECT_GE(found["steps"].get<double>(), 0.5 * found["expected_steps"].get<double>());
  // A time without end is none: it comes to rest.
  const Result rested = marquetry(
      folder, {"shock", "a.png", "-o", "p.png", "--method", "osher-rudin", "-t", "1e6", "--json"});
  ASSERT_EQ(rested.status, 0) << rested.error;
  EXPECT_LT(rested.json()["result"]["steps"].get<double>(), 50'000);
  EXPECT_THAT(rested.error, testing::Not(HasSubstr("with 100")));
}

TEST(Shock, SharpensTexturesAcrossTheirSeam) {
  const Folder folder;
  write_strip(folder);
  write_image(folder / "step.png", blurred_step(64, 48));
  const Result result =
      marquetry(folder, {"shock", "strip.obj", "step.png", "-o", "sharp.png", "-t", "3", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  const Image<float> before = read_texture(folder / "step.png").pixels;
  const Image<float> after = read_texture(folder / "sharp.png").pixels;
  for (const int column : {10, 27, 37, 55})
    EXPECT_LT(grey_rows(after, column), 0.6 * grey_rows(before, column));
  // The texels on the two sides of the seam show the same.
  for (int y = 8; y < 40; ++y) EXPECT_NEAR(after(28, y), after(35, y), 0.03);
  // Texels outside charts stay.
  for (int x = 0; x < 64; ++x) EXPECT_EQ(after(x, 0), before(x, 0));
  EXPECT_EQ(result.json()["result"]["paths"]["count"], result.json()["result"]["unknowns"]);
}

/// A blurred step in colours at the vertices of a flat sheet.
void write_sheet(const Folder& folder) {
  std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 1681\nproperty float x\nproperty float y\n"
      "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
      "element face 3200\nproperty list uchar int vertex_indices\nend_header\n";
  for (int j = 0; j <= 40; ++j)
    for (int i = 0; i <= 40; ++i) {
      const std::string grey = std::to_string(int(128 + 100 * std::tanh((i - 19.3) / 5)));
      ply += std::to_string(i) + " " + std::to_string(j) + " 0 " + grey + " " + grey + " 7\n";
    }
  for (int j = 0; j < 40; ++j)
    for (int i = 0; i < 40; ++i) {
      const int v = 41 * j + i;
      for (const auto& [a, b, c] : {std::array{v, v + 1, v + 42}, std::array{v, v + 42, v + 41}})
        ply += "3 " + std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(c) + "\n";
    }
  write_bytes(folder / "sheet.ply", ply);
}

TEST(Shock, SharpensColoursAtVertices) {
  const Folder folder;
  write_sheet(folder);
  const Result result = marquetry(folder, {"shock", "sheet.ply", "-o", "sharp.ply", "-t", "3"});
  ASSERT_EQ(result.status, 0) << result.error;
  const Model before = read_model(folder / "sheet.ply"), after = read_model(folder / "sharp.ply");
  const auto greys = [](const Model& model) {
    int count = 0;
    for (std::size_t v = 0; v < 1681; ++v)
      count += model.colors.values[3 * v] > 0.25F && model.colors.values[3 * v] < 0.75F;
    return count;
  };
  EXPECT_LT(greys(after), 0.6 * greys(before));
  for (std::size_t v = 0; v < 1681; ++v)
    EXPECT_EQ(after.colors.values[3 * v + 2], before.colors.values[3 * v + 2]);
  EXPECT_EQ(marquetry(folder, {"shock", "sheet.ply", "-o", "sharp.png"}).status, 2);
}

TEST(Shock, PutsPicturesIntoAGlb) {
  const Folder folder;
  write_strip(folder);
  const Result result =
      marquetry(folder, {"shock", "strip.obj", "-o", "sharp.glb", "-t", "3", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.json()["result"]["outputs"].dump(), R"(["sharp.glb"])");
  EXPECT_EQ(folder.names(),
            (std::vector<std::string>{"sharp.glb", "strip.mtl", "strip.obj", "strip.png"}));
  ASSERT_EQ(marquetry(folder, {"shock", "strip.obj", "-o", "sharp.png", "-t", "3"}).status, 0);
  const Model glb = read_model(folder / "sharp.glb");
  ASSERT_EQ(glb.textures.size(), 1U);
  EXPECT_EQ(glb.textures[0].pixels, read_texture(folder / "sharp.png").pixels);
  // Once more from the GLB: at time 0 it comes back as it is.
  ASSERT_EQ(marquetry(folder, {"shock", "sharp.glb", "-o", "same.glb", "-t", "0"}).status, 0);
  EXPECT_EQ(file_bytes(folder / "same.glb"), file_bytes(folder / "sharp.glb"));
}

TEST(Shock, GivesTheSameBitsForAnyNumberOfThreads) {
  const Folder folder;
  write_strip(folder);
  for (const std::string input : {"strip.png", "strip.obj"}) {
    for (const std::string threads : {"1", "2", "7"})
      ASSERT_EQ(
          marquetry(folder, {"shock", input, "-o", "o" + threads + ".png", "--threads", threads})
              .status,
          0);
    EXPECT_EQ(file_bytes(folder / "o2.png"), file_bytes(folder / "o1.png"));
    EXPECT_EQ(file_bytes(folder / "o7.png"), file_bytes(folder / "o1.png"));
    EXPECT_NE(file_bytes(folder / "o1.png"), file_bytes(folder / "strip.png"));
  }
}

TEST(Shock, StopsWhenAskedTo) {
  const Folder folder;
  write_strip(folder, 1500, 1100);
  const Result result = marquetry(folder, {"shock", "strip.obj", "-o", "o.png", "--time", "1e9"},
                                  {.interrupt_at = {"smooth"}});
  EXPECT_EQ(result.status, 130) << result.error;
  EXPECT_EQ(folder.names(), (std::vector<std::string>{"strip.mtl", "strip.obj", "strip.png"}));
}

TEST(Shock, RefusesWhatDoesNotFit) {
  const Folder folder;
  write_strip(folder);
  const auto error = [&](std::vector<std::string> words) {
    words.insert(words.begin(), "shock");
    const Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 2) << result.error;
    return result.error;
  };
  EXPECT_THAT(error({"strip.png", "strip.png", "-o", "o.png"}),
              HasSubstr("strip.png: is a picture"));
  EXPECT_THAT(error({"strip.png", "-o", "o.obj"}), HasSubstr("wanted a picture"));
  EXPECT_THAT(error({"strip.png", "-o", "strip.png"}), HasSubstr("strip.png"));
  EXPECT_THAT(error({"strip.png", "--vertices", "-o", "o.png"}),
              HasSubstr("--vertices is for models"));
  EXPECT_THAT(error({"strip.obj", "--method", "composed", "-o", "o.png"}),
              HasSubstr("--method is for pictures"));
  EXPECT_THAT(error({"strip.png", "--steps", "9", "-o", "o.png"}),
              HasSubstr("--steps is for --method composed and iterated"));
  for (const char* model : {"strip.png", "strip.obj"})
    EXPECT_THAT(error({model, "--fit-weight", "7", "-o", "o.png"}),
                HasSubstr("--fit-weight is for shapes"));
  for (const char* model : {"strip.png", "strip.obj"})
    EXPECT_THAT(error({model, "--smooth-normals", "1%", "-o", "o.png"}),
                HasSubstr("--smooth-normals is for shapes"));
  EXPECT_THAT(error({"strip.png", "--geometry", "-o", "o.png"}),
              HasSubstr("strip.png: is a picture and has no shape"));
  const auto coloured = [](const std::string& red) {
    return "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
           "property float z\nproperty float red\nproperty float green\nproperty float blue\n"
           "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
           "0 0 0 0.1 0 0\n1 0 0 " + red + " 0 0\n0 1 0 0.5 0 0\n3 0 1 2\n";
  };
  write_bytes(folder / "vc.ply", coloured("0.2"));
  write_bytes(folder / "nan.ply", coloured("nan"));
  EXPECT_THAT(error({"vc.ply", "strip.png", "-o", "o.ply"}),
              HasSubstr("vc.ply: its colours at vertices are what is processed, and 'strip.png'"));
  EXPECT_THAT(error({"nan.ply", "-o", "o.ply"}), HasSubstr("nan.ply: channel 0 of the colour of vertex 1"));
  EXPECT_THAT(error({"missing.png", "-o", "o.png"}), HasSubstr("missing.png"));
  EXPECT_THAT(error({"strip.obj", "--time", "-1", "-o", "o.png"}), HasSubstr("--time"));
  EXPECT_THAT(error({"strip.obj", "--time", "1", "--absolute-time", "1", "-o", "o.png"}),
              HasSubstr("--absolute-time"));
  write_bytes(folder / "broken.png", "no picture");
  EXPECT_THAT(error({"broken.png", "-o", "o.png"}), HasSubstr("broken.png"));
}

TEST(Shock, SaysHowManyExtremaTheExplicitSchemeAsPrintedPasses) {
  const Folder folder;
  write_image(folder / "a.png", busy_picture(40, 30));
  const auto extrema = [&](const std::string& method) {
    const Result result =
        marquetry(folder, {"shock", "a.png", "-o", "o.png", "--method", method, "--overwrite", "--json"});
    EXPECT_EQ(result.status, 0) << result.error;
    return result.json()["result"]["extrema"];
  };
  const auto bounded = extrema("osher-rudin"), printed = extrema("osher-rudin-as-printed");
  EXPECT_EQ(bounded["count"], printed["count"]);
  EXPECT_EQ(bounded["passed"], 0);
  EXPECT_GT(printed["passed"].get<int>(), 0);
}

/// A parabola of values, φ = ½kx², whose potential is ½k²(x² + ¼) where nothing is smoothed.
constexpr double parabola_k = 1.0 / 800;

void write_parabola(const Folder& folder) {
  Image<float> image(40, 30, 1);
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 40; ++x) image(x, y) = float(0.5 * parabola_k * x * x);
  write_image(folder / "q.exr", image, Depth::f32);
}

TEST(ShockOutputs, OfAPictureAreItsPotentialAndMinusItsGradient) {
  const Folder folder;
  write_parabola(folder);
  const Words words = {"shock", "q.exr", "-o", "o.exr", "--smooth", "0", "--smooth-potential", "0"};
  const auto with = [&](const Words& more) {
    Words all = words;
    all.insert(all.end(), more.begin(), more.end());
    return marquetry(folder, all);
  };
  const Result result = with({"--write-potential", "p.exr", "--write-field", "f.ply", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.json()["result"]["outputs"].dump(), R"(["o.exr","p.exr","f.ply"])");
  const Image<float> P = read_texture(folder / "p.exr").pixels;
  const double k2 = parabola_k * parabola_k;
  for (int y = 0; y < 30; ++y)
    for (int x = 1; x < 39; ++x) EXPECT_NEAR(P(x, y), 0.5 * k2 * (x * x + 0.25), 1e-5 * k2 * 1600);
  EXPECT_NEAR(result.json()["result"]["potential"]["largest"].get<double>(),
              *std::ranges::max_element(P.values()), 1e-9);
  // −dP/dx = −k²x in the pixel's square, from x − ½ to x + ½: two triangles each.
  const Mesh squares = image_rectangle(40, 30, ImageTriangles::per_pixel);
  const VectorField field = read_vector_field(folder / "f.ply", squares);
  int inner = 0;
  for (int t = 0; t < squares.triangle_count(); ++t) {
    const int x = t / 2 % 40;
    if (x < 3 || x > 36) continue;
    ++inner;
    const Vector3& X = field.vectors[std::size_t(t)];
    EXPECT_NEAR(X.x(), -0.5 * (double(P(x + 1, 5)) - P(x - 1, 5)), 0.3 * k2) << x;
    EXPECT_NEAR(X.y(), 0, 1e-6 * k2);
  }
  EXPECT_EQ(inner, 2 * 34 * 30);
  // What is written is what lic reads, and the result is what it was without.
  EXPECT_EQ(marquetry(folder, {"lic", "q.exr", "--field", "f.ply", "--over", "nothing", "-o", "l.png"}).status, 0);
  ASSERT_EQ(with({"--write-potential", "p.png", "--write-field", "m.png", "--overwrite"}).status, 0);
  EXPECT_EQ(marquetry(folder, {"lic", "q.exr", "--field", "m.png", "--by", "paths", "--over", "nothing", "-o", "n.png"})
                .status,
            0);
  const Image<float> map = read_texture(folder / "m.png").pixels, colours = read_texture(folder / "p.png").pixels;
  EXPECT_EQ(colours.channels(), 3);
  EXPECT_GT(colours(38, 9, 1), colours(3, 9, 1) + 0.5F) << "bright where edges are strong";
  EXPECT_LT(map(30, 9, 0), 0.01F) << "to the left";
  EXPECT_NEAR(map(30, 9, 1), 0.5F, 0.01F);
  EXPECT_GT(map(30, 9, 2), 1.5F * map(15, 9, 2));
  const auto sharp = file_bytes(folder / "o.exr");
  ASSERT_EQ(with({"--overwrite"}).status, 0);
  EXPECT_EQ(file_bytes(folder / "o.exr"), sharp);
}

TEST(ShockOutputs, OfATextureAreReadBackByLic) {
  const Folder folder;
  write_strip(folder);
  const Result result = marquetry(folder, {"shock", "strip.obj", "-o", "sharp.obj", "--write-potential", "p.tif",
                                           "--write-field", "f.vf", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  const Model strip = read_model(folder / "strip.obj");
  const Image<float> P = read_texture(folder / "p.tif").pixels;
  EXPECT_EQ(P.channels(), 1);
  EXPECT_EQ(P.width(), strip.textures.front().pixels.width());
  EXPECT_EQ(read_vector_field(folder / "f.vf", strip.mesh).vectors.size(), std::size_t(strip.mesh.triangle_count()));
  EXPECT_EQ(marquetry(folder, {"lic", "strip.obj", "--field", "f.vf", "-o", "l.png"}).status, 0);
  // Frames have files of their own.
  ASSERT_EQ(marquetry(folder, {"shock", "strip.obj", "-o", "s_%d.png", "--write-field", "m_%d.png", "--frames", "1-2"})
                .status,
            0);
  EXPECT_TRUE(file_bytes(folder / "m_1.png") == file_bytes(folder / "m_2.png"));
}

/// P and its colours from such a file: three doubles, one more and three bytes per vertex.
std::vector<double> potential_in(const std::string& bytes, int count) {
  const std::size_t begin = bytes.find("end_header\n") + 11;
  std::vector<double> values;
  for (int v = 0; v < count; ++v) {
    double value = 0;
    std::memcpy(&value, bytes.data() + begin + std::size_t(v) * 35 + 24, 8);
    values.push_back(value);
  }
  return values;
}

TEST(ShockOutputs, AtVerticesAndOfShapesAreMinusTheGradientTriangleByTriangle) {
  const Folder folder;
  write_sheet(folder);
  ASSERT_EQ(marquetry(folder, {"sample", "sphere", "--size", "64", "-o", "s/"}).status, 0);
  for (const Words& words : {Words{"shock", "sheet.ply", "-o", "o.ply"},
                             Words{"shock", "s/sphere.obj", "--geometry", "-o", "o.obj"}}) {
    Words all = words;
    for (const char* word : {"--write-potential", "p.ply", "--write-field", "f.ply", "--overwrite"})
      all.emplace_back(word);
    const Result result = marquetry(folder, all);
    ASSERT_EQ(result.status, 0) << result.error;
    const Model model = read_model(folder / words[1]);
    const std::vector<double> P = potential_in(file_bytes(folder / "p.ply"), model.mesh.vertex_count());
    EXPECT_EQ(read_model(folder / "p.ply").colors.channels, 3);
    const VectorField field = read_vector_field(folder / "f.ply", model.mesh);
    double steepest = 0;
    for (int t = 0; t < model.mesh.triangle_count(); ++t) {
      // Along an edge the field is what P falls by.
      const Triangle& v = model.mesh.triangles[std::size_t(t)];
      for (int k = 0; k < 3; ++k) {
        const Vector3 edge = model.mesh.position(t, (k + 1) % 3) - model.mesh.position(t, k);
        const double fall = P[std::size_t(v[k])] - P[std::size_t(v[(k + 1) % 3])];
        steepest = std::max(steepest, std::abs(fall));
        EXPECT_NEAR(field.vectors[std::size_t(t)].dot(edge), fall, 1e-9 * (1 + std::abs(P[std::size_t(v[k])])));
      }
    }
    EXPECT_GT(steepest, 1e-6);
  }
}

TEST(ShockOutputs, AreRefusedWhereTheyCannotBe) {
  const Folder folder;
  write_strip(folder);
  write_bytes(folder / "fan.ply", coloured_ply);
  const auto before = folder.names();
  const auto error = [&](std::vector<std::string> words) {
    words.insert(words.begin(), "shock");
    const Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 2) << result.error;
    return result.error;
  };
  EXPECT_THAT(error({"strip.png", "-o", "o.png", "--method", "composed", "--write-potential", "p.png"}),
              HasSubstr("--write-potential: there is one for --method transport"));
  EXPECT_THAT(error({"strip.png", "-o", "o.png", "--concavity", "laplacian", "--write-field", "f.ply"}),
              HasSubstr("--write-field: there is one for"));
  EXPECT_THAT(error({"strip.png", "-o", "o.png", "--write-field", "f.obj"}),
              HasSubstr("wanted .ply, .vf or a picture"));
  EXPECT_THAT(error({"strip.obj", "-o", "o.png", "--write-potential", "p.ply"}), HasSubstr("wanted a picture"));
  EXPECT_THAT(error({"fan.ply", "-o", "o.ply", "--write-potential", "p.png"}), HasSubstr("wanted .ply"));
  EXPECT_THAT(error({"fan.ply", "-o", "o.ply", "--write-field", "f.png"}), HasSubstr("wanted .ply or .vf"));
  EXPECT_THAT(error({"fan.ply", "-o", "o.ply", "--write-field", "o.ply"}), HasSubstr("would be written twice"));
  EXPECT_THAT(error({"strip.obj", "-o", "o.png", "--write-field", "strip.png"}), HasSubstr("strip.png"));
  EXPECT_EQ(folder.names(), before);
}

}  // namespace
}  // namespace mq::test
