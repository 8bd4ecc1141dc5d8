// An option is shared by what help says of it: two verbs that have the same words, range and
// default for a name have the same option, wherever it was put into their tables.
#include "shell/shared_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "mq/base/error.h"
#include "shell/run.h"

namespace mq::app {
namespace {

/// All that help says of an option: its usage line and its entry.
std::string entry_of(const Option& option) {
  OptionTable table("", "");
  table.add(option);
  return help_text(table, HelpDetail::complete);
}

/// Inputs and outputs have no group: what they are is the verb's own affair.
bool may_be_shared(const Option& option) {
  return option.place == Option::Place::named && !option.group.empty();
}

std::vector<OptionTable> tables_of(const std::vector<Verb>& verbs) {
  std::vector<OptionTable> tables;
  for (const Verb& verb : verbs) {
    tables.push_back(verb.table);
    add_running_options(tables.back());
  }
  return tables;
}

/// Per name the wording that most verbs have, if enough of them do.
std::map<std::string, std::string> shared_entries(const std::vector<OptionTable>& tables) {
  std::map<std::string, std::map<std::string, int>> counts;
  for (const OptionTable& table : tables)
    for (const Option& option : table.options())
      if (may_be_shared(option)) ++counts[option.name][entry_of(option)];
  std::map<std::string, std::string> shared;
  for (const auto& [name, entries] : counts) {
    const auto most =
        std::ranges::max_element(entries, {}, [](const auto& entry) { return entry.second; });
    if (most->second >= least_sharing_verbs) shared[name] = most->first;
  }
  return shared;
}

bool is_shared(const std::map<std::string, std::string>& shared, const Option& option) {
  const auto found = shared.find(option.name);
  return found != shared.end() && may_be_shared(option) && found->second == entry_of(option);
}

}  // namespace

std::string own_help(const std::vector<Verb>& verbs, const std::string& name) {
  const std::vector<OptionTable> tables = tables_of(verbs);
  const auto table =
      std::ranges::find_if(tables, [&](const OptionTable& one) { return one.verb() == name; });
  if (table == tables.end())
    throw InvalidInput(fmt::format("there is no verb '{}' ('marquetry --help' lists them)", name));
  const auto shared = shared_entries(tables);
  OptionTable own(table->verb(), table->summary());
  std::vector<std::string> others;
  for (const Option& option : table->options())
    if (is_shared(shared, option))
      others.push_back(display_name(option));
    else
      own.add(option);
  return help_text(own, HelpDetail::complete) + "\n" +
         wrap_text(fmt::format("Shared with other verbs ('marquetry help options'): {}",
                               fmt::join(others, ", ")),
                   80, 2) +
         "\n";
}

std::string shared_help(const std::vector<Verb>& verbs) {
  const std::vector<OptionTable> tables = tables_of(verbs);
  const auto shared = shared_entries(tables);
  OptionTable all("VERB",
                  "Options that several verbs share; 'marquetry help VERB' has the others.");
  std::vector<std::string> added;
  for (const OptionTable& table : tables)
    for (const Option& option : table.options())
      if (is_shared(shared, option) && std::ranges::count(added, option.name) == 0) {
        added.push_back(option.name);
        all.add(option);
      }
  return help_text(all, HelpDetail::complete);
}

}  // namespace mq::app
