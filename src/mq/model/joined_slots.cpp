#include "mq/model/joined_slots.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <sstream>

#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "mq/io/document.h"
#include "mq/io/normals.h"
#include "mq/io/slots.h"

namespace mq {
namespace {

bool shares_pictures(const Model& model) {
  return model.document && model.document->is_gltf();
}

/// Whether all pictures of a slot are in the set, which they join.
bool all_known(const MaterialSlot& slot, std::set<std::string>& known) {
  bool all = true;
  for (const MaterialSlot::Use& use : slot.pictures) all = !known.insert(use.picture).second && all;
  return all;
}

}  // namespace

bool names_several_slots(const std::string& asked) {
  return asked == "all" || asked.find(',') != std::string::npos;
}

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
  std::set<const Texture*> taken;  // a file may name one picture twice
  for (Texture& texture : other.textures) {
    const auto place = std::ranges::find_if(model.others, [&](const Texture& mine) {
      return mine.path == texture.path && (!mine.path.empty() || mine.name == texture.name) &&
             !taken.contains(&mine);
    });
    if (place == model.others.end()) continue;
    taken.insert(&*place);
    const std::string name = place->name;
    *place = std::move(texture);
    place->name = name;
  }
}

void begin_slots(const std::vector<std::string>& slots, std::size_t textures, Model& model) {
  forget_file(model, Tangents::kept);
  model.tiles.clear();
  model.others.clear();
  model.slots.clear();
  model.slot = slots.front();
  const std::string stem = model.path.stem().string();
  const auto picture = [&](const std::string& name, const std::string& slot) {
    Texture texture;
    texture.name = name + ".png";
    texture.format.file_format = "png";
    texture.meaning = meaning_of_slot(slot);
    return texture;
  };
  const auto name = [&](const std::string& beginning, std::size_t t) {
    return textures == 1 ? beginning : fmt::format("{}_{}", beginning, t);
  };
  std::vector<Wrap> wraps(textures, Wrap::unspecified);
  for (std::size_t t = 0; t < std::min(textures, model.textures.size()); ++t)
    wraps[t] = model.textures[t].wrap;
  model.textures.clear();
  for (std::size_t t = 0; t < textures; ++t) {
    model.textures.push_back(picture(name(stem, t), slots.front()));
    model.textures.back().wrap = wraps[t];
  }
  for (const std::string& slot : slots) {
    MaterialSlot& added = model.slots.emplace_back(MaterialSlot{.name = slot, .pictures = {}});
    for (std::size_t t = 0; t < textures; ++t) {
      const bool is_first = slot == slots.front();
      if (!is_first) {
        added.with_texture.push_back(int(model.others.size()));
        model.others.push_back(picture(name(slot, t), slot));
      }
      added.pictures.push_back({(is_first ? model.textures[t] : model.others.back()).name, 0});
    }
  }
}

std::vector<SharedSlot> shared_slots(const Model& model, const std::vector<std::string>& with) {
  std::vector<SharedSlot> shared;
  if (!shares_pictures(model)) return shared;
  const auto has_all = [](const MaterialSlot& slot, const MaterialSlot& of) {
    return std::ranges::all_of(of.pictures, [&](const MaterialSlot::Use& use) {
      return std::ranges::count(slot.pictures, use) > 0;
    });
  };
  for (const MaterialSlot& slot : model.slots) {
    if (std::ranges::count(with, slot.name) > 0) continue;
    for (const MaterialSlot& other : model.slots)
      if (std::ranges::count(with, other.name) > 0 && has_all(other, slot)) {
        shared.push_back({slot.name, other.name});
        break;
      }
  }
  return shared;
}

void share_slots(const std::vector<SharedSlot>& shared, Model& model) {
  for (const SharedSlot& one : shared) {
    const auto of = std::ranges::find(model.slots, one.with, &MaterialSlot::name);
    if (of == model.slots.end()) continue;
    MaterialSlot slot = *of;
    slot.name = one.name;
    if (one.with == model.slot) slot.with_texture.assign(model.textures.size(), MaterialSlot::the_texture);
    model.slots.push_back(std::move(slot));
  }
}

void put_slot(const std::string& slot, std::vector<Texture> pictures, Model& model) {
  if (slot == model.slot) {
    for (std::size_t t = 0; t < pictures.size(); ++t) pictures[t].name = model.textures[t].name;
    model.textures = std::move(pictures);
    return;
  }
  const auto found = std::ranges::find(model.slots, slot, &MaterialSlot::name);
  for (std::size_t t = 0; t < pictures.size(); ++t) {
    Texture& place = model.others[std::size_t(found->with_texture[t])];
    pictures[t].name = place.name;
    place = std::move(pictures[t]);
  }
}

Model all_pictures(Model model) {
  model.tiles.clear();
  for (Texture& texture : model.others)
    if (!texture.pixels.empty() || !model.document) model.textures.push_back(std::move(texture));
  model.others.clear();
  return model;
}

}  // namespace mq
