// The manifest is a line of JSON per block, appended after the block: a line that is not whole, or
// that names bytes which are not there, is where a writer was stopped or a copy broke off.

#include "mq/io/evolving_file.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/io/detail/evolving_blocks.h"
#include "mq/io/detail/json_text.h"

namespace mq {
namespace {

namespace fs = std::filesystem;
using OrderedJson = nlohmann::ordered_json;

constexpr const char* format_name = "marquetry evolving mesh";
constexpr int version = 1;

OrderedJson parsed(std::string_view text) {
  if (too_deep_json(text)) return OrderedJson(OrderedJson::value_t::discarded);
  return OrderedJson::parse(text, nullptr, false);
}

/// A whole number of a line, from 0 to `most`; −1 where the line has none.
std::int64_t number(const OrderedJson& line, const char* name, std::int64_t most = std::int64_t(1) << 52) {
  const auto found = line.find(name);
  if (found == line.end() || !found->is_number_integer()) return -1;
  const auto value = found->get<std::int64_t>();
  return value > most ? -1 : value;
}

constexpr std::int64_t largest_int = 0x7fffffff;

void write_all(const fs::path& path, std::ios::openmode mode, const char* data, std::size_t size) {
  std::ofstream out(path, std::ios::binary | mode);
  out.write(data, std::streamsize(size));
  out.close();
  if (!out)
    throw IoError(
        fmt::format("cannot write {}: is the disk full, or the folder not yours?", path.string()));
}

}  // namespace

double store_step(double diagonal) {
  require(std::isfinite(diagonal) && diagonal > 0,
          fmt::format("the size of what is stored was found to be {}", diagonal));
  return std::exp2(std::ceil(std::log2(diagonal * 1e-6)));
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
  const OrderedJson head = parsed(text.substr(0, first_end));
  if (first_end == text.npos || !head.is_object() || head.value("format", OrderedJson()) != format_name)
    throw IoError(
        fmt::format("{}: found no evolving mesh, whose first line would say \"format\": "
                    "\"{}\"",
                    manifest_.string(), format_name));
  if (number(head, "version") != version)
    throw IoError(
        fmt::format("{}: its version is not {}, the one that is known: make it again, or "
                    "use the program that made it",
                    manifest_.string(), version));
  const OrderedJson blocks = head.value("blocks", OrderedJson()), exponent = head.value("step_exponent", OrderedJson());
  if (!blocks.is_string() || fs::path(blocks.get<std::string>()).has_parent_path() ||
      !exponent.is_number_integer() || std::abs(exponent.get<double>()) > 1000)
    throw IoError(
        fmt::format("{}: its first line names no file of blocks in the same folder, or no "
                    "step",
                    manifest_.string()));
  blocks_ = manifest_.parent_path() / blocks.get<std::string>();
  step_ = std::exp2(exponent.get<int>());
  about_ = head.value("about", OrderedJson::object()).dump();
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
    }
  }
  if (!broken_.empty())
    broken_ =
        fmt::format("{}: {}; {} before that {} whole", manifest_.string(), broken_,
                    counted(std::ssize(frames_), "frame"), frames_.size() == 1 ? "is" : "are");
}

/// Takes up one line; what is wrong with it in words, or nothing.
std::string EvolvingReader::add_line(std::string_view text, std::int64_t blocks_size) {
  const OrderedJson line = parsed(text);
  const std::string where = fmt::format("line {}", 2 + segments_.size() + frames_.size());
  if (!line.is_object()) return where + " is not JSON";
  StoredBlock block;
  block.offset = number(line, "offset");
  block.bytes = number(line, "bytes");
  const std::int64_t checksum = number(line, "crc32", 0xffffffff);
  const std::int64_t segment = number(line, "segment", largest_int);
  if (block.offset != whole_blocks_ || block.bytes < 0 || checksum < 0 || segment < 0)
    return where + " lacks one of segment, offset, bytes and crc32, or does not follow the last";
  if (block.bytes > blocks_size - block.offset)
    return fmt::format("{} names bytes up to {} of {}, which has {}", where,
                       block.offset + block.bytes, blocks_.filename().string(), blocks_size);
  block.checksum = std::uint32_t(checksum);
  if (line.contains("frame")) {
    const std::int64_t frame = number(line, "frame", largest_int);
    if (segment + 1 != std::ssize(segments_)) return where + " is of a segment that is not open";
    if (frame < 0 || (!frames_.empty() && frame <= frames_.back().number))
      return where + " has a frame number that does not increase";
    const OrderedJson measured = line.value("measured", OrderedJson());
    frames_.push_back(
        {block, int(frame), int(segment), measured.is_object() ? measured.dump() : ""});
  } else {
    if (segment != std::ssize(segments_)) return where + " does not begin the next segment";
    // An id and a coordinate of each axis take a byte each, and so do an id and three corners.
    for (const char* name : {"vertices", "triangles"})
      if (const std::int64_t most = block.bytes / 4, count = number(line, name);
          count < 0 || count > most)
        return fmt::format(
            "{} says {} {}, wanted a number from 0 to {}, as many as {} bytes can "
            "hold",
            where, line.value(name, OrderedJson()).dump(), name, most, block.bytes);
    segments_.push_back({block, int(number(line, "vertices")), int(number(line, "triangles"))});
  }
  whole_blocks_ += block.bytes;
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

std::vector<int> EvolvingReader::damaged() const {
  if (source_) return {};
  const auto changed = [&](const StoredBlock& block) {
    return crc32(bytes_of(block, "a block")) != block.checksum;
  };
  std::vector<bool> of_segment;
  for (const StoredSegment& segment : segments_) of_segment.push_back(changed(segment));
  std::vector<int> found;
  for (int f = 0; f < int(frames_.size()); ++f)
    if (of_segment[std::size_t(frames_[f].segment)] || changed(frames_[f])) found.push_back(f);
  return found;
}

EvolvingSegment EvolvingReader::segment(int index) const {
  if (source_) return source_->segment(index);
  const std::string what = fmt::format("segment {}", index);
  SegmentBlock found =
      decode_segment(block(segments_.at(std::size_t(index)), what), blocks_.string() + ": " + what);
  key_segment_ = index;
  key_ = std::move(found.key);
  return std::move(found.segment);
}

const std::vector<std::int64_t>& EvolvingReader::key(int segment_index) const {
  if (key_segment_ != segment_index) segment(segment_index);
  return key_;
}

std::vector<Vector3> EvolvingReader::positions(int frame) const {
  if (source_) return source_->positions(frame);
  const StoredFrame& stored = frames_.at(std::size_t(frame));
  const std::string what = fmt::format("frame {}", stored.number);
  return from_steps(
      decode_frame(block(stored, what), key(stored.segment), blocks_.string() + ": " + what),
      step_);
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

// ---- Writing ----

namespace {

fs::path blocks_beside(const fs::path& manifest) {
  fs::path blocks = fs::path(manifest).replace_extension(".blocks");
  require(manifest != blocks,
          manifest.string() + ": a store's name ends in .evolving; its blocks are beside it");
  return blocks;
}

}  // namespace

EvolvingWriter::EvolvingWriter(const fs::path& manifest, double step, const std::string& about)
    : step_(step) {
  const fs::path blocks = blocks_beside(manifest);
  beginning_ = std::make_unique<Beginning>(manifest, blocks);
  manifest_ = beginning_->manifest.temporary();
  blocks_ = beginning_->blocks.temporary();
  begin(blocks.filename().string(), about);
}

void EvolvingWriter::begin(const std::string& blocks_name, const std::string& about) {
  int exponent = 0;
  require(step_ > 0 && std::frexp(step_, &exponent) == 0.5,
          fmt::format("the step of a store is a power of two, not {}", step_));
  write_file(blocks_, {});
  const std::string line = OrderedJson{{"format", format_name},
                                {"version", version},
                                {"blocks", blocks_name},
                                {"step_exponent", exponent - 1},
                                {"about", parsed(about)}}
                               .dump(-1, ' ', false, OrderedJson::error_handler_t::replace) +
                           "\n";
  write_file(manifest_, bytes_of(line));
}

EvolvingWriter::EvolvingWriter(const EvolvingReader& reader, int frames)
    : blocks_(reader.blocks_file()), step_(reader.step()) {
  require(reader.is_store(), reader.manifest().string() + ": it is no store, and cannot be gone on with");
  require(frames >= 0 && frames <= std::ssize(reader.frames()),
          fmt::format("{} frames are to be kept of {}", frames, reader.frames().size()));
  manifest_ = reader.manifest();
  // Lines and blocks to keep: those before the first that is not.
  segment_ = frames > 0 ? reader.frames()[std::size_t(frames) - 1].segment : -1;
  const Bytes bytes = read_file(manifest_);
  const std::string_view text = text_of(bytes);
  std::size_t lines = 2 + std::size_t(segment_) + std::size_t(frames), end = 0;
  for (; lines > 0; --lines) end = text.find('\n', end) + 1;
  if (frames > 0) {
    const StoredFrame& last = reader.frames()[std::size_t(frames) - 1];
    size_ = last.offset + last.bytes;
    key_ = reader.key(segment_);
  }
  std::error_code failure;
  fs::resize_file(manifest_, end, failure);
  if (!failure) fs::resize_file(blocks_, std::uintmax_t(size_), failure);
  if (failure)
    throw IoError(
        fmt::format("{}: cannot go on with it: {}", manifest_.string(), failure.message()));
}

StoredBlock EvolvingWriter::append(const Bytes& bytes) {
  const StoredBlock block{size_, std::int64_t(bytes.size()), crc32(bytes)};
  write_all(blocks_, std::ios::app, reinterpret_cast<const char*>(bytes.data()), bytes.size());
  size_ += block.bytes;
  return block;
}

void EvolvingWriter::append_line(const std::string& line) {
  write_all(manifest_, std::ios::app, line.data(), line.size());
}

void EvolvingWriter::add_segment(const EvolvingSegment& segment,
                                 const std::vector<Vector3>& positions) {
  check(segment);
  require(std::ssize(positions) == segment.vertex_count(),
          fmt::format("{} positions were given for a segment of {} vertices", positions.size(),
                      segment.vertex_count()));
  key_ = in_steps(positions, step_);
  ++segment_;
  const StoredBlock block = append(encode_segment(segment, key_));
  append_line(OrderedJson{{"segment", segment_},
                   {"vertices", segment.vertex_count()},
                   {"triangles", segment.triangle_count()},
                   {"offset", block.offset},
                   {"bytes", block.bytes},
                   {"crc32", block.checksum}}
                  .dump() +
              "\n");
}

void EvolvingWriter::add_frame(int number, const std::vector<Vector3>& positions,
                               const std::string& measured) {
  require(segment_ >= 0 && 3 * positions.size() == key_.size(),
          fmt::format("{} positions were given for a segment of {} vertices", positions.size(),
                      key_.size() / 3));
  const StoredBlock block = append(encode_frame(in_steps(positions, step_), key_));
  OrderedJson line = {{"frame", number},
               {"segment", segment_},
               {"offset", block.offset},
               {"bytes", block.bytes},
               {"crc32", block.checksum}};
  if (!measured.empty()) line["measured"] = parsed(measured);
  append_line(line.dump() + "\n");
  if (!beginning_) return;
  beginning_->blocks.commit();
  beginning_->manifest.commit();
  blocks_ = beginning_->blocks.path();
  manifest_ = beginning_->manifest.path();
  beginning_.reset();
}

void write_evolving(const fs::path& manifest, const EvolvingMesh& evolving, double step,
                    const std::string& about, const std::vector<std::string>& measured) {
  check(evolving);
  require(measured.empty() || measured.size() == evolving.frames.size(),
          fmt::format("{} frames were given with what was measured of {}", evolving.frames.size(),
                      measured.size()));
  const fs::path blocks = blocks_beside(manifest);
  AtomicFile manifest_file(manifest), blocks_file(blocks);
  EvolvingWriter writer;
  writer.manifest_ = manifest_file.temporary();
  writer.blocks_ = blocks_file.temporary();
  writer.step_ = step;
  writer.begin(blocks.filename().string(), about);
  int open = -1;
  for (const EvolvingFrame& frame : evolving.frames) {
    // A segment without frames is kept: its number counts.
    for (; open < frame.segment; ++open) {
      const EvolvingSegment& next = evolving.segments[std::size_t(open) + 1];
      writer.add_segment(next, open + 1 == frame.segment
                                   ? frame.positions
                                   : std::vector<Vector3>(next.vertex_ids.size(), Vector3::Zero()));
    }
    writer.add_frame(
        frame.number, frame.positions,
        measured.empty() ? std::string() : measured[std::size_t(&frame - evolving.frames.data())]);
  }
  blocks_file.commit();
  manifest_file.commit();
}

}  // namespace mq
