#pragma once
/// The font that pictures and windows are lettered in.

#include <filesystem>

namespace mq {

/// DejaVu Sans, or another that packages put in their usual places; empty: there is none.
std::filesystem::path font_file();

}  // namespace mq
