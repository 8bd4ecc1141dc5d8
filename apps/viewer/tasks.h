#pragma once
/// What a person does with a model, and the tools for it.

#include <array>
#include <string>
#include <vector>

namespace mq::view {

enum class Task { look, compare, paint, photographs, measure, play, picture, change };

struct TaskWords {
  const char* name;   ///< in scripts
  const char* label;  ///< on its button
  const char* help;   ///< in a sentence
};

inline constexpr std::array<TaskWords, 8> task_words = {{
    {"look", "look", "Turn it, choose what is shown."},
    {"compare", "compare", "Before and after; another texture."},
    {"paint", "paint", "Bring out detail, or smooth it."},
    {"photographs", "photographs", "Which photograph is seen where."},
    {"measure", "measure", "Distances along the surface."},
    {"play", "play", "Watch a model that moves."},
    {"picture", "picture", "Make a picture of what is shown."},
    {"change", "change all", "Work on the whole texture."},
}};

/// Something that the task `change` offers.
struct ChangeWords {
  const char* tool;   ///< and verb
  const char* label;  ///< of its button
  const char* run;    ///< of the button that begins it
};

inline constexpr std::array<ChangeWords, 7> change_words = {{
    {"detail", "smooth, sharpen", "smooth or sharpen it now"},
    {"denoise", "take noise off", "take noise off now"},
    {"seams", "close seams", "close seams now"},
    {"shock", "crisp edges", "sharpen edges now"},
    {"lic", "draw lines", "draw lines now"},
    {"react", "grow a pattern", "grow it now"},
    {"interpolate", "between two", "make it now"},
}};

/// What the button that begins a tool's work says.
std::string run_words(const std::string& tool);

/// What the person has in hand with it.
std::string tool_words(const std::string& tool);

/// The task that a tool is for.
Task task_of(const std::string& tool);

/// The options of a tool that matter first; the others are under "more".
const std::vector<std::string>& first_options(const std::string& tool);

/// What a person calls an option of a tool; empty: by its name. Its name is in what is shown under the mouse.
std::string option_words(const std::string& tool, const std::string& option);

}  // namespace mq::view
