// marquetry batch JOBS: runs of other verbs, one after another, with one start.
#include <fmt/format.h>

#include <algorithm>
#include <new>
#include <set>

#include "mq/base/error.h"
#include "mq/io/bytes.h"
#include "mq/io/json_read.h"
#include "mq/io/path_status.h"
#include "mq/model/kept_work.h"
#include "shell/output_ledger.h"
#include "shell/run.h"
#include "shell/scratch.h"
#include "shell/standard_streams.h"
#include "shell/verb.h"
#include "shell/verb_run.h"

namespace mq::app {
namespace {

const char* const wanted_jobs = "a list of jobs, each a list of words or an object such as a report";

struct Job {
  int number = 0;
  Verb verb;
  OptionValues options;

  const std::string& name() const { return verb.table.verb(); }
};

/// Reads jobs. All verbs are made once, as a file may have thousands.
class JobReader {
 public:
  explicit JobReader(const OptionValues& batch)
      : batch_(batch), file_(batch.text("jobs")), bytes_(read_file(file_)) {}

  /// All jobs of the file, their options read and checked, so that a word that is wrong in the last is told
  /// before the first is run.
  std::vector<Job> read() const {
    const Json document = parse_json<Json>(file_, text(), wanted_jobs);
    const auto [rows, steps] = rows_of(document);
    if (!rows.is_array() || rows.empty())
      throw IoError(fmt::format("{}: found {}, wanted {}", json_place(file_, text(), steps),
                                rows.is_array() ? "no job" : "no list", wanted_jobs));
    std::vector<Job> jobs;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      std::vector<JsonStep> begin = steps;
      if (!is_report(document)) begin.emplace_back(i);
      try {
        jobs.push_back(job_of(rows[i], begin));
        jobs.back().number = int(i) + 1;
      } catch (const Error& error) {
        const std::string message = error.what();
        const bool has_place = message.starts_with(file_ + ", line");
        throw InvalidInput(
            fmt::format("job {} of {}: {}", i + 1, rows.size(),
                        has_place ? message : json_place(file_, text(), begin) + ": " + message));
      }
    }
    return jobs;
  }

 private:
  std::string_view text() const { return text_of(bytes_); }

  static bool is_report(const Json& document) {
    return document.is_object() && document.contains("verb") && document["verb"] != Json("batch");
  }

  /// The list, and the steps that lead to it: the document itself, its "jobs", those of a batch's report; of
  /// the report of another verb the one job that it is.
  std::pair<Json, std::vector<JsonStep>> rows_of(const Json& document) const {
    if (is_report(document)) return {Json::array({document}), {}};
    if (!document.is_object()) return {document, {}};
    if (document.contains("verb") && document.contains("result") && document["result"].contains("jobs"))
      return {document["result"]["jobs"], {"result", "jobs"}};
    for (const auto& [name, value] : document.items())
      if (name != "jobs")
        throw InvalidInput(
            fmt::format("{}: found '{}', wanted \"jobs\" alone; options of the batch are given to it",
                        json_place(file_, text(), {name}), name));
    return {document.value("jobs", Json()), {"jobs"}};
  }

  Job job_of(const Json& row, const std::vector<JsonStep>& begin) const {
    require(row.is_array() || row.is_object(),
            std::string("found ") + row.type_name() + ", wanted a list of words or an object");
    Job job = row.is_array() ? job_of_words(row) : job_of_object(row, begin);
    if (job.options.given("config")) read_config(job.options.text("config"), job.options);
    check_running_options(job.options);
    refuse_standard_streams(job.options);
    inherit(job.options);
    job.options.check();
    return job;
  }

  /// Those that can be run so: a window waits for somebody, and a batch within a batch may have no end.
  Job job_for(const std::string& name) const {
    Verb verb = find_verb(verbs_, name);
    require(name != "batch" && name != "view", fmt::format("'{}' cannot be run by 'batch'", name));
    OptionValues options(verb.table);
    return {0, std::move(verb), std::move(options)};
  }

  /// ["filter", "scan.obj", "-o", "out.obj"]: the words of a command line.
  Job job_of_words(const Json& words) const {
    std::vector<std::string> texts;
    for (const Json& word : words) texts.push_back(typed_text(word));
    require(!texts.empty(), "found an empty list, wanted a verb and its words");
    Job job = job_for(texts.front());
    job.options = parse_arguments(job.verb.table, {texts.begin() + 1, texts.end()});
    return job;
  }

  /// {"verb": "filter", "options": {"mesh": "scan.obj", ...}}, or the options beside the verb. A report has
  /// more than options.
  Job job_of_object(const Json& object, const std::vector<JsonStep>& begin) const {
    require(object.contains("verb") && object.at("verb").is_string(),
            "found no \"verb\", wanted the name of one");
    static const std::set<std::string> of_reports = {"verb",   "version", "options", "input",      "defects",
                                                     "result", "solve",   "seconds", "peak_bytes", "kept",   "frames",
                                                     "slots",  "job",     "error",   "shard"};
    if (object.contains("options"))
      for (const auto& [name, value] : object.items())
        require(of_reports.contains(name),
                fmt::format("found '{}' beside \"options\", wanted it among them", name));
    Job job = job_for(object.at("verb").get<std::string>());
    take_options(object, job.options, [&](const std::vector<JsonStep>& steps) {
      std::vector<JsonStep> all = begin;
      all.insert(all.end(), steps.begin(), steps.end());
      return json_place(file_, text(), all);
    });
    return job;
  }

  /// What the batch says for itself.
  static void check_running_options(const OptionValues& options) {
    for (const char* name : {"json", "help", "quiet"})
      require(!options.flag(name), fmt::format("--{}: a job has none of its own; give it to 'batch'", name));
    for (const char* name : {"progress", "memory", "scratch"})
      require(!options.given(name), fmt::format("--{}: a job has none of its own; give it to 'batch'", name));
  }

  /// Options of how it is run that the whole batch was given hold for each job that has no own.
  void inherit(OptionValues& job) const {
    for (const char* name : {"threads", "seed"})
      if (batch_.given(name) && !job.given(name)) job.set(name, {batch_.text(name)});
    for (const char* name : {"dry-run", "json"})
      if (batch_.flag(name)) job.set(name, {"true"});
    if (job.flag("no-clobber") || job.flag("overwrite")) return;
    for (const char* name : {"no-clobber", "overwrite"})
      if (batch_.flag(name)) job.set(name, {"true"});
  }

  const OptionValues& batch_;
  std::string file_;
  Bytes bytes_;
  std::vector<Verb> verbs_ = all_verbs();
};

/// The names of files among the options, of all or of those that are read.
enum class Names { all, of_inputs };
std::vector<std::string> names_in(const OptionValues& options, Names which) {
  std::vector<std::string> names;
  for (const Option& option : options.table().options())
    if (option.type == Option::Type::path && options.given(option.name) &&
        (which == Names::all || (option.name != "output" && option.name != "report")))
      for (const std::string& name : options.texts(option.name)) names.push_back(name);
  return names;
}

/// The object that stands for a job in the report.
Json failed_job(const Job& job, const std::string& message) {
  Json error = {{"message", message}};
  if (const Json file = file_of(message, names_in(job.options, Names::all)); !file.is_null())
    error["file"] = file;
  return {{"verb", job.name()}, {"options", options_json(job.options)}, {"error", error}};
}

/// One job after another.
class Batch {
 public:
  Batch(Run& run, std::vector<Job> jobs)
      : run_(run), jobs_(std::move(jobs)), ledger_(run.options().text("jobs")) {
    // Their own reports are none of what runs say they will write.
    const OptionValues& options = run_.options();
    ledger_.begin("the batch");
    if (options.given("report")) enter_report(options);
    for (const Job& job : jobs_) {
      ledger_.begin(fmt::format("job {}", job.number));
      if (job.options.given("report")) enter_report_of(job);
    }
  }

  /// Jobs from this one on. Returns the worst exit status.
  Exit go(std::size_t first) {
    const double share = 1.0 / double(jobs_.size() - first);
    for (std::size_t i = first; i < jobs_.size(); ++i) {
      say_safe(i);
      if (!go_one(jobs_[i], share) && !run_.options().flag("keep-going") && i + 1 < jobs_.size()) {
        run_.terminal().error(fmt::format(
            "stopped: --first {} goes on from here, --keep-going leaves out what fails", jobs_[i].number));
        break;
      }
    }
    report();
    return exit_;
  }

  void report() {
    run_.result = {{"jobs", reports_}, {"failed", failed_}};
    if (running_ > 0) run_.result.update({{"cancelled", true}, {"running", running_}});
    run_.print(fmt::format("{} of {} jobs done\n", int(reports_.size()) - failed_, jobs_.size()));
  }

 private:
  void enter_report(const OptionValues& options) {
    ledger_.enter({options.text("report")}, OutputLedger::Replacing::refused);
  }

  void enter_report_of(const Job& job) {
    try {
      enter_report(job.options);
    } catch (const IoError& error) {
      throw IoError(fmt::format("{}: {}", title(job), error.what()));
    }
  }

  std::string title(const Job& job) const { return fmt::format("job {} of {}", job.number, jobs_.size()); }

  void say_safe(std::size_t done) {
    if (done > 0)
      run_.terminal().safe(fmt::format("files of jobs before it are complete, and --first {} goes on from {}",
                                       jobs_[done].number, title(jobs_[done])));
  }

  /// Whether it did not fail.
  bool go_one(const Job& job, double share) {
    running_ = job.number;
    ledger_.begin(fmt::format("job {}", job.number));
    run_.terminal().set_part("");
    run_.terminal().remark(fmt::format("{}: {}", title(job), job.name()));
    run_.terminal().set_part(fmt::format("job {}", job.number));
    VerbOutcome outcome;
    const std::string message =
        waits_for_others(job)
            ? ""
            : done(job, run_.progress().step(fmt::format("{} ({})", title(job), job.name()), share), outcome);
    if (message.empty()) {
      exit_ = std::max(exit_, outcome.exit);
      add_report(job, std::move(outcome.report));
    } else {
      run_.terminal().error(message);
      add_report(job, failed_job(job, message));
      exit_ = Exit::error;
      ++failed_;
    }
    run_.terminal().say_where_more_is();
    run_.terminal().set_part("");
    running_ = 0;
    return message.empty();
  }

  /// With --dry-run, whether it would read what is not there yet.
  bool waits_for_others(const Job& job) {
    if (!job.options.flag("dry-run")) return false;
    std::error_code ignored;
    for (const std::string& name : names_in(job.options, Names::of_inputs))
      if ((ledger_.has(name) || is_awaited(name)) && !std::filesystem::exists(name, ignored)) {
        run_.terminal().remark(name +
                               " is not there yet, as an earlier job would write it: not looked at further");
        const bool has_output = std::ranges::count(job.options.table().options(), "output", &Option::name) > 0;
        if (has_output && job.options.given("output")) awaited_.insert(without_slash(job.options.text("output")));
        return true;
      }
    return false;
  }

  /// Whether a job that was not looked at further names it as its output, a folder that it lies in, or a file in it.
  bool is_awaited(const std::string& name) const {
    const std::filesystem::path path = without_slash(name);
    return std::ranges::any_of(awaited_, [&](const std::filesystem::path& output) {
      return path == output || path.parent_path() == output || path == output.parent_path();
    });
  }

  /// The full name, also of a folder with / at its end.
  static std::filesystem::path without_slash(const std::filesystem::path& path) {
    return (full_name(path) / "").parent_path();
  }

  static std::string model_of(const Job& job) {
    const bool has_one = std::ranges::count(job.options.table().options(), "mesh", &Option::name) > 0;
    return has_one && job.options.has("mesh") ? job.options.text("mesh") : std::string();
  }

  /// Whether the job before or after it works on the same model: then one keeps what the other can use.
  bool shares_model(const Job& job) const {
    const std::string model = model_of(job);
    const std::size_t i = std::size_t(&job - jobs_.data());
    const auto same = [&](std::size_t k) { return k < jobs_.size() && model_of(jobs_[k]) == model; };
    return !model.empty() && (same(i + 1) || (i > 0 && same(i - 1)));
  }

  /// What went wrong with it, if anything did; `Cancelled` is passed on.
  std::string done(const Job& job, const Progress& progress, VerbOutcome& outcome) {
    try {
      name_options_of(job.verb);
      if (!job_before_ || model_of(*job_before_) != model_of(job)) kept_.forget();
      job_before_ = &job;
      outcome = run_as_asked(job.verb, job.options, run_.terminal(), progress, shares_model(job) ? &kept_ : nullptr);
      if (!job.options.flag("dry-run")) write_report(job.options, outcome.report);
      return "";
    } catch (const Cancelled&) {
      throw;
    } catch (const Error& error) {
      return error.what();
    } catch (const std::bad_alloc&) {
      return out_of_memory();
    }
  }

  void add_report(const Job& job, Json report) {
    Json numbered = {{"job", job.number}};
    if (report.is_object()) numbered.update(report);
    reports_.push_back(std::move(numbered));
  }

  Run& run_;
  std::vector<Job> jobs_;
  KeptWork kept_;                   ///< of jobs in a row on one model
  const Job* job_before_ = nullptr;  ///< none yet
  OutputLedger ledger_;
  std::set<std::filesystem::path> awaited_;  ///< outputs of jobs that --dry-run did not look at further
  Json reports_ = Json::array();
  Exit exit_ = Exit::done;
  int failed_ = 0;
  int running_ = 0;  ///< the number of the job at hand; 0: none is
};

Exit run_batch(Run& run) {
  const OptionValues& options = run.options();
  run.will_read(options.text("jobs"));
  std::vector<Job> jobs = JobReader(options).read();
  const auto first = options.integer("first");
  require(first <= std::int64_t(jobs.size()),
          fmt::format("--first: found {}, and there are {} jobs", first, jobs.size()));
  Batch batch(run, std::move(jobs));
  try {
    return batch.go(std::size_t(first - 1));
  } catch (const Cancelled&) {
    run.terminal().set_part("");
    batch.report();
    if (!options.flag("dry-run")) write_report(options, run.report());
    throw;
  }
}

}  // namespace

Verb batch_verb() {
  using Type = Option::Type;
  OptionTable table("batch", "Run many verbs with one start, as a file of jobs says.");
  table.example("jobs.json --dry-run", "what it would do, nothing is written");
  table.example("jobs.json --keep-going --report done.json", "all jobs, and what became of each");
  table.add({.name = "jobs",
             .place = Option::Place::positional,
             .type = Type::path,
             .required = true,
             .help = "a JSON file: a list of jobs, or an object with \"jobs\"; - for standard input",
             .details =
                 "A job is the list of a command line's words, [\"filter\", \"scan.obj\", \"-o\", "
                 "\"out.obj\"], or an object with \"verb\" and \"options\", such as a report. All are read "
                 "before the first is run. Names of files are relative to the current folder."});
  table.add({.name = "keep-going",
             .letter = 'k',
             .help = "go on after a job that fails; the exit status is 2 all the same"});
  table.add({.name = "first",
             .type = Type::integer,
             .default_value = "1",
             .least = 1,
             .most = 1e9,
             .help = "the number of the job to begin with, to go on after an error"});
  return {table, run_batch};
}

}  // namespace mq::app
