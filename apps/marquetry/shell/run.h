#pragma once
/// One run of one verb: its options, its progress, what it says and what it reports.

#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "mq/base/defect.h"
#include "mq/base/options.h"
#include "mq/base/progress.h"
#include "mq/io/json_read.h"
#include "mq/io/model.h"
#include "shell/terminal.h"

namespace mq {
class KeptWork;
}

namespace mq::app {

using Json = nlohmann::ordered_json;

/// A part of the work: measured for the report, a share of the progress.
///
///     { Step step(run, "read", 0.2);  model = read_model(path, {}, step); }
class Step {
 public:
  Step(class Run& run, const std::string& name, double share);
  ~Step();
  Step(const Step&) = delete;
  Step& operator=(const Step&) = delete;

  operator const Progress&() const { return progress_; }
  const Progress& progress() const { return progress_; }

 private:
  Run& run_;
  std::string name_;
  Progress progress_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

class Run {
 public:
  Run(OptionValues options, Terminal& terminal, Progress progress);

  const OptionValues& options() const { return options_; }
  Terminal& terminal() { return terminal_; }
  const Progress& progress() const { return progress_; }
  bool dry_run() const { return options_.flag("dry-run"); }

  /// A result for people, on standard output; not shown where --json is asked for.
  void print(const std::string& text);

  /// Says that this file is read, so that nothing is written over it without --overwrite. Throws
  /// `IoError` where it is the file of --report.
  void will_read(const std::filesystem::path& path);

  /// Says now that these files will be written, so that a name that cannot be written to, that is
  /// one of the inputs, or that --no-clobber protects, is refused before any work is done, and so
  /// is a video where there is no ffmpeg. The folders of the files, and `folders` (empty: none), are made with
  /// those around them where they are not there, when the first file is written to them, and stay only if one is
  /// finished. With --dry-run only lists
  /// the files. `option` is what named them. Throws `IoError`.
  void will_write(const std::vector<std::filesystem::path>& paths,
                  std::set<std::filesystem::path> folders = {}, const std::string& option = "--output");
  void will_write(const std::vector<std::filesystem::path>& paths, const std::filesystem::path& folder) {
    will_write(paths, std::set{folder});
  }

  /// Puts defects into the report.
  void found(const Defects& defects);

  /// Names of the model's textures as `input` has them, "texture 0" where one has none.
  std::vector<std::string> texture_names() const;

  /// Says on standard error which of them are worth a look, each in a line; where more is to be had
  /// `Terminal::say_where_more_is` says.
  void warn(const Defects& defects);

  /// Told what textures, or colours at vertices, there are of work on its way, and what they are;
  /// empty: nobody looks on, and a verb does nothing for it. From the thread that works; results are
  /// the same either way.
  std::function<void(const std::string& what, const Model& model)> onlooker;

  /// Given the result of a verb that changes a model, which is not written then; empty: it is.
  std::function<void(Model model)> receiver;

  /// What runs before this one prepared on the same charts; null: nobody keeps it.
  KeptWork* kept = nullptr;

  Json input = Json::object();   ///< what was read
  Json result = Json::object();  ///< what the verb found, by name
  Json solve = nullptr;          ///< how the system was solved; null: none was
  Json defects = Json::array();
  Json kept_equation = nullptr;  ///< whether what was solved was prepared by a run before; null: nobody keeps it

  void add_seconds(const std::string& step, double seconds);

  /// The report's object: verb, version, options (as used), input, defects, result, solve,
  /// seconds, peak_bytes.
  Json report() const;

 private:
  /// Folders for results, made when the first file is written to them.
  class MadeFolders {
   public:
    MadeFolders() = default;
    MadeFolders(const MadeFolders&) = delete;
    MadeFolders& operator=(const MadeFolders&) = delete;
    ~MadeFolders();
    void make(const std::filesystem::path& folder);

   private:
    std::vector<std::filesystem::path> folders_;  ///< asked for
  };

  OptionValues options_;
  Terminal& terminal_;
  Progress progress_;
  MadeFolders made_;
  void protect(const std::filesystem::path& read, const std::filesystem::path& output,
               const std::string& option) const;

  std::vector<std::filesystem::path> inputs_;
  std::vector<std::pair<std::string, double>> seconds_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Prints on standard output. That nobody takes it shows in `ferror(stdout)`, for the frame to say.
void print_text(const std::string& text);

/// The file that a message begins with, if it is there, or else the longest of `words` that it names and
/// that could be a file's name; null where there is none.
Json file_of(const std::string& message, const std::vector<std::string>& words);

/// The options every verb has, under the heading "Running".
void add_running_options(OptionTable& table);

/// Adds --frames, for a verb that can be run over a sequence of numbered files.
void add_frames_option(OptionTable& table);

/// Whether this is that one: a verb may have frames of its own.
bool is_frames_option(const Option& option);

/// The number, or "inf", for which JSON has no other word.
Json number_json(double value);

/// The values of all options of `Scope::result` that have one, as JSON of their type.
Json options_json(const OptionValues& options);

/// A JSON value as a user would have typed it. Throws `InvalidInput` where it is a list or an object.
std::string typed_text(const Json& value);

/// Where a value stands that these steps lead to, for messages.
using JsonPlaces = std::function<std::string(std::vector<JsonStep>)>;

/// Fills in from an object (a report, or one of options) what was not given. Throws `InvalidInput` naming
/// the place and the option.
void take_options(const Json& object, OptionValues& options, const JsonPlaces& place);

/// The same from a configuration file. Throws `IoError` or `InvalidInput`.
void read_config(const std::filesystem::path& path, OptionValues& options);

/// Writes the report to the file of --report, if one is given.
void write_report(const OptionValues& options, const Json& report);

/// Texels have their places too, with the name of the texture where it is known.
Json defects_json(const Defects& defects, std::span<const std::string> textures = {});
Json places_json(std::span<const Defect::Place> places, std::span<const std::string> textures);

/// JSON as it is written everywhere: indented, bytes that are not UTF-8 replaced.
std::string json_text(const Json& json);

}  // namespace mq::app
