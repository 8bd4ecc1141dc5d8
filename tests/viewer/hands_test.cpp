// A task by real mouse and keyboard, in a window on a screen of Xvfb.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "places.h"
#include "viewer/sessions.h"

namespace mq::test {
namespace {

bool there_is(const std::string& program) {
  return std::system(("command -v " + program + " > /dev/null").c_str()) == 0;
}

/// hands.sh says what is done, and fails where the window does not answer.
TEST(Hands, OpenAModelPaintOnItAndSaveIt) {
  for (const char* program : {"xvfb-run", "xdotool"})
    if (!there_is(program)) GTEST_SKIP() << "there is no " << program;
  const Folder folder;
  write_sphere(folder, "256");
  std::filesystem::copy_file(folder / "sphere.obj", folder / "other.obj");
  const std::string command =
      "cd '" + folder.path().string() +
      "' && export XDG_STATE_HOME=\"$PWD/state\" XDG_CACHE_HOME=\"$PWD/cache\" && "
      "xvfb-run -a -s '-screen 0 1280x800x24' '" +
      (places::source() / "tests/viewer/hands.sh").string() + "' '" + places::program().string() + "'";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const auto report = nlohmann::json::parse(file_bytes(folder / "report.json"))["result"];
  EXPECT_EQ(report["tool"]["name"], "filter");
  const Image<float> before = picture(folder, "sphere.png"), first = picture(folder, "filtered.png"),
                     second = picture(folder, "filtered_2.png");
  int painted_first = 0, painted_second = 0;
  for (std::size_t k = 0; k < before.values().size(); ++k) {
    painted_first += before.values()[k] != first.values()[k];
    painted_second += before.values()[k] != second.values()[k];
  }
  EXPECT_GT(painted_first, 100);
  EXPECT_GT(painted_second, 50);
  if (there_is("ffmpeg")) {
    const auto differing_panels = [&](const std::string& name, const std::string& other) {
      const Image<float> a = picture(folder, name), b = picture(folder, other);
      int count = 0;
      for (std::size_t k = 0; k < a.values().size(); ++k) count += std::abs(a.values()[k] - b.values()[k]) > 0.1F;
      return count;
    };
    // A dim button does nothing.
    EXPECT_LT(differing_panels("photographs_before.png", "photographs_after.png"), 300);
    // Escape closes the list of what is shown.
    EXPECT_GT(differing_panels("list_before.png", "list_open.png"), 3000);
    EXPECT_LT(differing_panels("list_before.png", "list_closed.png"), 300);
  }
  // The window keeps in mind what was opened.
  EXPECT_THAT(file_bytes(folder / "state/marquetry/recent"),
              testing::MatchesRegex("/[^\n]*/other.obj\n/[^\n]*/sphere.obj\n"));
}

/// A window that has nothing to show ends, and says why where it was called.
TEST(Hands, AreToldWhyAModelCannotBeRead) {
  if (!there_is("xvfb-run")) GTEST_SKIP() << "there is no xvfb-run";
  const Folder folder;
  write_bytes(folder / "cut.obj", "v 0 0 0\nv 1 0 0\nf 1 2 3\n");
  const std::string command = "cd '" + folder.path().string() + "' && xvfb-run -a '" + places::program().string() +
                              "' view cut.obj 2> said.txt";
  EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 2);
  EXPECT_THAT(file_bytes(folder / "said.txt"), testing::HasSubstr("cut.obj, line 3: a face uses vertex 3"));
}

}  // namespace
}  // namespace mq::test
