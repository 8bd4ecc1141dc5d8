// What the program says of itself, whatever the verb.
#include "cli/program.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <sstream>

#include "cli/models.h"

namespace mq::test {
namespace {

using testing::HasSubstr;
using testing::StartsWith;
using Json = nlohmann::json;

TEST(Program, SaysItsVersion) {
  const Result result = marquetry({}, {"--version"});
  EXPECT_EQ(result.status, 0);
  EXPECT_THAT(result.output, StartsWith("marquetry "));
  EXPECT_EQ(result.error, "");
}

TEST(Program, ListsItsVerbs) {
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"--help"}, {"-h"}, {"help"}}) {
    const Result result = marquetry({}, words);
    EXPECT_EQ(result.status, 0);
    EXPECT_THAT(result.output, HasSubstr("usage: marquetry VERB"));
  }
}

TEST(Program, BeginsWithAFewLines) {
  const Result result = marquetry({}, {});
  EXPECT_EQ(result.status, 0);
  EXPECT_THAT(result.output, HasSubstr("marquetry help"));
  EXPECT_LE(std::ranges::count(result.output, '\n'), 12);
}

TEST(Program, RefusesAnUnknownVerb) {
  const Result result = marquetry({}, {"fitler"});
  EXPECT_EQ(result.status, 2);
  EXPECT_EQ(result.output, "");
  EXPECT_THAT(result.error, StartsWith("marquetry: there is no verb 'fitler'"));
  EXPECT_THAT(marquetry({}, {"sharpen"}).error, HasSubstr("'filter --strength 50%' sharpens"));
}

TEST(Program, NoticesThatItsOutputIsLost) {
  const Result result = marquetry({}, {"--help"}, {.standard_output = "/dev/full"});
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.error, HasSubstr("standard output"));
}

TEST(Program, TellsProgramsWhatWentWrong) {
  const Folder folder;
  write_bytes(folder / "cut.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n");
  for (const char* verb : {"inspect", "check", "filter", "render"}) {
    std::vector<std::string> words = {verb, "cut.obj", "--json"};
    if (words[0] == "filter") words.insert(words.end(), {"--beta", "1"});
    if (words[0] == "filter" || words[0] == "render") words.insert(words.end(), {"-o", "o.png"});
    const Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 2);
    const auto json = result.json();
    EXPECT_EQ(json["verb"], verb);
    EXPECT_EQ(json["error"]["file"], "cut.obj");
    EXPECT_THAT(json["error"]["message"].get<std::string>(), HasSubstr("line 4"));
    EXPECT_THAT(result.error, HasSubstr(json["error"]["message"].get<std::string>()));
  }
  const auto missing = marquetry(folder, {"inspect", "no.obj", "--json"}).json();
  EXPECT_EQ(missing["error"]["file"], "no.obj");
  const auto option = marquetry(folder, {"sample", "--jsn", "--json"}).json();
  EXPECT_THAT(option["error"]["message"].get<std::string>(), HasSubstr("did you mean '--json'?"));
  EXPECT_FALSE(option["error"].contains("file"));
}

TEST(Program, NamesTheLineOfAConfigurationThatIsNotUtf8) {
  const Folder folder;
  write_bytes(folder / "c.json", "{\n\"mesh\": \"gr\xfc\xdf.obj\"}\n");
  const Result result = marquetry(folder, {"inspect", "--config", "c.json"});
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.error, HasSubstr("c.json, line 2, column 12: holds bytes that are not UTF-8"));
}

/// The lines of a text, each an object of JSON.
std::vector<Json> json_lines(const std::string& text) {
  std::vector<Json> lines;
  std::stringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    lines.push_back(Json::parse(line, nullptr, false));
    EXPECT_TRUE(lines.back().is_object()) << line;
  }
  return lines;
}

TEST(Program, TellsProgramsHowFarItIs) {
  const Folder folder;
  write_strip(folder);
  const Result result = marquetry(folder, {"filter", "strip.obj", "-o", "out.png", "--beta", "2", "--size", "8",
                                           "--progress", "json"});
  EXPECT_EQ(result.status, 2);  // filter has no --size
  std::vector<Json> lines = json_lines(result.error);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0]["event"], "error");
  EXPECT_THAT(lines[0]["text"].get<std::string>(), HasSubstr("--size"));

  const Result done = marquetry(folder, {"filter", "strip.obj", "-o", "out.png", "--beta", "9", "--progress=json"});
  EXPECT_EQ(done.status, 0) << done.error;
  lines = json_lines(done.error);
  double fraction = 0, elapsed = 0;
  std::set<std::string> events;
  for (const Json& line : lines) {
    events.insert(line["event"]);
    if (line["event"] != "progress") continue;
    EXPECT_FALSE(line["step"].get<std::string>().empty());
    EXPECT_GE(line["fraction"], fraction);
    EXPECT_LE(line["fraction"], 1);
    EXPECT_GE(line["elapsed"], elapsed);
    EXPECT_TRUE(line["left"].is_null() || line["left"].get<double>() >= 0);
    fraction = line["fraction"], elapsed = line["elapsed"];
  }
  EXPECT_THAT(events, testing::IsSupersetOf({"progress", "remark"}));
  EXPECT_THAT(lines.back()["text"].get<std::string>(), HasSubstr("out.png"));
}

}  // namespace
}  // namespace mq::test
