#pragma once
/// Sliders, boxes and lists for the rows of an option table: the same words, defaults and ranges as
/// on the command line. And what panels of several tools have besides.

#include <functional>
#include <string>
#include <vector>

#include "mq/base/length.h"
#include "mq/base/options.h"
#include "session.h"

namespace mq::view {

/// Shows one option and takes over what a person does to it; true where that changed it. Throws
/// `InvalidInput` for what cannot be, which is not taken. `in_force` is the value that holds where
/// the option has none; empty: it says so. `words` are what a person calls it; empty: its name.
bool edit(OptionValues& values, const std::string& name, const std::string& in_force = {},
          const std::string& words = {});

/// A number as a person writes it, three digits of it and no powers of ten: "0.00123", "12.5", "1000".
std::string plain(double value);

/// A slider that shows its value in these words, "12.5 %", in place of a number.
struct SliderRange {
  double least, most;
  bool logarithmic = false;
};
bool slider(const char* label, double& value, const SliderRange& range, const std::string& words);

/// Several names in one line, "a.png; b.png".
std::string joined(const std::vector<std::string>& names);
std::vector<std::string> parted(const std::string& names);

/// Does it; what it throws is said at the bottom of the window.
void tried(Session& session, const std::function<void()>& what);

/// How large a brush is, from 0.1 to 50 % of √area, which is about the size of the model; `radius` and
/// `area` are what it is on the surface.
void edit_brush(Length& size, double radius, double area);

/// A name that can be changed, and a button to save there, "save mask": true once that is pressed, twice where a
/// file of that name is there that was not saved in this session.
bool ask_to_save(Session& session, const std::string& what, std::string& name);

/// Two buttons that take the tool's last stroke back and do it again, dim where there is none.
void undo_buttons(Session& session, class Tool& tool);

/// A button that copies what `command` returns.
void copy_button(Session& session, const std::function<std::string()>& command);

/// What `copy-command FILE` of a script does, and `copy-command` alone, which says it.
void copy_command(Session& session, const std::vector<std::string>& words,
                  const std::string& command);

}  // namespace mq::view
