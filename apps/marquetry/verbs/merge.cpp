// marquetry merge REPORT... [-o OUT]: the reports of all parts of a sequence as one, nothing missing.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "mq/base/error.h"
#include "mq/io/bytes.h"
#include "mq/io/frame_files.h"
#include "mq/io/json_read.h"
#include "mq/io/atomic_file.h"
#include "mq/io/path_status.h"
#include "shell/frame_numbers.h"
#include "shell/results.h"
#include "shell/run.h"
#include "shell/verb.h"

namespace mq::app {
namespace {

/// What one run with --shard reported: frame by frame, or of a part of a sequence that is worked on as a whole.
struct Part {
  std::string file;
  Shard shard;
  Json report;

  bool is_by_frame() const { return report.contains("frames"); }
};

/// Whether an object has a whole number of that name.
bool has_number(const Json& object, const char* name) {
  return object.is_object() && object.contains(name) && object[name].is_number_integer();
}

/// Of a part of a sequence that is worked on as a whole where it lies; none of others.
const Json* range_told(const Json& report) {
  if (!report.contains("result") || !report["result"].is_object() || !report["result"].contains("part")) return nullptr;
  const Json& range = report["result"]["part"];
  if (!has_number(range, "first") || !has_number(range, "end") || !has_number(range, "of") || !range.contains("shard"))
    return nullptr;
  return &range;
}

Part read_part(const std::string& file) {
  const std::string wanted = "what a run with --shard wrote for --report";
  const Bytes bytes = read_file(file);
  Part part{file, {}, parse_json<Json>(file, text_of(bytes), wanted)};
  const auto refuse = [&](const std::string& found) {
    throw InvalidInput(fmt::format("{}: found {}, wanted {}", file, found, wanted));
  };
  if (!part.report.is_object() || !part.report.contains("verb") || !part.report["verb"].is_string() ||
      !part.report.contains("options") || !part.report["options"].is_object())
    refuse("no report");
  if (part.report.contains("error")) refuse("the report of a run that failed");
  if (part.report["verb"] == "track" || part.report["verb"] == "evolve")
    refuse(fmt::format("a report of {}, whose parts become one by {} --motion part_%d.evolving",
                       part.report["verb"].get<std::string>(), part.report["verb"].get<std::string>()));
  const Json* range = range_told(part.report);
  const Json named = range != nullptr ? (*range)["shard"] : part.report.value("shard", Json());
  if (!named.is_string()) refuse("a report of no part of a sequence");
  const auto shard = parse_shard(named.get<std::string>());
  const Json& options = part.report["options"];
  if (!shard || (range == nullptr && (!part.is_by_frame() || !part.report["frames"].is_array() ||
                                      !options.contains("frames") || !options["frames"].is_string())))
    refuse("a report that says not which frames it has");
  if (range == nullptr)
    for (const Json& frame : part.report["frames"])
      if (!has_number(frame, "frame")) refuse("a frame without its number");
  part.shard = *shard;
  part.report["options"].erase("shard");
  return part;
}

/// All must say the same of what was asked for.
void check_alike(const Part& one, const Part& other) {
  const auto differ = [&](const std::string& what, const Json& a, const Json& b) {
    const auto said = [](const Json& value) { return value.is_null() ? "not given" : value.dump(); };
    throw InvalidInput(fmt::format("{}: {} is {}, but in {} it is {}; parts of one sequence are made with the same "
                                   "options: run one of them again",
                                   other.file, what, said(b), one.file, said(a)));
  };
  for (const char* name : {"verb", "version"})
    if (const Json a = one.report.value(name, Json()), b = other.report.value(name, Json()); a != b) differ(name, a, b);
  if (one.shard.count != other.shard.count) differ("the number of parts", one.shard.count, other.shard.count);
  const Json &a = one.report["options"], &b = other.report["options"];
  for (const Json& options : {a, b})
    for (const auto& [name, value] : options.items())
      if (const Json left = a.value(name, Json()), right = b.value(name, Json()); left != right)
        differ("--" + name, left, right);
}

std::string numbers(const std::vector<int>& all) {
  std::string text;
  constexpr std::size_t most = 10;
  for (std::size_t i = 0; i < all.size() && i < most; ++i) text += fmt::format("{}{}", i > 0 ? ", " : "", all[i]);
  return all.size() > most ? fmt::format("{} and {} more", text, all.size() - most) : text;
}

void refuse_missing_parts(const std::map<int, Part>& parts) {
  const int count = parts.begin()->second.shard.count;
  std::vector<int> missing;
  for (int k = 1; k <= count; ++k)
    if (!parts.contains(k)) missing.push_back(k);
  if (!missing.empty())
    throw InvalidInput(fmt::format("of {} parts {} missing: {}; run {} with --shard {}/{}", count,
                                   missing.size() == 1 ? "one is" : fmt::format("{} are", missing.size()),
                                   numbers(missing), missing.size() == 1 ? "it" : "the first", missing.front(), count));
}

/// The frames of a part are those that it should have.
void check_frames(const Part& part) {
  if (const Json* told = range_told(part.report)) {
    const FrameRange wanted = range_of(part.shard, (*told)["of"].get<int>());
    if ((*told)["first"] != wanted.first || (*told)["end"] != wanted.end)
      throw InvalidInput(fmt::format("{}: part {}/{} has frames {} to {} of {}, wanted {} to {}: run it again", part.file,
                                     part.shard.number, part.shard.count, (*told)["first"].get<int>() + 1,
                                     (*told)["end"].get<int>(), (*told)["of"].get<int>(), wanted.first + 1, wanted.end));
    return;
  }
  std::vector<int> found;
  for (const Json& frame : part.report["frames"]) found.push_back(frame["frame"].get<int>());
  const std::string range = part.report["options"]["frames"].get<std::string>();
  const std::vector<int> wanted = frames_of(part.shard, parse_frames(range));
  if (found != wanted)
    throw InvalidInput(fmt::format("{}: part {}/{} has frames {}, wanted {}: run it again", part.file,
                                   part.shard.number, part.shard.count, found.empty() ? "none" : numbers(found), numbers(wanted)));
}

/// Files that this report, of a frame or of a part, names are still there.
void check_outputs(const Part& part, const Json& report, const std::string& whose) {
  if (!report.contains("result") || !report["result"].is_object() || !report["result"].contains("outputs")) return;
  for (const Json& output : report["result"]["outputs"])
    if (output.is_string() && !is_there(output.get<std::string>()))
      throw IoError(fmt::format("{}: not there, though {} says that {} wrote it: run merge in the folder where the parts "
                                "were run, or part {}/{} again",
                                output.get<std::string>(), part.file, whose, part.shard.number, part.shard.count));
}

void check_outputs(const Part& part) {
  if (!part.is_by_frame()) return check_outputs(part, part.report, "it");
  for (const Json& frame : part.report["frames"])
    check_outputs(part, frame, fmt::format("frame {}", frame["frame"].get<int>()));
}

/// The reports of all frames, or of parts that are worked on as a whole, in order.
Json rows_of(const std::map<int, Part>& parts) {
  Json rows = Json::array();
  for (const auto& [number, part] : parts) {
    if (!part.is_by_frame()) {
      rows.push_back(part.report);
      rows.back().erase("options");
      continue;
    }
    for (const Json& frame : part.report["frames"]) rows.push_back(frame);
  }
  return rows;
}

/// How many frames the whole has.
std::size_t frame_count(const std::map<int, Part>& parts, const Json& rows) {
  const Json* told = range_told(parts.begin()->second.report);
  return told == nullptr ? rows.size() : (*told)["of"].get<std::size_t>();
}

/// What a run without --shard would have reported, its time that of all parts together; of a sequence that is worked on
/// as a whole what each part reported.
Json joined(const std::map<int, Part>& parts) {
  Json rows = rows_of(parts);
  double seconds = 0;
  std::int64_t peak = 0;
  for (const Json& row : rows) {
    if (row.contains("seconds") && row["seconds"].contains("total") && row["seconds"]["total"].is_number())
      seconds += row["seconds"]["total"].get<double>();
    if (has_number(row, "peak_bytes")) peak = std::max(peak, row["peak_bytes"].get<std::int64_t>());
  }
  const Part& first = parts.begin()->second;
  Json whole = first.is_by_frame() && !rows.empty() ? rows.back() : first.report;
  for (const char* name : {"frame", "shard"}) whole.erase(name);
  whole["options"] = first.report["options"];
  whole["seconds"] = {{"total", seconds}};
  whole["peak_bytes"] = peak;
  if (!first.is_by_frame()) whole["result"] = {{"frames", frame_count(parts, rows)}};
  whole[first.is_by_frame() ? "frames" : "parts"] = std::move(rows);
  return whole;
}

Exit merge(Run& run) {
  const OptionValues& options = run.options();
  std::map<int, Part> parts;
  for (const std::string& file : options.texts("reports")) {
    run.will_read(file);
    Part part = read_part(file);
    if (!parts.empty()) check_alike(parts.begin()->second, part);
    const auto [at, is_new] = parts.try_emplace(part.shard.number, part);
    if (!is_new)
      throw InvalidInput(fmt::format("{}: part {}/{} is in {} too; leave one of them out", file, part.shard.number,
                                     part.shard.count, at->second.file));
  }
  refuse_missing_parts(parts);
  for (const auto& [number, part] : parts) {
    run.progress().check();
    check_frames(part);
    check_outputs(part);
  }
  const Json whole = joined(parts);
  const auto count = whole.contains("frames") ? whole["frames"].size() : whole["result"]["frames"].get<std::size_t>();
  run.result = {{"verb", whole["verb"]},
                {"parts", parts.size()},
                {"frames", count},
                {"seconds", whole["seconds"]["total"]}};
  run.print(fmt::format("{}: {} frames of {} parts are there\n", whole["verb"].get<std::string>(),
                        count, parts.size()));
  if (!options.has("output")) return Exit::done;
  const std::string output = options.text("output");
  run.will_write({output});
  if (run.dry_run()) return Exit::done;
  write_file(output, bytes_of(json_text(whole)));
  say_written(run, {output});
  return Exit::done;
}

}  // namespace

Verb merge_verb() {
  using Type = Option::Type;
  OptionTable table("merge", "Put the reports of all parts of a sequence together, and refuse what is missing.");
  table.example("part_*.json -o whole.json", "the report of all frames, as if one machine had made them");
  table.example("part_*.json", "only whether all is there");
  table.add({.name = "reports",
             .place = Option::Place::positional,
             .type = Type::path,
             .count = Option::Count::many,
             .required = true,
             .help = "what runs with --shard wrote for --report, in any order",
             .details = "Of the same verb, version and options, each part once. The files that they name must be "
                        "there."});
  table.add({.name = "output",
             .letter = 'o',
             .type = Type::path,
             .metavar = "OUT",
             .help = "the report of the whole, which repeats it by --config"});
  return {table, merge};
}

}  // namespace mq::app
