// A file is a row of boxes: 32 bits of size, four characters of kind, content, which may be boxes
// again. The numbers have their highest byte first. What is wanted stands at
//
//   moov / mvhd                            ticks a second of the whole
//        / trak / edts / elst              which part of the track is shown
//               / mdia / mdhd              ticks a second of the track
//                      / hdlr              'vide'
//                      / minf / stbl / stsd   codec
//                                    / stsz   count of pictures
//                                    / stts   runs of pictures, each with how many ticks it lasts
//
// Sums are of doubles, exact up to 2⁵³ ticks, so that no file makes them overflow.
#include "mq/io/mp4.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mq/base/error.h"

namespace mq {
namespace {

class Reader {
 public:
  explicit Reader(const std::string& name) : name_(name) {}

  [[noreturn]] void fail(const std::string& what) const {
    throw IoError(fmt::format("{}: {}", name_, what));
  }

  std::uint64_t number(ByteView bytes, std::size_t at, std::size_t size) const {
    if (at > bytes.size() || bytes.size() - at < size)
      fail("a box of its index is cut short; copy it again, or make it again");
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < size; ++i) value = value << 8 | std::uint64_t(bytes[at + i]);
    return value;
  }

  /// Calls `found(kind, content)` for each box; false from it ends the search.
  template <class Found>
  void boxes(ByteView bytes, const Found& found) const {
    for (std::size_t at = 0; at < bytes.size();) {
      const std::size_t left = bytes.size() - at;
      if (left < 8) fail("it is cut short; copy it again, or make it again");
      std::uint64_t size = number(bytes, at, 4);
      std::size_t head = 8;
      if (size == 0) size = left;
      if (size == 1) {
        size = number(bytes, at + 8, 8);
        head = 16;
      }
      const std::string_view kind = text_of(bytes.subspan(at + 4, 4));
      if (size < head || size > left)
        fail(
            fmt::format("its box {} says it has {} bytes, and {} are there: it is cut short or "
                        "damaged; copy it again, or make it again",
                        shown(kind), size, left));
      if (!found(kind, bytes.subspan(at + head, std::size_t(size) - head))) return;
      at += std::size_t(size);
    }
  }

  std::optional<ByteView> find(ByteView bytes, std::string_view wanted) const {
    std::optional<ByteView> result;
    boxes(bytes, [&](std::string_view kind, ByteView content) {
      if (kind == wanted) result = content;
      return !result;
    });
    return result;
  }

  ByteView get(ByteView bytes, std::string_view wanted) const {
    const auto found = find(bytes, wanted);
    if (!found)
      fail(fmt::format("its index has no box {}: it is damaged; make it again", shown(wanted)));
    return *found;
  }

  /// Ticks a second, of mvhd or mdhd, whose times have 32 or 64 bits.
  double ticks(ByteView header) const {
    return double(number(header, number(header, 0, 1) == 1 ? 20 : 12, 4));
  }

 private:
  const std::string& name_;
};

bool is_video(const Reader& read, ByteView track) {
  return read.number(read.get(read.get(track, "mdia"), "hdlr"), 8, 4) == 0x76696465;  // vide
}

/// The same time a picture, or the time of all but the last, which some say to be none.
struct Times {
  double pictures = 0, ticks = 0, last = 0;
};

Times times_of(const Reader& read, ByteView stts) {
  Times all;
  const std::uint64_t runs = read.number(stts, 4, 4);
  for (std::uint64_t i = 0; i < runs; ++i) {
    const double count = double(read.number(stts, std::size_t(8 + 8 * i), 4));
    all.last = double(read.number(stts, std::size_t(12 + 8 * i), 4));
    all.pictures += count;
    all.ticks += count * all.last;
  }
  return all;
}

/// Whether all pictures begin within half a picture of where an even pace puts them; what is linear
/// within a run is farthest off at its ends.
bool even(const Reader& read, ByteView stts, double pictures_a_tick) {
  double picture = 0, tick = 0;
  const std::uint64_t runs = read.number(stts, 4, 4);
  for (std::uint64_t i = 0; i < runs; ++i) {
    const double count = double(read.number(stts, std::size_t(8 + 8 * i), 4)),
                 each = double(read.number(stts, std::size_t(12 + 8 * i), 4));
    if (count < 1) continue;
    for (const double within : {0.0, count - 1})
      if (!(std::abs((tick + within * each) * pictures_a_tick - picture - within) < 0.5))
        return false;
    picture += count;
    tick += count * each;
  }
  return true;
}

/// Whether the track is shown from its beginning to its end. Pictures that are not stored in their
/// order are shown later by some ticks, which an edit list takes back, so that only its length
/// says.
bool shown_whole(const Reader& read, ByteView movie, ByteView track, const Times& times,
                 double ticks) {
  const auto edits = read.find(track, "edts");
  const auto list = edits ? read.find(*edits, "elst") : std::nullopt;
  if (!list) return true;
  const bool wide = read.number(*list, 0, 1) == 1;
  const std::size_t size = wide ? 8 : 4;
  if (read.number(*list, 4, 4) != 1) return false;
  const double seconds = double(read.number(*list, 8, size)) / read.ticks(read.get(movie, "mvhd"));
  const bool empty = read.number(*list, 8 + size, size) >> (8 * size - 1) != 0;
  return !empty && seconds * ticks > times.ticks * (1 - 0.5 / times.pictures);
}

}  // namespace

Mp4Video mp4_video(ByteView bytes, const std::string& name) {
  const Reader read(name);
  if (bytes.size() < 8 || text_of(bytes.subspan(4, 4)) != "ftyp")
    read.fail(fmt::format("it is no MP4 ({} bytes)", bytes.size()));
  std::optional<ByteView> movie;
  read.boxes(bytes, [&](std::string_view kind, ByteView content) {  // to the end: cut short?
    if (kind == "moov" && !movie) movie = content;
    return true;
  });
  if (!movie) read.fail("it has no index of pictures (moov): it is cut short; make it again");
  std::optional<ByteView> track;
  read.boxes(*movie, [&](std::string_view kind, ByteView content) {
    if (kind == "trak" && is_video(read, content)) track = content;
    return !track;
  });
  if (!track) read.fail("it has no video track; name another file");
  const ByteView media = read.get(*track, "mdia");
  const ByteView table = read.get(read.get(media, "minf"), "stbl");
  Mp4Video video;
  const ByteView entry = read.get(table, "stsd");
  read.number(entry, 12, 4);
  video.codec = text_of(entry.subspan(12, 4));
  if (read.find(*movie, "mvex")) return video;

  const auto sizes = read.find(table, "stsz");
  const std::uint64_t count = read.number(sizes ? *sizes : read.get(table, "stz2"), 8, 4);
  const ByteView stts = read.get(table, "stts");
  const Times times = times_of(read, stts);
  const double ticks = read.ticks(read.get(media, "mdhd"));
  if (count == 0 || times.pictures != double(count) ||
      !shown_whole(read, *movie, *track, times, ticks))
    return video;
  video.pictures = std::int64_t(count);
  const double pictures_a_tick =
      count > 1 ? (double(count) - 1) / (times.ticks - times.last) : 1 / times.last;
  if (std::isfinite(pictures_a_tick * ticks) && pictures_a_tick * ticks > 0 &&
      even(read, stts, pictures_a_tick))
    video.rate = pictures_a_tick * ticks;
  return video;
}

}  // namespace mq
