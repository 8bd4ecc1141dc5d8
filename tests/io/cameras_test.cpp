// Cameras as files.
#include "mq/io/cameras.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fixtures.h"
#include "io/folder.h"
#include "mq/base/error.h"

namespace mq {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using Cameras = FolderTest;

const char* const cameras_txt =
    "# Camera list\n1 OPENCV 640 480 500 510 320 240 0.1 -0.2 0.001 0.002\n"
    "2 SIMPLE_RADIAL 100 80 90 50 40 -0.05\n";
const char* const images_txt =
    "# Image list\n1 0.7071067811865476 0 0.7071067811865476 0 1 2 3 1 first one.jpg\n"
    "10 20 5 11 21 -1\n2 1 0 0 0 0 0 4 2 second.png\n\n";

TEST_F(Cameras, OfColmapsTextExport) {
  put("cameras.txt", cameras_txt);
  put("images.txt", images_txt);
  put("first one.jpg", "x");
  put("images/second.png", "x");
  for (const auto& path : {folder / "", folder / "images.txt", folder / "cameras.txt"}) {
    const std::vector<Photograph> photographs = read_cameras(path);
    ASSERT_EQ(photographs.size(), 2U);
    const PinholeCamera& first = photographs[0].camera;
    EXPECT_EQ(photographs[0].picture.filename(), "first one.jpg");
    EXPECT_EQ(first.fy, 510);
    EXPECT_EQ(first.cx, 320);
    EXPECT_EQ(first.lens.k2, -0.2);
    EXPECT_EQ(first.lens.p2, 0.002);
    EXPECT_LT((first.rotation * Vector3(1, 0, 0) - Vector3(0, 0, -1)).norm(), 1e-12);
    EXPECT_EQ(first.translation, Vector3(1, 2, 3));
    EXPECT_EQ(photographs[1].camera.fx, 90);
    EXPECT_EQ(photographs[1].camera.fy, 90);
    EXPECT_EQ(photographs[1].camera.lens.k1, -0.05);
  }
}

TEST_F(Cameras, AreFoundInAProjectOfColmapsAsItLies) {
  put("project/sparse/0/cameras.txt", cameras_txt);
  put("project/sparse/0/images.txt", images_txt);
  put("project/images/first one.jpg", "x");
  put("project/images/second.png", "x");
  put("dense/sparse/cameras.txt", cameras_txt);
  put("dense/sparse/images.txt", images_txt);
  put("dense/images/first one.jpg", "1");
  put("dense/images/second.png", "2");
  for (const char* path : {"project", "project/", "project/sparse/0", "project/sparse/0/",
                           "project/sparse/0/cameras.txt", "dense", "dense/sparse", "dense/sparse/",
                           "dense/sparse/images.txt"}) {
    const std::vector<Photograph> photographs = read_cameras(folder / path);
    ASSERT_EQ(photographs.size(), 2U) << path;
    const auto images = folder / *std::filesystem::path(path).begin() / "images";
    EXPECT_TRUE(std::filesystem::equivalent(photographs[0].picture, images / "first one.jpg"))
        << path;
    EXPECT_TRUE(std::filesystem::equivalent(photographs[1].picture, images / "second.png")) << path;
  }
}

TEST_F(Cameras, AreWantedInAFolder) {
  put("empty/x.txt", "x");
  EXPECT_THAT(fixtures::error_of<IoError>([&] { read_cameras(folder / "empty"); }),
              AllOf(HasSubstr("has no cameras.txt"), HasSubstr("transforms.json")));
}

TEST_F(Cameras, ComeBackAsTheyWereWritten) {
  put("a.png", "x");
  PinholeCamera camera{.width = 10, .height = 20, .fx = 3.25, .fy = 4, .cx = 5.1, .cy = 9};
  camera.lens = {.projection = Lens::Projection::equisolid, .k1 = 0.1, .k3 = 1e-3, .p1 = -0.02};
  camera.skew = 0.125;
  camera.rotation << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  camera.translation = {1e-7, -2, 3};
  write_cameras(folder / "c.json", {{"a.png", camera}});
  const PinholeCamera back = read_cameras(folder / "c.json").at(0).camera;
  EXPECT_EQ(back.fx, camera.fx);
  EXPECT_EQ(back.lens, camera.lens);
  EXPECT_EQ(back.skew, camera.skew);
  EXPECT_EQ(back.rotation, camera.rotation);
  EXPECT_EQ(back.translation, camera.translation);
}

TEST_F(Cameras, AreRefusedWithTheirPlace) {
  put("a.png", "x");
  const auto json = [&](const std::string& text) {
    put("c.json", text);
    return fixtures::error_of<Error>([&] { read_cameras(folder / "c.json"); });
  };
  const std::string head = R"({"cameras":[{"image":"a.png","width":9,"height":9,"fx":5,)";
  EXPECT_THAT(json("{\n  \"cameras\" [\n"),
              HasSubstr("c.json, line 2, column 13: not JSON from here on"));
  EXPECT_THAT(json("[]"), HasSubstr("c.json, line 1, column 1: found a list of 0, wanted"));
  EXPECT_THAT(json("{}"), HasSubstr("found no \"cameras\", wanted a list of objects there"));
  EXPECT_THAT(json("{\"cameras\": [3]}"), HasSubstr("column 14: cameras[0]: found 3, wanted"));
  EXPECT_THAT(json("{\"cameras\": [{\"width\": 9, \"height\": 9,\n\"fx\": \"5\"}]}"),
              HasSubstr("c.json, line 2, column 7: cameras[0].fx: found \"5\", wanted a number"));
  EXPECT_THAT(json("{\"cameras\": [{\"width\": 9.5}]}"),
              HasSubstr("cameras[0].width: found 9.5, wanted a whole number"));
  EXPECT_THAT(json("{\"cameras\": [{\"width\": 1e999}]}"),
              HasSubstr("line 1, column 24: found a number too large"));
  EXPECT_THAT(json("{\"cameras\":[]}"), HasSubstr("holds no camera"));
  EXPECT_THAT(
      json(head + "\"rotation\":[[1,0,0],[0,1,0],[0,0,1]]}]}"),
      HasSubstr(
          "c.json, line 1, column 13: cameras[0]: found no \"translation\", wanted 3 numbers"));
  EXPECT_THAT(json(head + "\"rotation\":[[1,0,0],[0,1],[0,0,1]]}]}"),
              HasSubstr("cameras[0].rotation[1]: found a list of 2, wanted a row of 3 numbers"));
  EXPECT_THAT(json(head + "\"rotation\":[[2,0,0],[0,1,0],[0,0,1]],\"translation\":[0,0,0]}]}"),
              HasSubstr("no rotation"));
  EXPECT_THAT(
      json(
          R"({"cameras":[{"image":"b.png","width":9,"height":9,"fx":5,"quaternion":[1,0,0,0],"translation":[0,0,0]}]})"),
      HasSubstr("of 1 picture 1 is not there: b.png; looked in "));
  const auto colmap = [&](const std::string& cameras, const std::string& images) {
    put("cameras.txt", cameras);
    put("images.txt", images);
    return fixtures::error_of<Error>([&] { read_cameras(folder / "images.txt"); });
  };
  EXPECT_THAT(colmap("1 WIDE 9 9 1 1 1\n", ""), HasSubstr("the lens 'WIDE'"));
  EXPECT_THAT(colmap("1 PINHOLE 9 9 1 x 1 1\n", ""), HasSubstr("cameras.txt, line 1: word 6"));
  EXPECT_THAT(colmap("1 PINHOLE 9 9 1 1 1 1\n", "1 1 0 0\n\n"), HasSubstr("images.txt, line 1"));
  EXPECT_THAT(colmap("1 PINHOLE 9 9 1 1 1 1\n", "1 1 0 0 0 0 0 1 7 a.png\n\n"),
              HasSubstr("no camera \"7\""));
  EXPECT_THAT(colmap("1 PINHOLE 9 9 1 1 1 1\n", "1 0 0 0 0 0 0 1 1 a.png\n\n"),
              HasSubstr("no length"));
  EXPECT_THAT(colmap("1 PINHOLE 0 9 1 1 1 1\n", "1 1 0 0 0 0 0 1 1 a.png\n\n"),
              HasSubstr("above 0"));
}

}  // namespace
}  // namespace mq
