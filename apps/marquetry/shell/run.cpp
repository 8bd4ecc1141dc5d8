#include "shell/frame_numbers.h"
#include "shell/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <set>

#include "mq/base/error.h"
#include "mq/base/memory.h"
#include "mq/base/words.h"
#include "mq/io/atomic_file.h"
#include "mq/io/bytes.h"
#include "mq/io/held_files.h"
#include "mq/io/json_read.h"
#include "mq/io/path_status.h"
#include "mq/io/video.h"
#include "mq/version.h"
#include "shell/output_ledger.h"
#include "shell/scratch.h"
#include "shell/standard_streams.h"

namespace mq::app {
Step::Step(Run& run, const std::string& name, double share)
    : run_(run), name_(name), progress_(run.progress().step(name, share)) {}

Step::~Step() {
  const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start_;
  run_.add_seconds(name_, time.count());
}

Run::Run(OptionValues options, Terminal& terminal, Progress progress)
    : options_(std::move(options)), terminal_(terminal), progress_(std::move(progress)) {}

void print_text(const std::string& text) { std::fwrite(text.data(), 1, text.size(), stdout); }

void Run::print(const std::string& text) {
  if (!options_.flag("json")) print_text(terminal_.renamed(text));
}

/// Links and other spellings of a name are the same file.
void Run::protect(const std::filesystem::path& read, const std::filesystem::path& output,
                  const std::string& option) const {
  std::error_code ignored;
  if (options_.flag("overwrite") || !std::filesystem::equivalent(output, read, ignored)) return;
  throw IoError(fmt::format(
      "{}: {} would replace {}, which is read: choose another name, or allow it with --overwrite",
      output.string(), option, output == read ? "it" : read.string()));
}

void Run::will_read(const std::filesystem::path& path) {
  if (options_.given("report")) protect(path, options_.text("report"), "--report");
  inputs_.push_back(path);
}

Run::MadeFolders::~MadeFolders() {
  for (const std::filesystem::path& folder : folders_) make_no_more(folder);
}

void Run::MadeFolders::make(const std::filesystem::path& folder) {
  make_on_demand(folder);
  folders_.push_back(folder);
}

namespace {

/// Whether a model of this name is there, in whatever format.
bool has_model_of_name(const std::filesystem::path& path) {
  std::error_code failure;
  for (const auto& beside : std::filesystem::directory_iterator(full_name(path).parent_path(), failure))
    if (beside.path().stem() == path.stem() && names_model(beside.path())) return true;
  return false;
}

/// Throws where a new model would come with pictures or materials whose names nobody gave, and that are there: another
/// model may show them. Of several models, as of frames, each by itself: a file comes with that of its name, else with
/// the last one before it.
void protect_unnamed(const std::vector<std::filesystem::path>& paths) {
  namespace fs = std::filesystem;
  if (paths.empty() || !names_model(paths[0])) return;
  std::map<fs::path, fs::path> of_name;
  for (const fs::path& path : paths)
    if (names_model(path)) of_name.emplace(path.parent_path() / path.stem(), path);
  std::error_code failure;
  fs::path before;
  for (const fs::path& path : paths) {
    if (names_model(path)) before = path;
    if (names_model(path) || !fs::exists(path, failure)) continue;
    const auto found = of_name.find(path.parent_path() / path.stem());
    if (const fs::path& model = found != of_name.end() ? found->second : before; !has_model_of_name(model))
      throw IoError(fmt::format("{0}: exists already, and the new {1} would replace it: choose another name than {1}, "
                                "or replace it with --overwrite",
                                path.string(), model.string()));
  }
}

}  // namespace

void Run::will_write(const std::vector<std::filesystem::path>& paths,
                     std::set<std::filesystem::path> folders, const std::string& option) {
  namespace fs = std::filesystem;
  std::error_code failure;
  for (const auto& path : paths) {
    for (const auto& read : inputs_) protect(read, path, option);
    require(!options_.given("report") || full_name(path) != full_name(options_.text("report")),
            path.string() + ": " + option + " and --report name the same file; choose another for one");
  }
  std::set<fs::path> names;
  for (const auto& path : paths)
    require(names.insert(full_name(path)).second,
            path.string() + ": two outputs have this name; choose another for one");
  if (paths.size() > 1 && std::ranges::any_of(paths, names_standard_output))
    throw IoError(fmt::format("{}: {} files would be written, and standard output takes one: name a folder, or a "
                              "file for the first of them{}",
                              option, paths.size(),
                              names_model(paths[0]) || names_animation(paths[0]) ? "; glb:- holds all in one" : ""));
  for (const auto& path : paths)
    if (options_.flag("no-clobber") && fs::exists(path, failure))
      throw IoError(
          fmt::format("{}: exists already, and --no-clobber protects it: choose another "
                      "name, or remove it first",
                      path.string()));
  if (!options_.flag("overwrite")) protect_unnamed(paths);
  using Replacing = OutputLedger::Replacing;
  if (OutputLedger* ledger = OutputLedger::current())
    ledger->enter(paths, options_.flag("overwrite") ? Replacing::allowed : Replacing::refused);
  for (const auto& path : paths) folders.insert(path.parent_path());
  std::erase_if(folders, [&](const fs::path& folder) {
    return folder.empty() || names_held(folder) || fs::exists(folder, failure);
  });
  if (!dry_run())
    for (const fs::path& folder : folders) made_.make(folder);
  for (const auto& path : paths) {
    if (names_video(path)) require_video_program(path);
    if (dry_run()) terminal_.remark("would write " + path.string());
    if ((dry_run() && !folders.empty()) || names_held(path)) continue;
    const AtomicFile probe(path);  // makes and removes a temporary file, and its folder
  }
}

namespace {

/// What of a word on the command line could be a file's name.
bool names_file(const std::string& word) {
  const std::string extension = std::filesystem::path(word).extension().string();
  std::error_code ignored;
  return (extension.size() > 1 && std::isalpha(static_cast<unsigned char>(extension[1]))) ||
         word.find('/') != std::string::npos || std::filesystem::exists(word, ignored);
}

}  // namespace

Json file_of(const std::string& message, const std::vector<std::string>& words) {
  std::error_code ignored;
  for (const char* end : {": ", ", ", " is "})
    if (const std::string beginning = message.substr(0, message.find(end));
        std::filesystem::exists(beginning, ignored))
      return beginning;
  std::string best;
  for (const std::string& word : words) {
    const std::string name = word.starts_with("--") ? word.substr(word.find('=') + 1) : word;
    if (name.size() > best.size() && message.find(name) != std::string::npos && names_file(name))
      best = name;
  }
  return best.empty() ? Json() : Json(best);
}

void Run::found(const Defects& found_defects) {
  for (Json& one : defects_json(found_defects, texture_names())) defects.push_back(std::move(one));
}

std::vector<std::string> Run::texture_names() const {
  std::vector<std::string> names;
  if (!input.contains("textures")) return names;
  for (const Json& texture : input["textures"]) {
    const std::string name = texture["name"];
    names.push_back(name.empty() ? fmt::format("texture {}", names.size()) : name);
  }
  return names;
}

void Run::warn(const Defects& found_defects) {
  constexpr std::ptrdiff_t most = 3;  // lines that are read
  const auto serious = [](const Defect& defect) { return defect.severity == Defect::Severity::warning; };
  const std::ptrdiff_t count = std::ranges::count_if(found_defects, serious), told = count > most ? most - 1 : count;
  std::ptrdiff_t said = 0;
  for (const Defect& defect : found_defects)
    if (serious(defect) && said++ < told) terminal_.warning(short_sentence(defect));
  if (count > told)
    terminal_.warning(fmt::format("{} other kinds of defects; the work goes on in spite of them", count - told));
  if (count == 0 || !input.contains("files")) return;
  if (const std::string file = input["files"].front(); !names_held(file)) terminal_.point_to_check(file);
}

void Run::add_seconds(const std::string& step, double seconds) {
  for (auto& [name, sum] : seconds_)
    if (name == step) {
      sum += seconds;
      return;
    }
  seconds_.emplace_back(step, seconds);
}

Json Run::report() const {
  Json seconds = Json::object();
  for (const auto& [name, sum] : seconds_) seconds[name] = sum;
  seconds["total"] =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  Json all = {{"verb", options_.table().verb()},
              {"version", version},
              {"options", options_json(options_)},
              {"input", input},
              {"defects", defects},
              {"result", result},
              {"solve", solve},
              {"seconds", seconds},
              {"peak_bytes", peak_memory()}};
  if (!kept_equation.is_null()) all["kept"] = kept_equation;
  return all;
}

void add_running_options(OptionTable& table) {
  using Type = Option::Type;
  constexpr auto run = Option::Scope::run;
  const std::string group = "Running";
  table.add({.name = "json",
             .group = group,
             .help = "print the report, one JSON object, instead of text",
             .scope = run});
  table.add({.name = "report",
             .type = Type::path,
             .group = group,
             .help = "write the same object to a file",
             .scope = run});
  table.add({.name = "config",
             .type = Type::path,
             .group = group,
             .help = "take options that are not given from a report or a JSON object",
             .scope = run});
  table.add({.name = "threads",
             .type = Type::integer,
             .default_value = "0",
             .least = 0,
             .most = 4096,
             .group = group,
             .help = "how many threads work, 0: one per core",
             .details = "The result is the same to the last bit for any number.",
             .scope = run});
  add_scratch_options(table);
  table.add({.name = "seed",
             .type = Type::integer,
             .default_value = "0",
             .least = 0,
             .most = 4294967295,
             .group = group,
             .help = "of random numbers, which sample and react draw"});
  table.add({.name = "quiet",
             .letter = 'q',
             .group = group,
             .help = "no progress, remarks or warnings on standard error",
             .scope = run});
  table.add({.name = "progress",
             .type = Type::choice,
             .default_value = "text",
             .choices = {"text", "json"},
             .group = group,
             .help = "how what is said on standard error is written",
             .details = "json: a line for each thing, for programs that start this one: event (progress, remark, "
                        "warning or error), then fraction, step, elapsed and left, or text.",
             .scope = run});
  table.add({.name = "dry-run",
             .letter = 'n',
             .group = group,
             .help = "check options, inputs and outputs, write nothing",
             .scope = run});
  table.add({.name = "no-clobber",
             .group = group,
             .help = "refuse to replace a file that exists",
             .scope = run});
  table.add({.name = "overwrite",
             .group = group,
             .help = "let an output replace a file that is read",
             .scope = run});
  table.exclusive({"no-clobber", "overwrite"});
  table.add({.name = "help",
             .letter = 'h',
             .group = group,
             .help = "show this (-h: only the verb's own options)",
             .scope = run});
}

namespace {
constexpr const char* sequences = "Sequences";
}

bool is_frames_option(const Option& option) {
  return option.name == "frames" && option.group == sequences;
}

void add_frames_option(OptionTable& table) {
  Option frames = frames_option();
  frames.group = sequences;
  frames.help = "run once per frame number, such as 1-100 or 1-100x2";
  frames.details = "%04d in a file name stands for the number.";
  table.add(frames);
  Option shard = shard_option();
  shard.group = sequences;
  shard.help = "run only part I of N of the frames, on one of N machines";
  shard.details = "'merge' puts the reports of all parts together and says what is missing.";
  shard.scope = Option::Scope::run;
  table.add(shard);
}

Json number_json(double value) {
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  return value;
}

namespace {

Json typed(const Option& option, const OptionValues& options, const std::string& text) {
  switch (option.type) {
    case Option::Type::flag: return text == "true";
    case Option::Type::integer: return options.integer(option.name);
    case Option::Type::number: return number_json(options.number(option.name));
    default: return text;
  }
}

/// Given on the command line: the option itself or one that excludes it.
bool overridden(const OptionValues& given, const std::string& name) {
  for (const auto& group : given.table().exclusives())
    if (std::ranges::count(group, name))
      for (const std::string& other : group)
        if (given.given(other)) return true;
  return given.given(name);
}

void apply_option(const std::string& name, const Json& value, OptionValues& options) {
  std::vector<std::string> texts;
  if (value.is_array())
    for (const Json& one : value) texts.push_back(typed_text(one));
  else
    texts.push_back(typed_text(value));
  options.set(name, texts);
}

}  // namespace

std::string typed_text(const Json& value) {
  require(value.is_string() || value.is_number() || value.is_boolean(),
          "found " + value.dump() + ", wanted a text, a number or true or false");
  return value.is_string() ? value.get<std::string>() : value.dump();
}

void take_options(const Json& config, OptionValues& options, const JsonPlaces& place) {
  const std::string& own = options.table().verb();
  const Json verb = config.value("verb", Json(own));
  if (verb != Json(own))
    throw InvalidInput(fmt::format("{}: it was written by 'marquetry {}', not by 'marquetry {}'",
                                   place({"verb"}),
                                   verb.is_string() ? verb.get<std::string>() : verb.dump(), own));
  const OptionValues given = options;
  const bool nested = config.contains("options");
  const Json& rows = nested ? config.at("options") : config;
  if (!rows.is_object())
    throw InvalidInput(place({"options"}) + ": found no object, wanted one of options");
  for (const auto& [name, value] : rows.items()) {
    if (name == "verb" && !nested) continue;
    try {
      if (options.table().find(name).name != name || overridden(given, name)) continue;
      apply_option(name, value, options);
    } catch (const InvalidInput& error) {
      throw InvalidInput(
          place(nested ? std::vector<JsonStep>{"options", name} : std::vector<JsonStep>{name}) +
          ": " + error.what());
    }
  }
}

Json options_json(const OptionValues& options) {
  Json json = Json::object();
  for (const Option& option : options.table().options()) {
    const std::vector<std::string> texts = options.effective(option.name);
    if (option.scope == Option::Scope::run || texts.empty()) continue;
    if (option.count == Option::Count::many)
      json[option.name] = texts;
    else
      json[option.name] = typed(option, options, texts.front());
  }
  return json;
}

void read_config(const std::filesystem::path& path, OptionValues& options) {
  const std::string file = path.string(), wanted = "what --report wrote, or an object of options";
  const Bytes bytes = read_file(path);
  const std::string_view text = text_of(bytes);
  const Json config = parse_json<Json>(file, text, wanted);
  if (!config.is_object())
    throw IoError(
        fmt::format("{}: found no JSON object (wanted {})", json_place(file, text, {}), wanted));
  take_options(config, options, [&](const std::vector<JsonStep>& steps) { return json_place(file, text, steps); });
}

void write_report(const OptionValues& options, const Json& report) {
  if (options.given("report")) write_file(options.text("report"), bytes_of(json_text(report)));
}

Json places_json(std::span<const Defect::Place> places, std::span<const std::string> textures) {
  Json json = Json::array();
  for (const Defect::Place& place : places) {
    const bool known = std::size_t(place.texture) < textures.size();
    json.push_back({{"texture", place.texture},
                    {"name", known ? Json(textures[std::size_t(place.texture)]) : Json()},
                    {"column", place.column},
                    {"row", place.row},
                    {"texels", place.texels}});
  }
  return json;
}

Json defects_json(const Defects& defects, std::span<const std::string> textures) {
  static constexpr const char* severities[] = {"note", "warning", "refused"};
  Json json = Json::array();
  for (const Defect& defect : defects) {
    json.push_back({{"kind", defect.kind},
                    {"severity", severities[int(defect.severity)]},
                    {"element", defect.element},
                    {"count", defect.count},
                    {"ids", defect.ids},
                    {"message", defect.message}});
    if (defect.places.empty()) continue;
    json.back()["place_count"] = defect.place_count;
    json.back()["places"] = places_json(defect.places, textures);
  }
  return json;
}

std::string json_text(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace mq::app
