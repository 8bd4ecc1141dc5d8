// newmtl NAME
// KEYWORD [-s u [v [w]]] [-o u [v [w]]] [-clamp on|off] [other options] PICTURE
//
// Names may hold blanks, so a name is all that is left of its line once the options are read.
#include "mq/io/detail/mtl.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

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
void read_map(std::string_view text, Scanner& scanner, std::string slot, Material& material) {
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

}  // namespace

const MaterialMap* Material::map(const std::string& slot) const {
  const auto found = std::ranges::find(maps, slot, &MaterialMap::slot);
  return found == maps.end() ? nullptr : &*found;
}

std::vector<Material> parse_mtl(ByteView bytes) {
  const std::string_view text = text_of(bytes);
  std::vector<Material> materials;
  for (Scanner scanner(text); !scanner.at_end(); scanner.next_line()) {
    std::string_view key = scanner.word();
    if (key.starts_with("\xef\xbb\xbf")) key.remove_prefix(3);
    if (same_word(key, "newmtl")) {
      Material material;
      material.name = scanner.rest();
      const std::size_t end = scanner.offset();
      material.end = {-1, end, end, "\nmap_Kd "};
      materials.push_back(std::move(material));
    } else if (std::string slot = slot_of_mtl(key); !slot.empty() && !materials.empty()) {
      read_map(text, scanner, std::move(slot), materials.back());
    }
  }
  return materials;
}

std::string new_mtl(const std::vector<Material>& materials) {
  std::string text;
  for (const Material& m : materials) {
    text += "newmtl " + m.name + "\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\n";
    for (const MaterialMap& map : m.maps)
      text += std::string(mtl_keyword(map.slot)) + ' ' + map.picture + '\n';
  }
  return text;
}

}  // namespace mq
