#include "mq/model/joined_slots.h"

#include <algorithm>
#include <set>
#include <sstream>

#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "mq/io/document.h"
#include "mq/io/slots.h"

namespace mq {
namespace {

bool shares_pictures(const Model& model) {
  return model.document && (model.document->format == Document::Format::gltf ||
                            model.document->format == Document::Format::glb);
}

/// Whether all pictures of a slot are in the set, which they join.
bool all_known(const MaterialSlot& slot, std::set<std::string>& known) {
  bool all = true;
  for (const MaterialSlot::Use& use : slot.pictures) all = !known.insert(use.picture).second && all;
  return all;
}

}  // namespace

std::vector<std::string> slots_asked_for(const Model& model, const std::string& asked) {
  const std::string file = model.path.string();
  std::vector<std::string> names;
  if (asked == "all") {
    for (const MaterialSlot& slot : model.slots) names.push_back(slot.name);
  } else {
    std::stringstream words(asked);
    for (std::string word; std::getline(words, word, ',');) {
      require(!word.empty(), file + ": " + option_name("slot") + " '" + asked + "': a name between commas is empty");
      names.push_back(chosen_slot(model.slots, word, file));
    }
  }
  require(!names.empty(), file + ": its materials name no pictures, so it has no slots");
  std::ranges::stable_partition(names, [](const std::string& name) {
    return meaning_of_slot(name) == TextureMeaning::normals;
  });
  std::vector<std::string> slots;
  std::set<std::string> known;
  for (const std::string& name : names) {
    const auto slot = std::ranges::find(model.slots, name, &MaterialSlot::name);
    const bool again = slot != model.slots.end() && shares_pictures(model) && all_known(*slot, known);
    if (!again && std::ranges::count(slots, name) == 0) slots.push_back(name);
  }
  return slots;
}

void join_slot(Model other, Model& model) {
  for (Texture& texture : other.textures) {
    const auto place = std::ranges::find_if(model.others, [&](const Texture& mine) {
      return mine.path == texture.path && (!mine.path.empty() || mine.name == texture.name);
    });
    if (place == model.others.end()) continue;
    const std::string name = place->name;
    *place = std::move(texture);
    place->name = name;
  }
}

Model all_pictures(Model model) {
  model.tiles.clear();
  for (Texture& texture : model.others)
    if (!texture.pixels.empty()) model.textures.push_back(std::move(texture));
  model.others.clear();
  return model;
}

}  // namespace mq
