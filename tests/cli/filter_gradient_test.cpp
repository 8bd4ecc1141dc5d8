// Gradients of one's own: fields in files, and tables of differences.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "cli/models.h"

namespace mq::test {
namespace {

using testing::HasSubstr;
using Words = std::vector<std::string>;

class FilterGradient : public testing::Test {
 protected:
  void SetUp() override { write_strip(folder); }
  Result filter(Words more) const {
    Words words{"filter", "strip.obj", "-o", "out.exr", "--overwrite", "--depth", "float"};
    words.insert(words.end(), more.begin(), more.end());
    return marquetry(folder, words);
  }
  /// The red of the result at a texel.
  float at(int column, int row, int channel = 0) const { return read_texture(folder / "out.exr").pixels(column, row, channel); }
  void write_field(double x) const {
    std::string text = "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n"
                       "element face 4\nproperty list uchar int vertex_indices\nproperty double vx\nproperty double vy\n"
                       "property double vz\nend_header\n0 0 0\n1 0 0\n2 0 0\n0 1 0\n1 1 0\n2 1 0\n";
    for (const char* face : {"3 0 1 4", "3 0 4 3", "3 1 2 5", "3 1 5 4"}) text += fmt::format("{} {} 0 0\n", face, x);
    write_bytes(folder / "field.ply", text);
  }
  Folder folder;
};

/// With gradients alone the texture becomes a ramp over both charts, 2 long, of 0.1 a unit; its mean stays.
TEST_F(FilterGradient, MakesARampOverASeam) {
  write_field(0.1);
  const Result result = filter({"--gradient", "field.ply", "--alpha", "inf", "--tolerance", "1e-10"});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto place = [](int column) { return column < 32 ? ((column + 0.5) / 64 - 0.05) / 0.4 : 1 + ((column + 0.5) / 64 - 0.55) / 0.4; };
  for (const int column : {25, 38, 57})
    for (int channel = 0; channel < 3; ++channel)
      EXPECT_NEAR(at(column, 24, channel) - at(4, 24, channel), 0.1 * (place(column) - place(4)), 2e-5) << column;
  const float risen = at(57, 24) - at(4, 24);
  ASSERT_EQ(filter({"--gradient", "field.ply", "--alpha", "inf", "--gradient-scale", "-2", "--tolerance", "1e-10"}).status, 0);
  EXPECT_NEAR(at(57, 24) - at(4, 24), -2 * risen, 1e-5);
}

/// One field for each channel, and the texture's own gradients beside it.
TEST_F(FilterGradient, AddsToItsOwnGradientsChannelByChannel) {
  write_field(0);
  std::filesystem::rename(folder / "field.ply", folder / "none.ply");
  write_field(0.1);
  ASSERT_EQ(filter({"--gradient", "field.ply", "--gradient", "none.ply", "--gradient", "none.ply", "--beta", "1", "--alpha", "inf"}).status, 2)
      << "a field that is 0 everywhere";
  write_bytes(folder / "none.ply", file_bytes(folder / "field.ply"));
  ASSERT_EQ(filter({"--gradient", "field.ply", "--beta", "1", "--alpha", "inf", "--tolerance", "1e-10"}).status, 0);
  const Texture before = read_texture(folder / "strip.png");
  const auto change = [&](int column) { return double(at(column, 20)) - before.pixels(column, 20, 0); };
  for (const int column : {12, 20, 25})
    EXPECT_NEAR(change(column) - change(5), 0.1 * (column - 5) / 25.6, 2e-5) << "what was there stays, and a ramp comes to it";
}

/// A step that the table says is not there goes; without a name everything else keeps its own.
TEST_F(FilterGradient, TakesDifferencesFromATable) {
  Image<float> step(64, 48, 3);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x)
      for (int c = 0; c < 3; ++c) step(x, y, c) = x < 16 ? 0.25F : 0.75F;
  write_image(folder / "strip.png", step);
  std::string table = "column,row,to_column,to_row,value\n";
  for (int row = 4; row < 44; ++row)
    for (int next = std::max(4, row - 1); next <= std::min(43, row + 1); ++next) table += fmt::format("15,{},16,{},0\n", row, next);
  write_bytes(folder / "wanted.csv", table);
  const Result result = filter({"--gradient", "wanted.csv", "--alpha", "inf", "--tolerance", "1e-10"});
  ASSERT_EQ(result.status, 0) << result.error;
  const float left = at(10, 24), right = at(22, 24);
  EXPECT_NEAR(left, right, 0.01);
}

TEST_F(FilterGradient, IsRefusedWhereItDoesNotFit) {
  const auto expect_refusal = [](const Result& result, const std::string& why) {
    EXPECT_EQ(result.status, 2) << why;
    EXPECT_THAT(result.error, HasSubstr(why));
  };
  write_field(1);
  write_bytes(folder / "far.csv", "column,row,to_column,to_row,value\n10,20,14,20,0\n");
  expect_refusal(filter({"--gradient", "far.csv"}), "line 2: column 10, row 20 and column 14, row 20 are not next to each other");
  write_bytes(folder / "bad.csv", "1,2,3\n");
  expect_refusal(filter({"--gradient", "bad.csv"}), "bad.csv: line 1");
  expect_refusal(filter({"--gradient", "bad.csv", "--gradient", "far.csv"}), "give it alone");
  expect_refusal(filter({"--gradient", "missing.ply"}), "missing.ply");
  expect_refusal(filter({"--gradient", "field.ply", "--gradient", "field.ply"}), "given 2 times, wanted once, or once for each of 3 channels");
  expect_refusal(filter({"--gradient", "field.txt"}), "wanted a file .vf, .ply or .csv");
  expect_refusal(filter({"--gradient", "field.ply", "--strength", "50"}), "--strength");
  expect_refusal(filter({"--gradient", "field.ply", "--spot", "0,0,0,1"}), "--spot");
  expect_refusal(filter({"--gradient-scale", "2", "--beta", "0"}), "name one with --gradient");
  EXPECT_FALSE(std::filesystem::exists(folder / "out.exr"));
}

/// Fields of any length come back from .exr; 8 and 16 bits cut them, which is said.
TEST_F(FilterGradient, TakesMapsAsLongAsTheyAre) {
  write_field(3);
  const auto ramp = [&](const char* field) {
    const Result result = filter({"--gradient", field, "--gradient-scale", "0.01", "--alpha", "inf", "--tolerance", "1e-10"});
    EXPECT_EQ(result.status, 0) << result.error;
    EXPECT_EQ(result.error.find("have the length 1") != std::string::npos, std::string(field) == "map.png") << result.error;
    return at(25, 24) - at(4, 24);
  };
  for (const char* map : {"map.exr", "map.png"})
    ASSERT_EQ(marquetry(folder, {"fields", "strip.obj", "--field", "field.ply", "--strength", "kept", "-o", map}).status, 0);
  const float whole = ramp("field.ply");
  EXPECT_NEAR(whole, 0.03 * 21 / 25.6, 1e-4);
  EXPECT_NEAR(ramp("map.exr"), whole, 0.01 * whole);
  EXPECT_NEAR(ramp("map.png"), whole / 3, 0.01 * whole);
}

/// Colours of a table for pictures with alpha, which is none of them; several textures must be named.
TEST_F(FilterGradient, LeavesAlphaAlone) {
  write_image(folder / "strip.png", busy_picture(64, 48, 4));
  write_bytes(folder / "wanted.csv", "column,row,to_column,to_row,r,g,b\n15,20,16,20,0,0.1,0.2\n");
  ASSERT_EQ(filter({"--gradient", "wanted.csv", "--length", "3tx"}).status, 0);
  const Image<float> before = read_texture(folder / "strip.png").pixels;
  EXPECT_NE(at(15, 20, 1), before(15, 20, 1));
  EXPECT_EQ(at(15, 20, 3), before(15, 20, 3));
}

TEST_F(FilterGradient, WorksOnColoursAtVertices) {
  write_bytes(folder / "fan.ply", coloured_ply);
  write_bytes(folder / "wanted.csv", "vertex,to_vertex,value\n0,1,0\n0,2,0\n0,3,0\n0,4,0\n");
  const Result result = marquetry(folder, {"filter", "fan.ply", "-o", "out.ply", "--gradient", "wanted.csv", "--alpha", "inf"});
  ASSERT_EQ(result.status, 0) << result.error;
  const VertexSignal colours = read_model(folder / "out.ply").colors;
  EXPECT_NEAR(colours.values[0], colours.values[3], 1.1 / 255);
}

}  // namespace
}  // namespace mq::test
