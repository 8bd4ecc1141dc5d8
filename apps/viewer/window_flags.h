#pragma once
/// What the parts of the window have in common, as windows of ImGui.

#include <imgui.h>

namespace mq::view {

/// Without a title, in a place of its own, which a person cannot move, fold or resize.
inline constexpr ImGuiWindowFlags fixed_window =
    ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
    ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoBringToFrontOnFocus;

}  // namespace mq::view
