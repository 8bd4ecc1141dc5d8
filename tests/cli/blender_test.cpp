// What Blender exports is processed, and read by Blender again. Skipped where it is not installed.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "cli/program.h"
#include "places.h"

namespace mq::test {
namespace {

using testing::IsEmpty;
using Json = nlohmann::json;
using Words = std::vector<std::string>;

bool blender_is_there() { return std::system("command -v blender > /dev/null") == 0; }

/// blender_exchange.py VERB FOLDER, in Blender without a window.
void blender(const Folder& folder, const std::string& verb) {
  const std::string script = (places::source() / "tests/cli/blender_exchange.py").string();
  const std::string log = (folder / (verb + ".log")).string();
  const std::string line = "PATH=/usr/bin:$PATH blender --background --factory-startup --python-exit-code 1 --python '" +
                           script + "' -- " + verb + " '" + folder.path().string() + "' > '" + log +
                           "' 2>&1";
  ASSERT_EQ(std::system(line.c_str()), 0) << file_bytes(log);
}

/// Jumps of its normals at seams, in the model's axes; the root of their mean square.
double jumps(const Folder& folder, const std::string& file, const std::string& space = "tangent") {
  const Result result = marquetry(folder, {"seams", file, "--slot", "normal", "--normal-space", space,
                                           "-o", "unused.png", "--overwrite", "--json"});
  EXPECT_EQ(result.status, 0) << file << result.error;
  return result.status == 0 ? result.json()["result"]["seams"]["before"]["rms"].get<double>() : 1;
}

/// Filters PATH once for each choice of slots and notes down what Blender has to find changed.
void filter_slots(const Folder& folder, const std::string& name, const std::string& ending, Json& pairs) {
  const std::string before = name + "/" + name + ending;
  for (const auto& [slot, changed] : {std::pair<std::string, Words>{"", {"base-colour"}},
                                      {"normal", {"normal"}},
                                      {"all", {"base-colour", "normal"}}}) {
    const std::string into = name + "_" + (slot.empty() ? "first" : slot);
    const std::string after = into + "/" + name + ending;
    std::filesystem::create_directory(folder / into);
    Words words = {"filter", before, "-o", after, "--beta", "0", "--length", "2tx"};
    if (!slot.empty()) words.insert(words.end(), {"--slot", slot});
    const Result result = marquetry(folder, words);
    ASSERT_EQ(result.status, 0) << into << result.error;
    pairs.push_back({before, after, changed});
  }
}

// Blender bakes normals that are smooth over the surface, so they jump at no seam where its tangents
// are understood. Measured: 0.0014 with them, 0.158 with the green channel turned over.
TEST(Blender, ReadsItsModelsAgainWithOnlyTheProcessedPictureChanged) {
  if (!blender_is_there()) GTEST_SKIP() << "blender is not on the PATH";
  const Folder folder;
  ASSERT_NO_FATAL_FAILURE(blender(folder, "make"));
  EXPECT_EQ(file_bytes(folder / "plain_parts/plain_parts.gltf").find("TANGENT"), std::string::npos);
  EXPECT_NE(file_bytes(folder / "tangents_parts/tangents_parts.gltf").find("TANGENT"), std::string::npos);
  Json pairs = Json::array();
  for (const auto& [name, ending] : {std::pair<std::string, std::string>{"plain", ".glb"},
                                     {"tangents", ".glb"},
                                     {"plain_parts", ".gltf"},
                                     {"tangents_parts", ".gltf"}}) {
    ASSERT_NO_FATAL_FAILURE(filter_slots(folder, name, ending, pairs));
    EXPECT_LT(jumps(folder, name + "/" + name + ending), 0.004) << name;
    EXPECT_GT(jumps(folder, name + "/" + name + ending, "directx"), 0.1) << name;
    EXPECT_LT(jumps(folder, name + "_normal/" + name + ending), 0.004) << name;
    const Result inspected = marquetry(folder, {"inspect", name + "/" + name + ending, "--json"});
    const Json slots = inspected.json()["result"]["slots"];
    ASSERT_EQ(slots.size(), 2U) << name;
    for (const Json& slot : slots)
      EXPECT_EQ(slot["pictures"][0]["uv_set"], slot["slot"] == "normal" ? 0 : 1) << slot;
  }
  write_bytes(folder / "pairs.json", pairs.dump());
  ASSERT_NO_FATAL_FAILURE(blender(folder, "compare"));
  EXPECT_THAT(Json::parse(file_bytes(folder / "differences.json")), IsEmpty())
      << file_bytes(folder / "compare.log");
}

}  // namespace
}  // namespace mq::test
