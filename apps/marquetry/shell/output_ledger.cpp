#include "shell/output_ledger.h"

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/io/path_status.h"

namespace mq::app {
namespace {

OutputLedger* the_ledger = nullptr;

}  // namespace

OutputLedger::OutputLedger(const std::filesystem::path& list) : list_(full_name(list)) { the_ledger = this; }

OutputLedger::~OutputLedger() { the_ledger = nullptr; }

OutputLedger* OutputLedger::current() { return the_ledger; }

bool OutputLedger::has(const std::filesystem::path& path) const { return runs_.contains(full_name(path)); }

void OutputLedger::enter(const std::vector<std::filesystem::path>& paths, Replacing replacing) {
  for (const std::filesystem::path& path : paths) {
    const std::filesystem::path name = full_name(path);
    if (name == list_)
      throw IoError(fmt::format("{}: it is the list of what is run; choose another name", path.string()));
    const auto known = runs_.find(name);
    if (known != runs_.end() && known->second != run_ && replacing == Replacing::refused)
      throw IoError(
          fmt::format("{}: {} writes it too; choose another name or folder, or allow it with --overwrite",
                      path.string(), known->second));
    runs_[name] = run_;
  }
}

}  // namespace mq::app
