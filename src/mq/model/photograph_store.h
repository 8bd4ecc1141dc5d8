#pragma once
/// What was found of photographs, as files in a folder, so that work that was stopped can go on.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "mq/model/messages.h"

namespace mq {

using StoredBytes = std::vector<std::byte>;

/// One file per name, each written whole or not at all, with the `fingerprint` of its contents and that of what they
/// were found with. Without a folder nothing is kept and nothing found.
class PhotographStore {
 public:
  PhotographStore() = default;

  /// Makes the folder. `setup`: of what all that is kept depends on. Throws `IoError` where that cannot be.
  PhotographStore(std::filesystem::path folder, std::uint64_t setup, Messages& messages);

  bool keeps() const { return !folder_.empty(); }

  /// What was put by that name with this set-up and the same `source`, the fingerprint of what this one depends on
  /// besides. Nothing, with a remark, where it was found with others, of which the first is named, or where the
  /// file is damaged; nothing where there is none.
  std::optional<StoredBytes> find(const std::string& name, std::uint64_t source) const;

  /// Throws `IoError`.
  void put(const std::string& name, std::uint64_t source, std::span<const std::byte> bytes) const;

 private:
  std::filesystem::path folder_;
  std::uint64_t setup_ = 0;
  Messages* messages_ = nullptr;
  mutable bool told_ = false;  ///< that something was found with others
};

/// Removes what stores keep there, no files of others, and the folder where nothing else is in it.
void forget_stored_photographs(const std::filesystem::path& folder);

/// Numbers and lists of them, one after another.
class StoredWriter {
 public:
  template <class Number>
  void add(std::span<const Number> values) {
    static_assert(std::is_trivially_copyable_v<Number>);
    const std::uint64_t count = values.size();
    const auto size = std::as_bytes(std::span(&count, 1)), all = std::as_bytes(values);
    bytes.insert(bytes.end(), size.begin(), size.end());
    bytes.insert(bytes.end(), all.begin(), all.end());
  }
  template <class Number>
  void add(const std::vector<Number>& values) {
    add(std::span<const Number>(values));
  }
  template <class Number>
  void add(const Number& value) {
    add(std::span<const Number>(&value, 1));
  }
  void add(const std::string& text) { add(std::span<const char>(text)); }

  StoredBytes bytes;
};

/// In the order in which they were written; a store has told already that nothing is missing.
class StoredReader {
 public:
  explicit StoredReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <class Number>
  std::vector<Number> list() {
    std::uint64_t count = 0;
    take(std::as_writable_bytes(std::span(&count, 1)));
    require_left(count, sizeof(Number));
    std::vector<Number> values(count);
    take(std::as_writable_bytes(std::span(values)));
    return values;
  }
  template <class Number>
  Number one() {
    return list<Number>().at(0);
  }

 private:
  void take(std::span<std::byte> to);
  void require_left(std::uint64_t count, std::size_t size) const;

  std::span<const std::byte> bytes_;
};

}  // namespace mq
