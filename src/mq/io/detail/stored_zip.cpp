// Each file has a header of 30 bytes, its name and a field that fills up to the multiple; after all files the
// headers come again, with places, and the end says where these begin.
#include "mq/io/detail/stored_zip.h"

#include <fmt/format.h>

#include <cstring>
#include <limits>

#include "mq/base/error.h"
#include "mq/io/detail/evolving_blocks.h"

namespace mq {
namespace {

constexpr std::uint32_t local_mark = 0x04034b50, central_mark = 0x02014b50, end_mark = 0x06054b50;
constexpr std::uint16_t version_needed = 10, first_of_january_1980 = 0x21, padding_id = 0x1986;
constexpr std::size_t alignment = 64, local_size = 30, central_size = 46, field_size = 4;

struct Entry {
  const OutputFile& file;
  std::uint32_t checksum;
  std::uint32_t place;
};

template <class... Numbers>
void append_all(Bytes& bytes, Numbers... numbers) {
  (append_raw(bytes, numbers), ...);
}

/// What both headers say: no flags, stored, time, date, checksum, both sizes, length of the name.
void append_common(Bytes& bytes, const Entry& entry) {
  const auto size = std::uint32_t(entry.file.bytes.size());
  append_all(bytes, version_needed, std::uint16_t(0), std::uint16_t(0), std::uint16_t(0), first_of_january_1980,
             entry.checksum, size, size, std::uint16_t(entry.file.name.size()));
}

void append_bytes(Bytes& bytes, ByteView more) { bytes.insert(bytes.end(), more.begin(), more.end()); }

/// How many bytes go into the field, so that the file begins at a multiple.
std::uint16_t padding(std::size_t header_end) {
  return std::uint16_t((alignment - (header_end + field_size) % alignment) % alignment);
}

/// Numbers of an archive that is read, and that may be anything.
class Archive {
 public:
  Archive(ByteView bytes, const std::string& name) : bytes_(bytes), name_(name) {}

  std::uint32_t u32(std::size_t at) const { return load<std::uint32_t>(at); }
  std::uint16_t u16(std::size_t at) const { return load<std::uint16_t>(at); }

  ByteView part(std::size_t at, std::size_t size) const {
    if (at > bytes_.size() || size > bytes_.size() - at) fail("it is cut short; copy it again");
    return bytes_.subspan(at, size);
  }

  /// Where the headers of all files come again: the end says it, which a comment may follow.
  std::size_t end() const {
    for (std::size_t at = bytes_.size(); at >= end_size && bytes_.size() - at <= most_comment; --at)
      if (u32(at - end_size) == end_mark) return at - end_size;
    fail("it has no end as archives have; it may be cut short: copy it again");
  }

  [[noreturn]] void fail(const std::string& what) const { throw IoError(name_ + ": " + what); }

 private:
  template <class Number>
  Number load(std::size_t at) const {
    Number number = 0;
    std::memcpy(&number, part(at, sizeof number).data(), sizeof number);
    return number;
  }

  static constexpr std::size_t end_size = 22, most_comment = 0xffff;
  ByteView bytes_;
  const std::string& name_;
};

}  // namespace

std::vector<StoredFile> stored_files(ByteView zip, const std::string& name) {
  const Archive archive(zip, name);
  const std::size_t end = archive.end(), count = archive.u16(end + 10);
  std::vector<StoredFile> files;
  std::size_t at = archive.u32(end + 16);
  for (std::size_t i = 0; i < count; ++i) {
    if (archive.u32(at) != central_mark) archive.fail("its list of files is damaged; copy it again");
    const std::size_t size = archive.u32(at + 20), name_size = archive.u16(at + 28), place = archive.u32(at + 42);
    const std::string file(text_of(archive.part(at + central_size, name_size)));
    if (archive.u16(at + 10) != 0)
      archive.fail(
          fmt::format("{} in it is compressed, and a package of USD holds files as they are; make it again with "
                      "usdzip",
                      shown(file)));
    if (archive.u32(place) != local_mark) archive.fail(shown(file) + " is not where it should be; copy it again");
    const std::size_t data = place + local_size + archive.u16(place + 26) + archive.u16(place + 28);
    const ByteView bytes = archive.part(data, size);
    if (crc32(bytes) != archive.u32(at + 16))
      archive.fail(shown(file) + " in it is not as it was packed; copy it again");
    files.push_back({file, bytes});
    at += central_size + name_size + archive.u16(at + 30) + archive.u16(at + 32);
  }
  return files;
}

Bytes stored_zip(const std::vector<OutputFile>& files) {
  std::size_t size = 0;
  for (const OutputFile& file : files) size += file.bytes.size() + 3 * file.name.size() + 256;
  if (size > std::numeric_limits<std::uint32_t>::max())
    throw Unsupported("a USDZ package of more than 4 GB; write .usda");
  Bytes bytes;
  bytes.reserve(size);
  std::vector<Entry> entries;
  for (const OutputFile& file : files) {
    entries.push_back({file, crc32(file.bytes), std::uint32_t(bytes.size())});
    const std::uint16_t fill = padding(bytes.size() + local_size + file.name.size());
    append_raw(bytes, local_mark);
    append_common(bytes, entries.back());
    append_raw(bytes, std::uint16_t(field_size + fill));
    append_bytes(bytes, to_bytes(file.name));
    append_all(bytes, padding_id, fill);
    bytes.resize(bytes.size() + fill);
    append_bytes(bytes, file.bytes);
  }
  const std::size_t central = bytes.size();
  for (const Entry& entry : entries) {
    append_all(bytes, central_mark, version_needed);
    append_common(bytes, entry);
    // No extra field, no comment, on the first disk, no attributes.
    append_all(bytes, std::uint16_t(0), std::uint16_t(0), std::uint16_t(0), std::uint16_t(0), std::uint32_t(0),
               entry.place);
    append_bytes(bytes, to_bytes(entry.file.name));
  }
  const auto count = std::uint16_t(entries.size());
  append_all(bytes, end_mark, std::uint16_t(0), std::uint16_t(0), count, count,
             std::uint32_t(bytes.size() - central), std::uint32_t(central), std::uint16_t(0));
  return bytes;
}

}  // namespace mq
