// Regions of the old buffers that overlap are copied as one segment, at the same remainder by four, so
// that accessors stay aligned.
#include "mq/io/detail/gltf_packer.h"

#include <algorithm>
#include <functional>
#include <tuple>

#include "mq/io/detail/gltf_container.h"
#include "mq/io/detail/gltf_meshopt.h"
#include "mq/io/uri.h"

namespace mq {
namespace {

constexpr const char* meshopt_extension = "EXT_meshopt_compression";

/// Calls `visit` with every member "bufferView" outside the array of views.
void for_each_reference(Json& json, const std::function<void(Json&)>& visit) {
  if (json.is_array())
    for (Json& item : json) for_each_reference(item, visit);
  if (!json.is_object()) return;
  for (auto& [key, value] : json.items()) {
    if (key == "bufferView" && value.is_number_integer())
      visit(value);
    else if (key != "bufferViews")
      for_each_reference(value, visit);
  }
}

}  // namespace

GltfPacker::GltfPacker(const GltfFile& file) : file_(file), json_(file.json()) {
  for (std::size_t v = 0; v < file.size("bufferViews"); ++v) {
    const auto id = std::int64_t(v);
    View view{file.item("bufferViews", id), {file.stored_view(id), {}}, {file.compressed_view(id), {}}};
    views_.push_back(std::move(view));
  }
}

bool GltfPacker::can_pack(const GltfFile& file) {
  const Json& used = json_array(file.json(), "extensionsUsed", file.name());
  return std::ranges::none_of(used, [](const Json& name) {
    return name == "EXT_structural_metadata" || name == "EXT_feature_metadata" ||
           name == "KHR_meshopt_compression";
  });
}

std::int64_t GltfPacker::add_view(Bytes bytes, Json more) {
  more["byteLength"] = bytes.size();
  views_.push_back({std::move(more), {{}, std::move(bytes)}, {}});
  return std::ssize(views_) - 1;
}

void GltfPacker::compress_view(std::int64_t id, Bytes stream, Json extension) {
  View& view = views_[std::size_t(id)];
  view.members["extensions"][meshopt_extension] = std::move(extension);
  view.stored = {};
  view.stream = {{}, std::move(stream)};
}

void GltfPacker::place_regions(const std::vector<char>& used) {
  for (std::size_t v = 0; v < views_.size(); ++v)
    for (const Source* source : {&views_[v].stored, &views_[v].stream})
      if (used[v] && source->region)
        segments_.push_back({source->region->buffer, source->region->offset,
                             source->region->offset + source->region->length});
  std::ranges::sort(segments_, [](const Segment& a, const Segment& b) {
    return std::tie(a.buffer, a.begin, a.end) < std::tie(b.buffer, b.begin, b.end);
  });
  std::vector<Segment> joined;
  for (const Segment& next : segments_) {
    if (!joined.empty() && joined.back().buffer == next.buffer && next.begin < joined.back().end)
      joined.back().end = std::max(joined.back().end, next.end);
    else
      joined.push_back(next);
  }
  for (Segment& segment : joined) {
    pad_to_four(binary_, '\0');
    binary_.resize(binary_.size() + segment.begin % 4);
    segment.to = binary_.size();
    const ByteView from =
        file_.buffer(segment.buffer).subspan(segment.begin, segment.end - segment.begin);
    binary_.insert(binary_.end(), from.begin(), from.end());
  }
  segments_ = std::move(joined);
}

std::size_t GltfPacker::place(const Source& source) {
  if (source.region) {
    const auto found = std::ranges::find_if(segments_, [&](const Segment& segment) {
      return segment.buffer == source.region->buffer && segment.begin <= source.region->offset &&
             source.region->offset + source.region->length <= segment.end;
    });
    return found->to + source.region->offset - found->begin;
  }
  pad_to_four(binary_, '\0');
  binary_.insert(binary_.end(), source.own.begin(), source.own.end());
  return binary_.size() - source.own.size();
}

Json GltfPacker::view_json(const View& view) {
  Json json = view.members;
  const std::size_t length = json.value("byteLength", std::size_t(0));
  json["buffer"] = view.stored.is_there() ? 0 : 1;
  json["byteOffset"] = view.stored.is_there() ? place(view.stored) : fallback_;
  if (!view.stored.is_there()) fallback_ += (length + 3) / 4 * 4;
  if (view.stream.is_there()) {
    Json& extension = json["extensions"][meshopt_extension];
    extension["buffer"] = 0;
    extension["byteOffset"] = place(view.stream);
    extension["byteLength"] =
        view.stream.region ? view.stream.region->length : view.stream.own.size();
  }
  return json;
}

Document GltfPacker::packed(Document::Format format, const std::string& stem) {
  std::vector<char> used(views_.size(), 0);
  for_each_reference(json_, [&](Json& id) {
    if (const auto v = id.get<std::size_t>(); v < used.size()) used[v] = 1;
  });
  place_regions(used);
  std::vector<std::size_t> number(views_.size(), 0);
  Json views = Json::array();
  for (std::size_t v = 0; v < views_.size(); ++v) {
    if (!used[v]) continue;
    number[v] = views.size();
    views.push_back(view_json(views_[v]));
  }
  for_each_reference(json_, [&](Json& id) {
    if (const auto v = id.get<std::size_t>(); v < number.size()) id = number[v];
  });
  json_.erase("buffers");
  json_.erase("bufferViews");
  const bool glb = format == Document::Format::glb;
  if (!views.empty()) {
    pad_to_four(binary_, '\0');
    json_["bufferViews"] = std::move(views);
    json_["buffers"] = Json::array({{{"byteLength", binary_.size()}}});
    if (!glb) json_["buffers"][0]["uri"] = uri_of_name(stem + ".bin");
    if (fallback_ > 0)
      json_["buffers"].push_back(
          {{"byteLength", fallback_}, {"extensions", {{meshopt_extension, {{"fallback", true}}}}}});
  }
  const Bytes text = to_bytes(json_.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
  Document document;
  document.format = format;
  document.name = stem;
  document.bytes = glb ? glb_bytes(text, binary_, {}) : text;
  if (!glb && !binary_.empty()) document.parts.push_back({stem + ".bin", std::move(binary_)});
  return document;
}

}  // namespace mq
