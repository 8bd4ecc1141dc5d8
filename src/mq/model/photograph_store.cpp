#include "mq/model/photograph_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <string>

#include "mq/base/error.h"
#include "mq/io/atomic_file.h"
#include "mq/io/bytes.h"
#include "mq/io/file_print.h"
#include "mq/io/path_status.h"

namespace mq {
namespace {

/// Another where the files, or what is found of photographs, change.
constexpr std::string_view magic = "mqphot02", extension = ".photograph";

struct Head {
  std::array<char, 8> magic;
  std::uint64_t setup, source, print, size;  ///< of what follows
};

bool has_magic(std::span<const std::byte> bytes) {
  return bytes.size() >= magic.size() && std::memcmp(bytes.data(), magic.data(), magic.size()) == 0;
}

/// Of this version or another.
bool begins_with_magic(const std::filesystem::path& file) {
  constexpr std::size_t of_all_versions = 6;
  std::string begin(of_all_versions, ' ');
  return std::ifstream(file, std::ios::binary).read(begin.data(), std::streamsize(begin.size())) &&
         begin == magic.substr(0, of_all_versions);
}

std::filesystem::path file_in(const std::filesystem::path& folder, const std::string& name) {
  return folder / (name + std::string(extension));
}

}  // namespace

PhotographStore::PhotographStore(std::filesystem::path folder, std::uint64_t setup, Messages& messages)
    : folder_(std::move(folder)), setup_(setup), messages_(&messages) {
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (error || !is_folder(folder_))
    throw IoError(fmt::format("{}: cannot be made a folder to keep work in: {}; name another", folder_.string(),
                              error ? error.message() : "it is a file"));
}

std::optional<StoredBytes> PhotographStore::find(const std::string& name, std::uint64_t source) const {
  if (!keeps()) return std::nullopt;
  const std::filesystem::path file = file_in(folder_, name);
  if (!is_there(file)) return std::nullopt;
  StoredBytes bytes = read_file(file);
  Head head;
  const bool whole = has_magic(bytes) && bytes.size() >= sizeof head;
  if (whole) std::memcpy(&head, bytes.data(), sizeof head);
  if (!whole || head.size != bytes.size() - sizeof head ||
      head.print != fingerprint(std::span(bytes).subspan(sizeof head))) {
    messages_->remark(file.string() + ": is cut short or damaged: that photograph is read again");
    return std::nullopt;
  }
  if (head.setup != setup_ || head.source != source) {
    if (!told_)
      messages_->remark(file.string() + ": was found with other photographs, cameras, options or another model: this "
                                        "one, and others of which that is so, are found again");
    told_ = true;
    return std::nullopt;
  }
  bytes.erase(bytes.begin(), bytes.begin() + sizeof head);
  return bytes;
}

void PhotographStore::put(const std::string& name, std::uint64_t source, std::span<const std::byte> bytes) const {
  if (!keeps()) return;
  Head head{{}, setup_, source, fingerprint(bytes), bytes.size()};
  std::ranges::copy(magic, head.magic.begin());
  const auto first = std::as_bytes(std::span(&head, 1));
  StoredBytes all(first.begin(), first.end());
  all.insert(all.end(), bytes.begin(), bytes.end());
  write_file(file_in(folder_, name), all);
}

void forget_stored_photographs(const std::filesystem::path& folder) {
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored))
    if (entry.is_regular_file(ignored) && entry.path().extension() == extension && begins_with_magic(entry.path()))
      std::filesystem::remove(entry.path(), ignored);
  if (std::filesystem::is_empty(folder, ignored)) std::filesystem::remove(folder, ignored);
}

void StoredReader::require_left(std::uint64_t count, std::size_t size) const {
  require(count <= bytes_.size() / size, "what was kept of a photograph ends too early: remove it");
}

void StoredReader::take(std::span<std::byte> to) {
  require_left(to.size(), 1);
  if (!to.empty()) std::memcpy(to.data(), bytes_.data(), to.size());
  bytes_ = bytes_.subspan(to.size());
}

}  // namespace mq
