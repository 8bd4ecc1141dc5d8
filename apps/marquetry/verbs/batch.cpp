// marquetry batch JOBS: runs of other verbs, one after another, with one start.
#include <fmt/format.h>

#include <algorithm>
#include <new>

#include "mq/base/error.h"
#include "mq/io/bytes.h"
#include "mq/io/json_read.h"
#include "shell/run.h"
#include "shell/standard_streams.h"
#include "shell/verb.h"
#include "shell/verb_run.h"

namespace mq::app {
namespace {

const char* const wanted_jobs = "a list of jobs, each a list of words or an object such as a report";

struct Job {
  Verb verb;
  OptionValues options;
};

/// Those that can be run so: a window waits for somebody, and a batch within a batch may have no end.
Verb verb_of_job(const std::string& name) {
  Verb verb = find_verb(all_verbs(), name);
  require(name != "batch" && name != "view", fmt::format("'{}' cannot be run by 'batch'", name));
  return verb;
}

/// ["filter", "scan.obj", "-o", "out.obj"]: the words of a command line.
Job job_of_words(const Json& words) {
  std::vector<std::string> texts;
  for (const Json& word : words) texts.push_back(typed_text(word));
  require(!texts.empty(), "found an empty list, wanted a verb and its words");
  Job job{verb_of_job(texts.front()), OptionValues(OptionTable("", ""))};
  job.options = parse_arguments(job.verb.table, {texts.begin() + 1, texts.end()});
  if (job.options.given("config")) read_config(job.options.text("config"), job.options);
  return job;
}

/// {"verb": "filter", "options": {"mesh": "scan.obj", ...}}, or the options beside the verb.
Job job_of_object(const Json& object, const JsonPlaces& place) {
  require(object.contains("verb") && object.at("verb").is_string(),
          "found no \"verb\", wanted the name of one");
  Job job{verb_of_job(object.at("verb").get<std::string>()), OptionValues(OptionTable("", ""))};
  job.options = OptionValues(job.verb.table);
  take_options(object, job.options, place);
  return job;
}

/// What the batch says for itself.
void check_running_options(const OptionValues& options) {
  for (const char* name : {"json", "help"})
    require(!options.flag(name), fmt::format("--{}: a job has none of its own; give it to 'batch'", name));
  require(!options.given("progress"), "--progress: a job has none of its own; give it to 'batch'");
}

/// Options of how it is run that the whole batch was given hold for each job that has no own.
void inherit(const OptionValues& batch, OptionValues& job) {
  for (const char* name : {"threads", "seed"})
    if (batch.given(name) && !job.given(name)) job.set(name, {batch.text(name)});
  for (const char* name : {"dry-run", "json"})
    if (batch.flag(name)) job.set(name, {"true"});
  if (job.flag("no-clobber") || job.flag("overwrite")) return;
  for (const char* name : {"no-clobber", "overwrite"})
    if (batch.flag(name)) job.set(name, {"true"});
}

/// All jobs of the file, their options read and checked, so that a word that is wrong in the last is told
/// before the first is run.
std::vector<Job> read_jobs(const OptionValues& batch) {
  const std::string file = batch.text("jobs");
  const Bytes bytes = read_file(file);
  const std::string_view text = text_of(bytes);
  const Json document = parse_json<Json>(file, text, wanted_jobs);
  const bool nested = document.is_object() && document.contains("jobs");
  const Json& rows = nested ? document.at("jobs") : document;
  if (!rows.is_array() || rows.empty())
    throw IoError(fmt::format("{}: found {}, wanted {}",
                              json_place(file, text, {}), rows.is_array() ? "no job" : "no list", wanted_jobs));
  std::vector<Job> jobs;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const JsonPlaces place = [&](std::vector<JsonStep> steps) {
      steps.insert(steps.begin(), i);
      if (nested) steps.insert(steps.begin(), "jobs");
      return json_place(file, text, steps);
    };
    try {
      require(rows[i].is_array() || rows[i].is_object(),
              std::string("found ") + rows[i].type_name() + ", wanted a list of words or an object");
      Job job = rows[i].is_array() ? job_of_words(rows[i]) : job_of_object(rows[i], place);
      check_running_options(job.options);
      refuse_standard_streams(job.options);
      inherit(batch, job.options);
      job.options.check();
      jobs.push_back(std::move(job));
    } catch (const Error& error) {
      const std::string message = error.what();
      const std::string named = message.starts_with(file + ", line") ? message : place({}) + ": " + message;
      throw InvalidInput(fmt::format("job {} of {}: {}", i + 1, rows.size(), named));
    }
  }
  return jobs;
}

/// The object that stands for a job in the report.
Json failed_job(const Job& job, const std::string& message) {
  return {{"verb", job.verb.table.verb()},
          {"options", options_json(job.options)},
          {"error", {{"message", message}}}};
}

/// What went wrong with it, if anything did; `Cancelled` is passed on.
std::string run_job(Run& run, const Job& job, const Progress& progress, VerbOutcome& outcome) {
  try {
    name_options_of(job.verb);
    outcome = run_as_asked(job.verb, job.options, run.terminal(), progress);
    if (!job.options.flag("dry-run")) write_report(job.options, outcome.report);
    return "";
  } catch (const Cancelled&) {
    throw;
  } catch (const Error& error) {
    return error.what();
  } catch (const std::bad_alloc&) {
    return "not enough memory: use smaller textures, or a machine with more";
  }
}

Exit batch(Run& run) {
  const OptionValues& options = run.options();
  run.will_read(options.text("jobs"));
  const std::vector<Job> jobs = read_jobs(options);
  const auto first = options.integer("first");
  require(first <= std::int64_t(jobs.size()),
          fmt::format("--first: found {}, and there are {} jobs", first, jobs.size()));
  const std::size_t begin = std::size_t(first - 1);
  Exit exit = Exit::done;
  Json reports = Json::array();
  std::size_t failed = 0;
  for (std::size_t i = begin; i < jobs.size(); ++i) {
    const Job& job = jobs[i];
    const std::string name = fmt::format("job {} of {}", i + 1, jobs.size());
    const std::string verb = job.verb.table.verb();
    run.print(fmt::format("{}: {}\n", name, verb));
    VerbOutcome outcome;
    const std::string message = run_job(
        run, job, run.progress().step(fmt::format("{} ({})", name, verb), 1.0 / double(jobs.size() - begin)), outcome);
    if (message.empty()) {
      exit = std::max(exit, outcome.exit);
      reports.push_back(std::move(outcome.report));
      continue;
    }
    const std::string said = fmt::format("{} ({}): {}", name, verb, message);
    if (!options.flag("keep-going"))
      throw Error(fmt::format("{} (--first {} goes on from here, --keep-going leaves out what fails)", said, i + 1));
    run.terminal().error(said);
    reports.push_back(failed_job(job, message));
    exit = Exit::error;
    ++failed;
  }
  run.result = {{"jobs", std::move(reports)}, {"failed", failed}};
  run.print(fmt::format("{} of {} jobs done\n", jobs.size() - begin - failed, jobs.size() - begin));
  return exit;
}

}  // namespace

Verb batch_verb() {
  using Type = Option::Type;
  OptionTable table("batch", "Run many verbs with one start, as a file of jobs says.");
  table.add({.name = "jobs",
             .place = Option::Place::positional,
             .type = Type::path,
             .required = true,
             .help = "a JSON file: a list of jobs, or an object with \"jobs\"",
             .details = "A job is the list of a command line's words, [\"filter\", \"scan.obj\", \"-o\", "
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
  return {table, batch};
}

}  // namespace mq::app
