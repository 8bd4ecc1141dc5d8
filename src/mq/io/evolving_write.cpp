// A block is appended and then its line.

#include <fmt/format.h>

#include <fstream>
#include <utility>

#include "mq/base/error.h"
#include "mq/io/detail/evolving_manifest.h"
#include "mq/io/evolving_file.h"

namespace mq {

namespace {

namespace fs = std::filesystem;
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

EvolvingWriter::EvolvingWriter(const fs::path& manifest, double step, const std::string& about, double uv_step,
                               int group_frames)
    : coder_(step, uv_step, group_frames) {
  const fs::path blocks = blocks_beside(manifest);
  beginning_ = std::make_unique<Beginning>(manifest, blocks);
  manifest_ = beginning_->manifest.temporary();
  blocks_ = beginning_->blocks.temporary();
  begin(blocks.filename().string(), about);
}

void EvolvingWriter::begin(const std::string& blocks_name, const std::string& about) {
  write_file(blocks_, {});
  write_file(manifest_, bytes_of(coder_.head(blocks_name, about)));
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
  write_evolving(reader.manifest(), kept, reader.step(), reader.about(), measured, reader.uv_step(),
                 reader.group_frames());
}

void EvolvingWriter::go_on(const EvolvingReader& reader, int frames) {
  manifest_ = reader.manifest();
  blocks_ = reader.blocks_file();
  StoreState state;
  std::int64_t end = 0;
  if (frames > 0) {
    const auto last = std::size_t(frames) - 1;
    const EvolvingReader::Moment& moment = reader.moment(frames - 1);
    const int group = moment.place.group;
    state = {.segment = moment.place.segment,
             .group = group,
             .frames_in_group = frames - reader.groups_[std::size_t(group)].first_frame,
             .size = reader.frames_[last].offset + reader.frames_[last].bytes,
             .open = moment.place.found,
             .order = moment.order,
             .motion = moment.motion};
    end = reader.end_of_frame_[last];
  } else {
    end = std::int64_t(text_of(read_file(manifest_)).find('\n')) + 1;
  }
  const std::int64_t size = state.size;
  coder_ = StoreCoder(reader.step_, reader.uv_step_, reader.group_frames_, std::move(state));
  std::error_code failure;
  fs::resize_file(manifest_, std::uintmax_t(end), failure);
  if (!failure) fs::resize_file(blocks_, std::uintmax_t(size), failure);
  if (failure)
    throw IoError(
        fmt::format("{}: cannot go on with it: {}", manifest_.string(), failure.message()));
}

void EvolvingWriter::append(const StorePiece& piece) {
  write_all(blocks_, std::ios::app, reinterpret_cast<const char*>(piece.block.data()), piece.block.size());
  write_all(manifest_, std::ios::app, piece.line.data(), piece.line.size());
}

void EvolvingWriter::add_segment(const EvolvingSegment& segment) { append(coder_.add_segment(segment)); }

void EvolvingWriter::add_frame(int number, const std::vector<Vector3>& positions,
                               const std::string& measured) {
  for (const StorePiece& piece : coder_.add_frame(number, positions, measured)) append(piece);
  if (!beginning_) return;
  beginning_->blocks.commit();
  beginning_->manifest.commit();
  blocks_ = beginning_->blocks.path();
  manifest_ = beginning_->manifest.path();
  beginning_.reset();
}

void write_evolving(const fs::path& manifest, const EvolvingMesh& evolving, double step,
                    const std::string& about, const std::vector<std::string>& measured,
                    double uv_step, int group_frames) {
  check(evolving);
  require(measured.empty() || measured.size() == evolving.frames.size(),
          fmt::format("{} frames were given with what was measured of {}", evolving.frames.size(),
                      measured.size()));
  const fs::path blocks = blocks_beside(manifest);
  AtomicFile manifest_file(manifest), blocks_file(blocks);
  EvolvingWriter writer;
  writer.manifest_ = manifest_file.temporary();
  writer.blocks_ = blocks_file.temporary();
  writer.coder_ = StoreCoder(step, uv_step, group_frames);
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
