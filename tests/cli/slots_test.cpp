#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "cli/gltf_square.h"
#include "cli/refusal.h"

namespace mq::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using Json = nlohmann::json;
using Words = std::vector<std::string>;

void expect_to_run(const Folder& folder, const Words& words) {
  const Result result = marquetry(folder, words);
  ASSERT_EQ(result.status, 0) << result.error;
}

const std::set<std::string> all_pictures{"g_color.png", "g_orm.png", "g_n.png", "g_glow.png"};

/// Which pictures of DIR/pbr.gltf differ from those that were read.
std::set<std::string> changed_in(const Folder& folder, const std::string& directory) {
  std::set<std::string> changed;
  for (const std::string& name : all_pictures)
    if (file_bytes(folder / (directory + "/" + name)) != file_bytes(folder / name))
      changed.insert(name);
  EXPECT_EQ(file_bytes(folder / (directory + "/pbr.gltf")), file_bytes(folder / "pbr.gltf"));
  return changed;
}

TEST(SlotsOfModels, AreListedWithWhatWillBeDone) {
  const Folder folder;
  write_pbr(folder);
  const Json json = marquetry(folder, {"inspect", "pbr.gltf", "--json"}).json();
  Json names = Json::array();
  for (const Json& slot : json["result"]["slots"]) {
    names.push_back(slot["slot"]);
    EXPECT_EQ(slot["processed"], slot["slot"] == "base-colour");
  }
  EXPECT_THAT(names, ElementsAre("base-colour", "metallic-roughness", "emissive", "normal"));
  const std::string said = marquetry(folder, {"check", "pbr.gltf", "--slot", "orm"}).output;
  EXPECT_THAT(said, HasSubstr("metallic-roughness: g_orm.png with set 0 (processed)"));
  EXPECT_THAT(said, HasSubstr("base-colour: g_color.png with set 0 (kept as it is)"));
}

TEST(SlotsOfModels, APictureReplacesTheSlotWhosePictureItIs) {
  const Folder folder;
  write_pbr(folder);
  std::filesystem::create_directory(folder / "out");
  expect_to_run(folder, {"filter", "pbr.gltf", "g_orm.png", "-o", "out/pbr.gltf", "--beta", "0"});
  EXPECT_THAT(changed_in(folder, "out"), ElementsAre("g_orm.png"));
}

TEST(SlotsOfModels, AreProcessedOneAtATime) {
  for (const auto& [slot, picture] : {std::pair("base-color", "g_color.png"), {"emissive", "g_glow.png"},
                                      {"metallicRoughnessTexture", "g_orm.png"}}) {
    const Folder folder;
    write_pbr(folder);
    std::filesystem::create_directory(folder / "out");
    expect_to_run(folder, {"filter", "pbr.gltf", "--slot", slot, "-o", "out/pbr.gltf", "--beta", "0"});
    EXPECT_THAT(changed_in(folder, "out"), ElementsAre(picture));
    expect_to_run(folder, {"filter", "pbr.gltf", "--slot", slot, "-o", "beside.gltf", "--beta", "0"});
    EXPECT_EQ(file_bytes(folder / "beside.gltf").find(picture), std::string::npos);
    for (const std::string& other : all_pictures) {
      if (other == picture) continue;
      EXPECT_NE(file_bytes(folder / "beside.gltf").find('"' + other), std::string::npos) << other;
    }
  }
}

TEST(SlotsOfModels, AllAreProcessedEachOnItsOwn) {
  const Folder folder;
  write_pbr(folder);
  std::filesystem::create_directory(folder / "out");
  const Words filter = {"filter", "pbr.gltf", "--beta", "0"};
  const auto with = [&](Words more) {
    Words words = filter;
    words.insert(words.end(), more.begin(), more.end());
    return words;
  };
  const Result result =
      marquetry(folder, with({"--slot", "all", "-o", "out/pbr.gltf", "--json"}));
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.json()["slots"].size(), 4u);
  EXPECT_EQ(result.json()["result"]["outputs"].size(), 5u);
  // The flat normal map stays as it was, bit for bit.
  EXPECT_EQ(changed_in(folder, "out"), (std::set<std::string>{"g_color.png", "g_orm.png", "g_glow.png"}));
  for (const auto& [slot, picture] : {std::pair("base-colour", "g_color.png"), {"emissive", "g_glow.png"},
                                      {"metallic-roughness", "g_orm.png"}}) {
    expect_to_run(folder, with({"--slot", slot, "-o", "alone.png", "--overwrite"}));
    EXPECT_EQ(file_bytes(folder / "alone.png"), file_bytes(folder / (std::string("out/") + picture)))
        << slot;
  }
  expect_to_run(folder, with({"--slot", "all", "-o", "pictures/"}));
  expect_to_run(folder, with({"--slot", "emissive,base-colour", "-o", "beside.gltf"}));
  for (const char* picture : {"g_color.png", "g_glow.png"}) {
    EXPECT_EQ(file_bytes(folder / ("pictures/" + std::string(picture))),
              file_bytes(folder / ("out/" + std::string(picture))));
    EXPECT_EQ(file_bytes(folder / ("beside_" + std::string(picture))),
              file_bytes(folder / ("out/" + std::string(picture))));
  }
  EXPECT_THAT(file_bytes(folder / "beside.gltf"), HasSubstr("\"beside_g_glow.png\""));
  EXPECT_THAT(file_bytes(folder / "beside.gltf"), HasSubstr("\"g_orm.png\""));
}

TEST(SlotsOfModels, InsideOneFileChangeThere) {
  const Folder folder;
  write_pbr(folder);
  Json gltf = Json::parse(file_bytes(folder / "pbr.gltf"));
  for (Json& image : gltf["images"]) {
    const std::string name = image["uri"];
    image = {{"name", name}, {"uri", data_uri("image/png", to_bytes(file_bytes(folder / name)))}};
  }
  write_bytes(folder / "whole.gltf", gltf.dump(1));
  const auto picture = [&](const std::string& file, const std::string& slot, const std::string& beta) {
    expect_to_run(folder, {"filter", file, "--slot", slot, "--beta", beta, "-o", "x.png", "--overwrite"});
    return read_texture(folder / "x.png").pixels;
  };
  const auto same = [](const Image<float>& a, const Image<float>& b) {
    return std::ranges::equal(a.values(), b.values());
  };
  expect_to_run(folder, {"filter", "whole.gltf", "--slot", "all", "--beta", "0", "-o", "all.gltf"});
  expect_to_run(folder, {"filter", "whole.gltf", "--slot", "emissive", "--beta", "0", "-o", "one.gltf"});
  for (const char* slot : {"base-colour", "emissive", "orm"}) {
    const Image<float> soft = picture("whole.gltf", slot, "0");
    EXPECT_TRUE(same(picture("all.gltf", slot, "1"), soft)) << slot;
    EXPECT_EQ(same(picture("one.gltf", slot, "1"), soft), std::string(slot) == "emissive") << slot;
  }
  EXPECT_TRUE(same(picture("one.gltf", "orm", "1"), read_texture(folder / "g_orm.png").pixels));
  EXPECT_EQ(folder.names().size(), 9u) << "no picture is written beside";
}

TEST(SlotsOfModels, OfOnePictureAreProcessedOnce) {
  const Folder folder;
  const Json material = {{"pbrMetallicRoughness", {{"metallicRoughnessTexture", {{"index", 0}}}}},
                         {"occlusionTexture", {{"index", 0}}}};
  write_bytes(folder / "orm.gltf", square_gltf({"g_orm.png"}, material).dump(1));
  write_image(folder / "g_orm.png", busy_picture(32, 32));
  const Result result = marquetry(
      folder, {"filter", "orm.gltf", "--slot", "all", "--beta", "0", "-o", "soft.gltf", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.json()["slots"].size(), 1u);
  EXPECT_THAT(result.error, HasSubstr("\"g_orm.png\" is that of two slots"));
  EXPECT_THAT(marquetry(folder, {"inspect", "orm.gltf", "--slot", "orm"}).output,
              HasSubstr("occlusion: g_orm.png with set 0 (changes with it: one picture for both)"));
  expect_to_run(folder, {"filter", "orm.gltf", "--slot", "occlusion", "--beta", "0", "-o", "alone.png"});
  EXPECT_EQ(file_bytes(folder / "soft.png"), file_bytes(folder / "alone.png"));
}

TEST(SlotsOfModels, NumbersHaveNoCurveOfColours) {
  const Folder folder;
  write_pbr(folder);
  const auto filtered = [&](const std::string& slot, const std::string& space) {
    expect_to_run(folder, {"filter", "pbr.gltf", "--slot", slot, "--space", space, "-o", "x.png", "--beta", "0",
                 "--overwrite"});
    return file_bytes(folder / "x.png");
  };
  EXPECT_EQ(filtered("orm", "linear"), filtered("orm", "stored"));
  EXPECT_NE(filtered("emissive", "linear"), filtered("emissive", "stored"));
}

TEST(SlotsOfModels, ThatCannotBeAreRefused) {
  const Folder folder;
  write_pbr(folder);
  const auto said = [&](Words more, const std::string& out = "out.gltf") {
    Words words = {"filter", "pbr.gltf", "--beta", "0", "-o", out};
    words.insert(words.end(), more.begin(), more.end());
    return refusal(folder, words, out);
  };
  EXPECT_THAT(said({"--slot", "occlusion"}), HasSubstr("they have base-colour, metallic-roughness"));
  EXPECT_THAT(said({"--slot", "all"}, "out.obj"), HasSubstr("into the format that was read, .gltf"));
  EXPECT_THAT(said({"--slot", "all"}, "out.png"), HasSubstr("has 4 textures"));
  EXPECT_THAT(said({"--slot", "normal"}, "out.ply"), HasSubstr("PLY names pictures for base-colour"));
  EXPECT_THAT(said({"--slot", "normal", "--geometry"}, "out.ply"), HasSubstr("--slot"));
  EXPECT_THAT(said({"--slot", "all", "--vertices"}), HasSubstr("--vertices looks at none"));
  EXPECT_THAT(refusal(folder, {"stitch", "pbr.gltf", "--slot", "all", "-o", "o.gltf"}, "o.gltf"),
              HasSubstr("'stitch' takes one slot at a time"));
  write_lightmap(folder);
  EXPECT_THAT(refusal(folder, {"filter", "lightmap.gltf", "g_orm.png", "--beta", "0", "-o", "o.gltf"},
                      "o.gltf"),
              HasSubstr("say what it is for by --slot"));
}

TEST(SlotsOfModels, InTilesComeBackWithTheModel) {
  const Folder folder;
  write_strip(folder);
  std::string text = strip_obj;
  text.replace(text.find("vt"), text.find("f 1") - text.find("vt"),
               "vt 0.1 0.1\nvt 0.9 0.1\nvt 0.9 0.9\nvt 0.1 0.9\n"
               "vt 1.1 0.1\nvt 1.9 0.1\nvt 1.9 0.9\nvt 1.1 0.9\n");
  write_bytes(folder / "strip.obj", text);
  write_bytes(folder / "strip.mtl", "newmtl strip\nmap_Kd c.<UDIM>.png\nmap_Pr r.<UDIM>.png\n");
  for (const char* tile : {"c.1001.png", "c.1002.png", "r.1001.png", "r.1002.png"})
    write_image(folder / tile, busy_picture(32, 24));
  std::filesystem::create_directory(folder / "out");
  expect_to_run(folder, {"filter", "strip.obj", "--beta", "0", "-o", "out/strip.obj"});
  EXPECT_EQ(file_bytes(folder / "out/strip.mtl"), file_bytes(folder / "strip.mtl"));
  for (const char* tile : {"r.1001.png", "r.1002.png"})
    EXPECT_EQ(file_bytes(folder / "out" / tile), file_bytes(folder / tile));
  EXPECT_NE(file_bytes(folder / "out/c.1002.png"), file_bytes(folder / "c.1002.png"));
  expect_to_run(folder, {"filter", "strip.obj", "--beta", "0", "--slot", "all", "-o", "soft.obj"});
  EXPECT_EQ(file_bytes(folder / "soft.mtl"),
            "newmtl strip\nmap_Kd soft_c.<UDIM>.png\nmap_Pr soft_r.<UDIM>.png\n");
  for (const char* tile : {"soft_r.1002.png", "soft_c.1002.png"})
    EXPECT_EQ(file_bytes(folder / tile), file_bytes(folder / "out/c.1002.png")) << tile;
}

TEST(SlotsOfModels, ProcessAPictureAsOftenAsTheFileNamesIt) {
  const Folder folder;
  Json gltf = square_gltf({"a.png", "b.png", "b.png"},
                          {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}},
                           {"emissiveTexture", {{"index", 1}}}});
  gltf["materials"].push_back(gltf["materials"][0]);
  gltf["materials"][1]["emissiveTexture"]["index"] = 2;
  Json second = gltf["meshes"][0]["primitives"][0];
  second["material"] = 1;
  gltf["meshes"][0]["primitives"].push_back(second);
  gltf["nodes"][0]["scale"] = {1, 1, 1};
  write_bytes(folder / "twice.gltf", gltf.dump(1));
  for (const char* name : {"a.png", "b.png"}) write_image(folder / name, busy_picture(16, 16));
  std::filesystem::create_directory(folder / "out");
  expect_to_run(folder, {"filter", "twice.gltf", "--slot", "all", "--beta", "0", "-o", "out/twice.gltf"});
  int pictures = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "out"))
    if (entry.path().extension() == ".png") {
      ++pictures;
      EXPECT_NE(file_bytes(entry.path()), file_bytes(folder / "a.png")) << entry.path();
    }
  EXPECT_EQ(pictures, 3);
}

}  // namespace
}  // namespace mq::test
