// The verbs of the program: their option tables, from which the package's functions are made, and a run of one.
#include <pybind11/stl.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <thread>

#include "arrays.h"
#include "calls.h"
#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "mq/base/option_words.h"
#include "parts.h"
#include "shell/run.h"
#include "shell/standard_streams.h"
#include "shell/verb.h"
#include "shell/verb_run.h"

namespace mq::python {
namespace {

using app::Verb;

/// With the options that every verb has.
const std::vector<Verb>& verbs() {
  static const std::vector<Verb> all = [] {
    std::vector<Verb> made = app::all_verbs();
    for (Verb& verb : made) app::add_running_options(verb.table);
    return made;
  }();
  return all;
}

/// The verb that is at work, as messages name options by what it calls them.
std::atomic<const Verb*> at_work{nullptr};

std::string keyword_of(std::string_view field) {
  const Verb* verb = at_work;
  if (verb == nullptr) return std::string(field);
  const auto renamed = verb->fields.find(field);
  std::string name = renamed == verb->fields.end() ? std::string(field) : renamed->second;
  for (char& c : name) c = c == '-' ? '_' : c;
  return name;
}

const Verb& find_verb(const std::string& name) {
  for (const Verb& verb : verbs())
    if (verb.table.verb() == name) return verb;
  throw InvalidInput("there is no verb '" + name + "'");
}

const char* type_name(Option::Type type) {
  static constexpr const char* names[] = {"flag", "integer", "number", "length", "choice", "text", "path"};
  return names[int(type)];
}

py::object bound(double value) { return std::isfinite(value) ? py::object(py::float_(value)) : py::none(); }

py::dict row_of(const Option& option) {
  py::dict row;
  row["name"] = option.name;
  row["positional"] = option.place == Option::Place::positional;
  row["type"] = type_name(option.type);
  row["many"] = option.count == Option::Count::many;
  row["default"] = option.default_value;
  row["required"] = option.required;
  row["unit"] = option.unit;
  row["least"] = bound(option.least);
  row["most"] = bound(option.most);
  row["infinite"] = option.infinite;
  row["choices"] = option.choices;
  row["value"] = value_name(option);
  row["facts"] = facts(option);
  row["group"] = option.group;
  row["help"] = option.help;
  row["details"] = option.details;
  return row;
}

py::list tables() {
  py::list all;
  for (const Verb& verb : verbs()) {
    py::dict table;
    table["name"] = verb.table.verb();
    table["summary"] = verb.table.summary();
    py::list rows;
    for (const Option& option : verb.table.options()) rows.append(row_of(option));
    table["options"] = rows;
    table["exclusives"] = verb.table.exclusives();
    all.append(table);
  }
  return all;
}

/// What a verb says goes into the mailbox.
class MailTerminal final : public app::Terminal {
 public:
  MailTerminal(const std::string& verb, Mailbox& mail) : Terminal(verb), mail_(mail) {
    set_voice(Voice::quiet);
  }
  void remark(const std::string& text) override { mail_.remark(text); }
  void warning(const std::string& text) override { mail_.warning(text); }

 private:
  Mailbox& mail_;
};

OptionValues values_of(const Verb& verb, const std::map<std::string, std::vector<std::string>>& given) {
  OptionValues values(verb.table);
  for (const auto& [name, texts] : given) values.set(name, texts);
  app::refuse_standard_streams(values);  // before one is opened
  values.set("json", {"true"});  // nothing is printed
  if (values.given("config")) app::read_config(values.text("config"), values);
  app::refuse_standard_streams(values);
  values.check();
  return values;
}

/// One verb at a time: they name their options for the whole process.
std::mutex& one_at_a_time() {
  static std::mutex mutex;
  return mutex;
}

py::tuple run_verb(const std::string& name, const std::map<std::string, std::vector<std::string>>& given,
                   const py::object& progress, const py::object& remark, const py::object& warning) {
  const Verb& verb = find_verb(name);
  app::VerbOutcome outcome;
  std::string safe;
  try {
    call({progress, remark, warning}, [&](const Progress& inner, Mailbox& mail) {
      std::unique_lock lock(one_at_a_time(), std::defer_lock);
      while (!lock.try_lock()) {
        inner.check();
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
      }
      at_work = &verb;
      MailTerminal terminal(name, mail);
      const std::shared_ptr<void> after(nullptr, [&](void*) {
        at_work = nullptr;
        safe = terminal.what_is_safe();
      });
      const OptionValues options = values_of(verb, given);
      outcome = app::run_as_asked(verb, options, terminal, inner);
      if (!options.flag("dry-run")) app::write_report(options, outcome.report);
    });
  } catch (const py::error_already_set& error) {
    if (safe.empty() || !error.matches(PyExc_KeyboardInterrupt)) throw;
    PyErr_SetObject(PyExc_KeyboardInterrupt, shown_text(safe).ptr());
    throw py::error_already_set();
  }
  return py::make_tuple(int(outcome.exit), shown_text(app::json_text(outcome.report)));
}

/// Checks names, values and what contradicts what, and runs nothing.
void check_options(const std::string& name, const std::map<std::string, std::vector<std::string>>& given) {
  values_of(find_verb(name), given);
}

}  // namespace

void add_verbs(py::module_& module) {
  set_option_names(keyword_of);
  module.def("tables", &tables);
  module.def("check_options", &check_options);
  module.def("run_verb", &run_verb);
}

}  // namespace mq::python
