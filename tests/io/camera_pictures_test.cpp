// Pictures of cameras by names that other machines gave them, and files that are damaged.
#include <gmock/gmock.h>

#include <random>

#include "io/camera_files.h"
#include "io/picture_bytes.h"
#include "mq/io/photograph_file.h"

namespace mq {
namespace {

using testing::AllOf;
using testing::HasSubstr;

/// A file that names one picture.
std::string naming(const std::string& name) {
  return R"({"cameras":[{"image":")" + name +
         R"(","width":9,"height":9,"fx":5,"quaternion":[1,0,0,0],"translation":[0,0,0]}]})";
}

TEST_F(CameraFiles, FindPicturesByNamesOfOtherMachines) {
  put("images/IMG_1.JPG", "x"), put("images/sub/deep.png", "x"), put("images/IMG.0002.tif", "x");
  const auto found = [&](const std::string& name) {
    put("c.json", naming(name));
    return read_cameras(folder / "c.json").at(0).picture.lexically_relative(folder).generic_string();
  };
  EXPECT_EQ(found("IMG_1.JPG"), "images/IMG_1.JPG");
  EXPECT_EQ(found("img_1.jpg"), "images/IMG_1.JPG");
  EXPECT_EQ(found("IMG_1.png"), "images/IMG_1.JPG");
  EXPECT_EQ(found("img_1.heic"), "images/IMG_1.JPG");
  EXPECT_EQ(found("IMG_1"), "images/IMG_1.JPG");
  EXPECT_EQ(found("C:\\\\photos\\\\IMG_1.JPG"), "images/IMG_1.JPG");
  EXPECT_EQ(found("/home/somebody/IMG_1.JPG"), "images/IMG_1.JPG");
  EXPECT_EQ(found("./images/IMG_1.JPG"), "images/IMG_1.JPG");
  EXPECT_EQ(found("sub/deep.png"), "images/sub/deep.png");
  EXPECT_EQ(found("IMG.0002"), "images/IMG.0002.tif");
  put("c.json", naming("IMG_2.JPG"));
  EXPECT_THAT(refused("c.json"), HasSubstr("IMG_2.JPG"));
  put("c.json", naming("IMG.0003"));
  EXPECT_THAT(refused("c.json"), HasSubstr("of 1 picture 1 is not there: IMG.0003"));
}

TEST_F(CameraFiles, RefuseNamesThatFitSeveralPictures) {
  put("images/img_1.jpg", "x"), put("images/IMG_1.JPG", "x"), put("b/img_1.png", "x");
  put("c.json", naming("Img_1.jpg"));
  EXPECT_THAT(refused("c.json"), AllOf(HasSubstr("its picture Img_1.jpg may be "), HasSubstr("IMG_1.JPG or "),
                                       HasSubstr("img_1.jpg: rename them")));
  put("c.json", naming("IMG_1.tif"));
  EXPECT_THAT(refused("c.json"), HasSubstr("may be "));
  // The folder that is given decides, alone.
  const CamerasOptions options{.images = {folder / "b"}};
  EXPECT_EQ(read_camera_set(folder / "c.json", options).photographs.at(0).picture, folder / "b" / "img_1.png");
  EXPECT_THAT(fixtures::error_of<IoError>([&] { read_camera_set(folder / "c.json", {.images = {folder / "none"}}); }),
              HasSubstr("wanted a folder"));
}

TEST_F(CameraFiles, ListMissingPictures) {
  std::filesystem::create_directory(folder / "text");
  for (int k = 3; k < 12; ++k) set.push_back({name(k), camera(1)});
  write_cameras(folder / "text", set, CameraFormat::colmap);
  EXPECT_THAT(refused("text"),
              AllOf(HasSubstr("of 12 pictures 9 are not there: photo 3.png, "), HasSubstr("photo 7.png, ...")));
  const CameraSet found =
      read_camera_set(folder / "text", {.missing = CamerasOptions::Missing::list});
  EXPECT_EQ(found.photographs.size(), 3U);
  EXPECT_EQ(found.missing.size(), 9U);
  EXPECT_EQ(found.missing[8].picture, "photo 11.png");
  EXPECT_EQ(found.missing[8].camera.width, 64);
  // Of those whose file does not say it the size is not known.
  set.erase(set.begin() + 3, set.end());
  put("b.out", bundler());
  put("list.txt", "photo 0.png\nelsewhere.png\nphoto 2.png\n");
  const CameraSet bundled = read_camera_set(folder / "b.out", {.missing = CamerasOptions::Missing::list});
  EXPECT_EQ(bundled.missing.at(0).camera.width, 0);
}

TEST_F(CameraFiles, RefusePicturesOfTwoCameras) {
  std::filesystem::create_directory(folder / "text");
  set[2].picture = set[0].picture;
  write_cameras(folder / "text", set, CameraFormat::colmap);
  EXPECT_THAT(refused("text"), AllOf(HasSubstr("images.txt, line 7"), HasSubstr("is that of another camera, "),
                                     HasSubstr("images.txt, line 3, too")));
}

TEST_F(CameraFiles, NamePicturesFromWhereTheyAreWritten) {
  std::vector<Photograph> here = {{folder / "photo 0.png", camera(0)}, {"elsewhere.png", camera(1)}};
  std::filesystem::create_directory(folder / "sub");
  const auto named = [&](const char* path, CameraFormat format) {
    return named_for(folder / path, format, here)[0].picture.generic_string();
  };
  EXPECT_EQ(named("sub/c.json", CameraFormat::json), "../photo 0.png");
  EXPECT_EQ(named("c.json", CameraFormat::transforms), "photo 0.png");
  EXPECT_EQ(named("sub", CameraFormat::colmap), "photo 0.png");
  here[1].picture = folder / "sub" / "photo 1.png";
  put("sub/photo 1.png", "x");
  EXPECT_EQ(named_for(folder / "out", CameraFormat::colmap, here)[1].picture, "sub/photo 1.png");
  EXPECT_EQ(camera_format_of("transforms.json"), CameraFormat::transforms);
  EXPECT_EQ(camera_format_of("a/c.JSON"), CameraFormat::json);
  EXPECT_EQ(camera_format_of("sparse"), CameraFormat::colmap);
  EXPECT_THROW(camera_format_of("c.xml"), InvalidInput);
}

TEST_F(CameraFiles, AreOfPicturesAsTheyLieOrAsTheyAreTurned) {
  write_image(folder / "plain.jpg", Image<float>(64, 48, 3, 0.5F));
  const auto fitted = [&](int width, int height, int tag) {
    PinholeCamera c = camera(0);
    c.width = width, c.height = height;
    const Photograph photograph{put("t.jpg", test::with_orientation(get("plain.jpg"), tag)), c};
    const FittedCamera found = fitted_camera(photograph, picture_info(photograph.picture));
    const Texture texture = read_photograph(photograph, found.turn);
    EXPECT_EQ(texture.pixels.width(), found.camera.width);
    EXPECT_EQ(texture.pixels.height(), found.camera.height);
    return found.turn;
  };
  for (int tag = 1; tag <= 8; ++tag) {
    EXPECT_EQ(fitted(64, 48, tag), PictureTurn::as_stored) << tag;
    EXPECT_EQ(fitted(128, 96, tag), PictureTurn::as_stored) << tag;
    if (tag >= 5) {
      EXPECT_EQ(fitted(48, 64, tag), PictureTurn::upright) << tag;
      EXPECT_EQ(fitted(24, 32, tag), PictureTurn::upright) << tag;
    } else {
      EXPECT_THAT(fixtures::error_of<InvalidInput>([&] { fitted(48, 64, tag); }),
                  AllOf(HasSubstr("t.jpg: is 64 × 48"), HasSubstr("lies on its side"))) << tag;
    }
  }
  EXPECT_THAT(fixtures::error_of<InvalidInput>([&] { fitted(64, 64, 6); }), HasSubstr("cropped"));
}

/// Bundler's files say no sizes: those of the other pictures do.
TEST_F(CameraFiles, AreOfPicturesLikeTheOthersWhereTheirFileSaysNoSizes) {
  set.clear();
  std::string list;
  for (int k = 0; k < 9; ++k) {
    set.push_back({name(k), camera(0)});
    write_image(folder / name(k), Image<float>(64, 48, 3, 0.5F));
    list += name(k) + "\n";
  }
  put("b.out", bundler()), put("list.txt", list);
  write_image(folder / "lies.jpg", Image<float>(48, 64, 3, 0.5F));
  put("photo 1.png", test::with_orientation(get("lies.jpg"), 6));
  write_image(folder / name(2), Image<float>(32, 24, 3, 0.5F));
  write_image(folder / name(3), Image<float>(60, 48, 3, 0.5F));
  write_image(folder / name(4), Image<float>(48, 64, 3, 0.5F));
  const CameraSet found = read_camera_set(folder / "b.out", {.unreadable = CamerasOptions::Missing::list});
  ASSERT_EQ(found.photographs.size(), 8U);
  const auto fitted = [&](std::size_t k) {
    return fitted_camera(found.photographs[k], picture_info(found.photographs[k].picture));
  };
  EXPECT_EQ(fitted(1).turn, PictureTurn::upright);
  EXPECT_EQ(fitted(1).camera.cx, 32);
  EXPECT_THAT(found.notes.at(0), AllOf(HasSubstr("photo 1.png: is 48 × 64"), HasSubstr("turned as its tag")));
  EXPECT_EQ(fitted(2).camera.fx, 70.5 / 2);
  EXPECT_EQ(fitted(2).camera.width, 32);
  ASSERT_EQ(found.unreadable.size(), 1U);
  EXPECT_THAT(found.unreadable[0].why, AllOf(HasSubstr("photo 3.png: is 60 × 48"), HasSubstr("cropped")));
  EXPECT_EQ(found.photographs[3].picture.filename(), name(4));
  ASSERT_EQ(found.doubts.size(), 1U);
  EXPECT_THAT(found.doubts[0], AllOf(HasSubstr("photo 4.png: is 48 × 64"), HasSubstr("no tag")));
  EXPECT_THAT(refused("b.out"), HasSubstr("photo 3.png: is 60 × 48"));
}

TEST_F(CameraFiles, RefuseBinaryFilesThatAreCutShortOrCountTooMuch) {
  std::filesystem::create_directory(folder / "b");
  write_cameras(folder / "b", set, CameraFormat::colmap_binary);
  const std::string cameras = get("b/cameras.bin"), images = get("b/images.bin");
  for (std::size_t size = 0; size < images.size(); size += 7) {
    put("b/images.bin", images.substr(0, size));
    EXPECT_THAT(refused("b"), HasSubstr("copied whole")) << size;
  }
  put("b/images.bin", images);
  for (std::size_t size = 0; size < cameras.size(); size += 7) {
    put("b/cameras.bin", cameras.substr(0, size));
    EXPECT_THAT(refused("b"), HasSubstr("copied whole")) << size;
  }
  put("b/cameras.bin", "\xff\xff\xff\xff\xff\xff\xff\x7f" + cameras.substr(8));
  EXPECT_THAT(refused("b"), HasSubstr("cameras.bin, byte 0: found a count of 9223372036854775807 cameras"));
  std::string unknown = cameras;
  unknown[12] = 16;
  put("b/cameras.bin", unknown);
  EXPECT_THAT(refused("b"), HasSubstr("the lens of number 16 is not known"));
  put("b/cameras.bin", cameras);
  std::string nan = images;
  nan.replace(8 + 4 + 32, 8, std::string(6, '\0') + "\xf8\x7f");
  put("b/images.bin", nan);
  EXPECT_THAT(refused("b"), HasSubstr("finite numbers"));
}

/// Whatever is flipped, cut or doubled in a file, it is read or refused, never more.
TEST_F(CameraFiles, SurviveAnyDamage) {
  std::filesystem::create_directory(folder / "t");
  std::filesystem::create_directory(folder / "b");
  write_cameras(folder / "t", set, CameraFormat::colmap);
  write_cameras(folder / "b", set, CameraFormat::colmap_binary);
  write_cameras(folder / "c.json", set);
  write_cameras(folder / "transforms.json", set, CameraFormat::transforms);
  put("list.txt", "photo 0.png\nphoto 1.png\nphoto 2.png\n");
  put("b.out", bundler()), put("c.xml", metashape()), put("photo 0.xmp", xmp(0, "brown4t2"));
  put("c.gltf", gltf()), put_bytes("scene.mvs", openmvs(7));
  std::mt19937 random(7);
  int refusals = 0, readings = 0;
  for (const char* name : {"t/cameras.txt", "t/images.txt", "b/cameras.bin", "b/images.bin", "c.json",
                           "transforms.json", "b.out", "list.txt", "c.xml", "photo 0.xmp", "c.gltf", "scene.mvs"}) {
    const std::string whole = get(name), read = std::string(name) == "list.txt" ? "b.out" : name;
    for (int round = 0; round < 250; ++round) {
      std::string damaged = whole;
      const std::size_t at = random() % damaged.size();
      if (round % 10 == 8) damaged.resize(at);
      if (round % 10 == 9) damaged.insert(at, damaged.substr(at / 2, random() % 40));
      if (round % 10 < 8) damaged[at] = char(damaged[at] ^ (round % 2 ? 1 << random() % 8 : int(random() % 256)));
      put(name, damaged);
      try {
        for (const Photograph& photograph : read_camera_set(folder / read, {.images = {folder}}).photographs)
          photograph.camera.project({0.1, 0.1, 0.1});
        ++readings;
      } catch (const Error&) {
        ++refusals;
      }
    }
    put(name, whole);
  }
  EXPECT_GT(refusals, 500);
  EXPECT_GT(readings, 200);
}

}  // namespace
}  // namespace mq
