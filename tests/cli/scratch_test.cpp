// --memory: large blocks in a file on the disk.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "cli/models.h"
#include "cli/program.h"

namespace mq::test {
namespace {

using testing::HasSubstr;

/// Whether the program beside these tests has the module: under sanitizers it does not.
bool there_is_no_scratch(const Result& result) { return result.error.find("libmarquetry_scratch.so:") != std::string::npos; }

/// Whether the folder of tests is one that --scratch refuses.
bool is_in_memory(const Result& result) { return result.error.find("lies in memory itself") != std::string::npos; }

/// Whether its file system cannot have the file.
bool is_without_files(const Result& result) { return result.error.find("cannot have the file") != std::string::npos; }

#define SKIP_WITHOUT_SCRATCH(result)                                                     \
  if (there_is_no_scratch(result)) GTEST_SKIP() << "no libmarquetry_scratch.so here";    \
  if (is_in_memory(result)) GTEST_SKIP() << "folders of tests lie in memory";            \
  if (is_without_files(result)) GTEST_SKIP() << "no disk can be reserved where they lie"

TEST(Scratch, GivesTheSamePictureInLessMemory) {
  const Folder folder;
  ASSERT_EQ(marquetry(folder, {"sample", "bust", "--size", "1024", "-o", "bust/"}).status, 0);
  const auto filtered = [&](const char* name, const std::vector<std::string>& more) {
    std::vector<std::string> words = {"filter", "bust/bust.obj", "--beta", "0", "-o", name, "--json", "--threads", "2"};
    words.insert(words.end(), more.begin(), more.end());
    return marquetry(folder, words);
  };
  const Result within = filtered("within.png", {"--memory", "230MB", "--scratch", "."});
  SKIP_WITHOUT_SCRATCH(within);
  ASSERT_EQ(within.status, 0) << within.error;
  const Result free = filtered("free.png", {});
  ASSERT_EQ(free.status, 0) << free.error;
  EXPECT_EQ(file_bytes(folder / "within.png"), file_bytes(folder / "free.png"));
  // 390 MB without; what is touched between two looks of the thread that watches comes on top of what was asked for.
  EXPECT_LT(within.json().at("peak_bytes").get<double>(), 0.85 * free.json().at("peak_bytes").get<double>());
  EXPECT_FALSE(within.json().at("options").contains("memory")) << "it says nothing of the result";
  std::filesystem::remove_all(folder / "bust");
  EXPECT_EQ(folder.names(), (std::vector<std::string>{"free.png", "within.png"}));
}

TEST(Scratch, OfABatchIsThatOfAllItsJobs) {
  const Folder folder;
  write_strip(folder);
  write_bytes(folder / "jobs.json", R"([["filter", "strip.obj", "--beta", 2, "-o", "a.png", "--memory", "1GB"]])");
  const Result of_a_job = marquetry(folder, {"batch", "jobs.json"});
  EXPECT_EQ(of_a_job.status, 2);
  EXPECT_THAT(of_a_job.error, HasSubstr("--memory: a job has none of its own; give it to 'batch'"));
  write_bytes(folder / "jobs.json", R"([["filter", "strip.obj", "--beta", 2, "-o", "a.png"]])");
  const Result of_all = marquetry(folder, {"batch", "jobs.json", "--memory", "1GB", "--scratch", "."});
  SKIP_WITHOUT_SCRATCH(of_all);
  EXPECT_EQ(of_all.status, 0) << of_all.error;
}

TEST(Scratch, ThatIsFullIsAnErrorAndNoSignal) {
  const Folder folder;
  write_strip(folder, 1024, 1024);
  const Result result = marquetry(folder, {"filter", "strip.obj", "--beta", "2", "-o", "a.png", "--memory", "1GB", "--scratch", "."},
                                  {.largest_file = 20'000'000});
  SKIP_WITHOUT_SCRATCH(result);
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.error, HasSubstr("the disk that memory lies on is full"));
  EXPECT_FALSE(std::filesystem::exists(folder / "a.png"));
}

TEST(Scratch, SaysWhatItCannotBeGiven) {
  const Folder folder;
  write_strip(folder);
  const auto error = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"filter", "strip.obj", "--beta", "2", "-o", "a.png"};
    words.insert(words.end(), more.begin(), more.end());
    const Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 2);
    return result.error;
  };
  for (const char* size : {"8", "much", "20MB", "-1GB", "8GBs", "nan%"})
    EXPECT_THAT(error({"--memory", size}), HasSubstr("found '" + std::string(size) + "', wanted 100MB or more"));
  EXPECT_THAT(error({"--memory", "1GB", "--scratch", "nowhere"}), HasSubstr("nowhere"));
  EXPECT_THAT(error({"--memory", "1GB", "--scratch", "/dev/shm"}), HasSubstr("lies in memory itself"));
  EXPECT_THAT(error({"--scratch", "."}), HasSubstr("--scratch is where the file of --memory lies: give that too"));
  EXPECT_FALSE(std::filesystem::exists(folder / "a.png"));
}

}  // namespace
}  // namespace mq::test
