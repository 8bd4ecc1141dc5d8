// It finds the verb, reads its options, shows progress, stops on Ctrl-C, writes the report and
// turns errors into words and an exit status. The work itself is in verbs/, one file each, and in
// the library.
#include "shell/program.h"

#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <optional>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "mq/base/error.h"
#include "mq/base/instruction_set.h"
#include "mq/io/atomic_file.h"
#include "mq/version.h"
#include "shell/completion.h"
#include "shell/interrupt.h"
#include "shell/manual.h"
#include "shell/run.h"
#include "shell/scratch.h"
#include "shell/shared_options.h"
#include "shell/standard_streams.h"
#include "shell/terminal.h"
#include "shell/verb_run.h"

namespace mq::app {
namespace {

std::string overview(const std::vector<Verb>& verbs) {
  const std::string& program = verbs.front().table.program();
  std::string text = "usage: " + program +
                     " VERB INPUT... -o OUTPUT [options]\n\n"
                     "Signal processing on textured triangle meshes.\n\n";
  for (const Verb& verb : verbs)
    text += fmt::format("  {:<12}{}\n", verb.table.verb(), wrap_text(verb.table.summary(), 80, 14));
  return text +
         fmt::format("\n'{0} VERB -h' is short help, '{0} VERB --help' all there is to know;\n"
                     "'{0} help VERB' leaves out what verbs share, which '{0} help options' has.\n",
                     program);
}

/// What is said to who gives no word at all.
std::string introduction() {
  return "Signal processing on textured triangle meshes.\n\n"
         "  marquetry sample bust -o bust/                        a textured model to try things on\n"
         "  marquetry inspect bust/bust.obj                       what a model is\n"
         "  marquetry filter bust/bust.obj -o clear.obj --strength 50%\n"
         "                                                        its detail brought out\n"
         "  marquetry stitch scan.obj -o stitched.obj             steps between photographs taken out\n"
         "  marquetry view clear.obj                              a window to look and to paint in\n\n"
         "'marquetry help' lists all verbs, 'marquetry VERB -h' says what one does.\n";
}

/// What the words ask to be told, if they do; looked for before anything can be wrong with them.
std::optional<HelpDetail> help_wanted(const std::vector<std::string>& words) {
  const auto end = std::ranges::find(words, "--");
  if (std::find(words.begin(), end, "--help") != end) return HelpDetail::complete;
  if (std::find(words.begin(), end, "-h") != end) return HelpDetail::brief;
  return std::nullopt;
}

/// Whether the words ask for JSON on standard error; looked for before anything can be wrong with them.
bool wants_json_lines(const std::vector<std::string>& words) {
  const auto end = std::ranges::find(words, "--");
  for (auto word = words.begin(); word != end; ++word)
    if (*word == "--progress=json" || (*word == "--progress" && word + 1 != end && *(word + 1) == "json"))
      return true;
  return false;
}

OptionValues read_options(const OptionTable& table, const std::vector<std::string>& words,
                          StandardStreams& streams) {
  OptionValues options = parse_arguments(table, words);
  streams.stand_in(options);
  if (options.given("config")) read_config(options.text("config"), options);
  streams.stand_in(options);  // for what the configuration file gave
  options.check();
  return options;
}

Exit run_verb(const Verb& verb, const std::vector<std::string>& words, Terminal& terminal) {
  if (const auto detail = help_wanted(words)) {
    print_text(help_text(verb.table, *detail));
    return Exit::done;
  }
  start_with_scratch(words);
  name_options_of(verb);
  if (wants_json_lines(words)) terminal.set_form(Terminal::Form::json);
  StandardStreams streams(terminal);
  const OptionValues options = read_options(verb.table, words, streams);
  if (options.text("progress") == "json") terminal.set_form(Terminal::Form::json);
  if (options.flag("quiet")) terminal.set_voice(Terminal::Voice::quiet);
  warn_of_little_memory(options, terminal);
  if (options.given("report")) const AtomicFile probe(options.text("report"));
  const Progress progress([&](const ProgressEvent& event) { terminal.progress(event); },
                          &Interrupt::requested());
  const VerbOutcome outcome = run_as_asked(verb, options, terminal, progress);
  if (options.flag("dry-run")) return outcome.exit;
  const Json report = streams.as_given(outcome.report);
  write_report(options, report);
  if (options.flag("json") && !streams.writes()) print_text(json_text(report));
  streams.send();
  return outcome.exit;
}

/// With the options that every verb has.
std::vector<Verb> complete(std::vector<Verb> verbs) {
  for (Verb& verb : verbs) add_running_options(verb.table);
  return verbs;
}

/// The words of a shell's completions and of manual pages, for those who package the program:
/// --completion SHELL, --manual, --manual VERB.
std::string packaging_text(const std::vector<Verb>& verbs, const std::vector<std::string>& words) {
  if (words[0] == "--completion")
    return completion_script(words.size() > 1 ? words[1] : "", complete(verbs));
  return words.size() > 1 ? manual_page(find_verb(verbs, words[1]).table) : manual_page(verbs);
}

/// MARQUETRY_INSTRUCTIONS holds the program to a form of its kernels, to compare machines.
void choose_instructions() {
  if (const char* name = std::getenv("MARQUETRY_INSTRUCTIONS"); name != nullptr && *name != '\0')
    use_instruction_set(parse_instruction_set(name));
}

/// Which verb works on which signals, as a table of docs/.
std::string signals_table(const std::vector<Verb>& verbs) {
  std::string text = "| | textures | colours at vertices | pictures |\n|---|---|---|---|\n";
  const auto cell = [](const std::string& what) { return what.empty() ? "–" : what; };
  for (const Verb& verb : verbs)
    for (const Signals& row : verb.signals)
      text += fmt::format("| {} (`{}`) | {} | {} | {} |\n", row.what,
                          row.with.empty() ? verb.table.verb() : verb.table.verb() + " " + row.with,
                          cell(row.textures), cell(row.vertices), cell(row.pictures));
  return text;
}

/// `marquetry help`, alone or with a verb, "options" or "signals" after it.
std::string help_of(const std::vector<Verb>& verbs, const std::vector<std::string>& words) {
  if (words.size() < 2) return overview(verbs);
  if (words[1] == "signals") return signals_table(verbs);
  return words[1] == "options" ? shared_help(verbs) : own_help(verbs, words[1]);
}

Exit run_words(const std::vector<Verb>& verbs, const std::vector<std::string>& words,
               Terminal& terminal) {
  if (words.empty()) {
    print_text(introduction());
    return Exit::done;
  }
  if (words[0] == "--help" || words[0] == "-h") {
    print_text(overview(verbs));
    return Exit::done;
  }
  if (words[0] == "help") {
    print_text(help_of(verbs, words));
    return Exit::done;
  }
  if (words[0] == "--version") {
    print_text(fmt::format("marquetry {}\n", version));
    return Exit::done;
  }
  if (words[0] == "--completion" || words[0] == "--manual") {
    print_text(packaging_text(verbs, words));
    return Exit::done;
  }
  choose_instructions();
  return run_verb(find_verb(verbs, words[0]), {words.begin() + 1, words.end()}, terminal);
}

/// Says what went wrong: in words, and where --json was asked for as an object as well.
void say_error(const std::string& error_message, const std::vector<std::string>& words,
               Terminal& terminal) {
  const std::string message = terminal.renamed(error_message);
  terminal.error(message);
  const auto end = std::ranges::find(words, "--");
  if (std::find(words.begin(), end, "--json") == end) return;
  Json error = {{"message", message}};
  if (const Json file = file_of(message, words); !file.is_null()) error["file"] = file;
  print_text(json_text({{"verb", words[0]}, {"version", version}, {"error", error}}));
}

/// Says what went wrong and chooses the exit status.
Exit guarded(const std::vector<Verb>& verbs, const std::vector<std::string>& words) {
  const bool named = !words.empty() && std::ranges::any_of(verbs, [&](const Verb& verb) {
    return verb.table.verb() == words[0];
  });
  Terminal terminal(named ? words[0] : "", verbs.front().table.program());
  const auto fail = [&](const std::string& message) { say_error(message, words, terminal); };
  try {
    const Interrupt interrupt(terminal);
    const Exit exit = run_words(verbs, words, terminal);
    if (std::fflush(stdout) != 0 || std::ferror(stdout))
      throw IoError("standard output cannot be written to (is the disk full?)");
    return exit;
  } catch (const Cancelled&) {
    fail("cancelled, " + what_is_left(terminal));
    return Exit::cancelled;
  } catch (const std::bad_alloc&) {
    fail(out_of_memory());
  } catch (const Error& error) {
    fail(error.what());
  } catch (const std::exception& error) {
    fail(fmt::format("internal error, please report it: {}", error.what()));
  }
  return Exit::error;
}

/// Large arrays go back to the system when they are freed: the parts of a solver are made one after
/// another, and glibc's threshold would else grow until it keeps what the first of them held. Small ones
/// are kept: to ask for new pages each time takes a twentieth of `filter`, and saves a fortieth of its memory. So are
/// 64 MiB of what they leave, of which setting the first threshold alone has glibc return all but 128 KiB each time.
void return_large_arrays() {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 1 << 22);
  mallopt(M_TRIM_THRESHOLD, 1 << 26);
#endif
}

}  // namespace

int run_program(const std::vector<Verb>& verbs, const std::vector<std::string>& words) {
  return_large_arrays();
  std::signal(SIGXFSZ, SIG_IGN);  // a file that grows too large is a write error like any other
  return int(guarded(verbs, words));
}

}  // namespace mq::app
