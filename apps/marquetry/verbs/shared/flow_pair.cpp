#include "verbs/shared/flow_pair.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/io/file_names.h"
#include "options/flow_options.h"
#include "options/signal_options.h"
#include "shell/duration.h"
#include "shell/results.h"

namespace mq::app {
namespace {

/// Of the blend's error, that a field is remarked to leave.
constexpr double much_left = 0.25;

/// Of all pixels, that it is remarked nothing fits.
constexpr double many_unfit = 0.01;

/// Of the ratio of light, that is told.
constexpr double told_light = 0.005;

/// A forecast of less than both is not worth a word.
constexpr double long_seconds = 60;
constexpr double many_bytes = 2e9;

void require_second(const std::vector<std::string>& names, const std::string& first) {
  require(!names.empty(),
          fmt::format("{}: there is nothing to align it with: name a second picture "
                      "after it",
                      first));
}

/// The same without factorisations.
std::string without_factors(const OptionValues& options) {
  const bool thesis = options.text("preset") == "thesis";
  if (options.text("basis") != "vertex")
    return thesis ? "--basis vertex without --preset thesis" : "--basis vertex";
  return "--scales hierarchical";
}

/// Says how far two pictures go together where far motions were searched for.
void say_fit(Run& run, const ImageFlow& flow, ImageLight asked) {
  if (!flow.fit) return;
  const ImageFlow::Fit& fit = *flow.fit;
  if (fit.light == ImageLight::evened && fit.ratio.size > told_light)
    run.terminal().remark(
        fmt::format("the light is another in each, by {:.0f} % on the mean: the ratio is made good where they are "
                    "aligned, and pictures between go from the one to the other; --light kept leaves it",
                    100 * std::expm1(fit.ratio.size)));
  if (fit.light != asked && fit.light == ImageLight::matched)
    run.terminal().remark("the light is another in each, so both are brought to one mean and variance before they are "
                          "aligned: --light matched");
  if (!fit.unrelated && fit.unfit > many_unfit)
    run.terminal().remark(
        fmt::format("nothing in the one picture fits {:.0f} % of the other: there the two are mixed as they lie",
                    100 * fit.unfit));
}

/// Says of a pair, aligned as `run.result` says, why it did not come nearer, or not near.
void warn_of_little(Run& run, const Likeness& alike, const std::optional<ImageFlow::Fit>& fit = {}) {
  const double before = run.result["error"].front(), after = run.result["error"].back();
  if (alike.first_constant || alike.second_constant)
    run.terminal().warning(fmt::format("{} of one colour, so nothing says what moves where",
                                       alike.first_constant && alike.second_constant
                                           ? "both signals are"
                                       : alike.first_constant ? "the first signal is"
                                                              : "the second signal is"));
  else if (alike.equal)
    run.terminal().remark("the two are equal, so the field is 0");
  else if (before == 0)
    run.terminal().warning(
        "--detail leaves nothing of what the two differ in, so nothing says what moves where: give "
        "a larger one, or 0 to leave out nothing");
  else if (run.result["longest"] == 0)
    run.terminal().warning(
        "no motion brings the two nearer to each other, so the field is 0: try another --largest, "
        "or --detail 0 where shades are broad");
  else if (fit && fit->unrelated)
    run.terminal().warning(fmt::format(
        "the two seem to show different things: along the best motion {:.0f} % of their detail is alike, nothing in the "
        "one fits {:.0f} % of the other, and {:.0f} % of what they differ in is left, so pictures between are mixed as "
        "they lie; --search none moves them all the same",
        100 * fit->alike, 100 * fit->unfit, 100 * after / before));
  else if (fit && fit->strained)
    run.terminal().warning(fmt::format(
        "parts of what lies between may be mangled: along the motion that was found, which bends, only {:.0f} % of the "
        "detail of the two is alike, as where things turn and hide parts of themselves. Look at it; pictures nearer to "
        "each other do better",
        100 * fit->alike));
  else if (after > much_left * before)
    run.terminal().remark(fmt::format(
        "{:.0f} % of what the two differ in is left: where things moved farther than was "
        "found try a larger --largest, where shades are broad --detail 0",
        100 * after / before));
}

/// Says what factorisations will take where that is much, and what else could be done.
void warn_of_cost(Run& run, const FlowForecast& forecast) {
  const double total = forecast.factorisations * forecast.seconds;
  if (total < long_seconds && double(forecast.bytes) < many_bytes) return;
  run.terminal().remark(
      fmt::format("each correction factors a matrix of {:.2g} million unknowns, which takes about "
                  "{} and {:.1f} "
                  "GB, and there are up to {}, together about {}; {} factors none",
                  forecast.unknowns * 1e-6, duration(forecast.seconds), forecast.bytes * 1e-9,
                  forecast.factorisations, duration(total), without_factors(run.options())));
}

void refuse_what_is_for_textures(const OptionValues& options) {
  const auto require_left_out = [](bool left_out, const std::string& what) {
    require(left_out, what + " is for textures, not for colours at vertices: leave it out");
  };
  require_left_out(!asks_for(options, "space"), "--space");
  require_left_out(!asks_for(options, "longest-edge"), "--longest-edge");
  for (const std::string name : {"largest", "smallest", "detail"})
    if (options.has(name) && parse_length(options.text(name)).unit == Length::Unit::texels)
      throw InvalidInput(
          fmt::format("--{}: found '{}': at vertices there are no texels; give a length in the "
                      "model's units, or in % of the square root of its area",
                      name, options.text(name)));
}

PicturePair read_pair(Run& run) {
  const std::string name = run.options().text("mesh");
  const std::vector<std::string> others = run.options().texts("texture");
  require_second(others, name);
  require(others.size() == 1,
          fmt::format("{}: is a picture, so one more is read after it; found '{}' as well", name,
                      others.back()));
  const Step step(run, "read", 0.1);
  run.will_read(name);
  run.will_read(others.front());
  PicturePair pair(name, others.front(), value_space(run.options()), run.terminal(), step);
  run.input = picture_json(pair.model());
  run.input["files"].push_back(others.front());
  return pair;
}

}  // namespace

bool is_picture_pair(const OptionValues& options) { return !names_model(options.text("mesh")); }

AskedPictures::AskedPictures(Run& run) : pair_(read_pair(run)), given_(field_of(run, "flow")) {}

std::optional<Image<float>> AskedPictures::field_of(Run& run, const std::string& option) const {
  if (!run.options().has(option)) return {};
  const std::string name = run.options().text(option);
  run.will_read(name);
  Image<float> field = pair_.read_field(name);
  run.input["files"].push_back(name);
  return field;
}

ImageFlow AskedPictures::align(Run& run, const ImageFlowOptions& options,
                               const Progress& progress) const {
  ImageFlow flow =
      given_ ? pair_.follow(*given_, options, progress) : pair_.align(options, progress);
  run.result = flow_json(flow);
  say_fit(run, flow, options.light);
  if (!given_) {
    warn_of_little(run, pair_.likeness(), flow.fit);
  } else if (flow.error.front() > 0 && !(flow.error.back() < flow.error.front())) {
    run.terminal().warning(fmt::format(
        "{}: brings the two no nearer to each other (error {:.4g}, mixed as they lie {:.4g}): it "
        "may be of another pair, or from the second to the first",
        run.options().text("flow"), flow.error.back(), flow.error.front()));
  }
  return flow;
}

AskedModels::AskedModels(Run& run) {
  const OptionValues& options = run.options();
  const std::string name = options.text("mesh");
  const std::vector<std::string> others = options.texts("texture");
  require_second(others, name);
  const bool models = names_model(others.front());
  require(
      !models || others.size() == 1,
      fmt::format("{}: one more model is read after it; found '{}' as well", name, others.back()));
  require(
      models || others.size() % 2 == 0,
      fmt::format("{}: pictures come in pairs, all of the first and then all of the second; found "
                  "{}",
                  name, counted(std::ssize(others), "picture")));
  const auto middle = others.begin() + (models ? 0 : std::ssize(others) / 2);
  factors_ = model_flow_options(options).is_factored();
  const double share = factors_ ? 0.01 : 0.15;
  scene_ = read_usable_model(run, models ? MissingPictures::unneeded : MissingPictures::refuse,
                             share, std::vector<std::filesystem::path>(others.begin(), middle));
  const bool vertices = models || app::at_vertices(options, scene_);
  require(
      models || !vertices,
      fmt::format("{}: colours at vertices are aligned with those of a second model; found '{}'",
                  name, others.front()));
  if (vertices) refuse_what_is_for_textures(options);
  for (const std::string& other : others) {
    const Json& read = run.input["files"];
    if (std::ranges::find(read, Json(other)) == read.end()) run.input["files"].push_back(other);
  }
  const Step step(run, "assemble", share);
  if (!models) {
    read_textures(run, {middle, others.end()}, step);
    return;
  }
  about(scene_.model, [&] {
    const Model second = read_model(
        others.front(), {.textures = {}, .pictures = ReadModelOptions::Pictures::skip});
    pair_ = std::make_unique<ModelPair>(scene_, second, run.terminal());
  });
}

void AskedModels::read_textures(Run& run, const std::vector<std::string>& second,
                                const Progress& progress) {
  about(scene_.model, [&] {
    require(second.size() == scene_.model.textures.size(),
            fmt::format("{} of its textures come first and as many after; found {}",
                        scene_.model.textures.size(),
                        counted(2 * std::ssize(second), "picture")));
    std::vector<Texture> textures;
    for (const std::string& file : second) textures.push_back(read_texture(file));
    pair_ = std::make_unique<ModelPair>(scene_, std::move(textures), value_space(run.options()),
                                        run.terminal(), progress);
  });
  say_defects(run, pair_->target());
}

/// The edges to cut to: as given, longer where --longest-edge is not and that would be too many.
double AskedModels::edge_for(Run& run, double longest_edge) const {
  if (run.options().has("longest-edge")) return longest_edge;
  const double edge = pair_->quick_edge(longest_edge);
  if (edge > longest_edge)
    run.terminal().remark(fmt::format(
        "triangles are cut to {:.1f} texels, which makes about {:.2g} million vertices; "
        "--longest-edge {:g} sees finer and takes {:.1f} times the time and memory",
        edge, ModelPair::quick_vertices * 1e-6, longest_edge,
        edge * edge / (longest_edge * longest_edge)));
  return edge;
}

ModelPairFlow AskedModels::align(Run& run, const ModelFlowOptions& given, const Progress& progress) const {
  ModelFlowOptions options = given;
  const bool cut = !pair_->at_vertices() && given.longest_edge;
  if (cut) options.longest_edge = edge_for(run, *given.longest_edge);
  Json foreseen;
  options.foresee = [&](const FlowForecast& forecast) {
    warn_of_cost(run, forecast);
    foreseen = {{"unknowns", forecast.unknowns},
                {"factorisations", forecast.factorisations},
                {"seconds", forecast.seconds},
                {"bytes", forecast.bytes}};
  };
  try {
    ModelPairFlow found = pair_->align(options, progress);
    run.result = flow_json(found.flow());
    if (!foreseen.is_null()) run.result["forecast"] = foreseen;
    run.result["vertices"] = found.vertices();
    if (cut) run.result["longest_edge"] = *options.longest_edge;
    warn_of_little(run, pair_->likeness());
    return found;
  } catch (const OutOfMemory& error) {
    if (!factors_) throw;
    throw OutOfMemory(
        fmt::format("{}; here that is {}", error.what(), without_factors(run.options())));
  }
}

}  // namespace mq::app
