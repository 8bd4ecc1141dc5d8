// Every mesh of the test data is read, or refused in words, and comes back byte for byte.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "io/folder.h"
#include "mq/io/bytes.h"
#include "mq/io/model.h"
#include "places.h"

namespace mq {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

std::vector<fs::path> meshes() {
  std::vector<fs::path> paths;
  std::error_code ignored;
  for (const auto& entry : fs::recursive_directory_iterator(places::data(), ignored)) {
    const std::string extension = entry.path().extension().string();
    if (extension == ".obj" || extension == ".ply" || extension == ".gltf" || extension == ".glb")
      paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

class Data : public FolderTest {};

TEST_F(Data, IsReadOrRefusedInWordsAndComesBack) {
  const std::vector<fs::path> paths = meshes();
  if (paths.empty()) GTEST_SKIP() << "no test data in " << places::data();
  int refused = 0;
  for (const fs::path& path : paths) {
    SCOPED_TRACE(path.string());
    Model model;
    try {
      model = read_model(path, {{}, ReadModelOptions::Pictures::skip});
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("Draco"));
      ++refused;
      continue;
    }
    EXPECT_GT(model.mesh.triangle_count(), 0);
    for (const Texture& texture : model.textures)
      EXPECT_TRUE(texture.path.empty() || fs::exists(texture.path)) << texture.path;
    for (const std::string& note : model.notes) EXPECT_NE(note, "");
    const fs::path copy = folder / path.filename();
    write_model(copy, model);
    EXPECT_EQ(read_file(copy), read_file(path));
    fs::remove_all(folder);
    fs::create_directories(folder);
  }
  EXPECT_LE(refused, 1);
}

TEST_F(Data, HasPicturesForItsTexturedModels) {
  for (const char* name : {"A_textured/fuze/fuze.obj", "A_textured/spot/spot.obj",
                           "B_sequences/fox_run/frame_0000.ply"}) {
    const fs::path path = places::data() / name;
    if (!fs::exists(path)) continue;
    const Model model = read_model(path);
    ASSERT_EQ(model.textures.size(), 1u) << name;
    EXPECT_GT(model.textures[0].pixels.width(), 0);
  }
}

}  // namespace
}  // namespace mq
