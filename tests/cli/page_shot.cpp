// page_shot FILE.html[#STATE] OUT.png: what a page that `play` wrote shows in a browser, once it
// does.
#include <cstdio>
#include <exception>
#include <filesystem>

#include "cli/browser.h"
#include "cli/program.h"

int main(int count, char** words) try {
  if (count != 3) {
    std::fputs("usage: page_shot FILE.html[#STATE] OUT.png\n", stderr);
    return 2;
  }
  const mq::test::Folder folder;
  mq::test::Browser browser(folder / "profile");
  browser.open("file://" + std::filesystem::absolute(words[1]).string());
  if (!browser.becomes_true("document.body.dataset.frame && !location.hash.includes('frame=') || "
                            "location.hash.includes('frame=' + document.body.dataset.frame)")) {
    std::fprintf(stderr, "%s: it shows nothing within a minute\n", words[1]);
    return 2;
  }
  browser.screenshot(std::filesystem::absolute(words[2]));
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "page_shot: %s\n", error.what());
  return 2;
}
