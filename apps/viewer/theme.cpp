#include "theme.h"

#include <fmt/format.h>

#include <imgui.h>

#include <cmath>

#include "mq/draw/font_file.h"

namespace mq::view {
namespace {

/// Pixels of a line's letters on a common screen.
constexpr double letters = 15;

/// Latin, Greek and Cyrillic letters, punctuation, arrows and signs.
constexpr ImWchar glyphs[] = {0x20,   0x24F,  0x370,  0x52F,  0x2000, 0x206F, 0x20A0,
                              0x20BF, 0x2190, 0x21FF, 0x2200, 0x22FF, 0x25A0, 0x25FF, 0};

}  // namespace

std::string set_sizes(double scale) {
  ImGuiIO& io = ImGui::GetIO();
  const std::string file = font_file().string();
  ImFontConfig config;
  if (file.empty()) {
    config.SizePixels = float(std::round(13 * scale));
    io.Fonts->AddFontDefault(&config);
    config.SizePixels = float(std::round(26 * scale));
    io.Fonts->AddFontDefault(&config);
  } else {
    config.OversampleH = 2;
    io.Fonts->AddFontFromFileTTF(file.c_str(), float(std::round(letters * scale)), &config, glyphs);
    io.Fonts->AddFontFromFileTTF(file.c_str(), float(std::round(28 * scale)), &config);
  }
  ImGuiStyle& style = ImGui::GetStyle();
  style.FrameRounding = 3;
  style.GrabRounding = 3;
  style.PopupRounding = 4;
  style.WindowPadding = {10, 8};
  style.FramePadding = {6, 3};
  style.ItemSpacing = {6, 6};
  style.ItemInnerSpacing = {6, 4};
  style.ScrollbarSize = 12;
  style.ScaleAllSizes(float(scale));
  return file;
}

void set_theme(Theme theme) {
  ImVec4* const colours = ImGui::GetStyle().Colors;
  if (theme == Theme::dark)
    ImGui::StyleColorsDark();
  else
    ImGui::StyleColorsLight();
  const bool dark = theme == Theme::dark;
  const ImVec4 accent = dark ? ImVec4(0.24F, 0.47F, 0.72F, 1) : ImVec4(0.38F, 0.62F, 0.88F, 1);
  const auto faint = [&](float alpha) { return ImVec4(accent.x, accent.y, accent.z, alpha); };
  colours[ImGuiCol_WindowBg] = dark ? ImVec4(0.13F, 0.13F, 0.14F, 1) : ImVec4(0.95F, 0.95F, 0.94F, 1);
  colours[ImGuiCol_PopupBg] = dark ? ImVec4(0.17F, 0.17F, 0.18F, 1) : ImVec4(1, 1, 1, 1);
  colours[ImGuiCol_FrameBg] = dark ? ImVec4(0.22F, 0.22F, 0.24F, 1) : ImVec4(0.85F, 0.85F, 0.84F, 1);
  colours[ImGuiCol_FrameBgHovered] = faint(0.45F);
  colours[ImGuiCol_FrameBgActive] = faint(0.6F);
  colours[ImGuiCol_Button] = dark ? ImVec4(0.27F, 0.27F, 0.3F, 1) : ImVec4(0.82F, 0.82F, 0.81F, 1);
  colours[ImGuiCol_ButtonHovered] = faint(0.75F);
  colours[ImGuiCol_ButtonActive] = accent;
  colours[ImGuiCol_SliderGrab] = accent;
  colours[ImGuiCol_SliderGrabActive] = accent;
  colours[ImGuiCol_CheckMark] = dark ? ImVec4(0.45F, 0.7F, 0.96F, 1) : ImVec4(0.1F, 0.35F, 0.65F, 1);
  colours[ImGuiCol_Header] = faint(0.35F);
  colours[ImGuiCol_HeaderHovered] = faint(0.55F);
  colours[ImGuiCol_HeaderActive] = faint(0.7F);
  colours[ImGuiCol_PlotHistogram] = accent;
  colours[ImGuiCol_ModalWindowDimBg] = ImVec4(0, 0, 0, 0.45F);
  colours[ImGuiCol_TitleBgActive] = colours[ImGuiCol_TitleBg] =
      dark ? ImVec4(0.2F, 0.24F, 0.3F, 1) : ImVec4(0.8F, 0.86F, 0.93F, 1);
  colours[ImGuiCol_TextDisabled] = dark ? ImVec4(0.62F, 0.62F, 0.64F, 1) : ImVec4(0.38F, 0.38F, 0.4F, 1);
}

void title(const char* text) {
  ImGui::PushFont(ImGui::GetIO().Fonts->Fonts.back());  // of `set_sizes`, the last one
  ImGui::TextUnformatted(text);
  ImGui::PopFont();
}

void heading(const char* text) {
  ImGui::Spacing();
  ImGui::TextUnformatted(text);
  ImGui::Separator();
}

void progress_bar(double fraction, const std::string& step) {
  const float room = ImGui::GetContentRegionAvail().x - 2 * ImGui::GetStyle().FramePadding.x;
  const std::string between = " / ";
  const std::string share = fmt::format("{:.0f} %  ", std::floor(100 * fraction));
  std::string shown = share + step;
  for (std::size_t at = 0; ImGui::CalcTextSize(shown.c_str()).x > room;) {
    at = step.find(between, at);
    if (at == std::string::npos) break;
    at += between.size();
    shown = share + "... / " + step.substr(at);
  }
  ImGui::ProgressBar(float(fraction), {-1, 0}, shown.c_str());
}

void remark(const std::string& text) {
  ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
  ImGui::PushTextWrapPos(0);
  ImGui::TextUnformatted(text.c_str());
  ImGui::PopTextWrapPos();
  ImGui::PopStyleColor();
}

}  // namespace mq::view
