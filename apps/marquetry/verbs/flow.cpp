// marquetry flow A.png B.png -o DIR, marquetry flow MESH A.png B.png -o DIR: the vector field along
// which two signals meet. The mathematics is in flow/.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "options/signal_options.h"
#include "options/flow_options.h"
#include "verbs/shared/flow_pair.h"
#include "mq/base/error.h"
#include "mq/draw/contact_sheet.h"
#include "mq/draw/false_colour.h"
#include "mq/draw/flow_colour.h"
#include "mq/flow/flow_errors.h"
#include "mq/io/atomic_file.h"
#include "mq/io/flow_file.h"
#include "mq/io/path_status.h"
#include "mq/io/vector_field.h"
#include "shell/results.h"
#include "shell/verb.h"

namespace mq::app {
namespace {

namespace fs = std::filesystem;

/// The folder for all that is written.
fs::path folder_of(const OptionValues& options) {
  const fs::path folder = options.text("output");
  require(!folder.has_extension() || is_folder(folder),
          fmt::format("--output: found '{}', wanted a folder: several files are written",
                      folder.string()));
  return folder;
}

void write_report(Run& run, const fs::path& path) {
  const std::string text = json_text(run.report());
  write_file(path, std::as_bytes(std::span(text.data(), text.size())));
}

double root_mean_square(std::span<const float> a, std::span<const float> b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (double(b[i]) - a[i]) * (double(b[i]) - a[i]);
  return std::sqrt(sum / double(std::max<std::size_t>(1, a.size())));
}

/// √ of the mean square over channels, per pixel.
Image<float> distances(const Image<float>& a, const Image<float>& b) {
  Image<float> result(a.width(), a.height(), 1);
  for (int y = 0; y < a.height(); ++y)
    for (int x = 0; x < a.width(); ++x)
      result(x, y) = float(root_mean_square(a.pixel(x, y), b.pixel(x, y)));
  return result;
}

/// How far apart the pictures are before and after, in the same colours.
Image<float> error_sheet(const Image<float>& before, const Image<float>& after) {
  const double most = *std::ranges::max_element(before.values());
  const FalseColour scale{.low = 0, .high = most > 0 ? most : 1};
  LegendOptions legend_options;
  legend_options.height = std::clamp(before.height(), 160, 500);
  return contact_sheet({{false_colour(before, scale), "linear blend"},
                        {false_colour(after, scale), "along the flow"},
                        {legend(scale, legend_options), ""}},
                       {.columns = 3});
}

/// The field and the true one in the same colours, and how far their ends lie apart.
Image<float> truth_sheet(const Image<float>& field, const Image<float>& truth) {
  const double most = std::max(longest(field), longest(truth));
  const Image<float> errors = endpoint_errors(field, truth);
  std::vector<float> known;
  std::ranges::copy_if(errors.values(), std::back_inserter(known),
                       [](float value) { return std::isfinite(value); });
  // A few pixels at edges must not decide for all.
  const auto high = known.begin() + std::ssize(known) * 99 / 100;
  std::ranges::nth_element(known, high);
  const FalseColour scale{.low = 0, .high = *high > 0 ? *high : 1};
  LegendOptions legend_options;
  legend_options.height = std::clamp(field.height(), 160, 500);
  return contact_sheet({{flow_picture(field, most), "field"},
                        {flow_picture(truth, most), "truth"},
                        {flow_wheel(most), ""},
                        {false_colour(errors, scale), "apart, pixels"},
                        {legend(scale, legend_options), ""}},
                       {.columns = 3});
}

Json truth_json(const FlowErrors& errors) {
  return {{"pixels", errors.pixels},
          {"endpoint", errors.endpoint},
          {"endpoint_rms", errors.endpoint_root_mean_square},
          {"angular", errors.angular},
          {"outliers", errors.outliers}};
}

/// Says which results of an earlier run, of names that this one has not, lie among its own.
void remark_stale(Run& run, const fs::path& folder, const std::vector<fs::path>& written) {
  std::string stale;
  for (const char* name : {"field.flo", "field.png", "field.exr", "field.vf", "colours.png",
                           "error.png", "error.ply", "error", "blend.png", "blend.exr",
                           "halfway.png", "halfway.exr", "halfway.ply", "halfway", "truth.png"}) {
    const fs::path path = folder / name;
    std::error_code ignored;
    const bool own = std::ranges::any_of(
        written, [&](const fs::path& one) { return one == path || one.parent_path() == path; });
    if (!own && fs::exists(path, ignored)) stale += (stale.empty() ? "" : ", ") + path.string();
  }
  if (!stale.empty()) run.terminal().remark("not of this run, but there from before: " + stale);
}

/// What people want to know at once.
void print_result(Run& run, double before, double after) {
  const Json& error = run.result["error"];
  run.print(
      fmt::format("error {:.4g} to {:.4g} of the signals' variance; difference {:.4g} to {:.4g} "
                  "(root mean square); longest vector {:.4g}\n",
                  error.front().get<double>(), error.back().get<double>(), before, after,
                  run.result["longest"].get<double>()));
}

/// Of pictures like this one: .png, or .exr for what that does not hold.
std::string extension_for(const Texture& texture) {
  const Depth depth = texture.format.depth;
  const bool floats = depth == Depth::half || depth == Depth::f32;
  return floats || texture.pixels.channels() > 4 ? ".exr" : ".png";
}

Exit flow_pictures(Run& run) {
  const OptionValues& options = run.options();
  const ImageFlowOptions how = image_flow_options(options);
  const fs::path folder = folder_of(options);
  const AskedPictures asked(run);
  const PicturePair& pair = asked.pair();
  require_scales(options, how, pair.first().width(), pair.first().height());
  const std::optional<Image<float>> truth = asked.field_of(run, "truth");
  const std::string mixed = extension_for(pair.model().textures.front());
  std::vector<fs::path> paths = {folder / ("field." + options.text("format")),
                                 folder / "colours.png",
                                 folder / "error.png",
                                 folder / ("blend" + mixed),
                                 folder / ("halfway" + mixed),
                                 folder / "report.json"};
  if (truth) paths.push_back(folder / "truth.png");
  run.will_write(paths, folder);
  if (run.dry_run()) return Exit::done;

  ImageFlow flow;
  {
    const Step step(run, "align", 0.8);
    flow = asked.align(run, how, step);
  }
  const Step step(run, "write", 0.1);
  const AlignedImages met = aligned(flow, pair.first(), pair.second());
  const double before = root_mean_square(pair.first().values(), pair.second().values());
  const double after = root_mean_square(met.source.values(), met.target.values());
  run.result["difference"] = {before, after};
  const Image<float> field = forward_displacement(flow);
  for (const std::string& note : write_flow(paths[0], field)) run.terminal().remark(note);
  write_image(paths[1], flow_picture_with_wheel(field, longest(field)));
  write_image(paths[2], error_sheet(distances(pair.first(), pair.second()),
                                    distances(met.source, met.target)));
  const Image<float> still(field.width(), field.height(), 2);
  for (const bool moved : {false, true}) {
    ImageFlow along = flow;
    if (!moved) along.field = still;
    Texture middle = pair.stored(pair.between(along, 0.5));
    // Of another format's tags none says what is written; in an EXR they name the channels.
    if (middle.format.file_format != "openexr") middle.format.tags = nullptr;
    for (const std::string& note : write_texture(paths[moved ? 4 : 3], middle))
      run.terminal().remark(note);
  }
  if (truth) {
    const FlowErrors errors = flow_errors(field, *truth);
    run.result["truth"] = truth_json(errors);
    write_image(paths[6], truth_sheet(field, *truth));
    run.print(
        fmt::format("beside the true field: endpoint error {:.4g} pixels, angular error {:.4g} "
                    "degrees, {:.2f} % "
                    "of {} pixels off by more than 3 and 5 %\n",
                    errors.endpoint, errors.angular, 100 * errors.outliers, errors.pixels));
  }
  say_written(run, paths);
  remark_stale(run, folder, paths);
  write_report(run, paths[5]);
  print_result(run, before, after);
  return Exit::done;
}

/// A row's root mean square difference per unknown, as one column.
Vector distances(const Signal& a, const Signal& b) {
  return ((b - a).rowwise().squaredNorm() / double(std::max<Eigen::Index>(1, a.cols())))
      .cwiseSqrt();
}

Exit flow_model(Run& run) {
  const OptionValues& options = run.options();
  require(!asks_for(options, "format"),
          "--format is for pictures; on a model fields are .vf files");
  require(!options.has("truth"), "--truth is for pictures");
  const ModelFlowOptions how = model_flow_options(options);
  const fs::path folder = folder_of(options);
  const AskedModels asked(run);
  const ModelPair& pair = asked.pair();
  // Pictures of the model go by their own names, so the two kinds lie in folders of their own.
  const bool vertices = pair.at_vertices();
  const Model& model = asked.model();
  const auto outputs_in = [&](const char* what) {
    return Outputs(vertices ? (folder / (std::string(what) + ".ply")).string()
                            : (folder / what).string() + "/",
                   model, vertices ? Outputs::Kind::model : Outputs::Kind::pictures);
  };
  std::vector<fs::path> paths = {folder / "field.vf", folder / "report.json"};
  run.will_write(paths, folder);
  const Outputs halfway = outputs_in("halfway"), error = outputs_in("error");
  for (const Outputs* outputs : {&halfway, &error}) {
    run.will_write(outputs->paths(), outputs->folders());
    paths.insert(paths.end(), outputs->paths().begin(), outputs->paths().end());
  }
  if (run.dry_run()) return Exit::done;

  const ModelPairFlow flow = [&] {
    const Step step(run, "align", asked.share_of_align());
    return asked.align(run, how, step);
  }();
  const Step step(run, "write", 0.2);
  const WarpedPair met = flow.warp_pair(0.5, step.progress().step("meet", 0.5));
  const Vector before = distances(pair.first(), pair.second()),
               after = distances(met.source, met.target);
  const double mean_before = std::sqrt(before.squaredNorm() / double(before.size()));
  const double mean_after = std::sqrt(after.squaredNorm() / double(after.size()));
  run.result["difference"] = {mean_before, mean_after};
  if (mean_after > mean_before)
    run.terminal().warning(fmt::format(
        "along the field the two differ by more than mixed as they lie ({:.4g}, {:.4g}): "
        "{}",
        mean_after, mean_before,
        "try another --largest, or --detail 0"));
  write_vector_field(paths[0], asked.surface().mesh, flow.field());
  halfway.write(pair.with(0.5 * (met.source + met.target), 0.5),
                step.progress().step("halfway", 0.2));
  {
    Model differences = model;
    const double most = before.size() > 0 ? before.maxCoeff() : 0;
    pair.target().replace(
        false_colours(after, {.low = 0, .high = most > 0 ? most : 1}), Depth::u8, differences);
    error.write(std::move(differences), step.progress().step("error", 0.2));
  }
  say_written(run, paths);
  remark_stale(run, folder, paths);
  write_report(run, paths[1]);
  print_result(run, mean_before, mean_after);
  return Exit::done;
}

Exit run_flow(Run& run) {
  return is_picture_pair(run.options()) ? flow_pictures(run) : flow_model(run);
}

}  // namespace

Verb flow_verb() {
  using Type = Option::Type;
  OptionTable table(
      "flow",
      "Find the vector field along which two pictures, textures or colourings of a model "
      "meet: optical flow.");
  table.example("first.png second.png -o flow/", "how a picture becomes another");
  table.example("bust.obj first.png second.png -o flow/", "the same on a surface");
  add_flow_options(table);
  table.add({.name = "output",
             .letter = 'o',
             .type = Type::path,
             .required = true,
             .metavar = "DIR",
             .help =
                 "a folder for the field, its colours, what is left of the difference, the halfway "
                 "picture and the report"});
  table.add({.name = "format",
             .type = Type::choice,
             .default_value = "flo",
             .choices = {"flo", "png", "exr"},
             .group = "Pictures",
             .help = "of the field: .flo (Middlebury), .png (KITTI) or .exr"});
  table.add({.name = "truth",
             .type = Type::path,
             .metavar = "FILE",
             .group = "Pictures",
             .help = "the true field, .flo, .png (KITTI) or .exr: the report says how far the one "
                     "found is from it"});
  add_frames_option(table);
  return {table, run_flow,
          {{.what = "optical flow", .textures = "yes, across seams"}}};
}

}  // namespace mq::app
