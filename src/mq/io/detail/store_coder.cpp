#include "mq/io/detail/store_coder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "mq/base/error.h"
#include "mq/io/detail/evolving_blocks.h"
#include "mq/io/detail/evolving_change.h"
#include "mq/io/detail/evolving_manifest.h"
#include "mq/io/detail/evolving_uvs.h"

namespace mq {
namespace {

using OrderedJson = nlohmann::ordered_json;

/// Puts the place of a block that follows `size` bytes into its line.
void put_place(OrderedJson& line, std::int64_t size, const Bytes& block) {
  line.update({{"offset", size}, {"bytes", block.size()}, {"crc32", crc32(block)}});
}

}  // namespace

StoreCoder::StoreCoder(double step, double uv_step, int group_frames, StoreState state)
    : step_(step), uv_step_(uv_step), group_frames_(group_frames), state_(std::move(state)) {
  require(is_step(step_), fmt::format("the step of a store has at most eight significant bits, and is not {}", step_));
  int exponent = 0;
  require(uv_step_ == 0 || (std::isnormal(uv_step_) && std::frexp(uv_step_, &exponent) == 0.5),
          fmt::format("the step of texture coordinates is a power of two or 0, not {}", uv_step_));
  require(group_frames_ > 0, fmt::format("a group of {} frames was asked for, wanted one at least", group_frames_));
}

std::string StoreCoder::head(const std::string& blocks_name, const std::string& about) const {
  return OrderedJson{{"format", store_format},
                     {"version", store_version},
                     {"blocks", blocks_name},
                     {"step", step_},
                     {"uv_step", uv_step_},
                     {"group_frames", group_frames_},
                     {"about", manifest_line(about)}}
             .dump(-1, ' ', false, OrderedJson::error_handler_t::replace) +
         "\n";
}

/// The open segment, as what is new since `before`; since nothing it begins a group.
StorePiece StoreCoder::open_segment(const EvolvingSegment& before) {
  StorePiece piece{encode_change(state_.open, before, uv_step_), {}, before.vertex_ids.empty()};
  OrderedJson line = {{"segment", state_.segment}};
  if (piece.begins_group) {
    line["group"] = ++state_.group;
    state_.frames_in_group = 0;
    state_.motion = {};
  }
  line.update({{"vertices", state_.open.vertex_count()}, {"triangles", state_.open.triangle_count()}});
  put_place(line, state_.size, piece.block);
  state_.size += std::ssize(piece.block);
  piece.line = line.dump() + "\n";
  return piece;
}

StorePiece StoreCoder::add_segment(const EvolvingSegment& segment) {
  check(segment);
  const EvolvingSegment before = std::exchange(state_.open, segment);
  state_.open.uvs = rounded_uvs(std::move(state_.open.uvs), uv_step_);
  ++state_.segment;
  const std::vector<int> from = vertices_before(state_.open, before);
  // Where most is new, the next frame tells little of it either.
  const bool is_new = 2 * std::ranges::count(from, -1) >= std::ssize(from);
  const bool begins_group = is_new || state_.frames_in_group >= group_frames_;
  StorePiece piece = open_segment(begins_group ? EvolvingSegment{} : before);
  if (!begins_group) state_.motion = carried_over(state_.motion, from, state_.open.triangles);
  state_.order = order_of(state_.open, state_.motion);
  return piece;
}

std::vector<StorePiece> StoreCoder::add_frame(int number, const std::vector<Vector3>& positions,
                                              const std::string& measured) {
  require(state_.segment >= 0 && std::ssize(positions) == state_.open.vertex_count(),
          fmt::format("{} positions were given for a segment of {} vertices", positions.size(),
                      state_.open.vertex_count()));
  std::vector<std::int64_t> coordinates = in_steps(positions, step_);
  std::vector<StorePiece> pieces;
  if (state_.frames_in_group >= group_frames_) {
    pieces.push_back(open_segment({}));
    state_.order = order_of(state_.open, state_.motion);
  }
  StorePiece& piece = pieces.emplace_back();
  piece.block = encode_positions(coordinates, state_.order, state_.motion);
  OrderedJson line = {{"frame", number}, {"segment", state_.segment}};
  put_place(line, state_.size, piece.block);
  if (!measured.empty()) line["measured"] = manifest_line(measured);
  piece.line = line.dump() + "\n";
  state_.size += std::ssize(piece.block);
  state_.motion.advance(std::move(coordinates));
  ++state_.frames_in_group;
  return pieces;
}

}  // namespace mq
