#include "verbs/shared/flow_pair.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/fem/flat_triangle.h"
#include "mq/io/file_names.h"
#include "mq/io/flow_file.h"
#include "options/flow_options.h"
#include "options/signal_options.h"
#include "shell/duration.h"
#include "shell/results.h"

namespace mq::app {
namespace {

bool has_alpha(const Image<float>& picture) {
  return colour_channels(picture.channels()) < picture.channels();
}

void multiply_by_alpha(Image<float>& picture) {
  if (!has_alpha(picture)) return;
  const int alpha = picture.channels() - 1;
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x)
      for (int c = 0; c < alpha; ++c) picture(x, y, c) *= picture(x, y, alpha);
}

void divide_by_alpha(Image<float>& picture) {
  if (!has_alpha(picture)) return;
  const int alpha = picture.channels() - 1;
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x)
      for (int c = 0; c < alpha; ++c)
        if (picture(x, y, alpha) > 0) picture(x, y, c) /= picture(x, y, alpha);
}

/// A range below this share of the largest value is rounding.
constexpr double least_range = 1e-6;
/// Of the blend's error, that a field is remarked to leave.
constexpr double much_left = 0.25;

/// Without --longest-edge triangles are not cut to more vertices than about this: about a minute. A
/// megatexel, whole, at the usual two texels makes a little less.
constexpr double most_vertices = 0.75e6;

/// A forecast of less than both is not worth a word.
constexpr double long_seconds = 60;
constexpr double many_bytes = 2e9;

bool is_constant(std::span<const float> values, int channels) {
  std::vector<float> low(values.begin(),
                         values.begin() + std::min<std::ptrdiff_t>(channels, std::ssize(values)));
  std::vector<float> high = low;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t c = i % std::size_t(channels);
    low[c] = std::min(low[c], values[i]);
    high[c] = std::max(high[c], values[i]);
  }
  for (std::size_t c = 0; c < low.size(); ++c)
    if (high[c] - low[c] > least_range * std::max(std::abs(low[c]), std::abs(high[c])))
      return false;
  return true;
}

bool is_constant(const Signal& signal) {
  if (signal.rows() == 0) return true;
  const Eigen::RowVectorXd low = signal.colwise().minCoeff(), high = signal.colwise().maxCoeff();
  return ((high - low).array() <= least_range * low.array().abs().max(high.array().abs())).all();
}

std::string described(const Texture& texture) {
  return fmt::format("{} x {} pixels with {}", texture.pixels.width(), texture.pixels.height(),
                     counted(texture.pixels.channels(), "channel"));
}

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

}  // namespace

void warn_of_little(Run& run, const Alike& alike) {
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
  else if (after > much_left * before)
    run.terminal().remark(fmt::format(
        "{:.0f} % of what the two differ in is left: where things moved farther than was "
        "found try a larger --largest, where shades are broad --detail 0",
        100 * after / before));
}

bool is_picture_pair(const OptionValues& options) { return !names_model(options.text("mesh")); }

PicturePair::PicturePair(Run& run) : values_(value_space(run.options())) {
  const std::string name = run.options().text("mesh");
  const std::vector<std::string> others = run.options().texts("texture");
  require_second(others, name);
  require(others.size() == 1,
          fmt::format("{}: is a picture, so one more is read after it; found '{}' as well", name,
                      others.back()));
  const Step step(run, "read", 0.1);
  model_.path = name;
  model_.textures.push_back(read_texture(name, step.progress().step("first", 0.5)));
  const Texture& first = model_.textures.front();
  const Texture second = read_texture(others.front(), step.progress().step("second", 0.5));
  for (const Texture* texture : {&first, &second})
    for (const std::string& note : texture->notes) run.terminal().remark(note);
  run.will_read(name);
  run.will_read(others.front());
  run.input = {{"files", Json::array({name, others.front()})},
               {"width", first.pixels.width()},
               {"height", first.pixels.height()},
               {"channels", first.pixels.channels()},
               {"depth", depth_name(first.format.depth)}};
  require(first.pixels.width() == second.pixels.width() &&
              first.pixels.height() == second.pixels.height() &&
              first.pixels.channels() == second.pixels.channels(),
          fmt::format("{}: has {}, and {} has {}: convert one of them", others.front(),
                      described(second), name, described(first)));
  first_ = decoded(first, values_);
  second_ = decoded(second, values_);
  multiply_by_alpha(first_);
  multiply_by_alpha(second_);
  given_ = field_of(run, "flow");
}

std::optional<Image<float>> PicturePair::field_of(Run& run, const std::string& option) const {
  if (!run.options().has(option)) return {};
  const std::string name = run.options().text(option);
  run.will_read(name);
  Image<float> field = read_flow(name);
  if (field.width() != first_.width() || field.height() != first_.height())
    throw IoError(fmt::format(
        "{}: has {} x {} pixels, and the pictures have {} x {}: a field of these is wanted", name,
        field.width(), field.height(), first_.width(), first_.height()));
  if (std::ranges::none_of(field.values(), [](float value) { return std::isfinite(value); }))
    throw IoError(name + ": says of no pixel where it goes: all are marked as unknown");
  run.input["files"].push_back(name);
  return field;
}

ImageFlow PicturePair::align(Run& run, const ImageFlowOptions& options,
                             const Progress& progress) const {
  ImageFlow flow;
  if (given_) {
    about(model_, [&] { flow = known_flow(first_, second_, *given_, options, progress); });
    run.result = flow_json(flow);
    if (flow.error.front() > 0 && !(flow.error.back() < flow.error.front()))
      run.terminal().warning(fmt::format(
          "{}: brings the two no nearer to each other (error {:.4g}, mixed as they lie {:.4g}): it "
          "may be of another pair, or from the second to the first",
          run.options().text("flow"), flow.error.back(), flow.error.front()));
    return flow;
  }
  about(model_, [&] { flow = image_flow(first_, second_, options, progress); });
  run.result = flow_json(flow);
  warn_of_little(run, {.first_constant = is_constant(first_.values(), first_.channels()),
                       .second_constant = is_constant(second_.values(), second_.channels()),
                       .equal = first_ == second_});
  return flow;
}

Texture PicturePair::stored(const Image<float>& picture) const {
  Texture texture = model_.textures.front();
  texture.path.clear();
  Image<float> divided = picture;
  divide_by_alpha(divided);
  texture.pixels = encoded(divided, texture, values_);
  return texture;
}

ModelPair::ModelPair(Run& run) {
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
  std::vector<std::filesystem::path> first, second;
  for (std::size_t i = 0; i < others.size() && !models; ++i)
    (i < others.size() / 2 ? first : second).emplace_back(others[i]);
  factors_ = texture_flow_options(options).flow.solver == FlowSolver::direct;
  const double share = factors_ ? 0.01 : 0.15;
  scene_ = read_usable_model(run, models ? MissingPictures::unneeded : MissingPictures::refuse,
                             share, first);
  vertices_ = models || app::at_vertices(options, scene_);
  require(
      models || !vertices_,
      fmt::format("{}: colours at vertices are aligned with those of a second model; found '{}'",
                  name, others.front()));
  refuse_what_is_for_textures(options);
  for (const std::string& other : others) {
    const Json& read = run.input["files"];
    if (std::ranges::find(read, Json(other)) == read.end()) run.input["files"].push_back(other);
  }
  const Step step(run, "assemble", share);
  about(scene_.model, [&] {
    if (models)
      take_colours(run, name, others.front());
    else
      take_textures(run, first, second, step);
  });
}

void ModelPair::take_colours(Run& run, const std::string& name, const std::string& file) {
  require(scene_.model.colors.channels > 0, "has no colours at its vertices to align");
  auto target = std::make_unique<VertexColourSignal>(scene_);
  const Model other =
      read_model(file, {.textures = {}, .pictures = ReadModelOptions::Pictures::skip});
  require(other.mesh.vertex_count() == scene_.model.mesh.vertex_count() &&
              other.colors.channels == scene_.model.colors.channels,
          fmt::format("{}: has {} with {} of colour, and {} has {} with {}: the same vertices in "
                      "the same order are wanted",
                      file, counted(other.mesh.vertex_count(), "vertex"),
                      counted(other.colors.channels, "channel"), name,
                      counted(scene_.model.mesh.vertex_count(), "vertex"),
                      counted(scene_.model.colors.channels, "channel")));
  for (std::size_t i = 0; i < other.colors.values.size(); ++i)
    require(std::isfinite(other.colors.values[i]),
            fmt::format("{}: a colour of vertex {} (counted from 0) is {}; it must be finite", file,
                        i / std::size_t(other.colors.channels), other.colors.values[i]));
  if (other.mesh.triangles != scene_.model.mesh.triangles)
    run.terminal().warning(fmt::format(
        "{}: its triangles are not those of {}: colours are compared vertex by vertex, in "
        "the order of the files",
        file, name));
  first_ = target->values();
  second_ = target->values_of(other.colors);
  second_colors_ = other.colors;
  target_ = std::move(target);
}

void ModelPair::take_textures(Run& run, const std::vector<std::filesystem::path>& first,
                              const std::vector<std::filesystem::path>& second,
                              const Progress& progress) {
  require(first.size() == scene_.model.textures.size(),
          fmt::format("{} of its textures come first and as many after; found {}",
                      scene_.model.textures.size(),
                      counted(std::ssize(first) + std::ssize(second), "picture")));
  auto target = make_texture_signal(run, scene_, {.values = value_space(run.options())}, progress);
  std::vector<Texture> textures;
  for (std::size_t i = 0; i < second.size(); ++i) {
    textures.push_back(read_texture(second[i]));
    const Image<float>& pixels = textures.back().pixels;
    const Image<float>& wanted = scene_.model.textures[i].pixels;
    require(pixels.width() == wanted.width() && pixels.height() == wanted.height() &&
                pixels.channels() == wanted.channels(),
            fmt::format("{}: has {}, and {} has {}: convert one of them", second[i].string(),
                        described(textures.back()), first[i].string(),
                        described(scene_.model.textures[i])));
  }
  first_ = target->values();
  second_ = target->values_of(textures);
  for (Texture& texture : textures) second_pictures_.push_back(std::move(texture.pixels));
  target_ = std::move(target);
}

Model ModelPair::with(const Signal& values, double t) const {
  Model model = scene_.model;
  const auto mix = [t](std::span<float> first, std::span<const float> second) {
    for (std::size_t i = 0; i < first.size(); ++i)
      first[i] = t == 1 ? second[i] : float(first[i] + t * (double(second[i]) - first[i]));
  };
  if (t > 0 && vertices_) mix(model.colors.values, second_colors_.values);
  for (std::size_t i = 0; i < second_pictures_.size() && t > 0; ++i)
    mix(model.textures[i].pixels.values(), second_pictures_[i].values());
  if (t == 1) return model;
  // Where both pictures agree with the signal before, `put` changes nothing: all of the first's.
  Model shown = scene_.model;
  target_->put(first_, values, shown);
  if (vertices_) {
    const std::vector<int>& unknowns = scene_.surface.vertex_from_source;
    const int channels = model.colors.channels;
    for (std::size_t v = 0; v < unknowns.size(); ++v)
      if (unknowns[v] >= 0)
        std::copy_n(&shown.colors.values[v * channels], channels,
                    &model.colors.values[v * channels]);
    return model;
  }
  const TexelSpace& space = *target_->texel_space();
  for (const Texels::Place& place : space.texels().places) {
    const auto from = shown.textures[std::size_t(place.texture)].pixels.pixel(place.x, place.y);
    std::ranges::copy(
        from, model.textures[std::size_t(place.texture)].pixels.pixel(place.x, place.y).begin());
  }
  return model;
}

double ModelPair::edge_for(Run& run, double longest_edge) const {
  double texels = 0;  // also of charts that lie upon each other
  for (const Chart& chart : scene_.atlas->charts) texels += chart.texel_area;
  double vertices = expected_vertices(int(std::min(texels, 2e9)), longest_edge);
  if (run.options().has("longest-edge") || !(vertices > most_vertices / 4)) return longest_edge;
  // Narrow triangles make more: counted on a cut that is as much coarser as makes it cheap.
  const double coarser = std::sqrt(std::max(1.0, 16 * vertices / most_vertices));
  const TexelSpace& space = *target_->texel_space();
  const RefinedTexture sparse(scene_.surface, *scene_.atlas, space, coarser * longest_edge);
  const int added = sparse.fine().surface.mesh.vertex_count() - scene_.surface.mesh.vertex_count();
  vertices = std::max(vertices, added * coarser * coarser);
  if (!(vertices > most_vertices)) return longest_edge;
  const double edge = longest_edge * std::sqrt(vertices / most_vertices);
  run.terminal().remark(
      fmt::format("triangles are cut to {:.1f} texels, which makes about {:.2g} million vertices; "
                  "--longest-edge {:g} sees finer and takes {:.1f} times the time and memory",
                  edge, most_vertices * 1e-6, longest_edge, vertices / most_vertices));
  return edge;
}

void ModelPair::refuse_what_is_for_textures(const OptionValues& options) const {
  if (!vertices_) return;
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

void ModelPair::align(Run& run, const TextureFlowOptions& given, const Progress& progress) {
  TextureFlowOptions options = given;
  if (!vertices_) {
    options.longest_edge = edge_for(run, given.longest_edge);
    // The cut mesh that flow works on has no texels.
    for (Length* length : {&options.flow.largest, &options.flow.smallest, &options.flow.detail})
      if (length->unit == Length::Unit::texels)
        *length = {length->value * target_->space().scale().texel_spacing, Length::Unit::model};
  }
  Json foreseen;
  options.flow.foresee = [&](const FlowForecast& forecast) {
    warn_of_cost(run, forecast);
    foreseen = {{"unknowns", forecast.unknowns},
                {"factorisations", forecast.factorisations},
                {"seconds", forecast.seconds},
                {"bytes", forecast.bytes}};
  };
  try {
    find(options, progress);
  } catch (const OutOfMemory& error) {
    if (!factors_) throw;
    throw OutOfMemory(
        fmt::format("{}; here that is {}", error.what(), without_factors(run.options())));
  }
  run.result = flow_json(flow());
  if (!foreseen.is_null()) run.result["forecast"] = foreseen;
  run.result["vertices"] = flow_vertices();
  if (!vertices_) run.result["longest_edge"] = options.longest_edge;
  warn_of_little(run, {.first_constant = is_constant(first_),
                       .second_constant = is_constant(second_),
                       .equal = first_ == second_});
}

void ModelPair::find(const TextureFlowOptions& options, const Progress& progress) {
  about(scene_.model, [&] {
    if (vertices_) {
      flow_ =
          mesh_flow(scene_.surface, first_, second_, options.flow, progress.step("align", 0.95));
      mesh_ = std::make_unique<TraceMesh>(scene_.surface, progress.step("order triangles", 0.05));
      return;
    }
    const TexelSpace& space = *target_->texel_space();
    textures_ = std::make_unique<TextureFlow>(scene_.surface, *scene_.atlas, space, first_, second_,
                                              options, progress);
  });
}

void ModelPair::warn_of_cost(Run& run, const FlowForecast& forecast) const {
  const double total = forecast.factorisations * forecast.seconds;
  if (total < long_seconds && double(forecast.bytes) < many_bytes) return;
  run.terminal().remark(
      fmt::format("each correction factors a matrix of {:.2g} million unknowns, which takes about "
                  "{} and {:.1f} "
                  "GB, and there are up to {}, together about {}; {} factors none",
                  forecast.unknowns * 1e-6, duration(forecast.seconds), forecast.bytes * 1e-9,
                  forecast.factorisations, duration(total), without_factors(run.options())));
}

WarpedPair ModelPair::warp_pair(double t, const Progress& progress) const {
  return textures_ ? textures_->warp_pair(first_, second_, t, progress)
                   : mq::warp_pair(*mesh_, flow_.field, first_, second_, t, progress);
}

Signal ModelPair::between(double t, const Progress& progress) const {
  if (t == 0) return first_;
  if (t == 1) return second_;
  const WarpedPair warped = warp_pair(t, progress);
  return warped.source + t * (warped.target - warped.source);
}

TangentField ModelPair::field() const {
  return textures_ ? textures_->field() : field_in_space(scene_.surface, flow_.field);
}

}  // namespace mq::app
