// marquetry spectrum, run as a user runs it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/models.h"
#include "mq/io/vector_field.h"

namespace mq::test {
namespace {

using ::testing::HasSubstr;

TEST(SpectrumOfFields, FindsTwoZerosPerHandleInTheWhitneyBasisAlone) {
  const Folder folder;
  ASSERT_EQ(marquetry(folder, {"sample", "torus", "--size", "64", "-o", "t/"}).status, 0);
  const auto before = folder.names();
  for (const std::string basis : {"triangle", "gradient", "whitney", "vertex", "texel"}) {
    const Result result =
        marquetry(folder, {"spectrum", "t/torus.obj", "--basis", basis, "-k", "6", "--json"});
    ASSERT_EQ(result.status, 0) << result.error;
    const auto found = result.json()["result"];
    EXPECT_EQ(found["eigenvalues"].size(), 6U);
    EXPECT_EQ(found["zeros"], basis == "whitney" ? 2 : 0) << basis;
    EXPECT_GT(found["eigenvalues_at_area_1"][5].get<double>(), 1);
  }
  EXPECT_EQ(folder.names(), before);
  const Result said = marquetry(folder, {"spectrum", "t/torus.obj", "-k", "3"});
  EXPECT_THAT(said.output, HasSubstr("at area 1"));
}

TEST(SpectrumOfFields, WritesFieldsThatLicTakesAndDrawsThem) {
  const Folder folder;
  write_strip(folder);
  const Result result = marquetry(folder, {"spectrum", "strip.obj", "-k", "2", "-b", "triangle",
                                           "-o", "fields/", "--lines", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  const Model strip = read_model(folder / "strip.obj");
  const VectorField field = read_vector_field(folder / "fields/strip_triangle_01.ply", strip.mesh);
  EXPECT_EQ(field.at, VectorField::At::triangles);
  EXPECT_EQ(result.json()["result"]["outputs"].size(), 4U);
  const Texture drawn = read_texture(folder / "fields/strip_triangle_02.png");
  EXPECT_EQ(drawn.pixels.width(), strip.textures.front().pixels.width());
  const auto range = std::ranges::minmax(drawn.pixels.values());
  EXPECT_GT(range.max - range.min, 0.5F);
  EXPECT_EQ(marquetry(folder, {"lic", "strip.obj", "--field", "fields/strip_triangle_01.ply", "-o",
                               "l.png"})
                .status,
            0);
  ASSERT_EQ(marquetry(folder, {"spectrum", "strip.obj", "-k", "2", "-b", "triangle", "-o", "v/",
                               "--lines", "--vertices"})
                .status,
            0);
  EXPECT_EQ(read_model(folder / "v/strip_triangle_01_lines.ply").colors.channels, 3);
}

TEST(SpectrumOfFields, IsRepeatedFromItsReportWithAnyNumberOfThreads) {
  const Folder folder;
  ASSERT_EQ(marquetry(folder, {"sample", "torus", "--size", "64", "-o", "t/"}).status, 0);
  ASSERT_EQ(marquetry(folder, {"spectrum", "t/torus.obj", "-k", "4", "-o", "a/", "--report",
                               "r.json", "--threads", "1"})
                .status,
            0);
  const Result again =
      marquetry(folder, {"spectrum", "--config", "r.json", "-o", "b/", "--threads", "7"});
  ASSERT_EQ(again.status, 0) << again.error;
  EXPECT_EQ(file_bytes(folder / "a/torus_whitney_04.ply"),
            file_bytes(folder / "b/torus_whitney_04.ply"));
}

/// Two triangles over an edge of length 2, each of this height: with ½ the weight 2/(cot α + cot β) is −4/3 and the
/// areas are ½ each, so that the fields that differ most have 2·(−4/3)/½.
std::string kite_obj(const std::string& height) {
  return "v -1 0 0\nv 1 0 0\nv 0 " + height + " 0\nv 0 -" + height + " 0\nf 1 2 3\nf 2 1 4\n";
}

TEST(SpectrumOfFields, SaysHowManyWeightsAreNegativeAsPrinted) {
  const Folder folder;
  write_bytes(folder / "obtuse.obj", kite_obj("0.5"));
  write_bytes(folder / "circle.obj", kite_obj("1"));
  const auto run = [&](const std::string& mesh, const std::string& dual) {
    return marquetry(folder, {"spectrum", mesh, "-b", "triangle", "--dual", dual, "-k", "4", "--json"});
  };
  const Result printed = run("obtuse.obj", "circumcentric-as-printed");
  ASSERT_EQ(printed.status, 0) << printed.error;
  EXPECT_THAT(printed.error, HasSubstr("1 edge is not Delaunay"));
  const auto found = printed.json()["result"];
  EXPECT_EQ(found["negative_weights"], 1);
  const double expected[] = {-16.0 / 3, -16.0 / 3, 0, 0};
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(found["eigenvalues"][std::size_t(k)].get<double>(), expected[k], 1e-9);
  const Result delaunay = run("obtuse.obj", "circumcentric");
  ASSERT_EQ(delaunay.status, 0) << delaunay.error;
  EXPECT_EQ(delaunay.json()["result"]["negative_weights"], 0);
  EXPECT_EQ(delaunay.json()["result"]["zeros"], 2);
  EXPECT_GT(delaunay.json()["result"]["eigenvalues"][2].get<double>(), 0.1);
  const Result infinite = run("circle.obj", "circumcentric-as-printed");
  EXPECT_EQ(infinite.status, 2);
  EXPECT_THAT(infinite.error, HasSubstr("circle.obj: 1 of 1 edges lie between two triangles on one circle"));
}

TEST(SpectrumOfFields, LeavesOutWhatHasNoMassInOnePoint) {
  const Folder folder;
  write_bytes(folder / "square.obj", kite_obj("1"));
  const auto found = [&](const std::string& mass, const std::string& count) {
    return marquetry(folder, {"spectrum", "square.obj", "--mass", mass, "-k", count, "--json"});
  };
  const Result one = found("one-point", "4"), exact = found("exact", "5");
  ASSERT_EQ(one.status, 0) << one.error;
  ASSERT_EQ(exact.status, 0) << exact.error;
  EXPECT_THAT(one.error, HasSubstr("1 field rotates about the middles of all triangles and has no mass"));
  EXPECT_EQ(one.json()["result"]["massless_fields"], 1);
  EXPECT_EQ(one.json()["result"]["unknowns"], 4);
  EXPECT_EQ(exact.json()["result"]["massless_fields"], 0);
  EXPECT_EQ(exact.json()["result"]["unknowns"], 5);
  EXPECT_EQ(found("one-point", "5").status, 2);
}

TEST(SpectrumOfFields, RefusesWhatDoesNotFit) {
  const Folder folder;
  write_strip(folder);
  const auto error = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"spectrum", "strip.obj"});
    const Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 2) << result.error;
    return result.error;
  };
  EXPECT_THAT(error({"--lines"}), HasSubstr("--output"));
  EXPECT_THAT(error({"-k", "900"}), HasSubstr("strip.obj: 900 eigenvalues were asked for"));
  EXPECT_THAT(error({"-k", "0"}), HasSubstr("--count"));
  EXPECT_THAT(error({"--basis", "edges"}), HasSubstr("--basis"));
  EXPECT_THAT(error({"--dual", "barycentric"}), HasSubstr("--dual is for --basis triangle"));
  EXPECT_THAT(error({"--dual", "circumcentric-as-printed"}), HasSubstr("--dual is for --basis triangle"));
  EXPECT_THAT(error({"--basis", "vertex", "--mass", "one-point"}), HasSubstr("--mass is for --basis whitney"));
  write_bytes(folder / "line.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
  const Result flat = marquetry(folder, {"spectrum", "line.obj"});
  EXPECT_EQ(flat.status, 2);
  EXPECT_THAT(flat.error, HasSubstr("line.obj: the surface has no area"));
}

}  // namespace
}  // namespace mq::test
