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
  /// Looks in these folders, in their order, then in those that are in the `deep` ones, up to six further down.
  explicit PictureFinder(std::vector<std::filesystem::path> folders, std::vector<std::filesystem::path> deep = {});

  /// A picture of that name; else of the last part of it; else so but for capitals; else also but for
  /// the extension, where one of a picture is there; else the same in folders further down, of several those whose
  /// folders are called as the name says. Nothing where there is none. Throws `IoError`
  /// beginning with `where` where all but the first two find several.
  std::optional<std::filesystem::path> find(const std::string& name, const std::string& where) const;

  const std::vector<std::filesystem::path>& folders() const { return folders_; }

 private:
  using Names = std::multimap<std::string, std::filesystem::path>;
  /// Files in small letters, with and without extension.
  struct Listed {
    bool done = false;
    Names by_name, by_stem;

    void add(const std::filesystem::path& file);
  };
  std::optional<std::filesystem::path> listed(const Listed& files, const std::filesystem::path& asked,
                                              const std::string& name, const std::string& where) const;
  void list_files() const;
  void list_deep_files() const;

  std::vector<std::filesystem::path> folders_, deep_;
  mutable Listed listed_, deep_listed_;
};

}  // namespace mq
