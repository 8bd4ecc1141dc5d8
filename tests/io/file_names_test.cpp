// What names and first bytes say about formats.
#include "mq/io/file_names.h"

#include <gtest/gtest.h>

#include "io/folder.h"
#include "mq/io/bytes.h"
#include "mq/io/model.h"

namespace mq {
namespace {

TEST(ExtensionByContent, IsThatOfTheFormat) {
  using namespace std::string_view_literals;
  const std::pair<std::string_view, std::string_view> cases[] = {
      {"v 0 0 0\n", ".obj"},
      {"# made by hand\r\n\r\nmtllib a.mtl\r\n", ".obj"},
      {"# a remark that does not end", ".obj"},
      {"ply\nformat ascii 1.0\n", ".ply"},
      {"glTF\x02\0\0\0"sv, ".glb"},
      {" {\"asset\": {\"version\": \"2.0\"}}", ".gltf"},
      {"[{\"verb\": \"filter\"}]", ".json"},
      {"RIFF\x10\0\0\0WEBPVP8L"sv, ".webp"},
      {"RIFF\x10\0\0\0WAVE"sv, ""},
      {"RIFF", ""},
      {"PIEH", ".flo"},
      {"#usda 1.0\n(\n", ".usda"},
      {"\xef\xbb\xbf#usda 1.0\n", ".usda"},
      {"PXR-USDC\0"sv, ".usdc"},
      {"PK\x03\x04", ".usdz"},
      {"very long ago", ""},
      {"", ""}};
  for (const auto& [bytes, extension] : cases) EXPECT_EQ(extension_by_content(bytes), extension) << bytes;
}

using WrittenPictures = FolderTest;

TEST_F(WrittenPictures, BeginAsTheirExtensionSays) {
  for (const std::string extension : {".png", ".jpg", ".tif", ".exr", ".bmp", ".webp"}) {
    const auto path = folder / ("a" + extension);
    write_image(path, Image<float>(3, 2, 3), extension == ".exr" ? Depth::half : Depth::u8);
    EXPECT_EQ(extension_by_content(text_of(read_file(path)).substr(0, 256)), extension);
  }
}

}  // namespace
}  // namespace mq
