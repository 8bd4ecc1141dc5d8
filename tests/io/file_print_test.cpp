#include "mq/io/file_print.h"

#include <gtest/gtest.h>

#include "fixtures.h"
#include "mq/base/error.h"
#include "mq/io/bytes.h"
#include "mq/io/atomic_file.h"

namespace mq {
namespace {

namespace fs = std::filesystem;

class FilePrints : public testing::Test {
 protected:
  FilePrints() { fs::create_directories(folder_); }
  ~FilePrints() override { fs::remove_all(folder_); }
  fs::path folder_ =
      fs::path(testing::TempDir()) / testing::UnitTest::GetInstance()->current_test_info()->name();
};

TEST_F(FilePrints, AreLengthAndTheChecksumOfTheStandard) {
  write_file(folder_ / "a", bytes_of("123456789"));
  EXPECT_EQ(file_print(folder_ / "a"), (FilePrint{9, 0xCBF43926}));
  EXPECT_THROW(file_print(folder_ / "none"), IoError);
}

TEST_F(FilePrints, AreOfAllThatAModelIsMadeOf) {
  Model model;
  model.mesh = fixtures::flat_square(2);
  ASSERT_TRUE(model.mesh.has_uvs());
  model.mesh.textures.assign(model.mesh.triangles.size(), 0);
  Texture texture;
  texture.name = "t.png";
  texture.pixels = Image<float>(2, 2, 3);
  model.textures.push_back(std::move(texture));
  EXPECT_TRUE(files_of(model).empty());
  write_model(folder_ / "m.obj", model);
  std::vector<fs::path> parts = {folder_ / "m.obj", folder_ / "m.mtl"};
  EXPECT_EQ(
      files_of(read_model(folder_ / "m.obj", {.textures = {}, .pictures = ReadModelOptions::Pictures::skip})),
      parts);
  parts.push_back(folder_ / "t.png");
  EXPECT_EQ(files_of(read_model(folder_ / "m.obj")), parts);
  write_model(folder_ / "m.gltf", model);
  parts = {folder_ / "m.gltf", folder_ / "m.bin", folder_ / "t.png"};
  EXPECT_EQ(files_of(read_model(folder_ / "m.gltf")), parts);
}

}  // namespace
}  // namespace mq
