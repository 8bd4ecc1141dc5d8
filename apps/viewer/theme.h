#pragma once
/// How panels look: colours, sizes and the font, for any resolution of a screen.

#include <string>
#include <vector>

namespace mq::view {

enum class Theme { dark, light };

inline const std::vector<std::string> theme_names = {"dark", "light"};

/// The font and all sizes for so many pixels in place of one of a common screen; once, before the
/// first picture. The font is DejaVu Sans or another that packages put in their usual places, and
/// where there is none the one that ImGui brings. Returns its file; empty: it is that one.
std::string set_sizes(double scale);

/// At any time between two pictures.
void set_theme(Theme theme);

/// In larger letters.
void title(const char* text);

/// Shown at the head of a part of a panel.
void heading(const char* text);

/// How far something is, with its step, of which the last parts are shown where not all have room: "... / solve".
void progress_bar(double fraction, const std::string& step);

/// Words that explain, in a quieter colour, in as many lines as they want.
void remark(const std::string& text);

}  // namespace mq::view
