#include "mq/model/bake_target.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "mq/io/file_names.h"
#include "mq/io/materials.h"
#include "mq/io/slots.h"

namespace mq {

void begin_bake(const std::vector<std::string>& slots, const std::vector<SharedSlot>& shared, TexturedModel& target) {
  Model& model = target.model;
  const bool is_anew = slots.size() > 1 || !shared.empty() ||
                       (slots.size() == 1 && slots.front() != base_slot && slots.front() != model.slot);
  if (is_anew) {
    begin_slots(slots, target.texture_sizes.size(), model);
    share_slots(shared, model);
  } else if (!model.document) {
    model.slots.clear();
  }
}

void begin_bake_as(const Model& source, const std::vector<std::string>& slots, BakedSlots asked,
                   const std::filesystem::path& output, TexturedModel& target, Messages& messages) {
  const ModelMaterials of_source = file_materials(source), own = file_materials(target.model);
  const std::vector<const Material*> used = of_source.used();
  const std::vector<std::string> baked = slots.empty() ? std::vector<std::string>{base_slot} : slots;
  Material joint = joined(used, baked);
  if (factors_for_one(source) == BakeOptions::Factors::applied) joint = without_factors(std::move(joint), baked);
  const bool has_materials = names_gltf(output) || lower_extension(output) == ".obj";
  const bool multiplies = names_gltf(output) && target.model.colors.channels > 0;
  const bool looks_otherwise = !used.empty() && !look_alike(joint, joined(own.used(), {}));
  begin_bake(slots, shared_slots(source, slots), target);
  const bool is_to_show_all = asked == BakedSlots::as_the_source && has_materials;
  if (target.model.document && is_to_show_all && (looks_otherwise || multiplies))
    begin_slots(baked, target.texture_sizes.size(), target.model);
  if (target.model.document) return;
  if (multiplies) leave_out_colours(target.model, messages);
  if (used.empty()) return;
  target.model.materials =
      std::make_shared<const ModelMaterials>(one_for_all(std::move(joint), target.model.mesh.triangle_count()));
  if (const std::string lost = lost_by_joining(used, baked); has_materials && !lost.empty())
    messages.remark(fmt::format("{}: its materials become one, which does not say all of theirs: {}",
                                source.path.string(), lost));
}

BakeOptions::Factors factors_for_one(const Model& source) {
  using Factors = BakeOptions::Factors;
  if (source.colors.channels > 0 && source.colors.is_light && !source.textures.empty()) return Factors::applied;
  const ModelMaterials materials = file_materials(source);
  return all_look_alike(materials.used()) ? Factors::apart : Factors::applied;
}

BakeOptions::Factors factors_into_pictures(const std::vector<std::string>& slots, Model& model) {
  if (!model.materials) return BakeOptions::Factors::apart;
  ModelMaterials bare = *model.materials;
  std::vector<std::string> baked;
  for (const std::string& slot : slots)
    if (mtl_keyword(slot)) baked.push_back(slot);
  for (Material& material : bare.materials)
    material = without_factors(std::move(material), baked, AlphaFactor::stays);
  model.materials = std::make_shared<const ModelMaterials>(std::move(bare));
  return BakeOptions::Factors::applied_but_alpha;
}

void leave_out_colours(Model& model, Messages& messages) {
  model.colors = {};
  messages.remark("the colours at vertices are in the picture now, and no longer at vertices, by which glTF would "
                  "multiply it");
}

}  // namespace mq
