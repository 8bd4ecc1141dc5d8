// Links in the documentation lead somewhere: files exist, headings after '#' too, and every page of
// docs/ can be reached from its README.
#include <gtest/gtest.h>

#include <cctype>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "rules/sources.h"

namespace {

namespace fs = std::filesystem;

using mq::rules::root;

/// A page without its fenced blocks and code spans, which hold no links, one entry per line.
std::vector<std::string> prose_of(const fs::path& page) {
  static const std::regex code("`[^`]*`");
  std::ifstream file(page);
  std::vector<std::string> lines;
  bool fenced = false;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("```")) fenced = !fenced;
    // The words of a code span count in a heading's anchor.
    const bool heading = line.starts_with("#");
    lines.push_back(fenced ? "" : heading ? line : std::regex_replace(line, code, "``"));
  }
  return lines;
}

/// The anchor that a heading gets: lower case, spaces as hyphens, other punctuation left out.
std::string anchor_of(const std::string& heading) {
  std::string anchor;
  for (const char c : heading) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 128 || std::isalnum(byte) || c == '_' || c == '-')
      anchor += char(std::tolower(byte));
    else if (c == ' ')
      anchor += '-';
  }
  return anchor;
}

std::set<std::string> anchors_of(const fs::path& page) {
  static const std::regex heading("^#+ +(.*)$"), named("<a +(?:id|name)=\"([^\"]+)\"");
  std::set<std::string> anchors;
  for (const std::string& line : prose_of(page)) {
    std::smatch match;
    if (std::regex_match(line, match, heading)) {
      const std::string anchor = anchor_of(match[1]);
      // Of equal headings the second is called anchor-1, and so on.
      std::string name = anchor;
      for (int i = 1; anchors.contains(name); ++i) name = anchor + "-" + std::to_string(i);
      anchors.insert(name);
    }
    for (auto it = std::sregex_iterator(line.begin(), line.end(), named);
         it != std::sregex_iterator(); ++it)
      anchors.insert((*it)[1]);
  }
  return anchors;
}

struct Link {
  std::string target;
  std::size_t line;
};

std::vector<Link> links_of(const fs::path& page) {
  static const std::regex link(R"(\]\(([^)\s]+)\))");
  std::vector<Link> links;
  const auto lines = prose_of(page);
  for (std::size_t i = 0; i < lines.size(); ++i)
    for (auto it = std::sregex_iterator(lines[i].begin(), lines[i].end(), link);
         it != std::sregex_iterator(); ++it)
      links.push_back({(*it)[1], i + 1});
  return links;
}

bool is_elsewhere(const std::string& target) {
  return target.find("://") != std::string::npos || target.starts_with("mailto:");
}

/// The pages that a person reads: those of docs/ and its folders, and the two in front of the
/// house.
std::vector<fs::path> pages() {
  std::vector<fs::path> all = {root / "README.md", root / "CONTRIBUTING.md"};
  for (const auto& entry : fs::recursive_directory_iterator(root / "docs"))
    if (entry.path().extension() == ".md") all.push_back(entry.path());
  for (const auto& entry : fs::directory_iterator(root / "src/mq"))
    if (entry.is_directory()) all.push_back(entry.path() / "README.md");
  return all;
}

TEST(Links, LeadToFilesAndHeadingsThatExist) {
  int links = 0;
  for (const fs::path& page : pages())
    for (const Link& link : links_of(page)) {
      if (is_elsewhere(link.target)) continue;
      ++links;
      const std::string where =
          fs::relative(page, root).string() + ":" + std::to_string(link.line) + ": " + link.target;
      const auto hash = link.target.find('#');
      const std::string file = link.target.substr(0, hash);
      const fs::path target = file.empty() ? page : page.parent_path() / file;
      EXPECT_TRUE(fs::exists(target)) << where << " is not there";
      if (hash == std::string::npos || !fs::exists(target)) continue;
      const std::string anchor = link.target.substr(hash + 1);
      EXPECT_TRUE(anchors_of(target).contains(anchor)) << where << " is no heading of that page";
      // Others are called differently by the site and by where the pages are read as they are.
      EXPECT_TRUE(std::regex_match(anchor, std::regex("[a-z0-9]+([-_][a-z0-9]+)*")))
          << where << ": link to headings of plain words";
    }
  EXPECT_GT(links, 100);
}

TEST(Links, ReachEveryPageOfTheDocs) {
  std::vector<fs::path> open = {fs::canonical(root / "docs/README.md")};
  std::set<fs::path> reached(open.begin(), open.end());
  while (!open.empty()) {
    const fs::path page = open.back();
    open.pop_back();
    for (const Link& link : links_of(page)) {
      if (is_elsewhere(link.target)) continue;
      const std::string file = link.target.substr(0, link.target.find('#'));
      if (!file.ends_with(".md") || !fs::exists(page.parent_path() / file)) continue;
      const fs::path target = fs::canonical(page.parent_path() / file);
      if (reached.insert(target).second) open.push_back(target);
    }
  }
  for (const auto& entry : fs::recursive_directory_iterator(root / "docs"))
    EXPECT_TRUE(entry.path().extension() != ".md" || reached.contains(fs::canonical(entry.path())))
        << fs::relative(entry.path(), root) << " cannot be reached from docs/README.md";
}

TEST(Links, ShowEveryPictureThatIsKept) {
  std::set<std::string> shown;
  for (const fs::path& page : pages())
    for (const Link& link : links_of(page)) shown.insert(fs::path(link.target).filename().string());
  for (const auto& entry : fs::directory_iterator(root / "docs/pictures"))
    EXPECT_TRUE(shown.contains(entry.path().filename().string()))
        << "no page shows " << fs::relative(entry.path(), root);
}

}  // namespace
