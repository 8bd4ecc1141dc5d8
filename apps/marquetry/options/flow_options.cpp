#include "options/flow_options.h"

#include <fmt/format.h>

#include <cmath>

#include "mq/base/error.h"
#include "mq/draw/flow_colour.h"
#include "options/model_options.h"
#include "options/signal_options.h"
#include "mq/model/signal_pair.h"
#include "shell/arguments.h"

namespace mq::app {
namespace {

/// A length where one is given, else what stands.
void take_length(const OptionValues& options, const std::string& name, Length& length) {
  if (options.has(name)) length = parse_length(options.text(name));
}

void take_number(const OptionValues& options, const std::string& name, double& number) {
  if (asks_for(options, name)) number = options.number(name);
}

/// What pictures and models are asked alike.
void take_common(const OptionValues& options, FlowOptions& flow) {
  flow.alignment =
      options.text("alignment") == "forward" ? FlowAlignment::forward : FlowAlignment::halfway;
  if (options.has("steps")) flow.steps = int(options.integer("steps"));
  take_length(options, "largest", flow.largest);
  take_length(options, "smallest", flow.smallest);
  take_length(options, "detail", flow.detail);
  take_number(options, "robust-data", flow.robust_data);
  take_number(options, "robust-smoothness", flow.robust_smoothness);
  take_number(options, "gradients", flow.gradient_weight);
}

void refuse(const OptionValues& options, const std::string& name, const std::string& what) {
  require(!asks_for(options, name), fmt::format("--{} is for {}", name, what));
}

/// How the two are moved, and at which scales.
void add_scale_options(OptionTable& table, const std::string& group) {
  using Type = Option::Type;
  table.add({.name = "preset",
             .type = Type::choice,
             .default_value = "default",
             .choices = {"default", "thesis"},
             .group = group,
             .help = "thesis: seven scales with one correction each, and the published weights",
             .details = "Options given beside it go before what it says."});
  table.add({.name = "alignment",
             .type = Type::choice,
             .default_value = "halfway",
             .choices = {"halfway", "forward"},
             .group = group,
             .help = "halfway: both are moved by half; forward: the second alone"});
  table.add({.name = "largest",
             .type = Type::length,
             .group = group,
             .help = fmt::format("the first scale: about half of the longest motion [default {} for "
                                 "pictures, {} for models]",
                                 as_typed(ImageFlowOptions{}.largest),
                                 as_typed(MeshFlowOptions{}.largest)),
             .details = "Signals are smoothed over this length and fields are as smooth; it is "
                        "halved from scale to scale. Texels are pixels."});
  table.add({.name = "smallest",
             .type = Type::length,
             .group = group,
             .help = fmt::format(
                 "the last scale [default {} for pictures, four texels for textures, two mean edges for models]",
                 as_typed(ImageFlowOptions{}.smallest))});
  table.add({.name = "detail",
             .type = Type::length,
             .group = group,
             .help = fmt::format("what is broader counts as light and is left out; 0: nothing is "
                                 "[default {} for pictures, {} for models]",
                                 as_typed(ImageFlowOptions{}.detail),
                                 as_typed(MeshFlowOptions{}.detail))});
}

/// What a correction minimises, and how many there are.
void add_correction_options(OptionTable& table, const std::string& group) {
  using Type = Option::Type;
  table.add({.name = "robust-data",
             .type = Type::number,
             .default_value = as_typed(FlowOptions{}.robust_data),
             .least = 0,
             .most = 1000,
             .group = group,
             .help = "differences beyond this many standard deviations count less; 0: as squares"});
  table.add(
      {.name = "robust-smoothness",
       .type = Type::number,
       .default_value = as_typed(FlowOptions{}.robust_smoothness),
       .least = 0,
       .most = 1000,
       .group = group,
       .help = "changes of the field beyond this count less, so that it may break; 0: as squares"});
  table.add({.name = "steps",
             .type = Type::integer,
             .least = 1,
             .most = 1000,
             .group = group,
             .help = fmt::format("corrections at each scale, at most; fewer where they gain little "
                                 "[default {} for pictures, {} for models]",
                                 ImageFlowOptions{}.steps, MeshFlowOptions{}.steps),
             .details = "On coarser meshes twice as many."});
  table.add({.name = "scales",
             .type = Type::choice,
             .choices = {"hierarchical", "full", "single"},
             .metavar = "HOW",
             .group = group,
             .help = "hierarchical, full or single [default hierarchical]",
             .details =
                 "hierarchical: each scale on a grid or a mesh as coarse as it allows. full: at "
                 "the resolution of the input. single: the smallest scale alone, for pictures."});
  table.add(
      {.name = "gradients",
       .type = Type::number,
       .default_value = as_typed(FlowOptions{}.gradient_weight),
       .least = 0,
       .most = 1000,
       .group = group,
       .help = "weight of the signal's slopes beside itself, which change less with the light"});
}

void add_options_for_pictures(OptionTable& table) {
  using Type = Option::Type;
  table.add({.name = "light",
             .type = Type::choice,
             .choices = {"auto", "kept", "matched"},
             .group = "Pictures",
             .help =
                 "auto: where means along the motion say that light is another in each, its ratio is made good "
                 "[default auto]",
             .details = "matched: each channel of both is brought to one mean and variance first, where contrast "
                        "differs; what moves into a picture or out of it changes them too. With --search none auto is "
                        "kept."});
  table.add({.name = "paths",
             .type = Type::choice,
             .choices = {"integrated", "straight"},
             .group = "Pictures",
             .help = "whether pixels follow the field or go straight along their vector [default "
                     "integrated]"});
  table.add({.name = "search",
             .type = Type::choice,
             .choices = {"far", "none"},
             .group = "Pictures",
             .help = "far: where pixels are left that do not fit, motions up to 0.3 of the sides are searched for, and "
                     "small things may move beside them [default far; none with --preset thesis, other --scales and "
                     "--alignment forward]"});
  table.add({.name = "flow",
             .type = Type::path,
             .metavar = "FILE",
             .group = "Pictures",
             .help = "follow this field and look for none: .flo (Middlebury), .png (KITTI) or .exr",
             .details = "It says where each pixel of the first goes; where it is not known that of "
                        "the nearest pixel counts."});
}

void add_options_for_models(OptionTable& table) {
  using Type = Option::Type;
  table.add({.name = "basis",
             .type = Type::choice,
             .choices = {"vertex", "triangle", "gradient", "whitney"},
             .metavar = "BASIS",
             .group = "Models",
             .help = "of fields on triangles: vertex, triangle, gradient or whitney [default a vector per texel for "
                     "textures, vertex for colours of vertices]",
             .details = "All but vertex are solved by factorisations. Of textures triangles are cut for them."});
  table.add({.name = "longest-edge",
             .type = Type::number,
             .unit = "texels",
             .least = 0.25,
             .most = 64,
             .group = "Models",
             .help = fmt::format("of textures: triangles are cut until no edge is longer, and the field is found on "
                                 "them [default with --basis, --scales full or --preset thesis {}, more where that "
                                 "makes more than {:g} million vertices]",
                                 as_typed(usual_longest_edge), ModelPair::quick_vertices * 1e-6)});
}

}  // namespace

void add_flow_options(OptionTable& table) {
  add_model_options(
      table, "the first picture, or a model: OBJ, PLY, glTF or GLB",
      "the second picture; for a model the pictures of both, first all of the first, or "
      "a second PLY with colours at the same vertices");
  const std::string group = "Flow";
  add_scale_options(table, group);
  add_correction_options(table, group);
  add_options_for_pictures(table);
  add_options_for_models(table);
  add_vertices_option(table, "colours at vertices, though there are textures");
  add_space_option(table);
}

ImageFlowOptions image_flow_options(const OptionValues& options) {
  for (const char* name : {"basis", "longest-edge", "vertices", "weld", "flipped", "slot", "uv-set"})
    refuse(options, name, "models, and these are pictures");
  refuse(options, "layer", "models; of pictures the colour layer is taken");
  if (options.has("flow"))
    for (const char* name : {"preset", "alignment", "largest", "smallest", "robust-smoothness",
                             "steps", "scales", "gradients", "paths", "search"})
      require(!asks_for(options, name),
              fmt::format("--{}: says how a field is looked for, and --flow gives one", name));
  const bool thesis = options.text("preset") == "thesis";
  ImageFlowOptions flow = thesis ? ImageFlowOptions::thesis() : ImageFlowOptions();
  if (options.has("scales")) {
    const std::string scales = options.text("scales");
    flow.scales = scales == "full"     ? ImageFlowOptions::Scales::full
                  : scales == "single" ? ImageFlowOptions::Scales::single
                                       : ImageFlowOptions::Scales::hierarchical;
  }
  if (options.has("paths"))
    flow.path = options.text("paths") == "straight" ? FlowPath::straight : FlowPath::integrated;
  if (options.has("search")) flow.search = options.text("search") == "far" ? FlowSearch::far : FlowSearch::none;
  if (options.has("light"))
    flow.light = options.text("light") == "matched" ? ImageLight::matched
                 : options.text("light") == "kept"  ? ImageLight::kept
                                                    : ImageLight::doubted;
  take_common(options, flow);
  return flow;
}

void require_scales(const OptionValues& options, const ImageFlowOptions& flow, int width,
                    int height) {
  if (!options.has("smallest") || flow.scales == ImageFlowOptions::Scales::single) return;
  const SurfaceScale scale{.area = double(width) * height, .texel_spacing = 1};
  const double smallest = std::sqrt(weight_from_length(flow.smallest, scale));
  const double largest = std::sqrt(weight_from_length(flow.largest, scale));
  require(smallest <= largest * 1.001,
          fmt::format("--smallest: found {:.4g} pixels, which is above the largest scale, {:.4g} "
                      "pixels: give --largest at least that",
                      smallest, largest));
}

ModelFlowOptions model_flow_options(const OptionValues& options) {
  refuse(options, "paths", "pictures; on a model they always follow the field");
  refuse(options, "search", "pictures; on a model --largest says how far motions are looked for");
  refuse(options, "flow", "pictures; on a model the field is always looked for");
  refuse(options, "light",
         "pictures; on a model --detail leaves light out, and each signal has variance 1");
  const std::string name = options.has("basis") ? options.text("basis") : "vertex";
  const FlowBasis basis = name == "triangle"   ? FlowBasis::triangle
                          : name == "gradient" ? FlowBasis::gradient
                          : name == "whitney"  ? FlowBasis::whitney
                                               : FlowBasis::vertex;
  ModelFlowOptions flow;
  const bool thesis = options.text("preset") == "thesis";
  if (thesis) static_cast<MeshFlowOptions&>(flow) = thesis_flow(basis);
  flow.basis = basis;
  const std::string scales = options.has("scales") ? options.text("scales") : "";
  require(scales != "single",
          "--scales single is for pictures; on a model give --largest and "
          "--smallest the same length");
  require(!thesis || scales != "hierarchical",
          "--scales hierarchical: the weights of --preset thesis mean another smoothness on each coarser mesh; leave one "
          "of the two away");
  if (!scales.empty()) flow.solver = scales == "full" ? FlowSolver::direct : FlowSolver::hierarchical;
  take_common(options, flow);
  if (options.has("longest-edge"))
    flow.longest_edge = options.number("longest-edge");
  else if (flow.solver == FlowSolver::direct || flow.thesis || options.has("basis"))
    flow.longest_edge = usual_longest_edge;
  return flow;
}

Json flow_json(const ImageFlow& flow) {
  Json levels = Json::array();
  for (const ImageFlowLevel& level : flow.levels)
    levels.push_back({{"length", level.length},
                      {"smoothed", level.deviation},
                      {"width", level.width},
                      {"height", level.height},
                      {"steps", level.steps},
                      {"cycles", level.cycles},
                      {"scale", level.scale},
                      {"before", level.before},
                      {"after", level.after},
                      {"seconds", level.seconds}});
  double sum = 0;
  for (std::int64_t p = 0; p < flow.field.pixel_count(); ++p)
    sum += std::hypot(flow.field.values()[2 * std::size_t(p)],
                      flow.field.values()[2 * std::size_t(p) + 1]);
  Json result = {{"error", flow.error},
                 {"levels", levels},
                 {"longest", longest(flow.field)},
                 {"mean", sum / double(flow.field.pixel_count())}};
  if (flow.fit) {
    result["torn"] = flow.fit->torn;
    result["unfit"] = flow.fit->unfit;
    result["unrelated"] = flow.fit->unrelated;
    result["alike"] = flow.fit->alike;
    result["bend"] = flow.fit->bend;
    result["strained"] = flow.fit->strained;
    result["light"] = flow.fit->light == ImageLight::matched  ? "matched"
                      : flow.fit->light == ImageLight::evened ? "evened"
                                                              : "kept";
    if (flow.fit->light == ImageLight::evened) result["light_ratio"] = flow.fit->ratio.size;
  }
  return result;
}

Json flow_json(const MeshFlow& flow) {
  Json levels = Json::array();
  for (const MeshFlowLevel& level : flow.levels)
    levels.push_back({{"length", level.length},
                      {"vertices", level.vertices},
                      {"unknowns", level.unknowns},
                      {"steps", level.steps},
                      {"cycles", level.cycles},
                      {"scale", level.scale},
                      {"change", {{"data", level.change.data}, {"smoothness", level.change.smoothness}}},
                      {"smoothness", level.smoothness},
                      {"smooth_seconds", level.smooth_seconds},
                      {"build_seconds", level.build_seconds},
                      {"solve_seconds", level.solve_seconds},
                      {"warp_seconds", level.warp_seconds}});
  double most = 0, sum = 0;
  const Eigen::Index triangles = flow.field.size() / 2;
  for (Eigen::Index t = 0; t < triangles; ++t) {
    const double length = flow.field.segment<2>(2 * t).norm();
    most = std::max(most, length);
    sum += length;
  }
  return {{"error", flow.errors()},
          {"levels", levels},
          {"longest", most},
          {"mean", triangles > 0 ? sum / double(triangles) : 0}};
}

}  // namespace mq::app
