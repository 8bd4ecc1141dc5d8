#include "controls.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "mq/base/error.h"
#include "mq/io/atomic_file.h"
#include "theme.h"
#include "tool.h"

namespace mq::view {
namespace {

/// Not while it is dragged, which what is below can be looked at for.
void explain(const Option& option) {
  if (!ImGui::IsItemHovered() || ImGui::IsItemActive()) return;
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

/// None, or an empty one, is the default.
bool take(OptionValues& values, const std::string& name, const std::vector<std::string>& texts) {
  if (texts.empty() || texts == std::vector<std::string>{""})
    values.reset(name);
  else
    values.set(name, texts);
  return true;
}

/// "smooth-potential" as "smooth potential".
std::string label_of(const Option& option, std::string words) {
  if (words.empty()) {
    words = option.name;
    std::ranges::replace(words, '-', ' ');
  }
  return words + "###" + option.name;
}

/// Where an option allows much more than anybody wants, the slider has a hundredth to a hundred times what is usual.
SliderRange range_of(const Option& option, double value, const std::string& usual) {
  constexpr double factor = 100;
  const bool wide = option.most > 1 && option.most / std::max(option.least, 1e-3) > 200;
  const double middle = std::atof(usual.empty() ? option.default_value.c_str() : usual.c_str());
  if (!wide || !(middle > 0)) return {option.least, option.most, wide};
  return {std::max(option.least, std::min(middle / factor, value)),
          std::min(option.most, std::max(middle * factor, value)), true};
}

bool edit_number(OptionValues& values, const Option& option, const std::string& text, const std::string& label,
                 const std::string& usual) {
  double value = text.empty() ? 0 : std::atof(text.c_str());
  const bool bounded = std::isfinite(option.least) && std::isfinite(option.most);
  bool changed = false;
  if (option.type == Option::Type::integer) {
    int whole = int(value);
    changed = bounded
                  ? ImGui::SliderInt(label.c_str(), &whole, int(option.least),
                                     int(std::min(option.most, 1e6)),
                                     text.empty() ? not_given : "%d", ImGuiSliderFlags_AlwaysClamp)
                  : ImGui::InputInt(label.c_str(), &whole);
    explain(option);
    return changed && take(values, option.name, {std::to_string(whole)});
  }
  if (bounded) {
    const std::string unit = option.unit.empty() ? "" : " " + option.unit;
    changed = slider(label.c_str(), value, range_of(option, value, usual),
                     text.empty() ? not_given : plain(value) + unit);
  } else {
    auto typed = float(value);
    changed = ImGui::InputFloat(label.c_str(), &typed, 0, 0, "%.4g",
                                ImGuiInputTextFlags_EnterReturnsTrue);
    value = double(typed);
  }
  explain(option);
  return changed && take(values, option.name, {fmt::format("{:.4g}", value)});
}

/// A slider in the unit that the length has, and percent where it has none.
bool edit_length(OptionValues& values, const Option& option, const std::string& text, const std::string& label) {
  const Length length = text.empty() ? Length{1, Length::Unit::percent} : parse_length(text);
  const bool percent = length.unit == Length::Unit::percent,
             model = length.unit == Length::Unit::model;
  double value = length.value;
  const double least = percent ? 0.01
                       : model ? value / 20
                               : 0.25,
               most = percent ? std::max(50.0, value)
                      : model ? value * 20
                              : std::max(400.0, value);
  const bool changed = slider(label.c_str(), value, {least, most, true},
                              text.empty() ? not_given
                                           : plain(value) + (percent ? " %"
                                                             : model ? ""
                                                                     : " texels"));
  explain(option);
  return changed && take(values, option.name,
                         {fmt::format("{:.3g}{}", value,
                                      percent ? "%"
                                      : model ? ""
                                              : "tx")});
}

bool edit_choice(OptionValues& values, const Option& option, const std::string& label) {
  const std::string text = now(values, option.name);
  bool changed = false;
  if (ImGui::BeginCombo(label.c_str(), text.empty() ? not_given : text.c_str())) {
    if (option.default_value.empty() && ImGui::Selectable(not_given, text.empty()))
      values.reset(option.name), changed = true;
    for (const std::string& choice : option.choices)
      if (ImGui::Selectable(choice.c_str(), choice == text))
        changed = take(values, option.name, {choice});
    ImGui::EndCombo();
  }
  explain(option);
  return changed;
}

/// With a list beside it where there are words that are not names of files.
bool edit_text(OptionValues& values, const Option& option, const std::string& label) {
  std::string text = joined(values.effective(option.name));
  bool changed = false;
  const bool listed = !option.choices.empty();
  if (listed && ImGui::BeginCombo(("##" + option.name).c_str(), "", ImGuiComboFlags_NoPreview)) {
    for (const std::string& choice : option.choices)
      if (ImGui::Selectable(choice.c_str(), choice == text))
        changed = take(values, option.name, {choice});
    ImGui::EndCombo();
  }
  if (listed) {
    ImGui::SameLine(0, 0);
    ImGui::SetNextItemWidth(ImGui::CalcItemWidth() - ImGui::GetFrameHeight());
  }
  const bool typed =
      ImGui::InputTextWithHint(label.c_str(),
                               option.type == Option::Type::path ? "a file" : "", &text,
                               ImGuiInputTextFlags_EnterReturnsTrue);
  explain(option);
  const bool many = option.count == Option::Count::many;
  return changed || (typed && take(values, option.name, many ? parted(text) : std::vector{text}));
}

/// Takes back that it was given, where nothing is the default.
bool give_up(OptionValues& values, const Option& option) {
  if (!option.default_value.empty() || !values.given(option.name)) return false;
  ImGui::SameLine();
  if (!ImGui::SmallButton(("x##" + option.name).c_str())) return false;
  values.reset(option.name);
  return true;
}

}  // namespace

bool edit(OptionValues& values, const std::string& name, const std::string& in_force, const std::string& words) {
  const Option& option = values.table().find(name);
  const std::string own = now(values, name), text = own.empty() ? in_force : own, label = label_of(option, words);
  switch (option.type) {
    case Option::Type::flag: {
      bool on = values.flag(name);
      const bool changed = ImGui::Checkbox(label.c_str(), &on);
      explain(option);
      return changed && take(values, name, {on ? "true" : "false"});
    }
    case Option::Type::integer:
    case Option::Type::number: return edit_number(values, option, text, label, in_force) || give_up(values, option);
    case Option::Type::length: return edit_length(values, option, text, label) || give_up(values, option);
    case Option::Type::choice: return edit_choice(values, option, label);
    case Option::Type::text:
    case Option::Type::path: return edit_text(values, option, label) || give_up(values, option);
  }
  return false;
}

std::string plain(double value) {
  const double size = std::abs(value);
  if (size == 0) return "0";
  if (size < 1e-8 || size >= 1e9) return fmt::format("{:.3g}", value);
  const int decimals = std::max(0, 2 - int(std::floor(std::log10(size))));
  std::string digits = fmt::format("{:.{}f}", value, decimals);
  if (decimals > 0) {
    digits.erase(digits.find_last_not_of('0') + 1);
    if (digits.ends_with('.')) digits.pop_back();
  }
  return digits;
}

bool slider(const char* label, double& value, const SliderRange& range, const std::string& words) {
  std::string format;
  for (const char c : words) format += c == '%' ? "%%" : std::string(1, c);
  auto moved = float(value);
  if (!ImGui::SliderFloat(label, &moved, float(range.least), float(range.most), format.c_str(),
                          ImGuiSliderFlags_AlwaysClamp |
                              (range.logarithmic ? ImGuiSliderFlags_Logarithmic : 0)))
    return false;
  value = double(moved);
  return true;
}

std::string joined(const std::vector<std::string>& names) {
  return fmt::format("{}", fmt::join(names, "; "));
}

std::vector<std::string> parted(const std::string& names) {
  std::vector<std::string> parts(1);
  for (const char c : names) {
    if (c == ';')
      parts.emplace_back();
    else if (c != ' ' || !parts.back().empty())
      parts.back() += c;
  }
  std::erase(parts, "");
  return parts;
}

void tried(Session& session, const std::function<void()>& what) {
  session.refusal.clear();
  try {
    what();
  } catch (const Error& error) {
    session.refuse(error.what());
  }
}

void edit_brush(Length& size, double radius, double area) {
  double percent = radius / std::sqrt(area) * 100;
  if (slider("brush size", percent, {0.1, 50, true}, plain(percent) + " % of the model"))
    size = {percent, Length::Unit::percent};
}

bool ask_to_save(Session& session, const std::string& what, std::string& name) {
  std::string shown = session.name_of(name);
  const auto say_where = [&] {
    if (ImGui::IsItemHovered() && !name.empty())
      ImGui::SetTooltip("%s", std::filesystem::absolute(name).lexically_normal().c_str());
  };
  if (ImGui::InputText(("##" + what).c_str(), &shown)) name = session.placed(shown);
  say_where();
  ImGui::SameLine();
  std::error_code ignored;
  const bool taken = !session.saved_names.contains(name) && std::filesystem::is_regular_file(name, ignored);
  const bool asks = taken && session.replaced_name == name;
  const bool pressed = ImGui::Button((asks ? "replace it" : "save " + what).c_str());
  say_where();
  if (asks) remark(shown + " is there already, and not from here.");
  if (!pressed) return false;
  session.replaced_name = taken && !asks ? name : "";
  if (taken && !asks) return false;
  session.saved_names.insert(name);
  return true;
}

void undo_buttons(Session& session, Tool& tool) {
  const Tool::History history = tool.history();
  const auto button = [&](const char* words, const char* keys, bool there, const std::function<void()>& act) {
    ImGui::BeginDisabled(!there);
    if (ImGui::Button(words)) tried(session, act);
    ImGui::EndDisabled();
    if (ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled)) ImGui::SetTooltip("%s", keys);
  };
  button("undo", "Ctrl + Z", history.done > 0, [&] { tool.undo(); });
  ImGui::SameLine();
  button("redo", "Ctrl + Y", history.done < history.strokes.size(), [&] { tool.redo(); });
}

void copy_button(Session& session, const std::function<std::string()>& command) {
  if (!ImGui::Button("copy as command")) return;
  tried(session, [&] {
    const std::string line = command();
    ImGui::SetClipboardText(line.c_str());
    session.say(line);
  });
}

void copy_command(Session& session, const std::vector<std::string>& words,
                  const std::string& command) {
  if (words.size() == 1) return session.say(command);
  const std::string line = command + "\n";
  session.run.will_write({words[1]});
  write_file(words[1], std::as_bytes(std::span(line.data(), line.size())));
}

}  // namespace mq::view
