// The manifest is a line of JSON per block, appended after the block: a line that is not whole, or
// that names bytes which are not there, is where a writer was stopped or a copy broke off.

#include "mq/io/evolving_file.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/io/detail/evolving_blocks.h"
#include "mq/io/detail/evolving_change.h"
#include "mq/io/detail/evolving_manifest.h"

namespace mq {
namespace {

namespace fs = std::filesystem;
using OrderedJson = nlohmann::ordered_json;

constexpr std::int64_t largest_int = 0x7fffffff;

}  // namespace

double store_step(double diagonal) {
  require(std::isfinite(diagonal) && diagonal > 0,
          fmt::format("the size of what is stored was found to be {}", diagonal));
  return std::exp2(std::ceil(std::log2(diagonal * 1e-6)));
}

double step_within(double error) {
  constexpr int bits = 8;
  require(std::isfinite(error) && error > 0, fmt::format("positions were asked for to be off by at most {}", error));
  int exponent = 0;
  const double mantissa = std::frexp(2 / std::sqrt(3.0) * error, &exponent);  // half a step along x, y and z
  return std::ldexp(std::floor(std::ldexp(mantissa, bits)), exponent - bits);
}

double uv_step_within(double error) {
  require(std::isfinite(error) && error >= 0,
          fmt::format("texture coordinates were asked for to be off by at most {}", error));
  return error == 0 ? 0 : std::exp2(std::floor(std::log2(2 * error)));
}

std::vector<Vector3> rounded(std::vector<Vector3> positions, double step) {
  return from_steps(in_steps(positions, step), step);
}

// ---- Reading ----

EvolvingReader::EvolvingReader(fs::path file, std::shared_ptr<const EvolvingSource> source,
                               std::vector<StoredSegment> segments, std::vector<StoredFrame> frames, double step,
                               double metres_per_unit)
    : manifest_(file),
      blocks_(std::move(file)),
      source_(std::move(source)),
      segments_(std::move(segments)),
      frames_(std::move(frames)),
      step_(step),
      metres_per_unit_(metres_per_unit),
      about_("{}") {}

EvolvingReader::EvolvingReader(fs::path manifest) : manifest_(std::move(manifest)) {
  const Bytes bytes = read_file(manifest_);
  const std::string_view text = text_of(bytes);
  const std::size_t first_end = text.find('\n');
  read_head(first_end == text.npos ? std::string_view() : text.substr(0, first_end));
  std::error_code failure;
  const auto size = std::int64_t(fs::file_size(blocks_, failure));
  if (failure)
    throw IoError(fmt::format("{}: it belongs to {} and cannot be read: {}", blocks_.string(),
                              manifest_.string(), failure.message()));
  for (std::size_t at = first_end + 1; at < text.size() && broken_.empty();) {
    const std::size_t end = text.find('\n', at);
    if (end == text.npos) {
      broken_ = "its last line is not whole";
    } else {
      broken_ = add_line(text.substr(at, end - at), size);
      at = end + 1;
      if (end_of_frame_.size() < frames_.size()) end_of_frame_.push_back(std::int64_t(at));
    }
  }
  if (!broken_.empty())
    broken_ =
        fmt::format("{}: {}; {} before that {} whole", manifest_.string(), broken_,
                    counted(std::ssize(frames_), "frame"), frames_.size() == 1 ? "is" : "are");
}

void EvolvingReader::read_head(std::string_view line) {
  const OrderedJson head = manifest_line(line);
  if (!head.is_object() || head.value("format", OrderedJson()) != store_format)
    throw IoError(
        fmt::format("{}: found no evolving mesh, whose first line would say \"format\": "
                    "\"{}\"",
                    manifest_.string(), store_format));
  version_ = int(manifest_number(head, "version", largest_int));
  if (version_ < 1 || version_ > store_version)
    throw IoError(
        fmt::format("{}: its version is not 1 to {}, those that are known: make it again, or "
                    "use the program that made it",
                    manifest_.string(), store_version));
  const auto real = [&head](const char* name) {
    const OrderedJson value = head.value(name, OrderedJson());
    return value.is_number() ? value.get<double>() : -1;
  };
  if (version_ == 1) {
    const OrderedJson exponent = head.value("step_exponent", OrderedJson());
    if (exponent.is_number_integer() && std::abs(exponent.get<double>()) <= 1000)
      step_ = std::exp2(exponent.get<int>());
  } else {
    step_ = real("step");
    uv_step_ = real("uv_step");
    if (head.contains("group_frames")) group_frames_ = int(manifest_number(head, "group_frames", largest_int));
  }
  const OrderedJson blocks = head.value("blocks", OrderedJson());
  if (!blocks.is_string() || fs::path(blocks.get<std::string>()).has_parent_path() || !is_step(step_) ||
      !(uv_step_ == 0 || (is_step(uv_step_) && std::exp2(std::ilogb(uv_step_)) == uv_step_)) || group_frames_ < 1)
    throw IoError(
        fmt::format("{}: its first line names no file of blocks in the same folder, no step, or groups of no frame",
                    manifest_.string()));
  blocks_ = manifest_.parent_path() / blocks.get<std::string>();
  about_ = head.value("about", OrderedJson::object()).dump();
}

/// Takes up one line; what is wrong with it in words, or nothing.
std::string EvolvingReader::add_line(std::string_view text, std::int64_t blocks_size) {
  const OrderedJson line = manifest_line(text);
  const std::string where =
      fmt::format("line {}", 2 + frames_.size() + std::size_t(segment_lines_));
  if (!line.is_object()) return where + " is not JSON";
  StoredBlock block;
  block.offset = manifest_number(line, "offset");
  block.bytes = manifest_number(line, "bytes");
  const std::int64_t checksum = manifest_number(line, "crc32", 0xffffffff);
  const std::int64_t segment = manifest_number(line, "segment", largest_int);
  if (block.offset != whole_blocks_ || block.bytes < 0 || checksum < 0 || segment < 0)
    return where + " lacks one of segment, offset, bytes and crc32, or does not follow the last";
  if (block.bytes > blocks_size - block.offset)
    return fmt::format("{} names bytes up to {} of {}, which has {}", where,
                       block.offset + block.bytes, blocks_.filename().string(), blocks_size);
  block.checksum = std::uint32_t(checksum);
  if (line.contains("frame")) {
    const std::int64_t frame = manifest_number(line, "frame", largest_int);
    if (segment + 1 != std::ssize(segments_)) return where + " is of a segment that is not open";
    if (frame < 0 || (!frames_.empty() && frame <= frames_.back().number))
      return where + " has a frame number that does not increase";
    const OrderedJson measured = line.value("measured", OrderedJson());
    group_of_frame_.push_back(int(groups_.size()) - 1);
    frames_.push_back(
        {block, int(frame), int(segment), measured.is_object() ? measured.dump() : ""});
  } else if (const std::string wrong = add_segment_line(block, segment, line); !wrong.empty()) {
    return where + wrong;
  }
  whole_blocks_ += block.bytes;
  return "";
}

/// A segment that is not the next one is the last one once more, where a group begins.
std::string EvolvingReader::add_segment_line(const StoredBlock& block, std::int64_t segment,
                                             const OrderedJson& line) {
  const bool is_whole = version_ == 1 || line.contains("group"), is_next = segment == std::ssize(segments_);
  if (version_ != 1 && is_whole && manifest_number(line, "group") != std::ssize(groups_))
    return " does not begin the next group";
  if (!is_next && !(version_ != 1 && is_whole && segment + 1 == std::ssize(segments_)))
    return " does not begin the next segment";
  if (groups_.empty() && !is_whole) return " begins with no group";
  const std::int64_t each = version_ == 1 ? 0 : most_added_per_byte;
  for (const char* name : {"vertices", "triangles"}) {
    const std::int64_t before = is_whole ? 0 : name[0] == 'v' ? segments_.back().vertices : segments_.back().triangles;
    // In version 1 an id and a coordinate of each axis take a byte each, and so do an id and three corners.
    const std::int64_t most = std::min(version_ == 1 ? block.bytes / 4 : before + each * block.bytes, largest_int);
    if (const std::int64_t count = manifest_number(line, name); count < 0 || count > most)
      return fmt::format(" says {} {}, wanted a number from 0 to {}, as many as {} bytes can hold",
                         line.value(name, OrderedJson()).dump(), name, most, block.bytes);
  }
  const StoredSegment found{block, int(manifest_number(line, "vertices")), int(manifest_number(line, "triangles"))};
  if (!is_next && (found.vertices != segments_.back().vertices || found.triangles != segments_.back().triangles))
    return " has other counts than the segment that it repeats";
  if (is_whole) groups_.push_back({block, int(segment), int(frames_.size())});
  if (is_next) {
    segments_.push_back(found);
    group_of_segment_.push_back(int(groups_.size()) - 1);
  }
  ++segment_lines_;
  return "";
}

Bytes EvolvingReader::bytes_of(const StoredBlock& block, const std::string& what) const {
  Bytes bytes(std::size_t(block.bytes));
  std::ifstream in(blocks_, std::ios::binary);
  in.seekg(block.offset);
  in.read(reinterpret_cast<char*>(bytes.data()), block.bytes);
  if (!in) throw IoError(fmt::format("{}: {} cannot be read", blocks_.string(), what));
  return bytes;
}

Bytes EvolvingReader::block(const StoredBlock& block, const std::string& what) const {
  Bytes bytes = bytes_of(block, what);
  if (crc32(bytes) != block.checksum)
    throw IoError(
        fmt::format("{}: the bytes of {} are not those that were written; use frames that do not "
                    "need it, or make it again",
                    blocks_.string(), what));
  return bytes;
}

bool EvolvingReader::is_changed(const StoredBlock& block) const {
  return crc32(bytes_of(block, "a block")) != block.checksum;
}

std::vector<int> EvolvingReader::damaged() const {
  if (source_) return {};
  std::vector<int> found;
  bool is_bad = false, is_bad_segment = false;
  for (int f = 0, segment = -1; f < int(frames_.size()); ++f) {
    const int group = group_of_frame_[std::size_t(f)];
    if (f == 0 || group != group_of_frame_[std::size_t(f) - 1]) {
      segment = groups_[std::size_t(group)].segment;
      is_bad = is_bad_segment = is_changed(groups_[std::size_t(group)].block);
    }
    while (segment < frames_[f].segment) is_bad_segment |= is_changed(segments_[std::size_t(++segment)]);
    // In version 1 a segment is its own group, and a frame needs none before it.
    is_bad = (version_ != 1 && is_bad) || is_bad_segment || is_changed(frames_[f]);
    if (is_bad) found.push_back(f);
  }
  return found;
}

std::string EvolvingReader::named(const std::string& what) const { return blocks_.string() + ": " + what; }

void EvolvingReader::begin_group(Place& place, int group) const {
  const Group& first = groups_.at(std::size_t(group));
  const std::string what = fmt::format("segment {}", first.segment);
  place.found = decode_change(block(first.block, what), {}, named(what));
  place.group = group;
  place.segment = first.segment;
  require_counts(place);
}

void EvolvingReader::next_segment(Place& place) const {
  const int next = place.segment + 1;
  const std::string what = fmt::format("segment {}", next);
  place.found = decode_change(block(segments_.at(std::size_t(next)), what), place.found, named(what));
  place.segment = next;
  require_counts(place);
}

void EvolvingReader::require_counts(const Place& place) const {
  const StoredSegment& said = segments_[std::size_t(place.segment)];
  if (place.found.vertex_count() != said.vertices || place.found.triangle_count() != said.triangles)
    throw IoError(fmt::format("{}: segment {} has {} vertices and {} triangles, where {} says {} and {}; make it again",
                              blocks_.string(), place.segment, place.found.vertex_count(),
                              place.found.triangle_count(), manifest_.string(), said.vertices, said.triangles));
}

/// Goes on from the frame read last where that is before it in its group. What fails leaves nothing to go on from.
const EvolvingReader::Moment& EvolvingReader::moment(int frame) const {
  const int group = group_of_frame_.at(std::size_t(frame));
  Moment now = std::exchange(moment_, {});
  if (now.place.group != group || now.frame > frame) {
    now = {};
    begin_group(now.place, group);
    now.frame = groups_[std::size_t(group)].first_frame - 1;
    now.order = order_of(now.place.found, now.motion);
  }
  while (now.frame < frame) {
    const StoredFrame& next = frames_[std::size_t(++now.frame)];
    while (now.place.segment < next.segment) {
      const EvolvingSegment before = now.place.found;
      next_segment(now.place);
      const EvolvingSegment& after = now.place.found;
      now.motion = carried_over(now.motion, vertices_before(after, before), after.triangles);
      now.order = order_of(after, now.motion);
    }
    const std::string what = fmt::format("frame {}", next.number);
    now.motion.advance(decode_positions(block(next, what), now.order, now.motion, named(what)));
  }
  return moment_ = std::move(now);
}

EvolvingSegment EvolvingReader::segment(int index) const {
  if (source_) return source_->segment(index);
  const StoredSegment& stored = segments_.at(std::size_t(index));
  if (version_ == 1) {
    const std::string what = fmt::format("segment {}", index);
    SegmentBlock found = decode_segment(block(stored, what), named(what));
    key_segment_ = index;
    key_ = std::move(found.key);
    return std::move(found.segment);
  }
  if (moment_.place.segment == index) return moment_.place.found;
  const int group = group_of_segment_[std::size_t(index)];
  Place place = std::exchange(place_, {});
  if (place.group != group || place.segment > index) begin_group(place, group);
  while (place.segment < index) next_segment(place);
  place_ = std::move(place);
  return place_.found;
}

const std::vector<std::int64_t>& EvolvingReader::key(int segment_index) const {
  if (key_segment_ != segment_index) segment(segment_index);
  return key_;
}

std::vector<Vector3> EvolvingReader::positions(int frame) const {
  if (source_) return source_->positions(frame);
  const StoredFrame& stored = frames_.at(std::size_t(frame));
  if (version_ != 1) return from_steps(moment(frame).motion.coordinates, step_);
  const std::string what = fmt::format("frame {}", stored.number);
  return from_steps(decode_frame(block(stored, what), key(stored.segment), named(what)), step_);
}

EvolvingMesh EvolvingReader::read() const {
  EvolvingMesh evolving;
  for (int f = 0; f < int(frames_.size()); ++f) {
    while (std::ssize(evolving.segments) <= frames_[f].segment)
      evolving.segments.push_back(segment(int(evolving.segments.size())));
    evolving.frames.push_back({frames_[f].number, frames_[f].segment, positions(f)});
  }
  check(evolving);
  return evolving;
}

}  // namespace mq
