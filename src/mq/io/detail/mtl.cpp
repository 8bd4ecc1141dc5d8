// newmtl NAME
// KEYWORD [-s u [v [w]]] [-o u [v [w]]] [-clamp on|off] [other options] PICTURE
//
// Names may hold blanks, so a name is all that is left of its line once the options are read.
#include "mq/io/detail/mtl.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <optional>

#include "mq/io/slots.h"

namespace mq {
namespace {

bool same_word(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](unsigned char x, unsigned char y) {
    return std::tolower(x) == std::tolower(y);
  });
}

struct OptionSize {
  std::string_view name;
  int least, most;  ///< of words that follow it
};

constexpr std::array<OptionSize, 13> option_sizes{{{"-s", 1, 3},
                                                   {"-o", 1, 3},
                                                   {"-t", 1, 3},
                                                   {"-mm", 1, 2},
                                                   {"-clamp", 1, 1},
                                                   {"-blendu", 1, 1},
                                                   {"-blendv", 1, 1},
                                                   {"-cc", 1, 1},
                                                   {"-texres", 1, 1},
                                                   {"-bm", 1, 1},
                                                   {"-imfchan", 1, 1},
                                                   {"-boost", 1, 1},
                                                   {"-type", 1, 1}}};

/// The words that follow an option: words up to `least`, then numbers up to `most`.
std::vector<std::string_view> option_words(Scanner& scanner, const OptionSize& size) {
  std::vector<std::string_view> words;
  for (int i = 0; i < size.most; ++i) {
    Scanner ahead = scanner;
    const std::string_view word = ahead.word();
    double number = 0;
    if (word.empty() || (i >= size.least && !to_number(word, number))) break;
    words.push_back(word);
    scanner = ahead;
  }
  return words;
}

void set_vector(Vector2& vector, const std::vector<std::string_view>& words) {
  for (std::size_t i = 0; i < std::min<std::size_t>(2, words.size()); ++i) {
    double number = 0;
    if (to_number(words[i], number) && std::isfinite(number)) vector[int(i)] = number;
  }
}

/// Reads what follows the keyword of `slot` into `material`.
void read_map(std::string_view text, Scanner& scanner, std::string slot, MtlMaterial& material) {
  MaterialMap map;
  map.slot = std::move(slot);
  for (;;) {
    Scanner ahead = scanner;
    const std::string_view word = ahead.word();
    const auto option = std::find_if(option_sizes.begin(), option_sizes.end(),
                                     [&](const OptionSize& o) { return same_word(o.name, word); });
    if (option == option_sizes.end()) break;
    scanner = ahead;
    const auto words = option_words(scanner, *option);
    if (option->name == "-s") set_vector(map.scale, words);
    if (option->name == "-o") set_vector(map.offset, words);
    if (option->name == "-clamp" && !words.empty())
      map.wrap = same_word(words[0], "on") ? Wrap::clamp : Wrap::repeat;
  }
  const std::string_view name = scanner.rest();
  if (name.empty()) return;
  map.picture = name;
  const std::size_t begin = std::size_t(name.data() - text.data());
  map.place = {-1, begin, begin + name.size(), ""};
  std::erase_if(material.maps, [&](const MaterialMap& other) { return other.slot == map.slot; });
  material.maps.push_back(std::move(map));
}

/// The numbers that follow a keyword; nothing unless there are as many, all finite. One stands for
/// three.
std::optional<std::vector<float>> numbers_of(Scanner& scanner, std::size_t count) {
  std::vector<float> numbers;
  double number = 0;
  while (numbers.size() < count) {
    Scanner ahead = scanner;
    if (!to_number(ahead.word(), number) || !std::isfinite(number)) break;
    numbers.push_back(float(number));
    scanner = ahead;
  }
  if (numbers.size() == 1) numbers.resize(count, numbers[0]);
  if (numbers.size() != count) return {};
  return numbers;
}

void set_opacity(float opacity, Material& look) {
  look.base_colour[3] = std::clamp(opacity, 0.0F, 1.0F);
  look.alpha = look.base_colour[3] < 1 ? Material::Alpha::blend : Material::Alpha::opaque;
}

/// Whether a line names a picture of a kind that no slot is for.
bool names_other_picture(std::string_view key) {
  return same_word(key.substr(0, 4), "map_") || same_word(key, "refl") || same_word(key, "decal");
}

/// Reads a line without a picture.
void read_look(std::string_view key, Scanner& scanner, Material& look) {
  Scanner line = scanner;
  if (same_word(key, "Kd") || same_word(key, "Ke")) {
    const auto colour = numbers_of(scanner, 3);
    if (!colour) return;
    std::copy(colour->begin(), colour->end(),
              same_word(key, "Kd") ? look.base_colour.begin() : look.emissive.begin());
  } else if (same_word(key, "d")) {
    if (const auto number = numbers_of(scanner, 1)) set_opacity((*number)[0], look);
  } else if (same_word(key, "Tr")) {
    // Programs write 0 as well as 1 for what is opaque.
    const auto number = numbers_of(scanner, 1);
    if (number && (*number)[0] > 0 && (*number)[0] < 1) set_opacity(1 - (*number)[0], look);
  } else if (same_word(key, "Pm") || same_word(key, "Pr")) {
    if (const auto number = numbers_of(scanner, 1))
      (same_word(key, "Pm") ? look.metallic : look.roughness) = (*number)[0];
  } else if (!key.empty() && key[0] != '#' && !names_other_picture(key)) {
    look.more_mtl += std::string(key) + ' ' + std::string(line.rest()) + '\n';
  }
}

/// Pictures stand for the colours.
void finish_look(MtlMaterial& material) {
  Material& look = material.look;
  look.name = material.name;
  for (const MaterialMap& map : material.maps) look.slots.push_back(map.slot);
  if (material.map(base_slot)) look.base_colour = {1, 1, 1, look.base_colour[3]};
  if (material.map("emissive")) look.emissive = {1, 1, 1};
}

std::string mtl_colour(const char* key, const float* colour) {
  std::string line = key;
  for (int c = 0; c < 3; ++c) {
    line += ' ';
    append_number(line, colour[c]);
  }
  return line + '\n';
}

std::string mtl_number(const char* key, float value) {
  std::string line = std::string(key) + ' ';
  append_number(line, value);
  return line + '\n';
}

}  // namespace

const MaterialMap* MtlMaterial::map(const std::string& slot) const {
  const auto found = std::ranges::find(maps, slot, &MaterialMap::slot);
  return found == maps.end() ? nullptr : &*found;
}

std::vector<MtlMaterial> parse_mtl(ByteView bytes) {
  const std::string_view text = text_of(bytes);
  std::vector<MtlMaterial> materials;
  for (Scanner scanner(text); !scanner.at_end(); scanner.next_line()) {
    std::string_view key = scanner.word();
    if (key.starts_with("\xef\xbb\xbf")) key.remove_prefix(3);
    if (same_word(key, "newmtl")) {
      MtlMaterial material;
      material.name = scanner.rest();
      const std::size_t end = scanner.offset();
      material.end = {-1, end, end, "\nmap_Kd "};
      materials.push_back(std::move(material));
    } else if (std::string slot = slot_of_mtl(key); !slot.empty() && !materials.empty()) {
      read_map(text, scanner, std::move(slot), materials.back());
    } else if (!materials.empty()) {
      read_look(key, scanner, materials.back().look);
    }
  }
  for (MtlMaterial& material : materials) finish_look(material);
  return materials;
}

std::string new_mtl(const std::vector<MtlMaterial>& materials) {
  std::string text;
  for (const MtlMaterial& m : materials) {
    const Material& look = m.look;
    text += "newmtl " + m.name + '\n';
    if (look.more_mtl.empty()) text += "Ka 1 1 1\nKs 0 0 0\n";
    text += mtl_colour("Kd", look.base_colour.data());
    const bool shines = m.map("emissive") || !look.names_picture("emissive");
    if (shines && look.emissive != Material().emissive) text += mtl_colour("Ke", look.emissive.data());
    if (look.base_colour[3] != 1) text += mtl_number("d", look.base_colour[3]);
    if (look.metallic) text += mtl_number("Pm", *look.metallic);
    if (look.roughness) text += mtl_number("Pr", *look.roughness);
    text += look.more_mtl;
    for (const MaterialMap& map : m.maps)
      text += std::string(mtl_keyword(map.slot)) + ' ' + map.picture + '\n';
  }
  return text;
}

}  // namespace mq
