// A block is appended and then its line. Frames are told from those before them in their group; a group is begun when
// the last one has its frames, or when most vertices of a segment are new.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>

#include "mq/base/error.h"
#include "mq/io/detail/evolving_blocks.h"
#include "mq/io/detail/evolving_change.h"
#include "mq/io/detail/evolving_uvs.h"
#include "mq/io/detail/evolving_manifest.h"
#include "mq/io/evolving_file.h"

namespace mq {

namespace {

namespace fs = std::filesystem;
using OrderedJson = nlohmann::ordered_json;

void write_all(const fs::path& path, std::ios::openmode mode, const char* data, std::size_t size) {
  std::ofstream out(path, std::ios::binary | mode);
  out.write(data, std::streamsize(size));
  out.close();
  if (!out)
    throw IoError(
        fmt::format("cannot write {}: is the disk full, or the folder not yours?", path.string()));
}

fs::path blocks_beside(const fs::path& manifest) {
  fs::path blocks = fs::path(manifest).replace_extension(".blocks");
  require(manifest != blocks,
          manifest.string() + ": a store's name ends in .evolving; its blocks are beside it");
  return blocks;
}

}  // namespace

EvolvingWriter::EvolvingWriter(const fs::path& manifest, double step, const std::string& about, double uv_step)
    : step_(step), uv_step_(uv_step) {
  const fs::path blocks = blocks_beside(manifest);
  beginning_ = std::make_unique<Beginning>(manifest, blocks);
  manifest_ = beginning_->manifest.temporary();
  blocks_ = beginning_->blocks.temporary();
  begin(blocks.filename().string(), about);
}

void EvolvingWriter::begin(const std::string& blocks_name, const std::string& about) {
  require(is_step(step_), fmt::format("the step of a store has at most eight significant bits, and is not {}", step_));
  int exponent = 0;
  require(uv_step_ == 0 || (std::isnormal(uv_step_) && std::frexp(uv_step_, &exponent) == 0.5),
          fmt::format("the step of texture coordinates is a power of two or 0, not {}", uv_step_));
  write_file(blocks_, {});
  const std::string line = OrderedJson{{"format", store_format},
                                {"version", store_version},
                                {"blocks", blocks_name},
                                {"step", step_},
                                {"uv_step", uv_step_},
                                {"about", manifest_line(about)}}
                               .dump(-1, ' ', false, OrderedJson::error_handler_t::replace) +
                           "\n";
  write_file(manifest_, bytes_of(line));
}

EvolvingWriter::EvolvingWriter(const EvolvingReader& reader, int frames) {
  require(reader.is_store(), reader.manifest().string() + ": it is no store, and cannot be gone on with");
  require(frames >= 0 && frames <= std::ssize(reader.frames()),
          fmt::format("{} frames are to be kept of {}", frames, reader.frames().size()));
  const bool is_old = reader.version_ != store_version;
  if (is_old) make_anew(reader, frames);
  go_on(is_old ? EvolvingReader(reader.manifest()) : reader, frames);
}

/// In the version that is written now, with as many frames.
void EvolvingWriter::make_anew(const EvolvingReader& reader, int frames) const {
  EvolvingMesh kept;
  std::vector<std::string> measured;
  for (int f = 0; f < frames; ++f) {
    const StoredFrame& stored = reader.frames()[std::size_t(f)];
    while (std::ssize(kept.segments) <= stored.segment)
      kept.segments.push_back(reader.segment(int(kept.segments.size())));
    kept.frames.push_back({stored.number, stored.segment, reader.positions(f)});
    measured.push_back(stored.measured);
  }
  write_evolving(reader.manifest(), kept, reader.step(), reader.about(), measured, reader.uv_step());
}

void EvolvingWriter::go_on(const EvolvingReader& reader, int frames) {
  manifest_ = reader.manifest();
  blocks_ = reader.blocks_file();
  step_ = reader.step_;
  uv_step_ = reader.uv_step_;
  std::int64_t end = 0;
  if (frames > 0) {
    const auto last = std::size_t(frames) - 1;
    const EvolvingReader::Moment& moment = reader.moment(frames - 1);
    open_ = moment.place.found;
    order_ = moment.order;
    motion_ = moment.motion;
    segment_ = moment.place.segment;
    group_ = moment.place.group;
    frames_in_group_ = frames - reader.groups_[std::size_t(group_)].first_frame;
    size_ = reader.frames_[last].offset + reader.frames_[last].bytes;
    end = reader.end_of_frame_[last];
  } else {
    end = std::int64_t(text_of(read_file(manifest_)).find('\n')) + 1;
  }
  std::error_code failure;
  fs::resize_file(manifest_, std::uintmax_t(end), failure);
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

/// The open segment, as what is new since `before`; since nothing it begins a group.
void EvolvingWriter::append_segment(const EvolvingSegment& before) {
  const StoredBlock block = append(encode_change(open_, before, uv_step_));
  OrderedJson line = {{"segment", segment_}};
  if (before.vertex_ids.empty()) {
    line["group"] = ++group_;
    frames_in_group_ = 0;
    motion_ = {};
  }
  line.update({{"vertices", open_.vertex_count()},
               {"triangles", open_.triangle_count()},
               {"offset", block.offset},
               {"bytes", block.bytes},
               {"crc32", block.checksum}});
  append_line(line.dump() + "\n");
}

void EvolvingWriter::add_segment(const EvolvingSegment& segment) {
  check(segment);
  const EvolvingSegment before = std::exchange(open_, segment);
  open_.uvs = rounded_uvs(std::move(open_.uvs), uv_step_);
  ++segment_;
  const std::vector<int> from = vertices_before(open_, before);
  // Where most is new, the next frame tells little of it either.
  const bool is_new = 2 * std::ranges::count(from, -1) >= std::ssize(from);
  if (is_new || frames_in_group_ == store_group_frames) {
    append_segment({});
  } else {
    append_segment(before);
    motion_ = carried_over(motion_, from, open_.triangles);
  }
  order_ = order_of(open_, motion_);
}

void EvolvingWriter::add_frame(int number, const std::vector<Vector3>& positions,
                               const std::string& measured) {
  require(segment_ >= 0 && std::ssize(positions) == open_.vertex_count(),
          fmt::format("{} positions were given for a segment of {} vertices", positions.size(),
                      open_.vertex_count()));
  std::vector<std::int64_t> coordinates = in_steps(positions, step_);
  if (frames_in_group_ == store_group_frames) {
    append_segment({});
    order_ = order_of(open_, motion_);
  }
  const StoredBlock block = append(encode_positions(coordinates, order_, motion_));
  motion_.advance(std::move(coordinates));
  ++frames_in_group_;
  OrderedJson line = {{"frame", number},
               {"segment", segment_},
               {"offset", block.offset},
               {"bytes", block.bytes},
               {"crc32", block.checksum}};
  if (!measured.empty()) line["measured"] = manifest_line(measured);
  append_line(line.dump() + "\n");
  if (!beginning_) return;
  beginning_->blocks.commit();
  beginning_->manifest.commit();
  blocks_ = beginning_->blocks.path();
  manifest_ = beginning_->manifest.path();
  beginning_.reset();
}

void write_evolving(const fs::path& manifest, const EvolvingMesh& evolving, double step,
                    const std::string& about, const std::vector<std::string>& measured,
                    double uv_step) {
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
  writer.uv_step_ = uv_step;
  writer.begin(blocks.filename().string(), about);
  int open = -1;
  for (const EvolvingFrame& frame : evolving.frames) {
    // A segment without frames is kept: its number counts.
    while (open < frame.segment) writer.add_segment(evolving.segments[std::size_t(++open)]);
    writer.add_frame(
        frame.number, frame.positions,
        measured.empty() ? std::string() : measured[std::size_t(&frame - evolving.frames.data())]);
  }
  blocks_file.commit();
  manifest_file.commit();
}

}  // namespace mq
