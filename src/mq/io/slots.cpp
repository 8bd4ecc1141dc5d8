#include "mq/io/slots.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "mq/base/options.h"
#include "mq/base/words.h"
#include "mq/io/bytes.h"

namespace mq {
namespace {

/// Keywords of MTL in small letters; of those of one slot the first is written.
constexpr std::array<std::pair<const char*, const char*>, 18> mtl_keywords{
    {{"map_Kd", base_slot},      {"map_Ks", "specular-colour"}, {"map_Ka", "ambient"},
     {"map_Ke", "emissive"},     {"map_Ns", "shininess"},       {"map_d", "opacity"},
     {"norm", "normal"},         {"map_Kn", "normal"},          {"map_Bump", "bump"},
     {"bump", "bump"},           {"disp", "displacement"},      {"map_disp", "displacement"},
     {"map_Pr", "roughness"},    {"map_Pm", "metallic"},        {"map_Ps", "sheen"},
     {"map_AO", "occlusion"},    {"map_Pc", "clearcoat"},       {"map_Pcr", "clearcoat-roughness"}}};

/// Members of a glTF material that need no extension.
constexpr std::array<std::pair<const char*, const char*>, 5> gltf_keywords{
    {{"baseColorTexture", base_slot},
     {"metallicRoughnessTexture", "metallic-roughness"},
     {"normalTexture", "normal"},
     {"occlusionTexture", "occlusion"},
     {"emissiveTexture", "emissive"}}};

/// Slots that extensions of glTF's materials bring, beside those that MTL has as well.
constexpr std::array<const char*, 12> extension_slots{
    "clearcoat-normal", "sheen-colour",  "sheen-roughness",       "specular",
    "transmission",     "thickness",     "iridescence",           "iridescence-thickness",
    "anisotropy",       "specular-glossiness", "diffuse-transmission", "diffuse-transmission-colour"};

/// What other programs call slots.
constexpr std::array<std::pair<const char*, const char*>, 15> synonyms{
    {{"basecolour", base_slot},
     {"albedo", base_slot},
     {"diffuse", base_slot},
     {"colour", base_slot},
     {"base", base_slot},
     {"orm", "metallic-roughness"},
     {"metallicroughness", "metallic-roughness"},
     {"metalness", "metallic"},
     {"metal", "metallic"},
     {"ao", "occlusion"},
     {"ambient-occlusion", "occlusion"},
     {"emission", "emissive"},
     {"normals", "normal"},
     {"normal-map", "normal"},
     {"alpha", "opacity"}}};

char small(char c) { return c >= 'A' && c <= 'Z' ? char(c + 32) : c; }

std::string in_small_letters(std::string_view text) {
  std::string result(text);
  std::ranges::transform(result, result.begin(), small);
  return result;
}

/// British, as all words here.
std::string with_colour(std::string text) {
  for (std::size_t at = 0; (at = text.find("color", at)) != text.npos; at += 6)
    text.replace(at, 5, "colour");
  return text;
}

/// Whether a file of a format, named by its extension, can name pictures for a slot.
bool has_word_for(const std::string& extension, const std::string& slot) {
  const std::string format = in_small_letters(extension);
  if (format == ".obj") return mtl_keyword(slot) != nullptr;
  return (format == ".gltf" || format == ".glb") && gltf_keyword(slot) != nullptr;
}

const MaterialSlot* find_slot(const std::vector<MaterialSlot>& slots, const std::string& name) {
  const auto found = std::ranges::find(slots, name, &MaterialSlot::name);
  return found == slots.end() ? nullptr : &*found;
}

}  // namespace

std::string slot_of_gltf(std::string_view member) {
  constexpr std::string_view ending = "Texture";
  if (!member.ends_with(ending) || member.size() == ending.size()) return "";
  member.remove_suffix(ending.size());
  std::string words;
  for (const char c : member) {
    if (small(c) != c && !words.empty()) words += '-';
    words += small(c);
  }
  return words == "diffuse" ? base_slot : with_colour(words);
}

std::string slot_of_mtl(std::string_view keyword) {
  const std::string wanted = in_small_letters(keyword);
  for (const auto& [known, slot] : mtl_keywords)
    if (in_small_letters(known) == wanted) return slot;
  return "";
}

const char* mtl_keyword(const std::string& slot) {
  for (const auto& [known, of] : mtl_keywords)
    if (slot == of) return known;
  return nullptr;
}

const char* gltf_keyword(const std::string& slot) {
  for (const auto& [known, of] : gltf_keywords)
    if (slot == of) return known;
  return nullptr;
}

std::vector<SlotPicture> material_pictures(const Model& model, int texture,
                                           const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  const std::string own = model.slot.empty() ? base_slot : model.slot;
  std::vector<SlotPicture> pictures{{own, texture}};
  for (const MaterialSlot& slot : model.slots) {
    if (slot.name == own || slot.with_texture.size() != model.textures.size()) continue;
    const int with = slot.with_texture[std::size_t(texture)];
    const bool known = with == MaterialSlot::the_texture ||
                       (with >= 0 && with < std::ssize(model.others));
    if (known && has_word_for(extension, slot.name))
      pictures.push_back({slot.name, with >= 0 ? int(model.textures.size()) + with : texture});
  }
  return pictures;
}

std::vector<char> named_pictures(const Model& model, const std::filesystem::path& path) {
  std::vector<char> named(model.textures.size() + model.others.size(), 0);
  for (int t = 0; t < std::ssize(model.textures); ++t)
    for (const SlotPicture& one : material_pictures(model, t, path)) named[std::size_t(one.picture)] = 1;
  return named;
}

std::vector<std::string> slots_left_out(const Model& model, const std::filesystem::path& path) {
  std::map<std::string, std::set<int>> held;
  for (int t = 0; t < std::ssize(model.textures); ++t)
    for (const SlotPicture& one : material_pictures(model, t, path)) held[one.slot].insert(one.picture);
  std::vector<std::string> left_out;
  for (const MaterialSlot& slot : model.slots) {
    std::set<std::string> named;
    for (const MaterialSlot::Use& use : slot.pictures) named.insert(use.picture);
    if (slot.name != model.slot && held[slot.name].size() < named.size()) left_out.push_back(slot.name);
  }
  return left_out;
}

void set_companions(std::vector<MaterialSlot>& slots, std::size_t textures,
                    const std::vector<MaterialCompanions>& materials) {
  for (MaterialSlot& slot : slots) {
    slot.with_texture.assign(textures, MaterialSlot::none);
    std::vector<char> is_known(textures, 0);
    for (const MaterialCompanions& material : materials) {
      const auto place = std::size_t(material.texture);
      const auto found = material.pictures.find(slot.name);
      const int picture = found == material.pictures.end() ? MaterialSlot::none : found->second;
      int& with = slot.with_texture[place];
      with = !is_known[place] || with == picture ? picture : MaterialSlot::none;
      is_known[place] = 1;
    }
  }
}

std::string slot_from_text(std::string_view text) {
  if (std::string slot = slot_of_mtl(text); !slot.empty()) return slot;
  if (std::string slot = slot_of_gltf(text); !slot.empty()) return slot;
  std::string words = with_colour(in_small_letters(text));
  std::ranges::replace(words, '_', '-');
  std::ranges::replace(words, ' ', '-');
  for (const auto& [known, slot] : synonyms)
    if (words == known) return slot;
  return words;
}

TextureMeaning meaning_of_slot(const std::string& slot) {
  if (slot == "normal" || slot == "bump" || slot.ends_with("-normal"))
    return TextureMeaning::normals;
  for (const char* colours : {base_slot, "emissive", "ambient", "specular-glossiness"})
    if (slot == colours) return TextureMeaning::colours;
  return slot.ends_with("colour") ? TextureMeaning::colours : TextureMeaning::values;
}

std::string names_of(const std::vector<MaterialSlot>& slots) {
  std::string names;
  for (const MaterialSlot& slot : slots) names += (names.empty() ? "" : ", ") + slot.name;
  return names;
}

std::string chosen_slot(const std::vector<MaterialSlot>& slots, const std::string& asked,
                        const std::string& file) {
  if (asked.empty()) {
    if (slots.size() == 1) return slots.front().name;
    return base_slot;
  }
  const std::string name = slot_from_text(asked);
  if (name == base_slot || find_slot(slots, name)) return name;
  for (const auto& [wanted, instead] : {std::pair("normal", "bump"), {"specular", "specular-colour"}})
    if (name == wanted && find_slot(slots, instead)) return instead;
  std::vector<std::string> names;
  for (const MaterialSlot& slot : slots) names.push_back(slot.name);
  throw InvalidInput(fmt::format(
      "{}: {} {}: its materials name no picture for it{}; {}", file, option_name("slot"), shown(asked),
      did_you_mean(name, names),
      slots.empty() ? std::string("they name none at all") : "they have " + names_of(slots)));
}

std::string known_slot(const std::string& asked, const std::string& file) {
  const std::string name = slot_from_text(asked);
  std::set<std::string> known(extension_slots.begin(), extension_slots.end());
  for (const auto& [keyword, slot] : mtl_keywords) known.insert(slot);
  for (const auto& [keyword, slot] : gltf_keywords) known.insert(slot);
  if (known.contains(name)) return name;
  throw InvalidInput(fmt::format("{}: {} {}: no material has such a slot{}; for colours it is {}, for normals normal",
                                 file, option_name("slot"), shown(asked),
                                 did_you_mean(name, {known.begin(), known.end()}), base_slot));
}

void add_to_slots(std::vector<MaterialSlot>& slots, const std::string& slot,
                  const std::string& picture, int uv_set) {
  auto found = std::ranges::find(slots, slot, &MaterialSlot::name);
  if (found == slots.end()) found = slots.insert(slots.end(), MaterialSlot{slot, {}});
  const MaterialSlot::Use use{picture, uv_set};
  if (std::ranges::find(found->pictures, use) == found->pictures.end())
    found->pictures.push_back(use);
}

}  // namespace mq
