#include "verbs/shared/slots_report.h"

#include <fmt/format.h>

#include <algorithm>

#include "mq/io/document.h"
#include "mq/io/slots.h"
#include "mq/model/model_paints.h"
#include "mq/model/normal_axes.h"

namespace mq::app {
namespace {

/// The set a picture of a slot is looked up with.
int used_set(const Model& model, const MaterialSlot& slot, const MaterialSlot::Use& use) {
  return slot.name == model.slot && model.uv_set >= 0 ? model.uv_set : use.uv_set;
}

/// Whether pictures of another slot are among those processed: one file for both.
bool shares_picture(const Model& model, const MaterialSlot& slot) {
  for (const MaterialSlot::Use& use : slot.pictures)
    if (model.document && model.document->format != Document::Format::obj &&
        std::ranges::any_of(model.slots, [&](const MaterialSlot& other) {
          return other.name == model.slot &&
                 std::ranges::any_of(other.pictures, [&](const MaterialSlot::Use& its) {
                   return its.picture == use.picture;
                 });
        }))
      return true;
  return false;
}

std::string fate(const Model& model, const MaterialSlot& slot) {
  if (slot.name == model.slot) return "processed";
  return shares_picture(model, slot) ? "changes with it: one picture for both" : "kept as it is";
}

std::vector<std::string> tiles_of(const Model& model) {
  std::vector<std::string> names;
  for (std::size_t t = 0; t < model.tiles.size() && t < model.textures.size(); ++t)
    names.push_back(model.textures[t].name);
  return names;
}

}  // namespace

Json slots_json(const Model& model) {
  Json slots = Json::array();
  for (const MaterialSlot& slot : model.slots) {
    Json pictures = Json::array();
    for (const MaterialSlot::Use& use : slot.pictures)
      pictures.push_back({{"picture", use.picture}, {"uv_set", used_set(model, slot, use)}});
    slots.push_back({{"slot", slot.name},
                     {"processed", slot.name == model.slot},
                     {"pictures", std::move(pictures)}});
  }
  return {{"uv_sets", uv_set_count(model)}, {"slots", std::move(slots)}, {"tiles", tiles_of(model)}};
}

std::vector<std::pair<std::string, std::string>> slots_rows(const Model& model) {
  std::vector<std::pair<std::string, std::string>> rows;
  const int sets = uv_set_count(model);
  if (sets > 1)
    rows.emplace_back("uv sets", model.uv_set >= 0
                                     ? fmt::format("{}, of which set {} is processed", sets, model.uv_set)
                                     : std::to_string(sets));
  const bool plain = model.slots.size() == 1 && model.slots.front().name == base_slot && sets < 2;
  for (const MaterialSlot& slot : model.slots) {
    if (plain) break;
    std::string pictures;
    for (const MaterialSlot::Use& use : slot.pictures) {
      pictures += (pictures.empty() ? "" : ", ") + use.picture;
      if (sets > 1) pictures += fmt::format(" with set {}", used_set(model, slot, use));
    }
    rows.emplace_back("slot", fmt::format("{}: {} ({})", slot.name, pictures, fate(model, slot)));
  }
  if (const std::vector<std::string> tiles = tiles_of(model); !tiles.empty())
    rows.emplace_back("tiles", fmt::format("{}: {}", tiles.size(), fmt::join(tiles, ", ")));
  return rows;
}

Json normals_json(const TexturedModel& model) {
  if (!has_pictures(model) || model.model.textures.front().meaning != TextureMeaning::normals)
    return nullptr;
  const NormalMapShares shares =
      normal_map_shares(model, texel_coverage(model.surface, *model.atlas));
  const NormalAxes axes = found_axes(model, NormalAxes::as_found, shares);
  Json json = {{"axes", axes == NormalAxes::object ? "object" : "tangent"},
               {"upright", shares.upright}};
  if (axes != NormalAxes::object) json["frames"] = ShadingFrames(model, axes).source();
  return json;
}

std::vector<std::pair<std::string, std::string>> normals_rows(const Json& normals) {
  if (normals.is_null()) return {};
  const double percent = 100 * normals["upright"].get<double>();
  if (normals["axes"] == "object")
    return {{"normals", fmt::format("in object space ({:.0f} % point along z)", percent)}};
  return {{"normals",
           fmt::format("in tangent space ({:.0f} % point along z), processed in the model's axes as "
                       "what they add to its shading; {}",
                       percent, normals["frames"].get<std::string>())}};
}

}  // namespace mq::app
