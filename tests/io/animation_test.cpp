// Evolving meshes as USD, read again by a parser of its own, and as compressed glTF.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

#include "io/folder.h"
#include "mq/io/animation.h"
#include "mq/io/bytes.h"
#include "mq/io/detail/evolving_blocks.h"
#include "mq/io/detail/gltf_file.h"
#include "mq/io/document.h"
#include "mq/io/image_file.h"

namespace mq {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr double step = 0x1p-20;

/// A strip of quads that waves over six frames, 10, 12, ..., 20; from the fourth on its last quad is gone.
EvolvingMesh waving_strip() {
  Mesh mesh;
  constexpr int quads = 5;
  for (int i = 0; i <= quads; ++i)
    for (int j = 0; j < 2; ++j) {
      mesh.positions.emplace_back(i, j, 0);
      mesh.uvs.emplace_back(double(i) / quads, j);
    }
  for (int i = 0; i < quads; ++i) {
    mesh.triangles.push_back({2 * i, 2 * i + 2, 2 * i + 3});
    mesh.triangles.push_back({2 * i, 2 * i + 3, 2 * i + 1});
  }
  mesh.corner_uvs = mesh.triangles;
  Mesh shorter = mesh;
  for (int i = 0; i < 2; ++i) shorter.triangles.pop_back(), shorter.corner_uvs.pop_back();
  EvolvingMesh evolving;
  evolving.segments = {segment_of(mesh), segment_of(shorter)};
  for (int f = 0; f < 6; ++f) {
    EvolvingFrame frame{10 + 2 * f, f < 3 ? 0 : 1, mesh.positions};
    for (Vector3& p : frame.positions) p.z() = std::sin(p.x() + 0.3 * f);
    evolving.frames.push_back(std::move(frame));
  }
  return evolving;
}

/// What a USD layer holds at the place of one prim, as far as it is asked for.
class Prim {
 public:
  Prim(const std::string& layer, const std::string& head) {
    const std::size_t begin = layer.find("    def " + head);
    EXPECT_NE(begin, std::string::npos) << head;
    text_ = layer.substr(begin, layer.find("\n    }\n", begin) - begin);
  }

  /// The numbers of a value, brackets left out.
  std::vector<double> numbers(const std::string& name) const { return numbers_in(value(name)); }

  /// Those of each time sample.
  std::map<int, std::vector<double>> samples(const std::string& name) const {
    const std::string all = value(name + ".timeSamples");
    std::map<int, std::vector<double>> samples;
    for (std::size_t at = 0; (at = all.find(": [", at)) != std::string::npos; ++at) {
      const std::size_t line = all.rfind('\n', at);
      samples[std::stoi(all.substr(line, at - line))] = numbers_in(all.substr(at + 2, all.find('\n', at) - at - 2));
    }
    return samples;
  }

  bool has(const std::string& name) const { return text_.find(name) != std::string::npos; }
  const std::string& text() const { return text_; }

 private:
  /// What stands behind "NAME = ": a line, or, where it has braces, all between them.
  std::string value(const std::string& name) const {
    const std::size_t at = text_.find(" " + name + " = ");
    EXPECT_NE(at, std::string::npos) << name;
    const std::size_t begin = at + name.size() + 4;
    const char* end = text_[begin] == '{' ? "}" : "\n";
    return text_.substr(begin, text_.find(end, begin) - begin);
  }

  static std::vector<double> numbers_in(std::string text) {
    for (char& c : text)
      if (std::strchr("()[],", c)) c = ' ';
    std::vector<double> numbers;
    Scanner scanner(text);
    double number = 0;
    while (to_number(scanner.word(), number)) numbers.push_back(number);
    return numbers;
  }

  std::string text_;
};

class EvolvingAnimation : public FolderTest {
 protected:
  EvolvingAnimation() { write_evolving(folder / "strip.evolving", evolving, step); }

  EvolvingReader reader() const { return EvolvingReader(folder / "strip.evolving"); }
  static Image<float> picture(int frame) { return Image<float>(4, 4, 3, float(frame) / 10); }

  const EvolvingMesh evolving = waving_strip();
};

TEST_F(EvolvingAnimation, HoldsEveryFrameWithinAStep) {
  write_animation(folder / "strip.usda", reader(), {0, 5, 24});
  const std::string layer = get("strip.usda");
  EXPECT_THAT(layer, testing::StartsWith("#usda 1.0\n"));
  for (const char* line : {"startTimeCode = 10", "endTimeCode = 20", "timeCodesPerSecond = 24", "upAxis = \"Y\""})
    EXPECT_THAT(layer, HasSubstr(line));
  for (int s = 0; s < 2; ++s) {
    const Prim prim(layer, "Mesh \"segment_" + std::to_string(s) + "\"");
    const EvolvingSegment& segment = evolving.segments[std::size_t(s)];
    const std::vector<double> corners = prim.numbers("faceVertexIndices");
    EXPECT_EQ(prim.numbers("faceVertexCounts"), std::vector<double>(segment.triangles.size(), 3));
    ASSERT_EQ(corners.size(), 3 * segment.triangles.size());
    for (std::size_t i = 0; i < corners.size(); ++i) EXPECT_EQ(corners[i], segment.triangles[i / 3][i % 3]);
    const std::vector<double> uvs = prim.numbers("primvars:st"), of_corners = prim.numbers("primvars:st:indices");
    ASSERT_EQ(of_corners.size(), corners.size());
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Vector2& uv = segment.uvs[std::size_t(segment.corner_uvs[i / 3][i % 3])];
      EXPECT_NEAR(uvs[2 * std::size_t(of_corners[i])], uv.x(), 1e-7);
      EXPECT_NEAR(uvs[2 * std::size_t(of_corners[i]) + 1], uv.y(), 1e-7);
    }
    const auto samples = prim.samples("points"), boxes = prim.samples("extent");
    ASSERT_EQ(samples.size(), 3u);
    for (const EvolvingFrame& frame : evolving.frames) {
      if (frame.segment != s) continue;
      const std::vector<double>& points = samples.at(frame.number);
      ASSERT_EQ(points.size(), 3 * frame.positions.size());
      for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_NEAR(points[i], frame.positions[i / 3][int(i % 3)], step);
        EXPECT_LE(boxes.at(frame.number)[i % 3], points[i]);
        EXPECT_GE(boxes.at(frame.number)[3 + i % 3], points[i]);
      }
    }
  }
}

TEST_F(EvolvingAnimation, ShowsOneSegmentAtATime) {
  write_animation(folder / "strip.usda", reader(), {1, 4, 24});
  const std::string layer = get("strip.usda");
  EXPECT_THAT(Prim(layer, "Mesh \"segment_0\"").text(),
              HasSubstr("visibility.timeSamples = {\n            12: \"inherited\",\n            16: \"invisible\",\n"));
  EXPECT_THAT(Prim(layer, "Mesh \"segment_1\"").text(),
              HasSubstr("visibility.timeSamples = {\n            12: \"invisible\",\n            16: \"inherited\",\n        }"));
  write_animation(folder / "one.usda", reader(), {3, 5, 24});
  EXPECT_FALSE(Prim(get("one.usda"), "Mesh \"segment_0\"").has("visibility"));
}

TEST_F(EvolvingAnimation, NamesAPictureForEachSegment) {
  std::vector<int> asked;
  const auto pictures = [&](int frame) { return asked.push_back(frame), picture(frame); };
  write_animation(folder / "a@b.usda", reader(), {0, 5, 24}, pictures);
  EXPECT_THAT(asked, ElementsAre(0, 3));
  EXPECT_THAT(animation_files(folder / "a@b.usda", reader(), {0, 5, 24}, [](int) { return true; }),
              ElementsAre(folder / "a@b.usda", folder / "a@b_0.png", folder / "a@b_1.png"));
  const std::string layer = get("a@b.usda");
  for (const int s : {0, 1}) {
    const std::string number = std::to_string(s), name = "a@b_" + number + ".png";
    EXPECT_THAT(layer, HasSubstr("@@@" + name + "@@@"));
    EXPECT_THAT(Prim(layer, "Mesh \"segment_" + number + "\"").text(),
                HasSubstr("rel material:binding = </evolving/material_" + number + ">"));
    EXPECT_NEAR(read_texture(folder / name).pixels(1, 1, 0), 0.3 * s, 0.51 / 255);
  }
}

/// What a file of an archive is called and holds, by the local headers alone.
std::map<std::string, std::string> unpacked(const std::string& zip) {
  const auto number = [&](std::size_t at, std::size_t size) {
    std::uint32_t value = 0;
    std::memcpy(&value, zip.data() + at, size);
    return std::size_t(value);
  };
  std::map<std::string, std::string> files;
  for (std::size_t at = 0; number(at, 4) == 0x04034b50;) {
    EXPECT_EQ(number(at + 8, 2), 0u) << "compressed";
    const std::size_t size = number(at + 18, 4), name_size = number(at + 26, 2);
    const std::size_t data = at + 30 + name_size + number(at + 28, 2);
    EXPECT_EQ(number(at + 22, 4), size);
    EXPECT_EQ(data % 64, 0u);
    const std::string bytes = zip.substr(data, size);
    EXPECT_EQ(number(at + 14, 4), crc32(bytes_of(bytes)));
    files[zip.substr(at + 30, name_size)] = bytes;
    at = data + size;
  }
  return files;
}

TEST_F(EvolvingAnimation, IsPackedWithItsPictures) {
  const AnimationPart part{0, 5, 24};
  write_animation(folder / "strip.usda", reader(), part, picture);
  write_animation(folder / "strip.usdz", reader(), part, picture);
  const std::string zip = get("strip.usdz");
  const auto files = unpacked(zip);
  EXPECT_EQ(files.size(), 3u);
  for (const char* name : {"strip.usda", "strip_0.png", "strip_1.png"}) EXPECT_EQ(files.at(name), get(name));
  EXPECT_EQ(zip.find("strip.usda"), 30u);  // the layer that a package opens is its first file
  EXPECT_EQ(std::system(("python3 -m zipfile -t " + (folder / "strip.usdz").string() + " > /dev/null").c_str()), 0);
}

TEST_F(EvolvingAnimation, RefusesWhatItCannotHold) {
  EXPECT_THROW(write_animation(folder / "a.usdc", reader(), {0, 5, 24}), InvalidInput);
  EXPECT_THROW(write_animation(folder / "a.usda", reader(), {0, 6, 24}), InvalidInput);
  EXPECT_THROW(write_animation(folder / "a.usda", reader(), {0, 5, 0}), InvalidInput);
  EvolvingMesh far = evolving;
  far.frames[2].positions[0].x() = 1e39;
  write_evolving(folder / "far.evolving", far, 0x1p100);
  EXPECT_THROW(write_animation(folder / "a.usda", EvolvingReader(folder / "far.evolving"), {0, 5, 24}), Unsupported);
  EXPECT_FALSE(there("a.usda"));
}

/// Every number of a GLB's accessors, in their order.
std::vector<double> numbers_of_accessors(const std::filesystem::path& path) {
  Document document;
  document.format = Document::Format::glb;
  document.name = path.filename().string();
  document.bytes = read_file(path);
  const GltfFile file(document);
  std::vector<double> numbers;
  for (std::size_t id = 0; id < file.json()["accessors"].size(); ++id) {
    std::vector<double> values = file.values(std::int64_t(id), {1, 2, 3}).values;
    if (file.json()["accessors"][id]["componentType"] == 5125)  // of a triangle any corner may come first
      for (auto corner = values.begin(); corner != values.end(); corner += 3)
        std::rotate(corner, std::min_element(corner, corner + 3), corner + 3);
    numbers.insert(numbers.end(), values.begin(), values.end());
  }
  return numbers;
}

TEST_F(EvolvingAnimation, AsGltfIsCompressedWithoutLoss) {
  write_animation(folder / "plain.glb", reader(), {0, 5, 24});
  write_animation(folder / "packed.glb", reader(), {0, 5, 24, Compression::meshopt});
  EXPECT_THAT(get("packed.glb"), HasSubstr("EXT_meshopt_compression"));
  const auto plain = numbers_of_accessors(folder / "plain.glb");
  EXPECT_GT(plain.size(), 300U);
  EXPECT_EQ(plain, numbers_of_accessors(folder / "packed.glb"));
  EXPECT_THROW(write_animation(folder / "a.glb", reader(), {0, 5, 24, Compression::draco}), InvalidInput);
  EXPECT_THROW(write_animation(folder / "a.usda", reader(), {0, 5, 24, Compression::meshopt}), InvalidInput);
}

}  // namespace
}  // namespace mq
