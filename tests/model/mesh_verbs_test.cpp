// What verbs of one model do is a few calls of the library: the same calls give the same files,
// byte for byte.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <limits>

#include "model/program_files.h"
#include "mq/draw/texel_maps.h"
#include "mq/fem/field_spectrum.h"
#include "mq/filter/geometry_filter.h"
#include "mq/io/image_file.h"
#include "mq/io/vector_field.h"
#include "mq/model/field_files.h"
#include "mq/model/lossless_textures.h"
#include "mq/model/model_picture.h"
#include "mq/model/moved_vertices.h"
#include "mq/model/outputs.h"
#include "mq/model/photograph_texture.h"
#include "mq/model/photographs.h"
#include "mq/model/remeshed_model.h"
#include "mq/model/texture_fill.h"
#include "mq/model/unwrapped_model.h"

namespace mq {
namespace {

using test::Folder;
using test::marquetry;

/// What the program writes as FILE when it is asked for these words.
std::string of_program(const Folder& folder, std::vector<std::string> words,
                       const std::string& file) {
  words.insert(words.end(), {"-o", file});
  const test::Result result = marquetry(folder, words);
  EXPECT_EQ(result.status, 0) << result.error;
  return test::file_bytes(folder / file);
}

/// What a model becomes as a file of that name.
std::string of_library(const Folder& folder, const Model& model, const std::string& file,
                       Outputs::Kind kind = Outputs::Kind::pictures) {
  Outputs(folder / file, model, kind).write(model, {});
  return test::file_bytes(folder / file);
}

TEST(VerbFill, ContinuesChartsAtTheirBordersAndSpreadsThem) {
  for (const char* distance : {"", "3"}) {
    TwoCharts strip;
    std::vector<std::string> words = {"fill", "strip.obj"};
    FillOptions options;
    if (*distance) words.insert(words.end(), {"--distance", distance}), options.distance = 3;
    const std::string wanted = of_program(strip.folder, words, "out.png");
    const TextureFill fill(strip.model, options, strip.messages);
    EXPECT_GT(fill.border_texels(), 0);
    EXPECT_GT(fill.put(fill.solve(), strip.model.model), 0);
    EXPECT_EQ(of_library(strip.folder, strip.model.model, "ours.png"), wanted);
  }
}

TEST(VerbFill, LetsChartsGoOnByThemselvesInLight) {
  TwoCharts strip;
  const std::string wanted = of_program(
      strip.folder, {"fill", "strip.obj", "--weight", "0", "--space", "linear"}, "out.png");
  const TextureFill fill(strip.model,
                         {.values = {.space = ColourSpace::linear},
                          .weight = 0,
                          .distance = std::numeric_limits<double>::infinity()},
                         strip.messages);
  fill.put(fill.solve(), strip.model.model);
  EXPECT_EQ(of_library(strip.folder, strip.model.model, "ours.png"), wanted);
}

TEST(TextureFill, RefusesAModelWithoutCharts) {
  TwoCharts strip;
  strip.model.atlas.reset();
  EXPECT_THROW(TextureFill(strip.model, {}, strip.messages), InvalidInput);
}

TEST(VerbMask, DrawsWhatTexelsAreUsedFor) {
  const std::vector<std::pair<std::string, TexelUse>> uses = {{"active", TexelUse::active},
                                                              {"boundary", TexelUse::boundary},
                                                              {"chart", TexelUse::chart},
                                                              {"triangle", TexelUse::triangle},
                                                              {"depth", TexelUse::depth}};
  for (const auto& [name, use] : uses) {
    TwoCharts strip(MissingPictures::assume);
    const std::string wanted =
        of_program(strip.folder, {"mask", "strip.obj", "--what", name}, "out.png");
    TexelMaps maps = texel_maps(strip.model.surface, *strip.model.atlas, use);
    EXPECT_GT(maps.marked, 0);
    replace_with_lossless(strip.model.model, std::move(maps.pictures), "mask");
    EXPECT_EQ(of_library(strip.folder, strip.model.model, "ours.png"), wanted) << name;
  }
}

TEST(VerbUnwrap, GivesTheModelTheAtlasOfItsSurface) {
  TwoCharts strip(MissingPictures::unneeded);
  const std::string wanted =
      of_program(strip.folder, {"unwrap", "strip.obj", "--size", "64"}, "out.obj");
  put_unwrapped(unwrap(strip.model.surface, {.width = 64, .height = 64}), strip.model);
  EXPECT_EQ(overlapping_texels(strip.model, {64, 64}), 0);
  EXPECT_EQ(of_library(strip.folder, strip.model.model, "out.obj", Outputs::Kind::model), wanted);
}

TEST(VerbRemesh, CarriesTexturesAndColoursOfBoth) {
  const Folder folder;
  test::write_strip(folder);
  test::write_bytes(folder / "raised.obj",
                    "mtllib strip.mtl\nusemtl strip\n"
                    "v 0 0 0\nv 1 0 0\nv 2 0 0.5\nv 0 1 0\nv 1 1 0\nv 2 1 0.5\n"
                    "vt 0.05 0.1\nvt 0.45 0.1\nvt 0.45 0.9\nvt 0.05 0.9\n"
                    "vt 0.55 0.1\nvt 0.95 0.1\nvt 0.95 0.9\nvt 0.55 0.9\n"
                    "f 1/1 2/2 5/3 4/4\nf 2/5 3/6 6/7 5/8\n");
  Messages messages;
  for (const bool paint : {false, true}) {
    const RemeshInput of_template = remesh_input(read_model(folder / "strip.obj"), messages);
    const RemeshInput target =
        remesh_input(read_model(folder / "raised.obj"), messages, &of_template.model.mesh);
    RemeshedContents contents;
    if (paint) contents = {RemeshedContents::Textures::left_out, RemeshedContents::Colours::origin};
    Model model = begin_remeshed(of_template, target, contents);
    EXPECT_EQ(model.textures.size(), paint ? 0U : 2U);
    finish_remeshed(of_template, target,
                    remesh(of_template.surface, target.surface, {.tolerance = 0.1}), contents,
                    messages, model);
    std::vector<std::string> words = {"remesh", "strip.obj", "raised.obj", "-t", "0.1"};
    if (paint) words.emplace_back("--paint");
    const std::string file = paint ? "out.ply" : "out.glb";
    const std::string wanted = of_program(folder, words, file);
    EXPECT_EQ(of_library(folder, model, "ours" + file.substr(3),
                         paint ? Outputs::Kind::model : Outputs::Kind::pictures),
              wanted);
  }
}

TEST(RemeshInput, RefusesWhatIsNoSurface) {
  Messages messages;
  EXPECT_THROW(remesh_input({}, messages), InvalidInput);
}

TEST(VerbRender, DrawsAViewAPageAndALayout) {
  TwoCharts strip;
  Image<float> other = test::busy_picture(64, 48);
  for (float& value : other.values()) value = 1 - value;
  write_image(strip.folder / "other.png", other);
  const std::vector<Texture> after = {read_texture(strip.folder / "other.png")};
  const ModelRenderer renderer(strip.model);
  ModelPictureOptions options;
  options.render.width = options.render.height = options.layout.side = 80;
  options.render.view = parse_view("corner");
  const auto ours = [&](const Image<float>& picture) {
    write_image(strip.folder / "ours.png", picture);
    return test::file_bytes(strip.folder / "ours.png");
  };
  const auto wanted = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"render", "strip.obj", "-s", "80"});
    return of_program(strip.folder, words, "out.png");
  };
  EXPECT_EQ(ours(renderer.draw(options)), wanted({}));
  EXPECT_EQ(ours(renderer.draw(options, after)), wanted({"--compare", "other.png"}));
  EXPECT_EQ(ours(draw_layout(strip.model, after, options.layout)),
            wanted({"--layout", "--compare", "other.png"}));
  options.page = ModelPictureOptions::Page::overview;
  EXPECT_EQ(ours(renderer.draw(options)), wanted({"--overview"}));
  options.page = ModelPictureOptions::Page::views;
  options.views = {"front", "top"};
  options.render.view = parse_view("front");
  EXPECT_EQ(ours(renderer.draw(options)), wanted({"-v", "front", "-v", "top"}));
  EXPECT_EQ(ours(renderer.draw(options, after)),
            wanted({"-v", "front", "-v", "top", "--compare", "other.png"}));
}

TEST(VerbRender, LooksAtTheWorstSeam) {
  TwoCharts strip;
  const ModelRenderer renderer(strip.model);
  ModelPictureOptions options;
  options.render.width = options.render.height = 80;
  options.render.view.projection = View::Projection::orthographic;
  options.render.view =
      renderer
          .sight_of_seam(texture_seams(strip.model), 16 * strip.model.atlas->texel_spacing(),
                         options.render.view)
          .view;
  write_image(strip.folder / "ours.png", renderer.draw(options));
  EXPECT_EQ(test::file_bytes(strip.folder / "ours.png"),
            of_program(strip.folder,
                       {"render", "strip.obj", "-s", "80", "--at", "seam", "--extent", "16tx",
                        "--projection", "orthographic"},
                       "out.png"));
}

TEST(VerbSpectrum, WritesFieldsAndTheirLines) {
  TwoCharts strip(MissingPictures::assume);
  const test::Result result = marquetry(
      strip.folder, {"spectrum", "strip.obj", "-k", "2", "-b", "vertex", "--lines", "-o", "out/"});
  ASSERT_EQ(result.status, 0) << result.error;
  const FieldSpectrum found =
      field_spectrum(strip.model.surface, {.basis = FieldBasis::vertex, .count = 2});
  const TextureSignal signal(strip.model, {.pictures = TextureSignalOptions::Pictures::replaced},
                             strip.messages);
  const FieldLines lines(signal);
  const std::vector<FieldFile> files =
      field_files(strip.model.model, {.folder = strip.folder / "ours",
                                      .name = "vertex",
                                      .count = 2,
                                      .lines = FieldFilesOptions::Lines::textures});
  std::filesystem::create_directory(strip.folder / "ours");
  for (const std::size_t k : {0, 1}) {
    write_vector_field(files[k].field, strip.model.model.mesh, found.fields[k]);
    write_lines(files[k], strip.model.model, signal,
                lines.draw(normalised(strip.model.surface, found.fields[k])).signal);
    ASSERT_EQ(files[k].paths().size(), 2U);
    for (const std::filesystem::path& path : files[k].paths())
      EXPECT_EQ(test::file_bytes(path),
                test::file_bytes(strip.folder / ("out/" + path.filename().string())));
  }
}

/// The model with what photographs show of it, stitched with the weight 100 at unit area.
void stitch(std::span<const Partial> partials, const TextureSignal& signal, TexturedModel& model) {
  const Signal before = signal.values();
  Composite composite = best_of(partials);
  signal.put(before, composite.values, model.model);
  const Stitcher stitcher(signal.space(), 100 * signal.space().scale().area, composite.labels,
                          signal.space().solver());
  const RegionLevels levels = stitcher.levels(composite.values, LightLaw::display);
  signal.put(composite.values, stitcher.stitch(composite.values, partials, levels).signal, model.model);
}

TEST(VerbStitch, TakesPhotographsAsTextures) {
  TwoCharts strip;
  const Image<float> all = test::busy_picture(64, 48);
  std::vector<Image<float>> confidence;
  for (const int side : {0, 1}) {
    Image<float> picture = all, shown(64, 48, 1);
    for (int y = 0; y < 48; ++y)
      for (int x = 0; x < 64; ++x) {
        for (int c = 0; c < 3; ++c) picture(x, y, c) = picture(x, y, c) / 2 + 0.25F * float(side);
        shown(x, y) = side == 0 ? float(63 - x) / 255 : float(x) / 255;
      }
    write_image(strip.folder / fmt::format("part{}.png", side), picture);
    write_image(strip.folder / fmt::format("shown{}.png", side), shown);
  }
  const std::string wanted =
      of_program(strip.folder,
                 {"stitch", "strip.obj", "--partial", "part0.png", "--partial", "part1.png",
                  "--confidence", "shown0.png", "--confidence", "shown1.png", "-a", "100"},
                 "out.png");
  const TextureSignal signal(strip.model, {}, strip.messages);
  std::vector<Partial> partials;
  for (const char* side : {"0", "1"}) {
    const std::string part = std::string("part") + side + ".png",
                      shown = std::string("shown") + side + ".png";
    const std::vector<Image<float>> pictures = {read_texture(strip.folder / shown).pixels};
    partials.push_back(
        partial_of_textures(strip.model, signal, {read_texture(strip.folder / part)}, pictures));
  }
  stitch(partials, signal, strip.model);
  EXPECT_TRUE(of_library(strip.folder, strip.model.model, "ours.png") == wanted);
  EXPECT_THROW(partial_of_textures(strip.model, signal, {read_texture(strip.folder / "part0.png")}),
               InvalidInput)
      << "it has no alpha";
}

TEST(VerbTexture, TakesPhotographsWithTheirCameras) {
  TwoCharts strip;
  for (const char* view : {"20,10", "-40,30"})
    of_program(strip.folder,
               {"render", "strip.obj", "-s", "120", "--unlit", "-v", view, "--cameras",
                std::string("from") + view + ".json"},
               std::string("from") + view + ".png");
  const std::string wanted = of_program(
      strip.folder, {"texture", "strip.obj", "--cameras", "from20,10.json", "--cameras", "from-40,30.json"}, "out.png");
  const TextureSignal signal(strip.model, {}, strip.messages);
  std::vector<Photograph> photographs;
  for (const char* file : {"from20,10.json", "from-40,30.json"})
    photographs.push_back(read_cameras(strip.folder / file).front());
  const PhotographTexturing work(strip.model, signal, photographs, {}, strip.messages);
  const PhotographTexture found = work.make();
  for (int view = 0; view < 2; ++view) {
    const Partial partial = work.partial(view);
    int own = 0;
    for (std::size_t i = 0; i < found.labels.size(); ++i)
      if (found.labels[i] == view) {
        ++own;
        EXPECT_GT(partial.confidence[i], 0);
        EXPECT_EQ(partial.values.row(Eigen::Index(i)), found.values.row(Eigen::Index(i)));
      }
    EXPECT_GT(own, 0);
    const std::vector<int> all_of_it = work.labels(std::vector<int>(found.labels.size(), view));
    for (std::size_t i = 0; i < found.labels.size(); ++i) EXPECT_EQ(all_of_it[i] == view, partial.confidence[i] > 0);
  }
  const double weight = weight_from_length(usual_photograph_length, signal.space().scale());
  const Signal made = Stitcher(signal.space(), weight, found.labels)
                          .stitch(found.values, found.beyond, found.offset)
                          .signal;
  signal.put(signal.values(), made, strip.model.model);
  EXPECT_EQ(of_library(strip.folder, strip.model.model, "ours.png"), wanted);
}

TEST(VerbFilter, MovesTheVerticesOfAShape) {
  TwoCharts strip(MissingPictures::unneeded);
  test::write_bytes(strip.folder / "hill.obj",
                    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv -1 0 0\nv 0 -1 0\nv 0 0 1\n"
                    "f 1 2 3\nf 1 3 4\nf 1 4 5\nf 6 5 2\n");
  strip.model = load_textured_model(strip.folder / "hill.obj",
                                    {.missing = MissingPictures::unneeded}, strip.messages);
  const std::string wanted = of_program(
      strip.folder, {"filter", "hill.obj", "--geometry", "-b", "0", "-l", "10%"}, "out.obj");
  const Surface& surface = strip.model.surface;
  const double weight = weight_from_length(parse_length("10%"), {.area = surface.area});
  const std::vector<Vector3> moved =
      filter_positions(surface, {.weight = weight}, VertexSpace(surface).solver()).positions;
  const ShapeChange change = shape_change(surface, moved);
  EXPECT_GT(change.largest_moved, change.rms_moved);
  EXPECT_LT(*change.area.change(), 0);
  EXPECT_FALSE(change.volume.has_value()) << "it is open";
  EXPECT_FALSE(move_vertices(moved, strip.model)) << "it says no normals";
  EXPECT_EQ(of_library(strip.folder, strip.model.model, "ours.obj", Outputs::Kind::model), wanted);
}

}  // namespace
}  // namespace mq
