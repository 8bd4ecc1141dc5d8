#pragma once
/// Pictures by the names that other programs, on other machines, gave them.

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace mq {

class PictureFinder {
 public:
  /// Looks in these folders, in their order.
  explicit PictureFinder(std::vector<std::filesystem::path> folders);

  /// A picture of that name; else of the last part of it; else so but for capitals; else also but for
  /// the extension, where one of a picture is there. Nothing where there is none. Throws `IoError`
  /// beginning with `where` where the last two find several.
  std::optional<std::filesystem::path> find(const std::string& name, const std::string& where) const;

  const std::vector<std::filesystem::path>& folders() const { return folders_; }

 private:
  using Names = std::multimap<std::string, std::filesystem::path>;
  std::optional<std::filesystem::path> unique(const Names& names, const std::string& key,
                                              const std::string& name, const std::string& where) const;
  void list_files() const;

  std::vector<std::filesystem::path> folders_;
  mutable bool listed_ = false;
  mutable Names by_name_, by_stem_;  ///< in small letters
};

}  // namespace mq
