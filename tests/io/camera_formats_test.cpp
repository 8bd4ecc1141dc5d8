// One set of cameras in each format shows the same points at the same places.
#include <gmock/gmock.h>

#include "io/camera_files.h"

namespace mq {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr double exact = 1e-9;  // pixels

TEST_F(CameraFiles, ComeBackFromWhatIsWritten) {
  set[0].camera.lens = {.k1 = -0.1, .k2 = 0.02, .p1 = 0.001, .p2 = -0.002};
  set[1].camera.lens = {.k1 = 0.03, .k2 = -0.01, .k3 = 0.004, .p1 = 0.001};
  for (const CameraFormat format : {CameraFormat::json, CameraFormat::transforms, CameraFormat::colmap,
                                    CameraFormat::colmap_binary}) {
    const bool file = format == CameraFormat::json || format == CameraFormat::transforms;
    const std::string path = file ? "c.json" : format == CameraFormat::colmap ? "text" : "binary";
    if (!file) std::filesystem::create_directory(folder / path);
    write_cameras(folder / path, set, format);
    for (const auto& made : camera_files(folder / path, format))
      EXPECT_TRUE(std::filesystem::exists(made)) << made;
    EXPECT_LT(apart_from_set(path), exact) << int(format);
  }
}

TEST_F(CameraFiles, KeepEachLensThatAFormatHas) {
  using Projection = Lens::Projection;
  const std::vector<std::pair<Lens, std::string>> lenses = {
      {{}, "SIMPLE_PINHOLE"},
      {{.k1 = -0.1}, "SIMPLE_RADIAL"},
      {{.k1 = -0.1, .k2 = 0.02}, "RADIAL"},
      {{.k1 = -0.1, .p2 = 0.002}, "OPENCV"},
      {{.k1 = -0.1, .k3 = 0.01, .d1 = 0.1, .d2 = 0.02, .d3 = 0.003}, "FULL_OPENCV"},
      {{.projection = Projection::field_of_view, .shape = 0.9}, "FOV"},
      {{.projection = Projection::fisheye, .k1 = 0.05}, "SIMPLE_RADIAL_FISHEYE"},
      {{.projection = Projection::fisheye, .k1 = 0.05, .k2 = -0.02}, "RADIAL_FISHEYE"},
      {{.projection = Projection::fisheye, .k1 = 0.05, .k4 = -0.003}, "OPENCV_FISHEYE"},
      {{.projection = Projection::fisheye, .k1 = 0.05, .p1 = 0.01, .s1 = 0.02, .s2 = 0.01},
       "THIN_PRISM_FISHEYE"},
      {{.projection = Projection::division, .shape = -0.2}, "SIMPLE_DIVISION"}};
  std::filesystem::create_directory(folder / "text");
  std::filesystem::create_directory(folder / "binary");
  for (const auto& [lens, model] : lenses) {
    for (Photograph& photograph : set) photograph.camera.lens = lens;
    write_cameras(folder / "text", set, CameraFormat::colmap);
    write_cameras(folder / "binary", set, CameraFormat::colmap_binary);
    write_cameras(folder / "c.json", set, CameraFormat::json);
    EXPECT_THAT(get("text/cameras.txt"), HasSubstr("\n1 " + model + " 64 48 70.5 "));
    for (const char* path : {"text", "binary", "c.json"}) {
      EXPECT_LT(apart_from_set(path), exact) << model;
      EXPECT_EQ(read_cameras(folder / path)[0].camera.lens, lens) << model;
    }
  }
  for (Photograph& photograph : set) photograph.camera.lens = lenses[8].first;
  write_cameras(folder / "transforms.json", set, CameraFormat::transforms);
  EXPECT_LT(apart_from_set("transforms.json"), exact);
}

TEST_F(CameraFiles, RefuseLensesThatAFormatHasNot) {
  using Projection = Lens::Projection;
  std::filesystem::create_directory(folder / "text");
  const auto refusal = [&](const Lens& lens, CameraFormat format) {
    set[1].camera.lens = lens;
    return fixtures::error_of<Unsupported>([&] { write_cameras(folder / "text", set, format); });
  };
  EXPECT_THAT(refusal({.k4 = 0.1}, CameraFormat::colmap),
              AllOf(HasSubstr("photo 1.png"), HasSubstr("perspective, k4")));
  EXPECT_THAT(refusal({.projection = Projection::equisolid}, CameraFormat::colmap_binary),
              HasSubstr("equisolid"));
  EXPECT_THAT(refusal({.d1 = 0.1}, CameraFormat::transforms), HasSubstr("perspective, d1"));
  EXPECT_THAT(refusal({.projection = Projection::fisheye}, CameraFormat::transforms),
              HasSubstr("one camera_model for all"));
  set[1].camera.skew = 1;
  EXPECT_THAT(refusal({}, CameraFormat::colmap), HasSubstr("perspective, skew"));
  EXPECT_TRUE(std::filesystem::is_empty(folder / "text"));
}

TEST_F(CameraFiles, OfBundler) {
  for (Photograph& photograph : set) photograph.camera.lens = {.k1 = -0.1, .k2 = 0.02};
  put("bundle/bundle.out", bundler());
  put("list.txt", "photo 0.png\nphoto 1.png 0 70.5\n./photo 2.png\n");
  EXPECT_LT(apart_from_set("bundle/bundle.out"), exact);
  std::filesystem::create_directories(folder / "project");
  std::filesystem::rename(folder / "bundle", folder / "project/bundle");
  put("project/list.txt", get("list.txt"));
  EXPECT_LT(apart_from_set("project"), exact);
  // COLMAP names them so.
  put("c.bundle.out", bundler()), put("c.list.txt", "photo 0.png\nphoto 1.png\nphoto 2.png\n");
  std::filesystem::remove(folder / "list.txt");
  EXPECT_LT(apart_from_set("c.bundle.out"), exact);
  put("list.txt", get("c.list.txt"));
  // One that Bundler could not place.
  std::string unplaced = bundler();
  unplaced.replace(unplaced.find("70.5 -0.1 0.02"), 14, "0 0 0");
  put("b.out", unplaced);
  const CameraSet found = read_camera_set(folder / "b.out");
  EXPECT_EQ(found.format, "Bundler");
  EXPECT_EQ(found.photographs.size(), 2U);
  EXPECT_EQ(found.without_pose, 1);
}

TEST_F(CameraFiles, OfMetashape) {
  for (Photograph& photograph : set) {
    photograph.camera.lens = {.k1 = -0.1, .k2 = 0.02, .k3 = -0.003, .k4 = 0.0004, .p1 = 0.002, .p2 = -0.001};
    photograph.camera.skew = 0.3;
    photograph.camera.fx += 0.7, photograph.camera.cx += 1.5, photograph.camera.cy -= 0.25;
  }
  put("c.xml", metashape());
  EXPECT_LT(apart_from_set("c.xml"), 1e-6);
  const CameraSet found = read_camera_set(folder / "c.xml");
  EXPECT_EQ(found.without_pose, 1);
  EXPECT_TRUE(found.notes.empty());
  // In a version without components the transform is the chunk's.
  std::string old = metashape();
  for (const char* words : {"<components next_id=\"1\"><component id=\"0\">", "</component></components>"})
    old.erase(old.find(words), std::string(words).size());
  put("old.xml", old);
  EXPECT_LT(apart_from_set("old.xml"), 1e-6);
  std::string global = metashape();
  global.replace(global.find("LOCAL_CS"), 8, "GEOGCS");
  put("global.xml", global);
  EXPECT_THAT(read_camera_set(folder / "global.xml").notes.at(0), HasSubstr("GEOGCS"));
}

TEST_F(CameraFiles, OfRealityCapture) {
  for (Photograph& photograph : set) {
    photograph.camera.lens = {.k1 = -0.1, .k2 = 0.02, .k3 = -0.003, .k4 = 0.0004, .p1 = 0.002, .p2 = -0.001};
    photograph.camera.skew = 0.3;
    photograph.camera.fy += 0.7, photograph.camera.cx += 1.5, photograph.camera.cy -= 0.25;
  }
  for (std::size_t k = 0; k < 3; ++k) put("photo " + std::to_string(k) + ".xmp", xmp(k, "brown4t2"));
  EXPECT_LT(apart_from_set(""), 1e-6);
  EXPECT_EQ(read_cameras(folder / "photo 1.xmp").size(), 1U);
  for (Photograph& photograph : set) photograph.camera.lens = {};
  for (std::size_t k = 0; k < 3; ++k)
    put("photo " + std::to_string(k) + ".xmp", xmp(k, k == 0 ? "perspective" : k == 1 ? "division" : "brown3"));
  EXPECT_LT(apart_from_set(""), 1e-6);
  // What cannot be known is refused, what is not a camera counted.
  set[1].camera.lens.k1 = 0.1;
  put("photo 1.xmp", xmp(1, "division"));
  EXPECT_THAT(refused(""), AllOf(HasSubstr("photo 1.xmp, line 3"), HasSubstr("found \"division\", wanted")));
  std::string unplaced = xmp(1, "brown3");
  unplaced.replace(unplaced.find("<xcr:Position>"), 14, "<xcr:Other>");
  unplaced.replace(unplaced.find("</xcr:Position>"), 15, "</xcr:Other>");
  put("photo 1.xmp", unplaced);
  put("photo 2.xmp", "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\"/>");
  const CameraSet found = read_camera_set(folder);
  EXPECT_EQ(found.without_pose, 1);
  EXPECT_EQ(found.photographs.size(), 1U);
  EXPECT_THAT(found.notes.at(0), HasSubstr("1 of its .xmp files are of other programs"));
}

TEST_F(CameraFiles, OfGltf) {
  put("c.gltf", gltf());
  EXPECT_LT(apart_from_set("c.gltf"), 1e-6);
  std::string wide = gltf();
  wide.replace(wide.find("1.33333"), 7, "1.77777");
  put("wide.gltf", wide);
  EXPECT_THAT(refused("wide.gltf"), AllOf(HasSubstr("nodes[1]"), HasSubstr("its aspect ratio is 1.778")));
  std::string loop = gltf();
  loop.replace(loop.find("\"children\":[1]"), 14, "\"children\":[0]");
  put("loop.gltf", loop);
  EXPECT_THAT(refused("loop.gltf"), HasSubstr("is not there: inner"));
}

TEST_F(CameraFiles, OfOpenMvs) {
  for (const std::uint32_t version : {1U, 2U, 3U, 4U, 5U, 6U, 7U}) {
    put_bytes("scene.mvs", openmvs(version));
    EXPECT_LT(apart_from_set("scene.mvs"), exact) << version;
  }
  put_bytes("normalised.mvs", openmvs(6, false));
  EXPECT_LT(apart_from_set("normalised.mvs"), exact);
  put_bytes("later.mvs", openmvs(8));
  EXPECT_THAT(refused("later.mvs"), AllOf(HasSubstr("version 8"), HasSubstr("InterfaceCOLMAP")));
  put("archive.mvs", std::string("MVS\0\0\0\0", 7));
  EXPECT_THAT(refused("archive.mvs"), HasSubstr("archive"));
}

/// As instant-ngp and nerfstudio write it.
TEST_F(CameraFiles, OfNerfTools) {
  std::string frames;
  for (int k = 0; k < 2; ++k) {
    Eigen::Matrix4d matrix = world_from(set[std::size_t(k)].camera);
    matrix.block<3, 2>(0, 1) *= -1;
    std::string list;
    for (int r = 0; r < 4; ++r) {
      std::string row = numbers(rows(matrix.row(r)));
      std::ranges::replace(row, ' ', ',');
      list += (r ? ",[" : "[") + row + "]";
    }
    frames += fmt::format("{}{{\"file_path\":\"./photo {}\",\"transform_matrix\":[{}]}}", k ? ",\n" : "", k, list);
  }
  set.pop_back();
  const double angle = 2 * std::atan(64 / (2 * 70.5));
  put("a.json", fmt::format("{{\"camera_angle_x\": {:.17g},\n\"frames\": [{}]}}", angle, frames));
  EXPECT_LT(apart_from_set("a.json"), exact);
  put("b.json", "{\"w\":64.0,\"h\":48,\"fl_x\":70.5,\"cx\":32,\"cy\":24,\"applied_scale\":1,\"frames\": [" + frames + "]}");
  EXPECT_LT(apart_from_set("b.json"), exact);
  EXPECT_THAT(read_camera_set(folder / "b.json").notes.at(0), HasSubstr("applied_transform"));
  for (Photograph& photograph : set) photograph.camera.lens = {.projection = Lens::Projection::fisheye, .k1 = 0.1};
  put("c.json", "{\"w\":64,\"h\":48,\"fl_x\":70.5,\"is_fisheye\":true,\"k1\":0.1,\"frames\": [" + frames + "]}");
  EXPECT_LT(apart_from_set("c.json"), exact);
  put("d.json", "{\"w\":64,\"h\":48,\"fl_x\":70.5,\n\"camera_model\":\"EQUIRECTANGULAR\",\"frames\": [" + frames + "]}");
  EXPECT_THAT(refused("d.json"), HasSubstr("camera_model: found \"EQUIRECTANGULAR\""));
  put("e.json", "{\"w\":64,\"h\":48,\"frames\": [" + frames + "]}");
  EXPECT_THAT(refused("e.json"), HasSubstr("found no \"fl_x\""));
}

}  // namespace
}  // namespace mq
