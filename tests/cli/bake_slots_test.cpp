// Pictures of all slots in files made anew, and baked.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "cli/gltf_square.h"
#include "cli/refusal.h"

namespace mq::test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using Json = nlohmann::json;
using Words = std::vector<std::string>;

Result run(const Folder& folder, const Words& words) {
  Result result = marquetry(folder, words);
  EXPECT_EQ(result.status, 0) << result.error;
  return result;
}

std::set<std::string> slots_in(const Folder& folder, const std::string& file) {
  std::set<std::string> names;
  for (const MaterialSlot& slot : read_model(folder / file).slots) names.insert(slot.name);
  return names;
}

Image<float> picture_of(const Folder& folder, const std::string& file, const std::string& slot) {
  const Model model = read_model(folder / file, {.textures = {}, .slot = slot});
  return model.textures.front().pixels;
}

std::set<std::string> files_in(const Folder& folder, const std::string& inner) {
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder / inner))
    names.insert(inner + "/" + entry.path().filename().string());
  return names;
}

bool same(const Image<float>& a, const Image<float>& b) {
  return a.width() == b.width() && std::ranges::equal(a.values(), b.values());
}

TEST(FilesMadeAnew, NameThePicturesOfAllSlots) {
  const Folder folder;
  write_pbr(folder);
  // An extension that names buffers in its own way keeps the JSON from going into a GLB.
  Json square = Json::parse(file_bytes(folder / "pbr.gltf"));
  square["extensionsUsed"] = {"EXT_structural_metadata"};
  write_bytes(folder / "pbr.gltf", square.dump());
  for (const std::string file : {"anew.glb", "out/anew.obj"}) {
    std::filesystem::create_directory(folder / "out");
    const Result result = run(folder, {"filter", "pbr.gltf", "--beta", "0", "-o", file});
    const bool is_obj = file.ends_with(".obj");
    EXPECT_EQ(slots_in(folder, file),
              is_obj ? (std::set<std::string>{"base-colour", "normal"})
                     : (std::set<std::string>{"base-colour", "metallic-roughness", "normal"}));
    // MTL has no word for metallic-roughness; the emissive picture has other texture coordinates.
    EXPECT_THAT(result.error, HasSubstr("made anew: not all pictures for "));
    EXPECT_EQ(result.error.find("metallic-roughness") != std::string::npos, is_obj) << result.error;
    EXPECT_THAT(result.error, HasSubstr("emissive"));
    EXPECT_TRUE(same(picture_of(folder, file, "normal"), read_texture(folder / "g_n.png").pixels));
    EXPECT_FALSE(same(picture_of(folder, file, "base-colour"), read_texture(folder / "g_color.png").pixels));
  }
  EXPECT_TRUE(same(picture_of(folder, "anew.glb", "metallic-roughness"),
                   read_texture(folder / "g_orm.png").pixels));
}

TEST(OtherContainers, KeepMaterialsAndAllPictures) {
  const Folder folder;
  write_pbr(folder);
  const std::set<std::string> slots{"base-colour", "metallic-roughness", "normal", "emissive"};
  const Json materials = Json::parse(file_bytes(folder / "pbr.gltf"))["materials"];
  std::filesystem::create_directory(folder / "in");
  Result result = run(folder, {"filter", "pbr.gltf", "--beta", "0", "-o", "in/pbr.glb", "--json"});
  EXPECT_EQ(result.json()["result"]["outputs"], Json({"in/pbr.glb"}));
  EXPECT_EQ(files_in(folder, "in"), std::set<std::string>{"in/pbr.glb"});
  EXPECT_EQ(slots_in(folder, "in/pbr.glb"), slots);
  EXPECT_FALSE(same(picture_of(folder, "in/pbr.glb", "base-colour"), read_texture(folder / "g_color.png").pixels));

  std::filesystem::create_directory(folder / "out");
  result = run(folder, {"filter", "in/pbr.glb", "--beta", "1", "-o", "out/pbr.gltf", "--json"});
  std::set<std::string> listed{"out/pbr.bin"};
  const Json report = result.json();
  for (const Json& name : report["result"]["outputs"]) listed.insert(name.get<std::string>());
  EXPECT_EQ(files_in(folder, "out"), listed);
  EXPECT_EQ(listed.size(), 6u);
  EXPECT_EQ(slots_in(folder, "out/pbr.gltf"), slots);
  for (const auto& [slot, file] : {std::pair("normal", "g_n.png"), {"emissive", "g_glow.png"}})
    EXPECT_TRUE(same(picture_of(folder, "out/pbr.gltf", slot), read_texture(folder / file).pixels));
  EXPECT_EQ(Json::parse(file_bytes(folder / "out/pbr.gltf"))["materials"], materials);
}

TEST(OtherContainers, HoldAllSlotsProcessed) {
  const Folder folder;
  write_pbr(folder);
  run(folder, {"filter", "pbr.gltf", "--slot", "all", "--beta", "0", "-o", "all.glb"});
  std::filesystem::create_directory(folder / "out");
  run(folder, {"filter", "pbr.gltf", "--slot", "all", "--beta", "0", "-o", "out/all.gltf"});
  for (const std::string slot : {"base-colour", "metallic-roughness", "normal", "emissive"})
    EXPECT_TRUE(same(picture_of(folder, "all.glb", slot), picture_of(folder, "out/all.gltf", slot))) << slot;
  EXPECT_FALSE(same(picture_of(folder, "all.glb", "emissive"), read_texture(folder / "g_glow.png").pixels));
}

TEST(Outputs, HaveTheFoldersOfTheirPictures) {
  const Folder folder;
  write_pbr(folder);
  std::string text = file_bytes(folder / "pbr.gltf");
  std::filesystem::create_directories(folder / "textures");
  for (const std::string name : {"g_color.png", "g_orm.png", "g_n.png", "g_glow.png"}) {
    std::filesystem::rename(folder / name, folder / "textures" / name);
    text.replace(text.find(name), name.size(), "textures/" + name);
  }
  write_bytes(folder / "pbr.gltf", text);
  std::filesystem::create_directory(folder / "out");
  run(folder, {"filter", "pbr.gltf", "--beta", "0", "-o", "out/pbr.gltf", "--dry-run"});
  EXPECT_TRUE(files_in(folder, "out").empty());
  run(folder, {"filter", "pbr.gltf", "--beta", "0", "-o", "out/pbr.gltf"});
  EXPECT_EQ(files_in(folder, "out/textures").size(), 4u);
  EXPECT_TRUE(same(picture_of(folder, "out/pbr.gltf", "normal"), read_texture(folder / "textures/g_n.png").pixels));
  run(folder, {"filter", "pbr.gltf", "--beta", "0", "-o", "none/such/pbr.gltf"});
  EXPECT_EQ(files_in(folder, "none/such/textures").size(), 4u);
}

TEST(OtherContainers, AreCompressedOnRequest) {
  const Folder folder;
  write_strip(folder);
  for (const std::string how : {"meshopt", "draco"}) {
    run(folder, {"filter", "strip.obj", "--beta", "2", "-o", how + ".glb", "--compress", how});
    const Model model = read_model(folder / (how + ".glb"));
    EXPECT_THAT(model.notes, testing::Contains(HasSubstr(how == "draco" ? "Draco" : "meshopt")));
    EXPECT_EQ(model.mesh.triangle_count(), read_model(folder / "strip.obj").mesh.triangle_count());
  }
  EXPECT_THAT(refusal(folder, {"filter", "strip.obj", "--beta", "2", "-o", "x.png", "--compress", "draco"}, "x.png"),
              HasSubstr("--compress draco: it is for .gltf and .glb, and --output is 'x.png'"));
}

TEST(FilesMadeAnew, LeaveOutWhatMaterialsDoNotAgreeOn) {
  const Folder folder;
  write_strip(folder);
  write_image(folder / "n.png", busy_picture(8, 8));
  write_image(folder / "m.png", busy_picture(4, 4));
  std::string text = strip_obj;
  text.insert(text.find("f 2/5"), "usemtl other\n");
  write_bytes(folder / "strip.obj", text);
  const std::string first = "newmtl strip\nmap_Kd strip.png\nnorm n.png\n";
  for (const auto& [second, names_it] :
       {std::pair<std::string, bool>("norm n.png\n", true), {"norm m.png\n", false}, {"", false}}) {
    write_bytes(folder / "strip.mtl", first + "newmtl other\nmap_Kd strip.png\n" + second);
    const Result result = run(folder, {"filter", "strip.obj", "--beta", "0", "-o", "x.gltf", "--overwrite"});
    EXPECT_EQ(slots_in(folder, "x.gltf").contains("normal"), names_it);
    EXPECT_EQ(result.error.find("not all pictures for normal") == std::string::npos, names_it);
  }
}

TEST(VerbBake, CarriesAllSlotsIntoAModelOrAFolder) {
  const Folder folder;
  write_pbr(folder);
  write_square_obj(folder, "target", "0.2", "0.8", "none.png");
  write_bytes(folder / "target.mtl", "newmtl m\n");
  const Result all =
      run(folder, {"bake", "pbr.gltf", "target.obj", "-o", "all.gltf", "--size", "64", "--json"});
  Json slots = Json::array();
  const Json report = all.json();
  for (const Json& slot : report["result"]["slots"]) {
    slots.push_back(slot["slot"]);
    EXPECT_EQ(slot["unseen"], 0);
  }
  EXPECT_THAT(slots, ElementsAre("base-colour", "normal", "metallic-roughness", "emissive"));
  std::filesystem::create_directory(folder / "out");
  run(folder, {"bake", "pbr.gltf", "target.obj", "-o", "out/", "--size", "64"});
  for (const auto& [slot, file] : {std::pair("base-colour", "out/target.png"),
                                   {"metallic-roughness", "out/metallic-roughness.png"},
                                   {"normal", "out/normal.png"},
                                   {"emissive", "out/emissive.png"}}) {
    run(folder, {"bake", "pbr.gltf", "target.obj", "--slot", slot, "-o", "one.png", "--size", "64", "--overwrite"});
    const Image<float> one = read_texture(folder / "one.png").pixels;
    EXPECT_TRUE(same(one, picture_of(folder, "all.gltf", slot))) << slot;
    EXPECT_TRUE(same(one, read_texture(folder / file).pixels)) << slot;
  }
}

TEST(VerbBake, OfSeveralSlotsWantsAPlaceForEach) {
  const Folder folder;
  write_pbr(folder);
  write_square_obj(folder, "target", "0.2", "0.8", "none.png");
  write_bytes(folder / "target.mtl", "newmtl m\n");
  run(folder, {"bake", "pbr.gltf", "target.obj", "-o", "base.png"});
  const auto refused = [&](const Words& more, const std::string& output) {
    Words words{"bake", "pbr.gltf", "target.obj", "--slot", "base-colour,orm", "-o", output};
    words.insert(words.end(), more.begin(), more.end());
    return refusal(folder, words, output);
  };
  EXPECT_THAT(refused({}, "x.png"), AllOf(HasSubstr("--output"), HasSubstr("2 textures")));
  EXPECT_THAT(refused({"--vertices"}, "x.ply"), AllOf(HasSubstr("--vertices"), HasSubstr("several")));
}

TEST(VerbUnwrap, BakesAllSlots) {
  const Folder folder;
  write_pbr(folder);
  run(folder, {"unwrap", "pbr.gltf", "--bake", "-o", "new.glb", "--size", "64"});
  EXPECT_EQ(slots_in(folder, "new.glb"),
            (std::set<std::string>{"base-colour", "metallic-roughness", "normal", "emissive"}));
  run(folder, {"unwrap", "pbr.gltf", "--bake", "--slot", "orm", "-o", "orm.glb", "--size", "64"});
  EXPECT_TRUE(same(picture_of(folder, "new.glb", "metallic-roughness"),
                   read_model(folder / "orm.glb").textures.front().pixels));
}

TEST(VerbRemesh, BakesWhatBothShowed) {
  const Folder folder;
  write_strip(folder);
  Image<float> smooth(64, 48, 3);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x)
      for (int c = 0; c < 3; ++c)
        smooth(x, y, c) = float(0.5 + 0.3 * std::sin(0.3 * x + c) * std::cos(0.25 * y));
  write_image(folder / "strip.png", smooth);
  const Result result = run(
      folder, {"remesh", "strip.obj", "strip.obj", "--bake", "--size", "128", "-o", "new.glb", "--json"});
  EXPECT_EQ(result.json()["result"]["unseen"], 0);
  const Model made = read_model(folder / "new.glb");
  ASSERT_EQ(made.textures.size(), 1u);
  EXPECT_EQ(made.textures.front().pixels.width(), 128);
  run(folder, {"bake", "new.glb", "strip.obj", "-o", "back.png"});
  const Image<float> before = read_texture(folder / "strip.png").pixels,
                     after = read_texture(folder / "back.png").pixels;
  double sum = 0;
  int count = 0;
  for (int y = 8; y < 40; ++y)
    for (int x : {6, 10, 15, 20, 25, 38, 45, 50, 55})
      sum += std::pow(before(x, y, 0) - after(x, y, 0), 2), ++count;
  EXPECT_LT(std::sqrt(sum / count), 0.02);
  const Words remesh{"remesh", "strip.obj", "strip.obj", "-o", "x.glb"};
  const auto refused = [&](Words more) {
    more.insert(more.begin(), remesh.begin(), remesh.end());
    return refusal(folder, more, "x.glb");
  };
  EXPECT_THAT(refused({"--bake", "--no-textures"}), HasSubstr("nothing to bake with --no-textures"));
  EXPECT_THAT(refused({"--size", "64"}), HasSubstr("--bake"));
}

}  // namespace
}  // namespace mq::test
