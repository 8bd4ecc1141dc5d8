#include "verbs/shared/photographs.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <span>

#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "mq/base/words.h"
#include "mq/io/image_file.h"
#include "mq/io/path_status.h"
#include "mq/io/photograph_file.h"
#include "shell/arguments.h"

namespace mq::app {

namespace {

const std::string heading = "Photographs";

void add_files(OptionTable& table) {
  using Type = Option::Type;
  table.add({.name = "cameras",
             .type = Type::path,
             .count = Option::Count::many,
             .required = true,
             .group = heading,
             .help = "photographs with their cameras, as the verb cameras reads them"});
  table.add({.name = "images",
             .type = Type::path,
             .count = Option::Count::many,
             .group = heading,
             .help = "folders with the photographs",
             .details = "Without it they are looked for beside the cameras, and where COLMAP's projects have them."});
  table.add({.name = "missing",
             .type = Type::choice,
             .default_value = "refuse",
             .choices = {"refuse", "skip"},
             .metavar = "HOW",
             .group = heading,
             .help = "stop where photographs are not there, cannot be read or do not fit their cameras, or go on "
                     "without them"});
}

}  // namespace

void add_photograph_options(OptionTable& table) {
  using Type = Option::Type;
  const PhotographTextureOptions usual;
  add_files(table);
  table.add({.name = "steepest",
             .type = Type::number,
             .default_value = as_typed(usual.projection.steepest),
             .unit = "degrees",
             .least = 1,
             .most = 90,
             .group = heading,
             .help = "from the normal, beyond which a view shows nothing"});
  table.add({.name = "bias",
             .type = Type::number,
             .default_value = as_typed(100 * usual.projection.bias),
             .unit = "%",
             .least = 0,
             .most = 100,
             .group = heading,
             .help = "of the model's diagonal: what is so close in front of a point does not hide it from a view"});
  table.add({.name = "outline",
             .type = Type::number,
             .default_value = as_typed(usual.projection.outline),
             .unit = "pixels",
             .least = 0,
             .most = 1000,
             .group = heading,
             .help = "around outlines that show what is behind them: more where the mesh or the cameras are off"});
  table.add({.name = "poses",
             .type = Type::choice,
             .default_value = "align",
             .choices = {"align", "keep"},
             .metavar = "HOW",
             .group = heading,
             .help = "move cameras a little and bend photographs, so that all show the same, or keep them",
             .details = "Else details are seen twice where cameras or the mesh are off by some pixels. Photographs are "
                        "read once more."});
  table.add({.name = "exposure",
             .type = Type::choice,
             .default_value = "match",
             .choices = {"match", "tone", "keep"},
             .metavar = "HOW",
             .group = heading,
             .help = "even out exposure, white balance and dark corners of the photographs; tone: their contrast too; "
                     "or keep them",
             .details = "tone is for photographs of several cameras, or developed in several ways."});
  table.add({.name = "outliers",
             .type = Type::choice,
             .default_value = "reject",
             .choices = {"reject", "keep"},
             .metavar = "HOW",
             .group = heading,
             .help = "leave out what disagrees with the other photographs of a place, or not",
             .details = "Passers-by and reflections; it takes three photographs to tell."});
  table.add({.name = "smoothness",
             .type = Type::number,
             .default_value = as_typed(usual.choice.smoothness),
             .least = 0,
             .most = 100,
             .group = heading,
             .help = "more: fewer, larger parts of one photograph; 0: always the one that shows most"});
  table.add({.name = "blend",
             .type = Type::choice,
             .default_value = "detail",
             .choices = {"best", "mean", "detail"},
             .metavar = "HOW",
             .group = heading,
             .help = "of photographs that agree: the best; the mean, by how well they show a place; or fine detail of "
                     "the best and the colour of the mean"});
}

namespace {

/// The first few of some names.
std::string named_of(std::span<const std::string> names) {
  constexpr std::size_t most_named = 5;
  const auto some = names.first(std::min(most_named, names.size()));
  return fmt::format("{}{}", fmt::join(some, ", "), names.size() > most_named ? ", ..." : "");
}

/// What is wrong with a photograph as far as its head tells; nothing where it fits its camera.
std::optional<std::string> what_is_wrong(const Photograph& photograph) {
  try {
    fitted_camera(photograph, picture_info(photograph.picture));
  } catch (const IoError& error) {
    return error.what();
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return std::nullopt;
}

/// Keeps those that can be read and fit their cameras. Of the others a warning each, or an error that names them all.
void leave_out_unusable(Run& run, std::vector<UnusablePhotograph> unusable, bool skip, GivenPhotographs& given) {
  constexpr std::size_t most_named = 20;
  std::vector<Photograph> photographs;
  for (Photograph& photograph : given.photographs) {
    run.will_read(photograph.picture);
    if (auto why = what_is_wrong(photograph))
      unusable.push_back({std::move(photograph), std::move(*why)});
    else
      photographs.push_back(std::move(photograph));
  }
  given.photographs = std::move(photographs);
  if (unusable.empty()) return;
  for (const UnusablePhotograph& one : unusable) {
    given.left_out.push_back({one.photograph.picture.string(), one.why});
    if (skip) run.terminal().warning(one.why + ": left out");
  }
  if (skip) return;
  const std::size_t named = std::min(most_named, unusable.size());
  std::vector<std::string> all;
  for (std::size_t k = 0; k < named; ++k) all.push_back(unusable[k].why);
  if (named < unusable.size()) all.push_back(fmt::format("and {} more", unusable.size() - named));
  throw IoError(fmt::format("{}; or go on without {} ({} skip)", fmt::join(all, "\n"),
                            unusable.size() == 1 ? "it" : "them", option_name("missing")));
}

/// Leaves out photographs that other files of cameras had already.
void unite(Run& run, const std::string& file, std::vector<Photograph>& fresh,
           std::map<std::filesystem::path, std::string>& files) {
  std::vector<std::string> twice;
  std::string before;
  std::erase_if(fresh, [&](const Photograph& photograph) {
    const auto [first, is_new] = files.emplace(full_name(photograph.picture), file);
    if (is_new) return false;
    twice.push_back(photograph.picture.string());
    before = first->second;
    return true;
  });
  if (twice.empty()) return;
  run.terminal().warning(fmt::format("{}: {} {} too: taken once, with the cameras there: {}", before,
                                     counted(std::ssize(twice), "picture"),
                                     (twice.size() == 1 ? "is in " : "are in ") + file,
                                     named_of(twice)));
}

/// Leaves out grey photographs among coloured ones, with a warning each: they have no colours to give. Where there are no
/// fewer of them they are used.
void leave_out_grey(Run& run, GivenPhotographs& given) {
  const auto is_grey = [](const Photograph& one) {
    return colour_channels(int(picture_info(one.picture).channels.size())) == 1;
  };
  const auto grey = std::ranges::count_if(given.photographs, is_grey), all = std::ssize(given.photographs);
  if (grey == 0 || grey == all) return;
  if (2 * grey >= all)
    return run.terminal().warning(fmt::format("{} of {} photographs are grey: where they are chosen the texture has "
                                              "no colours", grey, all));
  std::erase_if(given.photographs, [&](const Photograph& one) {
    if (!is_grey(one)) return false;
    const std::string picture = one.picture.string(), why = picture + ": is grey, and others are not";
    given.left_out.push_back({picture, why});
    run.terminal().warning(why + ": left out");
    return true;
  });
}

/// That pictures are not there, of which the first few are named.
std::string warning_of_missing(const std::string& file, std::span<const Photograph> missing) {
  std::vector<std::string> names;
  for (const Photograph& photograph : missing) names.push_back(photograph.picture.string());
  return fmt::format("{}: {} not there and left out: {}", file,
                     missing.size() == 1 ? "1 picture is" : fmt::format("{} pictures are", missing.size()),
                     named_of(names));
}

/// Of each file its cameras. Throws an error that names all files that cannot be read, a line each.
std::vector<CameraSet> read_sets(std::span<const std::string> files, const CamerasOptions& where) {
  std::vector<CameraSet> sets;
  std::vector<std::string> errors;
  for (const std::string& file : files) try {
      sets.push_back(read_camera_set(file, where));
    } catch (const Error& error) {
      errors.emplace_back(error.what());
    }
  if (!errors.empty()) throw IoError(fmt::format("{}", fmt::join(errors, "\n")));
  return sets;
}

}  // namespace

GivenPhotographs read_photographs(Run& run) {
  CamerasOptions where;
  where.unreadable = CamerasOptions::Missing::list;
  const bool skip = run.options().text("missing") == "skip";
  if (skip) where.missing = CamerasOptions::Missing::list;
  for (const std::string& folder : run.options().texts("images")) where.images.emplace_back(folder);
  GivenPhotographs given;
  std::vector<UnusablePhotograph> unusable;
  std::map<std::filesystem::path, std::string> files;
  std::set<std::string> missing;  // by the names that files of cameras give them
  const std::vector<std::string> names = run.options().texts("cameras");
  std::vector<CameraSet> sets = read_sets(names, where);
  for (std::size_t k = 0; k < sets.size(); ++k) {
    const std::string& file = names[k];
    CameraSet& cameras = sets[k];
    for (const std::string& note : cameras.notes) run.terminal().remark(file + ": " + note);
    for (const std::string& doubt : cameras.doubts) run.terminal().warning(doubt);
    if (cameras.without_pose > 0)
      run.terminal().warning(fmt::format("{}: {} without a place are left out", file,
                                         counted(cameras.without_pose, "photograph")));
    std::erase_if(cameras.missing, [&](const Photograph& one) { return !missing.insert(one.picture.string()).second; });
    if (!cameras.missing.empty()) run.terminal().warning(warning_of_missing(file, cameras.missing));
    for (const Photograph& one : cameras.missing) given.left_out.push_back({one.picture.string(), "is not there"});
    unite(run, file, cameras.photographs, files);
    std::ranges::move(cameras.unreadable, std::back_inserter(unusable));
    std::ranges::move(cameras.photographs, std::back_inserter(given.photographs));
  }
  leave_out_unusable(run, std::move(unusable), skip, given);
  leave_out_grey(run, given);
  require(!given.photographs.empty(),
          "none of the photographs is there, can be read and fits its camera: give their folder by --images");
  return given;
}

namespace {

PhotographBlend asked_blend(const OptionValues& options) {
  const std::string& how = options.text("blend");
  if (how == "best") return PhotographBlend::best;
  return how == "mean" ? PhotographBlend::mean : PhotographBlend::detail;
}

PhotographExposure asked_exposure(const OptionValues& options) {
  const std::string& how = options.text("exposure");
  if (how == "keep") return PhotographExposure::keep;
  return how == "tone" ? PhotographExposure::tone : PhotographExposure::match;
}

}  // namespace

PhotographTextureOptions asked_photograph_options(const OptionValues& options) {
  PhotographTextureOptions wanted;
  wanted.projection.steepest = options.number("steepest");
  wanted.projection.bias = options.number("bias") / 100;
  wanted.projection.outline = options.number("outline");
  wanted.align = options.text("poses") == "align";
  wanted.exposure = asked_exposure(options);
  wanted.reject_outliers = options.text("outliers") == "reject";
  wanted.choice.smoothness = options.number("smoothness");
  if (options.text("missing") == "skip") wanted.unreadable = UnreadablePhotographs::skip;
  wanted.blend = asked_blend(options);
  return wanted;
}

}  // namespace mq::app
