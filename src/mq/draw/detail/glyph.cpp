// Glyphs are drawn by FreeType, unhinted sideways so that letters keep their distances, and kept.
#include "mq/draw/detail/glyph.h"

#include <ft2build.h>
#include FT_FREETYPE_H

#include <map>
#include <memory>
#include <mutex>
#include <utility>

#include "mq/draw/detail/dot_font.h"
#include "mq/draw/font_file.h"

namespace mq {
namespace {

/// Of the height of capitals, in DejaVu Sans 0.73 of this: the size of letters.
constexpr int size_of_scale = 9;

class Font {
 public:
  Font() {
    const std::string file = font_file().string();
    if (file.empty() || FT_Init_FreeType(&library_) != 0) return;
    if (FT_New_Face(library_, file.c_str(), 0, &face_) != 0) face_ = nullptr;
  }

  ~Font() {
    if (face_) FT_Done_Face(face_);
    if (library_) FT_Done_FreeType(library_);
  }

  Font(const Font&) = delete;
  Font& operator=(const Font&) = delete;

  const Glyph& glyph(char32_t character, int scale) {
    const std::lock_guard lock(mutex_);
    const auto [place, is_new] = known_.try_emplace({character, scale});
    if (is_new) place->second = drawn(character, scale);
    return place->second;
  }

 private:
  Glyph drawn(char32_t character, int scale) {
    const FT_UInt index = face_ ? FT_Get_Char_Index(face_, character) : 0;
    if (index == 0 || FT_Set_Pixel_Sizes(face_, 0, FT_UInt(size_of_scale * scale)) != 0 ||
        FT_Load_Glyph(face_, index, FT_LOAD_RENDER | FT_LOAD_TARGET_LIGHT) != 0 ||
        face_->glyph->bitmap.pixel_mode != FT_PIXEL_MODE_GRAY)
      return dot_glyph(character, scale);
    const FT_GlyphSlot slot = face_->glyph;
    Glyph glyph{.left = slot->bitmap_left,
                .top = slot->bitmap_top,
                .width = int(slot->bitmap.width),
                .height = int(slot->bitmap.rows),
                .advance = int(slot->advance.x + 32) / 64};
    for (int y = 0; y < glyph.height; ++y) {
      const unsigned char* row = slot->bitmap.buffer + std::ptrdiff_t(y) * slot->bitmap.pitch;
      glyph.coverage.insert(glyph.coverage.end(), row, row + glyph.width);
    }
    return glyph;
  }

  FT_Library library_ = nullptr;
  FT_Face face_ = nullptr;
  std::mutex mutex_;
  std::map<std::pair<char32_t, int>, Glyph> known_;
};

}  // namespace

const Glyph& glyph(char32_t character, int scale) {
  static Font font;
  return font.glyph(character, scale);
}

}  // namespace mq
