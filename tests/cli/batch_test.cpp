// Many verbs with one start.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/models.h"
#include "cli/program.h"
#include "cli/refusal.h"

namespace mq::test {
namespace {

using testing::HasSubstr;
using testing::Not;

/// A folder with a strip and jobs.json.
struct Jobs : Folder {
  explicit Jobs(const std::string& jobs) {
    write_strip(*this);
    write_bytes(*this / "jobs.json", jobs);
  }
};

bool is_there(const Folder& folder, const std::string& name) {
  return std::filesystem::exists(folder / name);
}

TEST(Batch, DoesWhatCommandsDoOneAfterAnother) {
  const Jobs folder(R"({"jobs": [["filter", "strip.obj", "--beta", 2, "-o", "a.obj"],
    {"verb": "filter", "options": {"mesh": "a.obj", "beta": 0.5, "output": "b.png"}},
    {"verb": "seams", "mesh": "strip.obj", "output": "c.png"}]})");
  const Result result = marquetry(folder, {"batch", "jobs.json", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  ASSERT_EQ(marquetry(folder, {"filter", "strip.obj", "--beta", "2", "-o", "x.obj"}).status, 0);
  ASSERT_EQ(marquetry(folder, {"filter", "x.obj", "--beta", "0.5", "-o", "y.png"}).status, 0);
  ASSERT_EQ(marquetry(folder, {"seams", "strip.obj", "-o", "z.png"}).status, 0);
  EXPECT_EQ(file_bytes(folder / "b.png"), file_bytes(folder / "y.png"));
  EXPECT_EQ(file_bytes(folder / "c.png"), file_bytes(folder / "z.png"));
  const auto report = result.json();
  EXPECT_EQ(report.at("result").at("failed"), 0);
  EXPECT_FALSE(report.at("result").contains("cancelled"));
  ASSERT_EQ(report.at("result").at("jobs").size(), 3U);
  EXPECT_EQ(report.at("result").at("jobs").at(1).at("options").at("beta"), 0.5);
}

TEST(Batch, RepeatsReports) {
  const Jobs folder("[]");
  ASSERT_EQ(
      marquetry(folder, {"filter", "strip.obj", "--beta", "2", "-o", "a.png", "--report", "a.json"}).status,
      0);
  const std::string first = file_bytes(folder / "a.png");
  write_bytes(folder / "jobs.json", "[" + file_bytes(folder / "a.json") + "]");
  std::filesystem::remove(folder / "a.png");
  ASSERT_EQ(marquetry(folder, {"batch", "jobs.json"}).status, 0);
  EXPECT_EQ(file_bytes(folder / "a.png"), first);
}

TEST(Batch, ReadsAllJobsBeforeTheFirstIsRun) {
  const Jobs folder(
      "[[\"filter\", \"strip.obj\", \"--beta\", \"2\", \"-o\", \"a.png\"],\n"
      " {\"verb\": \"filter\", \"options\": {\"mesh\": \"strip.obj\",\n  \"betta\": 2, \"output\": "
      "\"b.png\"}}]");
  const std::string said = refusal(folder, {"batch", "jobs.json"}, "a.png");
  EXPECT_THAT(said, HasSubstr("job 2 of 2: jobs.json, line 3, column 12: "));
  EXPECT_THAT(said, HasSubstr("did you mean '--beta'?"));
}

TEST(Batch, SaysWhereAJobIsNone) {
  const std::map<std::string, std::string> cases = {
      {"[]", "no job"},
      {"{\"jobs\": [[\"check\", \"strip.obj\"]], \"threads\": 1}", "found 'threads'"},
      {"[{\"verb\": \"check\", \"options\": {\"mesh\": \"strip.obj\"}, \"weld\": \"none\"}]",
       "found 'weld' beside"},
      {"[[\"check\", \"strip.obj\", \"--report\", \"jobs.json\"]]", "the list of what is run"},
      {"[[\"check\", \"strip.obj\\u0000.obj\"]]", "wanted"},
      {"3", "no list"},
      {"{\"jobs\": 3}", "no list"},
      {"[\"filter\"]", "found string"},
      {"[[]]", "empty list"},
      {"[[\"fliter\"]]", "did you mean 'filter'?"},
      {"[{\"options\": {}}]", "no \"verb\""},
      {"[[\"batch\", \"jobs.json\"]]", "cannot be run by 'batch'"},
      {"[[\"view\", \"strip.obj\"]]", "cannot be run by 'batch'"},
      {"[[\"filter\", [1]]]", "wanted a text"},
      {"[[\"filter\", \"strip.obj\", \"-o\", \"a.png\", \"--json\"]]", "give it to 'batch'"},
      {"[[\"filter\", \"-\", \"-o\", \"a.png\"]]", "standard input"},
      {"[[\"filter\", \"strip.obj\"]]", "--output"},
      {"[[\"filter\"", "jobs.json, line 1"}};
  for (const auto& [jobs, wanted] : cases) {
    const Jobs folder(jobs);
    EXPECT_THAT(refusal(folder, {"batch", "jobs.json"}, "a.png"), HasSubstr(wanted)) << jobs;
  }
}

TEST(Batch, WaitsForWhatJobsThatWaitWouldWrite) {
  const Jobs folder(R"([["filter", "strip.obj", "--beta", "2", "-o", "a.obj"],
    ["filter", "a.obj", "--beta", "2", "-o", "made/b.obj"], ["check", "made/b.obj"], ["check", "made/none.obj"],
    ["check", "c.obj"]])");
  const Result result = marquetry(folder, {"batch", "jobs.json", "--dry-run", "--keep-going"});
  for (const char* name : {"job 2: a.obj", "job 3: made/b.obj"})
    EXPECT_THAT(result.error, HasSubstr(std::string(name) + " is not there yet"));
  EXPECT_THAT(result.error, HasSubstr("job 4: cannot read made/none.obj"));
  EXPECT_THAT(result.error, HasSubstr("job 5: cannot read c.obj"));
  EXPECT_EQ(result.status, 2);
}

TEST(Batch, NamesTheJobWhoseReportAnotherOneWrites) {
  const Jobs folder(R"([["check", "strip.obj", "--report", "r.json"], ["check", "strip.obj", "--report", "r.json"]])");
  EXPECT_THAT(refusal(folder, {"batch", "jobs.json"}, "r.json"), HasSubstr("job 2 of 2: r.json: job 1 writes it too"));
}

const char* const one_fails = R"([["filter", "strip.obj", "--beta", "2", "-o", "a.png"],
  ["filter", "missing.obj", "--beta", "2", "-o", "b.png"], ["filter", "strip.obj", "--beta", "2", "-o", "c.png"]])";

TEST(Batch, StopsAtTheFirstThatFailsAndGoesOnFromThere) {
  const Jobs folder(one_fails);
  const Result result = marquetry(folder, {"batch", "jobs.json"});
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.error, HasSubstr("job 2: cannot read missing.obj"));
  EXPECT_THAT(result.error, HasSubstr("--first 2"));
  EXPECT_TRUE(is_there(folder, "a.png"));
  EXPECT_FALSE(is_there(folder, "c.png"));
  EXPECT_EQ(marquetry(folder, {"batch", "jobs.json", "--first", "3"}).status, 0);
  EXPECT_TRUE(is_there(folder, "c.png"));
  EXPECT_THAT(refusal(folder, {"batch", "jobs.json", "--first", "4"}, "d.png"),
              HasSubstr("there are 3 jobs"));
}

TEST(Batch, LeavesOutWhatFailsWhereItShallGoOn) {
  const Jobs folder(one_fails);
  const Result result = marquetry(folder, {"batch", "jobs.json", "--keep-going", "--json"});
  EXPECT_EQ(result.status, 2);
  EXPECT_TRUE(is_there(folder, "c.png"));
  const auto found = result.json().at("result");
  EXPECT_EQ(found.at("failed"), 1);
  const auto failed = found.at("jobs").at(1);
  EXPECT_EQ(failed.at("job"), 2);
  EXPECT_EQ(failed.at("error").at("file"), "missing.obj");
}

TEST(Batch, HasAReportOfWhatWasDoneWhereItStops) {
  const Jobs folder(one_fails);
  ASSERT_EQ(marquetry(folder, {"batch", "jobs.json", "--report", "all.json"}).status, 2);
  const auto report = nlohmann::json::parse(file_bytes(folder / "all.json"));
  EXPECT_EQ(report.at("result").at("jobs").size(), 2U);
  std::filesystem::remove(folder / "a.png");
  write_bytes(folder / "missing.obj", strip_obj);
  EXPECT_EQ(marquetry(folder, {"batch", "all.json", "--dry-run"}).status, 0);
  EXPECT_EQ(marquetry(folder, {"batch", "all.json"}).status, 0);
  EXPECT_TRUE(is_there(folder, "a.png") && is_there(folder, "b.png"));
}

TEST(Batch, ReplacesNothingThatItWrote) {
  const Jobs folder(
      R"([["filter", "strip.obj", "--beta", "2", "-o", "v/a.obj"], ["filter", "strip.obj", "--beta", "3", "-o", "v/a.png"],
    ["filter", "strip.obj", "--beta", "3", "-o", "c.png"], ["filter", "strip.obj", "--beta", "0", "-o", "c.png", "--overwrite"]])");
  std::filesystem::create_directory(folder / "v");
  for (const bool dry : {true, false}) {
    std::vector<std::string> words{"batch", "jobs.json", "--keep-going", "--report", "r.json"};
    if (dry) words.emplace_back("--dry-run");
    const Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 2);
    EXPECT_THAT(result.error, HasSubstr("job 2: v/a.png: job 1 writes it too"));
    EXPECT_EQ(is_there(folder, "v/a.png"), !dry);
    EXPECT_EQ(is_there(folder, "c.png"), !dry);
  }
  EXPECT_EQ(nlohmann::json::parse(file_bytes(folder / "r.json")).at("result").at("failed"), 1);
}

TEST(Batch, LooksNoFurtherThanItCanWhereNothingIsWritten) {
  const Jobs folder(
      R"([["filter", "strip.obj", "--beta", "2", "-o", "a.obj"], ["filter", "a.obj", "--beta", "2", "-o", "b.png"]])");
  const Result result = marquetry(folder, {"batch", "jobs.json", "--dry-run"});
  EXPECT_EQ(result.status, 0) << result.error;
  EXPECT_THAT(result.error, HasSubstr("job 2: a.obj is not there yet"));
}

TEST(Batch, TakesConfigurationsAndNamesOfPlaces) {
  const Jobs folder(
      R"([{"verb": "filter", "options": {"mesh": "strip.obj", "config": "c.json", "output": "a.png"}},
    {"verb": "bake", "options": {"source": "strip.obj", "mesh": "strip.obj", "output": "b.png"}}])");
  write_bytes(folder / "c.json", R"({"beta": 0.5})");
  const Result result = marquetry(folder, {"batch", "jobs.json", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.json().at("result").at("jobs").at(0).at("options").at("beta"), 0.5);
  EXPECT_TRUE(is_there(folder, "b.png"));
}

TEST(Batch, HasRunningOptionsForAllJobs) {
  const Jobs folder(R"([["filter", "strip.obj", "--beta", "2", "-o", "a.png"]])");
  EXPECT_EQ(marquetry(folder, {"batch", "jobs.json", "--dry-run"}).status, 0);
  EXPECT_FALSE(is_there(folder, "a.png"));
  write_bytes(folder / "a.png", "mine");
  EXPECT_EQ(marquetry(folder, {"batch", "jobs.json", "--no-clobber"}).status, 2);
  EXPECT_EQ(file_bytes(folder / "a.png"), "mine");
}

TEST(Batch, EndsAsTheWorstOfItsJobs) {
  const Jobs folder(R"([["check", "folded.obj"], ["check", "strip.obj"]])");
  write_bytes(folder / "folded.obj", folded_obj);
  EXPECT_EQ(marquetry(folder, {"batch", "jobs.json"}).status, 1);
}

TEST(Batch, IsCancelledAsAWhole) {
  const Jobs folder(R"([["sample", "bust", "--size", "2048", "-o", "big/"],
    ["filter", "big/bust.obj", "--beta", "2", "-o", "a.png", "--overwrite"],
    ["filter", "strip.obj", "--beta", "2", "-o", "b.png"]])");
  std::filesystem::create_directory(folder / "big");
  const Result result = marquetry(folder, {"batch", "jobs.json", "--report", "r.json", "--progress", "json"},
                                  {.interrupt_at = {"job 2 of 3 ("}});
  EXPECT_EQ(result.status, 130);
  EXPECT_THAT(result.error, HasSubstr("cancelled"));
  EXPECT_THAT(result.error, HasSubstr("--first 2 goes on"));
  const nlohmann::json told = nlohmann::json::parse(file_bytes(folder / "r.json")).at("result");
  EXPECT_EQ(told.at("jobs").size(), 1U);
  EXPECT_EQ(told.at("cancelled"), true);
  EXPECT_EQ(told.at("running"), 2);
  EXPECT_FALSE(is_there(folder, "a.png"));
  EXPECT_FALSE(is_there(folder, "b.png"));
}

}  // namespace
}  // namespace mq::test
