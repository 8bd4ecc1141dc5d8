// What a verb does is a few calls of the library: the same calls give the same files, byte for
// byte.

#include <gtest/gtest.h>

#include <cmath>

#include "model/program_files.h"
#include "mq/base/error.h"
#include "mq/baseline/reference_solver.h"
#include "mq/draw/false_colour.h"
#include "mq/filter/denoise.h"
#include "mq/filter/line_integral.h"
#include "mq/filter/pattern_growth.h"
#include "mq/filter/seam_values.h"
#include "mq/filter/stitch.h"
#include "mq/io/image_file.h"
#include "mq/mesh/closest_point.h"
#include "mq/model/texture_fill.h"
#include "mq/model/field_lines.h"
#include "mq/model/model_field.h"
#include "mq/model/model_signal.h"
#include "mq/model/model_sources.h"
#include "mq/model/outputs.h"
#include "mq/model/solving.h"
#include "mq/model/stitch_regions.h"

namespace mq {
namespace {

using test::Folder;
using test::marquetry;

/// The strip, and what the program writes for it as out.FORMAT.
struct Strip : TwoCharts {
  using TwoCharts::TwoCharts;

  TextureSignal signal(const TextureSignalOptions& options = {}) {
    return TextureSignal(model, options, messages);
  }

  std::string of_program(std::vector<std::string> words, const std::string& file = "out.png") {
    words.insert(words.begin() + 1, "strip.obj");
    words.insert(words.end(), {"-o", file});
    const test::Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 0) << result.error;
    return test::file_bytes(folder / file);
  }

  /// What the library's result becomes as a file.
  std::string of_library(const std::string& file = "ours.png") {
    Outputs(folder / file, model.model, Outputs::Kind::pictures).write(model.model, {});
    return test::file_bytes(folder / file);
  }
};

double weight(const ModelSignal& signal, const std::string& length) {
  return weight_from_length(parse_length(length), signal.space().scale());
}

TEST(VerbFilter, IsAScreenedPoissonEquationOfTheModelsSignal) {
  Strip strip;
  const std::string wanted = strip.of_program({"filter", "-b", "3", "-l", "2tx", "--halo", "inf"});
  const TextureSignal signal = strip.signal();
  const Signal before = signal.values();
  signal.put(before, ScreenedPoisson(signal.space(), weight(signal, "2tx")).solve(before, 3).signal,
             strip.model.model);
  EXPECT_EQ(strip.of_library(), wanted);
}

TEST(VerbFilter, WorksOnLightAndOnNormalsByValueSpaces) {
  for (const char* space : {"linear", "log"}) {
    Strip strip;
    const std::string wanted =
        strip.of_program({"filter", "-b", "0", "-l", "2tx", "--space", space});
    ValueSpace values{.space = *space == 'l' && space[1] == 'o' ? ColourSpace::log
                                                                : ColourSpace::linear};
    const TextureSignal signal = strip.signal({.values = values});
    const Signal before = signal.values();
    signal.put(before,
               ScreenedPoisson(signal.space(), weight(signal, "2tx")).solve(before, 0).signal,
               strip.model.model);
    EXPECT_EQ(strip.of_library(), wanted) << space;
  }
}

TEST(VerbFilter, WorksOnAPictureAsOnASurface) {
  const Folder folder;
  write_image(folder / "photo.png", test::busy_picture(40, 30));
  const test::Result result =
      marquetry(folder, {"filter", "photo.png", "-b", "0", "-l", "3tx", "-o", "out.png"});
  ASSERT_EQ(result.status, 0) << result.error;
  const ImageSpace space(40, 30);
  Texture texture = read_texture(folder / "photo.png");
  const Signal before = space.gather({&texture.pixels, 1});
  space.scatter(smooth(space, before, parse_length("3tx")).signal, {&texture.pixels, 1});
  write_texture(folder / "ours.png", texture);
  EXPECT_EQ(test::file_bytes(folder / "ours.png"), test::file_bytes(folder / "out.png"));
}

TEST(VerbFilter, SmoothsColoursAtVertices) {
  const Folder folder;
  test::write_bytes(folder / "fan.ply", test::coloured_ply);
  const test::Result result =
      marquetry(folder, {"filter", "fan.ply", "-b", "0", "-l", "20%", "-o", "out.ply"});
  ASSERT_EQ(result.status, 0) << result.error;
  Messages messages;
  TexturedModel model = load_textured_model(folder / "fan.ply", {}, messages);
  const VertexColourSignal signal(model);
  const Signal before = signal.values();
  signal.put(before, ScreenedPoisson(signal.space(), weight(signal, "20%")).solve(before, 0).signal,
             model.model);
  write_model(folder / "ours.ply", model.model);
  EXPECT_EQ(test::file_bytes(folder / "ours.ply"), test::file_bytes(folder / "out.ply"));
}

TEST(VerbFilter, IsAsThePublishedSolverHasItWhereThatIsGiven) {
  Strip strip;
  const std::string wanted =
      strip.of_program({"filter", "-b", "3", "-l", "2tx", "--halo", "inf", "--solver", "reference"});
  const TextureSignal signal = strip.signal();
  const Signal before = signal.values();
  const SolverChoice choice{.kind = SolverChoice::Kind::given,
                            .factory = reference_solver(signal.space().texels())};
  Signal after;
  const SolveOutcome outcome = solve_with(
      choice, signal.space(),
      [&](const SolverFactory& factory, int) {
        const Filtered found =
            ScreenedPoisson(signal.space(), weight(signal, "2tx"), factory).solve(before, 3);
        after = found.signal;
        return found.report;
      },
      strip.messages);
  EXPECT_TRUE(outcome.report.converged);
  EXPECT_TRUE(outcome.tried.empty());
  signal.put(before, after, strip.model.model);
  EXPECT_EQ(strip.of_library(), wanted);
}

TEST(VerbDenoise, IsTheLibrarysDenoise) {
  Strip strip;
  const std::string wanted = strip.of_program({"denoise", "-l", "2tx", "--edge", "0.1"});
  const TextureSignal signal = strip.signal();
  const Signal before = signal.values();
  const Filtered found =
      denoise(signal.space(), before, {}, {.weight = weight(signal, "2tx"), .edge = 0.1});
  signal.put(before, found.signal, strip.model.model);
  EXPECT_EQ(strip.of_library(), wanted);
}

TEST(VerbGeodesic, MeasuresFromTheUnknownsAroundAPoint) {
  Strip strip(MissingPictures::assume);
  const std::string wanted = strip.of_program({"geodesic", "--from", "0.3,0.4,0"}, "out.exr");
  const TextureSignal signal =
      strip.signal({.shared = TextureSignalOptions::SharedTexels::one_for_each,
                    .pictures = TextureSignalOptions::Pictures::replaced});
  const ClosestPoint place = ClosestPointFinder(strip.model.surface.mesh)({0.3, 0.4, 0});
  const Geodesic found =
      GeodesicDistance(signal.space()).from(sources_at_point(strip.model, signal, place));
  signal.replace(found.distance, Depth::f32, strip.model.model);
  EXPECT_EQ(strip.of_library("ours.exr"), wanted);
  signal.replace(
      distance_colours(found.distance, {.most = signal.space().largest_shown(found.distance),
                                        .line_width = 1.5 * signal.scale().texel_spacing}),
      Depth::u8, strip.model.model);
  EXPECT_EQ(strip.of_library(), strip.of_program({"geodesic", "--from", "0.3,0.4,0"}));
}

TEST(VerbLic, SpreadsNoiseAlongAField) {
  Strip strip;
  const std::string wanted = strip.of_program({"lic", "--field", "gradient", "--over", "nothing"});
  const std::string over = strip.of_program({"lic", "--field", "gradient"}, "over.png");
  const TextureSignal signal = strip.signal();
  const ModelField found = model_field(
      strip.model, signal, {.kind = FieldRequest::Kind::gradient, .strength = FieldRequest::Strength::unit});
  const SurfaceScale scale = signal.space().scale();
  const double grain = usual_grain(signal.space());
  const Signal noise = solid_noise(signal.space().positions(), grain);
  const FieldLinesOptions usual;
  const LineIntegral lines =
      line_integral(*signal.space_across(found.field, usual.kappa), signal.space(), noise,
                    suiting(usual.alpha * scale.area, grain),
                    signal.space().solver());
  const Signal colours = signal.values(), grey = with_contrast(lines.signal);
  signal.put(colours, lines_over(colours, grey, 3), strip.model.model);
  EXPECT_TRUE(strip.of_library("ours_over.png") == over);
  signal.replace(grey.replicate(1, 3), Depth::u8, strip.model.model);
  EXPECT_TRUE(strip.of_library() == wanted);
}

TEST(VerbReact, GrowsThePresetFromSeeds) {
  Strip strip(MissingPictures::assume);
  const std::string wanted = strip.of_program({"react", "--time", "40", "-s", "8tx"}, "out.exr");
  const TextureSignal signal = strip.signal({.pictures = TextureSignalOptions::Pictures::replaced});
  const double wave = std::sqrt(weight(signal, "8tx"));
  const GrayScottPreset& spots = gray_scott_presets().front();
  ASSERT_EQ(spots.name, "spots");
  const PatternGrowth growth(signal.space(), &strip.model.surface, {}, diffusivities(spots, wave), wave, 40);
  const Substances state = growth.grow(gray_scott(spots.rates), growth.seeds(0));
  Signal second(signal.space().size(), 1);
  for (int i = 0; i < signal.space().size(); ++i) second(i, 0) = state[std::size_t(2 * i + 1)];
  signal.replace(second, Depth::f32, strip.model.model);
  spread_past_charts(signal.texels(), strip.model);
  EXPECT_TRUE(strip.of_library("ours.exr") == wanted);
}

TEST(VerbStitch, KeepsGradientsOfChartsAndNoStepsBetweenThem) {
  Strip strip;
  const std::string wanted = strip.of_program({"stitch", "-a", "100"});
  const TextureSignal signal = strip.signal();
  const Signal before = signal.values();
  const Stitcher stitcher(signal.space(), 100 * signal.space().scale().area,
                          signal.space().texels().chart);
  signal.put(before, stitcher.stitch(before, {}, stitcher.levels(before, LightLaw::display)).signal, strip.model.model);
  EXPECT_EQ(strip.of_library(), wanted);
}

TEST(VerbStitch, TakesRegionsFromLabels) {
  Strip strip;
  const Image<float>& picture = strip.model.model.textures[0].pixels;
  Image<float> labels(picture.width(), picture.height(), 1);
  for (int y = 0; y < labels.height(); ++y)
    for (int x = 0; x < labels.width(); ++x)
      labels(x, y) =
          float(y < labels.height() / 3 ? 9 : 100 * (1 + (2 * x > labels.width()))) / 255;
  write_image(strip.folder / "labels.png", labels);
  const std::string wanted =
      strip.of_program({"stitch", "--labels", "labels.png", "--unseen", "9", "-a", "100"});
  const TextureSignal signal = strip.signal();
  const StitchRegions regions =
      regions_of_labels(strip.model, signal, {{read_texture(strip.folder / "labels.png")}},
                        std::vector<double>{9}, strip.messages);
  EXPECT_EQ(regions.count(), 2);
  EXPECT_GT(regions.count_unseen(), 0);
  const Stitcher stitcher(signal.space(), 100 * signal.space().scale().area, regions.labels);
  const RegionLevels levels = stitcher.levels(regions.values, LightLaw::display);
  signal.put(regions.values, stitcher.stitch(regions.values, {}, levels).signal, strip.model.model);
  spread_past_unseen(regions.labels, signal.space(), strip.model, strip.model.model);
  EXPECT_TRUE(strip.of_library() == wanted);
}

TEST(StitchRegions, RefuseLabelsThatSayNothingForSure) {
  Strip strip;
  const TextureSignal signal = strip.signal();
  Texture labels = strip.model.model.textures[0];
  EXPECT_THROW(
      regions_of_labels(strip.model, signal, {{labels}}, std::vector<double>{1, 2}, strip.messages),
      InvalidInput);
  EXPECT_THROW(wanted_photographs(signal, strip.model.texture_sizes, {{labels}}, 1), InvalidInput);
  labels.format.file_format = "jpeg";
  EXPECT_THROW(regions_of_labels(strip.model, signal, {{labels}}, {}, strip.messages),
               InvalidInput);
}

TEST(VerbSeams, SmoothsTheChangeAtSeamTexels) {
  Strip strip;
  const std::string wanted = strip.of_program({"seams"});
  const TextureSignal signal = strip.signal({.space = soft_seams(*strip.model.atlas)});
  const Signal before = signal.values();
  const std::vector<char> free =
      seam_texels(strip.model.surface, *strip.model.atlas, signal.space());
  signal.put(before, smooth_at_seams(signal.space(), before, free, Smooth::change).signal,
             strip.model.model);
  EXPECT_EQ(strip.of_library(), wanted);
}

// ---- What the model room promises besides ----

TEST(TextureSignal, GivesBackTheBitsOfWhatDidNotChange) {
  Strip strip;
  const std::string source = test::file_bytes(strip.folder / "strip.png");
  const TextureSignal signal = strip.signal({.values = {.space = ColourSpace::log}});
  const Signal values = signal.values();
  signal.put(values, values, strip.model.model);
  EXPECT_EQ(strip.of_library(), source);
}

TEST(TextureSignal, EncodesOnlyTheTexelsThatChanged) {
  Strip strip;
  const Image<float> before = strip.model.model.textures[0].pixels;
  const TextureSignal signal = strip.signal({.values = {.space = ColourSpace::linear}});
  const Signal values = signal.values();
  Signal changed = values;
  changed(7, 0) = 0.25;
  signal.put(values, changed, strip.model.model);
  const Texels::Place at = signal.space().texels().places[7];
  const Image<float>& after = strip.model.model.textures[0].pixels;
  for (int y = 0; y < after.height(); ++y)
    for (int x = 0; x < after.width(); ++x)
      for (int c = 0; c < 3; ++c)
        if (x != at.x || y != at.y || c != 0) {
          // The other channels of that texel come back by the way there and back.
          const float tolerance = x == at.x && y == at.y ? 1e-6F : 0.0F;
          ASSERT_NEAR(after(x, y, c), before(x, y, c), tolerance);
        }
  EXPECT_NEAR(after(at.x, at.y, 0), srgb_from_linear(0.25), 1e-6);
}

TEST(TexturedModel, TakesAPictureForAFlatSurfaceOfOneChart) {
  const Folder folder;
  write_image(folder / "photo.png", test::busy_picture(20, 10));
  Messages messages;
  const TexturedModel model = load_textured_model(folder / "photo.png", {}, messages);
  EXPECT_TRUE(model.is_picture);
  EXPECT_EQ(model.atlas->charts.size(), 1U);
  EXPECT_EQ(TextureSignal(model, {}, messages).space().size(), 200);
  EXPECT_THROW(
      load_textured_model(folder / "photo.png", {.missing = MissingPictures::unneeded}, messages),
      IoError);
  EXPECT_THROW(Outputs(folder / "out.obj", model.model, Outputs::Kind::pictures), InvalidInput);
}

/// Never reaches a tolerance.
class Idle final : public LinearSolver {
 public:
  SolveReport solve(const Signal&, Signal&, const Progress&) const override {
    return {.method = "idle", .cycles = 3, .residuals = {1, 0.5}, .converged = false};
  }
  void update(const SparseMatrix&, const Progress&) override {}
};

/// What was said.
class Heard final : public Messages {
 public:
  void remark(const std::string& text) override { remarks.push_back(text); }
  void warning(const std::string& text) override { warnings.push_back(text); }
  std::vector<std::string> remarks, warnings;
};

TEST(SolveWith, WarnsWhereTheGivenSolverFallsShort) {
  Strip strip;
  const TextureSignal signal = strip.signal();
  Heard heard;
  const SolverChoice choice{
      .kind = SolverChoice::Kind::given,
      .factory = [](const SparseMatrix&, const Progress&) { return std::make_unique<Idle>(); }};
  int attempts = 0;
  const Attempt attempt = [&](const SolverFactory& factory, int) {
    ++attempts;
    const auto solver = factory(signal.space().mass(), {});
    Signal x = Signal::Zero(signal.space().size(), 1);
    return solver->solve(x, x);
  };
  EXPECT_FALSE(solve_with(choice, signal.space(), attempt, heard).report.converged);
  EXPECT_EQ(attempts, 1);
  ASSERT_EQ(heard.warnings.size(), 1U);
  EXPECT_NE(heard.warnings[0].find("less accurate than asked for"), std::string::npos);
}

TEST(SolveWith, FactorisesWhereMultigridFallsShort) {
  const Folder folder;
  write_image(folder / "photo.png", test::busy_picture(200, 180));
  Heard heard;
  const TexturedModel model = load_textured_model(folder / "photo.png", {}, heard);
  const TextureSignal signal(model, {}, heard);
  ASSERT_GT(signal.space().size(), most_for_factorisation);
  int attempts = 0;
  const SolveOutcome outcome = solve_with(
      {}, signal.space(),
      [&](const SolverFactory&, int retry) {
        ++attempts;
        SolveReport report{.method = retry == 0 ? "multigrid" : "direct", .residuals = {1, 0.5}};
        report.converged = retry > 0;
        return report;
      },
      heard);
  EXPECT_EQ(attempts, 2);
  EXPECT_EQ(outcome.report.method, "direct");
  ASSERT_EQ(outcome.tried.size(), 1U);
  EXPECT_EQ(outcome.tried[0].report.method, "multigrid");
  EXPECT_TRUE(heard.warnings.empty());
}

TEST(SolveWith, KeepsNothingOfIterationsThatDiverged) {
  Strip strip;
  const TextureSignal signal = strip.signal();
  const SolverChoice choice{.kind = SolverChoice::Kind::multigrid, .stop = {.max_cycles = 3}};
  const Attempt attempt = [](const SolverFactory&, int) {
    return SolveReport{.method = "multigrid",
                       .cycles = 3,
                       .residuals = {1, 1e-6, 1e-3, 1e-4},
                       .error = 7,
                       .converged = false};
  };
  EXPECT_THROW(solve_with(choice, signal.space(), attempt, strip.messages), SolverError);
}

TEST(SolveWith, KeepsWhatALimitedNumberOfCyclesReaches) {
  const Folder folder;
  write_image(folder / "photo.png", test::busy_picture(200, 180));
  Heard heard;
  const TexturedModel model = load_textured_model(folder / "photo.png", {}, heard);
  const TextureSignal signal(model, {}, heard);
  const Signal before = signal.values();
  const SolveOutcome outcome = solve_with(
      {.stop = {.max_cycles = 1}}, signal.space(),
      [&](const SolverFactory& factory, int) {
        return ScreenedPoisson(signal.space(), 1e4, factory).solve(before, 0).report;
      },
      heard);
  EXPECT_EQ(outcome.report.cycles, 1);
  EXPECT_TRUE(outcome.tried.empty());
}

}  // namespace
}  // namespace mq
