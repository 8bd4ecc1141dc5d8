#include "controls.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "mq/base/error.h"
#include "mq/base/length.h"

namespace mq::view {
namespace {

void explain(const Option& option) {
  if (!ImGui::IsItemHovered()) return;
  ImGui::BeginTooltip();
  ImGui::PushTextWrapPos(420);
  ImGui::TextUnformatted(("--" + option.name + ": " + option.help).c_str());
  if (!option.details.empty()) ImGui::TextUnformatted(option.details.c_str());
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
}

std::string now(const OptionValues& values, const std::string& name) {
  const auto texts = values.effective(name);
  return texts.empty() ? "" : texts.front();
}

/// In place of a number.
constexpr const char* not_given = "not given";

bool take(OptionValues& values, const std::string& name, const std::string& text) {
  try {
    OptionValues changed = values;
    changed.set(name, {text});
    values = changed;
    return true;
  } catch (const InvalidInput&) {
    return false;
  }
}

bool edit_number(OptionValues& values, const Option& option, const std::string& text) {
  auto value = float(text.empty() ? 0 : std::atof(text.c_str()));
  const bool bounded = std::isfinite(option.least) && std::isfinite(option.most);
  bool changed = false;
  if (option.type == Option::Type::integer) {
    int whole = int(value);
    changed = bounded
                  ? ImGui::SliderInt(option.name.c_str(), &whole, int(option.least),
                                     int(std::min(option.most, 1e6)),
                                     text.empty() ? not_given : "%d", ImGuiSliderFlags_AlwaysClamp)
                  : ImGui::InputInt(option.name.c_str(), &whole);
    explain(option);
    return changed && take(values, option.name, std::to_string(whole));
  }
  const bool wide = bounded && option.most / std::max(option.least, 1e-3) > 200;
  changed = bounded ? ImGui::SliderFloat(
                          option.name.c_str(), &value, float(option.least), float(option.most),
                          text.empty() ? not_given : "%.4g",
                          ImGuiSliderFlags_AlwaysClamp | (wide ? ImGuiSliderFlags_Logarithmic : 0))
                    : ImGui::InputFloat(option.name.c_str(), &value, 0, 0, "%.4g",
                                        ImGuiInputTextFlags_EnterReturnsTrue);
  explain(option);
  return changed && take(values, option.name, fmt::format("{:.4g}", value));
}

/// A slider in the unit that the length has, and percent where it has none.
bool edit_length(OptionValues& values, const Option& option, const std::string& text) {
  const Length length = text.empty() ? Length{1, Length::Unit::percent} : parse_length(text);
  const bool percent = length.unit == Length::Unit::percent,
             model = length.unit == Length::Unit::model;
  auto value = float(length.value);
  const float least = percent ? 0.01F
                      : model ? value / 20
                              : 0.25F,
              most = percent ? 50.F
                     : model ? value * 20
                             : 400.F;
  const bool changed = ImGui::SliderFloat(option.name.c_str(), &value, least, most,
                                          text.empty() ? not_given
                                          : percent    ? "%.3g %%"
                                          : model      ? "%.3g"
                                                       : "%.3g tx",
                                          ImGuiSliderFlags_Logarithmic);
  explain(option);
  return changed && take(values, option.name,
                         fmt::format("{:.3g}{}", value,
                                     percent ? "%"
                                     : model ? ""
                                             : "tx"));
}

bool edit_choice(OptionValues& values, const Option& option) {
  const std::string text = now(values, option.name);
  bool changed = false;
  if (ImGui::BeginCombo(option.name.c_str(), text.c_str())) {
    for (const std::string& choice : option.choices)
      if (ImGui::Selectable(choice.c_str(), choice == text))
        changed = take(values, option.name, choice);
    ImGui::EndCombo();
  }
  explain(option);
  return changed;
}

/// "a.png; b.png" of an option that may be given several times.
std::string joined(const std::vector<std::string>& texts) {
  std::string all;
  for (const std::string& text : texts) all += (all.empty() ? "" : "; ") + text;
  return all;
}

bool take_many(OptionValues& values, const std::string& name, const std::string& text) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == ';')
      parts.emplace_back();
    else if (c != ' ' || !parts.back().empty())
      parts.back() += c;
  }
  std::erase(parts, "");
  try {
    OptionValues changed = values;
    changed.set(name, parts);
    values = changed;
    return true;
  } catch (const InvalidInput&) {
    return false;
  }
}

/// With a list beside it where there are words that are not names of files.
bool edit_text(OptionValues& values, const Option& option) {
  char text[4096] = "";
  std::strncpy(text, joined(values.effective(option.name)).c_str(), sizeof(text) - 1);
  bool changed = false;
  const bool listed = !option.choices.empty();
  if (listed && ImGui::BeginCombo(("##" + option.name).c_str(), "", ImGuiComboFlags_NoPreview)) {
    for (const std::string& choice : option.choices)
      if (ImGui::Selectable(choice.c_str(), choice == text))
        changed = take(values, option.name, choice);
    ImGui::EndCombo();
  }
  if (listed) {
    ImGui::SameLine(0, 0);
    ImGui::SetNextItemWidth(ImGui::CalcItemWidth() - ImGui::GetFrameHeight());
  }
  const bool typed = ImGui::InputText(option.name.c_str(), text, sizeof(text),
                                      ImGuiInputTextFlags_EnterReturnsTrue);
  explain(option);
  if (option.count == Option::Count::many)
    return changed || (typed && take_many(values, option.name, text));
  return changed || (typed && take(values, option.name, text));
}

}  // namespace

bool edit(OptionValues& values, const std::string& name, const std::string& in_force) {
  const Option& option = values.table().find(name);
  const std::string own = now(values, name), text = own.empty() ? in_force : own;
  switch (option.type) {
    case Option::Type::flag: {
      bool on = values.flag(name);
      const bool changed = ImGui::Checkbox(name.c_str(), &on);
      explain(option);
      return changed && take(values, name, on ? "true" : "false");
    }
    case Option::Type::integer:
    case Option::Type::number: return edit_number(values, option, text);
    case Option::Type::length: return edit_length(values, option, text);
    case Option::Type::choice: return edit_choice(values, option);
    case Option::Type::text:
    case Option::Type::path: return edit_text(values, option);
  }
  return false;
}

}  // namespace mq::view
