#include <OpenImageIO/deepdata.h>
#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <string>

#include "io/folder.h"
#include "mq/io/image_file.h"

namespace mq {
namespace {

using OIIO::ImageSpec;
using OIIO::TypeDesc;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

/// A part of an EXR file: its channels with their types, and its pixels as OpenImageIO stores them.
struct ExrPart {
  ImageSpec spec;
  std::vector<std::byte> pixels;
};

ExrPart exr_part(int width, int height, const std::vector<std::pair<std::string, TypeDesc>>& channels,
                 const std::string& name = "") {
  ExrPart part;
  part.spec = ImageSpec(width, height, int(channels.size()), TypeDesc::FLOAT);
  part.spec.channelnames.clear();
  for (const auto& [channel, type] : channels) {
    part.spec.channelnames.push_back(channel);
    part.spec.channelformats.push_back(type);
  }
  part.spec.full_width = part.spec.full_height = 12;  // one display window for all parts
  if (!name.empty()) part.spec["oiio:subimagename"] = name;
  part.spec["compression"] = "zip";
  part.spec["maker"] = "of " + name;
  part.spec.alpha_channel = -1;
  part.pixels.resize(part.spec.image_bytes(true));
  const std::size_t step = part.spec.pixel_bytes(true);
  for (int c = 0; c < part.spec.nchannels; ++c) {
    std::vector<float> values(std::size_t(width) * height);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = float((i * 7 + std::size_t(c) * 13) % 64 + 1) / 64;
    std::byte* const at = part.pixels.data() + part.spec.pixel_bytes(0, c, true);
    const TypeDesc type = part.spec.channelformats[std::size_t(c)];
    if (type == TypeDesc::UINT)
      for (std::size_t i = 0; i < values.size(); ++i) {
        const auto number = std::uint32_t(4294967291U - i * 3);  // no float holds these
        std::memcpy(at + i * step, &number, sizeof number);
      }
    else
      OIIO::convert_image(1, width, height, 1, values.data(), TypeDesc::FLOAT, OIIO::AutoStride, OIIO::AutoStride,
                          OIIO::AutoStride, at, type, OIIO::stride_t(step), OIIO::AutoStride, OIIO::AutoStride);
  }
  return part;
}

void write_exr(const fs::path& path, const std::vector<ExrPart>& parts) {
  const auto out = OIIO::ImageOutput::create("openexr");
  std::vector<ImageSpec> specs;
  for (const ExrPart& part : parts) specs.push_back(part.spec);
  ASSERT_TRUE(out->open(path.string(), int(specs.size()), specs.data())) << out->geterror();
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (i > 0) {
      ASSERT_TRUE(out->open(path.string(), specs[i], OIIO::ImageOutput::AppendSubimage)) << out->geterror();
    }
    ASSERT_TRUE(out->write_image(TypeDesc::UNKNOWN, parts[i].pixels.data())) << out->geterror();
  }
  ASSERT_TRUE(out->close()) << out->geterror();
}

std::vector<ExrPart> read_exr(const fs::path& path) {
  std::vector<ExrPart> parts;
  const auto in = OIIO::ImageInput::open(path.string());
  for (int i = 0; in && in->seek_subimage(i, 0); ++i) {
    ExrPart& part = parts.emplace_back(ExrPart{in->spec(), {}});
    part.pixels.resize(part.spec.image_bytes(true));
    EXPECT_TRUE(in->read_image(i, 0, 0, part.spec.nchannels, TypeDesc::UNKNOWN, part.pixels.data()));
  }
  return parts;
}

/// A channel's type and its stored bytes, by its name.
std::pair<TypeDesc, std::string> channel(const ExrPart& part, const std::string& name) {
  const int c = part.spec.channelindex(name);
  if (c < 0) return {};
  const TypeDesc type = part.spec.channelformat(c);
  std::string bytes;
  const std::size_t step = part.spec.pixel_bytes(true), at = part.spec.pixel_bytes(0, c, true);
  for (std::size_t i = 0; i < part.pixels.size(); i += step)
    bytes.append(reinterpret_cast<const char*>(part.pixels.data()) + i + at, type.size());
  return {type, bytes};
}

class PictureLayersTest : public FolderTest {
 protected:
  /// Colours, depth, numbers of objects and a layer of light, in one part.
  void write_render(const std::string& compression = "zip") const {
    ExrPart part = exr_part(9, 5, {{"R", TypeDesc::HALF}, {"G", TypeDesc::HALF}, {"B", TypeDesc::HALF},
                                   {"A", TypeDesc::HALF}, {"Z", TypeDesc::FLOAT}, {"light.R", TypeDesc::FLOAT},
                                   {"light.G", TypeDesc::FLOAT}, {"light.B", TypeDesc::FLOAT},
                                   {"object.id", TypeDesc::UINT}});
    part.spec["compression"] = compression;
    write_exr(folder / "a.exr", {part});
  }
  void write_parts() const {
    write_exr(folder / "a.exr",
              {exr_part(6, 4, {{"X", TypeDesc::FLOAT}, {"Y", TypeDesc::FLOAT}}, "motion"),
               exr_part(9, 5, {{"R", TypeDesc::HALF}, {"G", TypeDesc::HALF}, {"B", TypeDesc::HALF}}, "beauty"),
               exr_part(3, 7, {{"crypto.R", TypeDesc::UINT}, {"crypto.G", TypeDesc::FLOAT}}, "ids")});
  }
};

std::string refusal_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

/// All channels of both files are equal, but those of `part` that `changed` names.
void expect_others_kept(const fs::path& one, const fs::path& two, std::size_t part,
                        const std::vector<std::string>& changed) {
  const std::vector<ExrPart> before = read_exr(one), after = read_exr(two);
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(before[i].spec.channelnames, after[i].spec.channelnames);
    EXPECT_EQ(before[i].spec.get_string_attribute("maker"), after[i].spec.get_string_attribute("maker"));
    EXPECT_EQ(before[i].spec.get_string_attribute("oiio:subimagename"),
              after[i].spec.get_string_attribute("oiio:subimagename"));
    for (const std::string& name : before[i].spec.channelnames) {
      const bool kept = i != part || std::ranges::find(changed, name) == changed.end();
      EXPECT_EQ(channel(before[i], name) == channel(after[i], name), kept) << i << " " << name;
      EXPECT_EQ(channel(before[i], name).first, channel(after[i], name).first) << name;
    }
  }
}

TEST_F(PictureLayersTest, ProcessesTheColoursAndNamesTheOthers) {
  write_render();
  const Texture read = read_texture(folder / "a.exr");
  EXPECT_EQ(read.pixels.channels(), 4);
  EXPECT_EQ(read.format.depth, Depth::half);
  EXPECT_THAT(read.format.layers->names, ElementsAre("RGBA", "Z", "light", "object"));
  EXPECT_EQ(read.format.layers->chosen, 0U);
  EXPECT_THAT(read.notes, ElementsAre(AllOf(HasSubstr("RGBA"), HasSubstr("Z"), HasSubstr("light"),
                                            HasSubstr("object"), HasSubstr("kept"))));
  EXPECT_EQ(picture_info(folder / "a.exr").channels, (std::vector<std::string>{"R", "G", "B", "A"}));
}

TEST_F(PictureLayersTest, DividesColoursByTheAlphaOfTheirLayerAlone) {
  write_render();
  const ExrPart stored = read_exr(folder / "a.exr").at(0);
  const auto in = OIIO::ImageInput::open((folder / "a.exr").string());
  std::vector<float> values(stored.spec.image_pixels() * 9);
  ASSERT_TRUE(in->read_image(0, 0, 0, 9, TypeDesc::FLOAT, values.data()));
  const Texture colours = read_texture(folder / "a.exr"), light = read_texture(folder / "a.exr", {}, {}, "light");
  for (int x = 0; x < 9; ++x) {
    EXPECT_FLOAT_EQ(colours.pixels.pixel(x, 0)[1], values[std::size_t(9 * x + 1)] / values[std::size_t(9 * x + 3)]);
    EXPECT_EQ(light.pixels.pixel(x, 0)[1],
              values[std::size_t(9 * x + stored.spec.channelindex("light.G"))]);
  }
}

TEST_F(PictureLayersTest, WritesAllOthersBackValueForValueAndTypeForType) {
  write_render();
  for (const auto& [layer, names] : std::vector<std::pair<std::string, std::vector<std::string>>>{
           {"", {"R", "G", "B"}}, {"light", {"light.R", "light.G", "light.B"}}, {"Z", {"Z"}}}) {
    Texture picture = read_texture(folder / "a.exr", {}, {}, layer);
    for (int y = 0; y < picture.pixels.height(); ++y)
      for (int x = 0; x < picture.pixels.width(); ++x)
        for (int c = 0; c < std::min(3, picture.pixels.channels()); ++c) picture.pixels.pixel(x, y)[c] *= 2;
    EXPECT_THAT(write_texture(folder / "b.exr", picture), ElementsAre());
    expect_others_kept(folder / "a.exr", folder / "b.exr", 0, names);
    EXPECT_EQ(read_texture(folder / "b.exr", {}, {}, layer).pixels, picture.pixels) << layer;
  }
}

TEST_F(PictureLayersTest, KeepsPartsOfOtherSizes) {
  write_parts();
  Texture picture = read_texture(folder / "a.exr");
  EXPECT_THAT(picture.format.layers->names, ElementsAre("motion", "beauty", "ids.crypto"));
  EXPECT_EQ(picture.format.layers->chosen, 1U);
  EXPECT_EQ(picture.pixels.width(), 9);
  for (float& value : picture.pixels.values()) value *= 2;
  write_texture(folder / "b.exr", picture);
  expect_others_kept(folder / "a.exr", folder / "b.exr", 1, {"R", "G", "B"});

  Texture motion = read_texture(folder / "a.exr", {}, {}, "motion");
  EXPECT_EQ(motion.pixels.width(), 6);
  for (float& value : motion.pixels.values()) value += 1;
  write_texture(folder / "c.exr", motion);
  expect_others_kept(folder / "a.exr", folder / "c.exr", 0, {"X", "Y"});
  EXPECT_EQ(read_texture(folder / "c.exr", {}, {}, "motion").pixels, motion.pixels);
}

TEST_F(PictureLayersTest, IsTheSameFileWhereNothingChanged) {
  write_parts();
  const Texture picture = read_texture(folder / "a.exr");
  write_texture(folder / "b.exr", picture);
  EXPECT_TRUE(get("a.exr") == get("b.exr"));
  write_encoded(folder / "c.exr", picture);
  expect_others_kept(folder / "a.exr", folder / "c.exr", 0, {});
}

TEST_F(PictureLayersTest, ChangesTheDepthOfTheProcessedLayerOnly) {
  write_render();
  Texture picture = read_texture(folder / "a.exr");
  picture.format.depth = Depth::f32;
  write_texture(folder / "b.exr", picture);
  const ExrPart before = read_exr(folder / "a.exr").at(0), after = read_exr(folder / "b.exr").at(0);
  for (const std::string& name : before.spec.channelnames)
    if (name.size() == 1 && name != "Z") {
      EXPECT_EQ(channel(after, name).first, TypeDesc(TypeDesc::FLOAT)) << name;
    } else {
      EXPECT_TRUE(channel(after, name) == channel(before, name)) << name;
    }
}

TEST_F(PictureLayersTest, LosesNothingToCompression) {
  for (const char* lossy : {"dwaa", "b44", "pxr24"}) {
    write_render(lossy);
    Texture picture = read_texture(folder / "a.exr");
    for (float& value : picture.pixels.values()) value *= 0.5F;
    EXPECT_THAT(write_texture(folder / "b.exr", picture), ElementsAre(AllOf(HasSubstr("zip"), HasSubstr(lossy))));
    expect_others_kept(folder / "a.exr", folder / "b.exr", 0, {"R", "G", "B", "A"});
  }
}

TEST_F(PictureLayersTest, SaysWhatIsLeftBehind) {
  write_render();
  Texture picture = read_texture(folder / "a.exr");
  EXPECT_THAT(write_texture(folder / "b.png", picture),
              ::testing::Contains(AllOf(HasSubstr("\"RGBA\" alone"), HasSubstr("3 others are left behind"))));
  picture.pixels = Image<float>(4, 4, 4);
  EXPECT_THAT(write_texture(folder / "b.exr", picture),
              ElementsAre(AllOf(HasSubstr("3 others are left behind"), HasSubstr("size"))));
  EXPECT_EQ(read_texture(folder / "b.exr").format.layers, nullptr);
}

TEST_F(PictureLayersTest, RefusesALayerThatIsNotThere) {
  write_render();
  EXPECT_THAT(refusal_of([&] { read_texture(folder / "a.exr", {}, {}, "lihgt"); }),
              AllOf(HasSubstr("a.exr"), HasSubstr("no layer 'lihgt'"), HasSubstr("RGBA"), HasSubstr("light")));
  EXPECT_THAT(refusal_of([&] { read_texture(folder / "a.exr", {}, {}, "object"); }), HasSubstr("type uint"));
  for (const char* name : {"a.png", "a.jpg", "a.webp"}) {
    write_image(folder / name, Image<float>(4, 4, 3));
    EXPECT_THAT(refusal_of([&] { read_texture(folder / name, {}, {}, "light"); }),
                AllOf(HasSubstr(name), HasSubstr("no layer 'light'")));
  }
}

/// Files with deep and flat parts are made by no version of OpenImageIO at hand.
TEST_F(PictureLayersTest, RefusesDeepParts) {
  ImageSpec deep(4, 4, 2, TypeDesc::FLOAT);
  deep.deep = true;
  deep.channelnames = {"A", "Z"};
  std::vector<ImageSpec> specs(2, deep);
  specs[0]["oiio:subimagename"] = "near", specs[1]["oiio:subimagename"] = "far";
  OIIO::DeepData samples(deep);
  for (int i = 0; i < 16; ++i) samples.set_samples(i, 1);
  const auto out = OIIO::ImageOutput::create("openexr");
  const std::string path = (folder / "a.exr").string();
  ASSERT_TRUE(out->open(path, 2, specs.data())) << out->geterror();
  ASSERT_TRUE(out->write_deep_image(samples)) << out->geterror();
  ASSERT_TRUE(out->open(path, specs[1], OIIO::ImageOutput::AppendSubimage)) << out->geterror();
  ASSERT_TRUE(out->write_deep_image(samples)) << out->geterror();
  ASSERT_TRUE(out->close());
  EXPECT_THAT(refusal_of([&] { read_texture(path); }), HasSubstr("deep image; flatten it first"));
}

TEST_F(PictureLayersTest, RefusesAFileThatIsCutShort) {
  write_parts();
  const auto size = fs::file_size(folder / "a.exr");
  for (const double share : {0.2, 0.5, 0.9}) {
    write_parts();
    fs::resize_file(folder / "a.exr", std::uintmax_t(share * double(size)));
    const std::string said = refusal_of([&] {
      Texture picture = read_texture(folder / "a.exr");
      picture.pixels.values()[0] += 1;
      write_texture(folder / "b.exr", picture);
    });
    EXPECT_THAT(said, HasSubstr(".exr")) << share;
    EXPECT_FALSE(fs::exists(folder / "b.exr"));
  }
}

}  // namespace
}  // namespace mq
