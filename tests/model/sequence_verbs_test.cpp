// What verbs of sequences do is a few calls of the library: the same calls give the same files,
// byte for byte.

#include <gtest/gtest.h>

#include <cmath>

#include "cli/models.h"
#include "evolving/evolving_models.h"
#include "mq/draw/lifespans.h"
#include "mq/io/animation.h"
#include "mq/io/film_page.h"
#include "mq/io/frame_files.h"
#include "mq/model/captured_files.h"
#include "mq/model/film_video.h"
#include "mq/model/relit_sequence.h"
#include "mq/model/sequence_tracker.h"
#include "mq/model/stored_atlas.h"
#include "mq/model/stored_frames.h"
#include "mq/model/stored_models.h"

namespace mq {
namespace {

using test::file_bytes;
using test::Folder;
using test::marquetry;

constexpr int side = 64;  // texels

LifespanAtlasOptions small_atlas() {
  LifespanAtlasOptions options;
  options.unwrap.width = options.unwrap.height = side;
  options.unwrap.trials = 2;
  return options;
}

/// A sheet that waves for six frames and is renewed here and there: bare.evolving without an atlas,
/// sheet.evolving with one, frame_%d.ply as it was captured, in colours, and texture_%d.png, which
/// flickers.
struct Sheet {
  Folder folder;
  Messages messages;
  std::vector<int> frames;

  Sheet() {
    const EvolvingMesh sheet = patched_sheet(6, 2, 5);
    write_evolving(folder / "bare.evolving", sheet, store_step(6));
    const EvolvingReader bare(folder / "bare.evolving");
    EvolvingMesh laid_out = read_frames(bare);
    lay_out_stored(bare, laid_out, small_atlas());
    write_laid_out(bare, laid_out, folder / "sheet.evolving");
    const Image<float> still = test::busy_picture(side, side);
    for (int f = 0; f < int(sheet.frames.size()); ++f) {
      frames.push_back(f);
      Model model;
      model.mesh = sheet.mesh(f);
      model.colors.channels = 3;
      for (const Vector3& p : model.mesh.positions)
        for (const double c : {p.x() / 6, p.y() / 6, 0.5 + 0.5 * std::sin(p.x() * p.y())})
          model.colors.values.push_back(float(c));
      write_model(numbered("frame_%d.ply", f), model);
      Image<float> picture = still;
      for (float& value : picture.values()) value = 0.1F + (0.6F + 0.1F * float(f % 2)) * value;
      write_image(numbered("texture_%d.png", f), picture);
    }
  }

  std::filesystem::path numbered(const std::string& name, int number) const {
    return folder / frame_name(name, number);
  }
  std::string path(const std::string& name) const { return (folder / name).string(); }
  EvolvingReader reader(const std::string& name = "sheet.evolving") const {
    return EvolvingReader(folder / name);
  }

  CapturedTextures captured(const EvolvingReader& store) {
    return {store, path("frame_%d.ply"), frames, {.side = side}, messages};
  }

  void run(const std::vector<std::string>& words) const {
    const test::Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 0) << result.error;
  }

  void expect_same(const std::string& ours, const std::string& of_program) const {
    const std::string bytes = file_bytes(folder / ours);
    EXPECT_FALSE(bytes.empty()) << ours;
    EXPECT_TRUE(bytes == file_bytes(folder / of_program)) << ours << " and " << of_program;
  }

  /// Of every frame.
  void expect_same_frames(const std::string& ours, const std::string& of_program) const {
    for (const int f : frames) expect_same(frame_name(ours, f), frame_name(of_program, f));
  }
};

TEST(VerbUnwrap, GivesAllFramesOfAStoreOneAtlas) {
  const Sheet sheet;
  for (const std::string look_ahead : {"", "1"}) {
    std::vector<std::string> words = {"unwrap", "bare.evolving", "-o", "out.evolving", "--size",
                                      "64",     "--trials",      "2"};
    LifespanAtlasOptions options = small_atlas();
    if (!look_ahead.empty()) {
      words.insert(words.end(), {"--look-ahead", look_ahead});
      options.look_ahead = 1;
    }
    sheet.run(words);
    const EvolvingReader bare = sheet.reader("bare.evolving");
    EvolvingMesh evolving = read_frames(bare);
    lay_out_stored(bare, evolving, options);
    // Beside the blocks the manifest has the name of its own and what the verb's options were.
    write_laid_out(bare, evolving, sheet.folder / "ours.evolving",
                   sheet.reader("out.evolving").about(), uv_step_within(store_uv_error / 64));
    sheet.expect_same("ours.blocks", "out.blocks");
    std::string manifest = file_bytes(sheet.folder / "ours.evolving");
    const std::size_t at = manifest.find("ours.blocks");
    ASSERT_NE(at, std::string::npos);
    EXPECT_EQ(manifest.replace(at, 4, "out"), file_bytes(sheet.folder / "out.evolving"));
  }
}

TEST(VerbEvolve, FollowsRemeshesAndLaysOut) {
  const Folder folder;
  // Balls that meet in frame 11.
  ASSERT_EQ(marquetry(folder, {"sample", "merging", "-o", "body/", "--triangles", "1000",
                               "--period", "40", "--frames", "10-12"})
                .status,
            0);
  const test::Result result = marquetry(folder, {"evolve", "body", "-o", "body.evolving", "--nodes",
                                                 "12", "--size", "64", "--trials", "2"});
  ASSERT_EQ(result.status, 0) << result.error;

  Messages silent;
  const FileFrames frames((folder / "body").string(), {}, silent);
  SequenceTrackerOptions options{.follow = {.remeshing = Remeshing::parts}};
  options.follow.track.node_spacing = 0.12;
  const std::filesystem::path ours = folder / "ours.evolving";
  {
    EvolvingStore store(ours);
    SequenceTracker(frames, store, options).run();
  }
  const EvolvingReader followed(ours);
  EvolvingMesh evolving = read_frames(followed);
  lay_out_stored(followed, evolving, small_atlas());
  write_laid_out(followed, evolving, ours, "{}", uv_step_within(store_uv_error / 64));
  EXPECT_EQ(file_bytes(folder / "ours.blocks"), file_bytes(folder / "body.blocks"));
  EXPECT_EQ(EvolvingReader(ours).step(), EvolvingReader(folder / "body.evolving").step());
  EXPECT_FALSE(EvolvingReader(ours).frames()[2].measured.empty());
}

TEST(VerbExport, WritesFramesAsModelsInColoursCarriedAlong) {
  const Sheet sheet;
  sheet.run({"export", "sheet.evolving", "-o", "out_%d.obj"});
  sheet.run({"export", "sheet.evolving", "-o", "painted_%d.ply", "--paint", "frame_0.ply"});
  const EvolvingReader reader = sheet.reader();
  std::vector<std::filesystem::path> bare, painted;
  for (const int f : sheet.frames) {
    bare.push_back(sheet.numbered("ours_%d.obj", f));
    painted.push_back(sheet.numbered("ours_%d.ply", f));
  }
  write_stored_models(reader, sheet.frames, bare);
  const CarriedColours colours(read_model(sheet.folder / "frame_0.ply"), reader);
  write_stored_models(reader, sheet.frames, painted, {.colours = &colours});
  sheet.expect_same_frames("ours_%d.obj", "out_%d.obj");
  sheet.expect_same_frames("ours_%d.ply", "painted_%d.ply");
}

TEST(VerbExport, SaysWhatAStoreHolds) {
  const Sheet sheet;
  const auto said =
      marquetry(sheet.folder, {"export", "sheet.evolving", "--json"}).json()["result"];
  const StoreFigures found = store_figures(sheet.reader(), {});
  EXPECT_EQ(said["triangles"], found.triangles);
  EXPECT_EQ(said["triangles_throughout"], found.throughout);
  EXPECT_EQ(said["lifespan_mean"], found.mean_lifespan);
  EXPECT_EQ(said["bytes"], found.bytes);
  EXPECT_LT(found.mean_lifespan, 6);
  EXPECT_GT(store_figures(sheet.reader(), {3, 4, 5}).throughout, found.throughout);
}

TEST(VerbExport, WritesWhatWasCaptured) {
  Sheet sheet;
  const EvolvingReader reader = sheet.reader();
  std::filesystem::create_directory(sheet.folder / "ours");
  for (const std::string output : {"out_%d.png", "out_%d.obj", "out.mp4", "out.glb"}) {
    sheet.run({"export", "sheet.evolving", "-o", output, "--from", "frame_%d.ply", "--size", "64", "--overwrite"});
    CapturedTextures captured = sheet.captured(reader);
    const std::vector<CapturedFigures> found =
        write_captured(captured, sheet.path("ours/" + output), {}, Compression::none, sheet.messages);
    EXPECT_EQ(found.size(), output == "out.glb" ? reader.segments().size() : 6U) << output;
    EXPECT_EQ(found[0].of, CapturedFigures::Of::texels);
    EXPECT_GT(found[0].count, 1000);
    EXPECT_FALSE(found[0].steps);
    if (has_frame_place(output))
      sheet.expect_same_frames("ours/" + output, output);
    else
      sheet.expect_same("ours/" + output, output);
  }
  sheet.run({"export", "bare.evolving", "-o", "out_%d.ply", "--from", "frame_%d.ply"});
  const EvolvingReader bare = sheet.reader("bare.evolving");
  CapturedTextures captured = sheet.captured(bare);
  const std::vector<CapturedFigures> found =
      write_captured(captured, sheet.path("ours_%d.ply"), {}, Compression::none, sheet.messages);
  EXPECT_EQ(found[5].of, CapturedFigures::Of::vertices);
  EXPECT_EQ(found[5].count, 49);
  sheet.expect_same_frames("ours_%d.ply", "out_%d.ply");
}

TEST(VerbExport, WritesAnAnimation) {
  const Sheet sheet;
  sheet.run({"export", "bare.evolving", "-o", "out.glb", "--frames", "1-4", "--rate", "12"});
  write_animation(sheet.folder / "ours.glb", sheet.reader("bare.evolving"), {1, 4, 12});
  sheet.expect_same("ours.glb", "out.glb");
}

/// The statement of a page that holds its film.
std::string film_of(const std::string& page) {
  const std::size_t at = page.find("const film = ");
  return at == std::string::npos ? "" : page.substr(at, page.find("\n", at) - at);
}

TEST(VerbPlay, PutsFilmAndVideoIntoOnePage) {
  Sheet sheet;
  const test::Result result = marquetry(sheet.folder, {"play", "sheet.evolving", "-o", "out.html",
                                                       "--from", "frame_%d.ply", "--size", "64"});
  if (result.error.find("three.js") != std::string::npos) GTEST_SKIP() << "no three.js";
  ASSERT_EQ(result.status, 0) << result.error;
  const EvolvingReader reader = sheet.reader();
  CapturedTextures captured = sheet.captured(reader);
  const CapturedFilmVideo made = captured_film_video(captured, {}, sheet.messages);
  const FilmVideo& video = made.video;
  EXPECT_EQ(made.figures.size(), 6U);
  const Film film = make_film(reader, sheet.frames, lifespan_colour);
  const std::string page =
      film_page("<script src=\"film.js\"></script>\n", {}, film,
                {.title = "sheet", .video_type = video.type, .video = video.bytes});
  EXPECT_GT(film_of(page).size(), 1000U);
  EXPECT_TRUE(film_of(page) == film_of(file_bytes(sheet.folder / "out.html")));
  EXPECT_THROW(film_page("<html>", {}, film, {}), std::logic_error);

  // The same video, once it is a file.
  test::write_bytes(sheet.folder / "textures.mp4", std::string(text_of(video.bytes)));
  const FilmVideo again =
      read_film_video(sheet.folder / "textures.mp4", {.frames = 6}, sheet.messages);
  EXPECT_EQ(again.bytes, video.bytes);
  EXPECT_EQ(again.rate, 30);
  EXPECT_THROW(read_film_video(sheet.folder / "textures.mp4", {.frames = 5}, sheet.messages),
               InvalidInput);
  EXPECT_THROW(
      read_film_video(sheet.folder / "textures.mp4", {.frames = 6, .rate = 60}, sheet.messages),
      InvalidInput);
  EXPECT_THROW(read_film_video("film.avi", {}, sheet.messages), InvalidInput);
}

TEST(VerbRelight, FiltersFromFilesToFiles) {
  Sheet sheet;
  const EvolvingReader reader = sheet.reader();
  const auto relit = [&](const std::string& output, const RelightOptions& options) {
    SequenceRelighter relighter(
        reader, sheet.frames,
        {.textures = sheet.path("texture_%d.png"), .output = sheet.path(output)}, options,
        sheet.messages);
    EXPECT_EQ(relighter.inputs().size(), 6U);
    const RelitSequence found = relighter.run();
    EXPECT_TRUE(found.filter.solve.converged);
    EXPECT_LT(found.measures.after.flicker.step, found.measures.before.flicker.step);
  };
  const std::vector<std::string> words = {"relight", "sheet.evolving", "texture_%d.png", "-o"};
  const auto run = [&](std::vector<std::string> more) {
    more.insert(more.begin(), words.begin(), words.end());
    sheet.run(more);
  };
  run({"mean_%d.png", "--length", "8tx", "--radius", "3"});
  relit("ours_mean_%d.png", {.spread = {8, Length::Unit::texels}, .radius = 3});
  sheet.expect_same_frames("ours_mean_%d.png", "mean_%d.png");
  run({"all.mp4", "--method", "poisson", "--space", "linear"});
  relit("ours_all.mp4",
        {.method = RelightOptions::Method::poisson, .values = {.space = ColourSpace::linear}});
  sheet.expect_same("ours_all.mp4", "all.mp4");
}

/// Flows are most of the work, and as much of its progress.
TEST(SequenceRelighter, SaysHowFarItIsWhileDriftIsFollowed) {
  Sheet sheet;
  const EvolvingReader reader = sheet.reader();
  for (const RelightOptions::Method method : {RelightOptions::Method::mean, RelightOptions::Method::poisson})
    for (const RelightOptions::Drift drift : {RelightOptions::Drift::follow, RelightOptions::Drift::measure}) {
      SequenceRelighter relighter(reader, sheet.frames,
                                  {.textures = sheet.path("texture_%d.png"), .output = sheet.path("out_%d.png")},
                                  {.method = method, .radius = 2, .drift = drift}, sheet.messages);
      double fraction = 0, in_flows = 0, first = 1, last = 0;
      relighter.run(Progress([&](const ProgressEvent& event) {
        EXPECT_GE(event.fraction, fraction) << event.step;
        if (event.step.find("follow") != std::string::npos) {
          in_flows += event.fraction - fraction;
          first = std::min(first, event.fraction), last = std::max(last, event.fraction);
        }
        fraction = event.fraction;
      }));
      EXPECT_LT(first, 0.35);
      EXPECT_LT(last, 0.98);
      EXPECT_GT(in_flows, 0.3);
      EXPECT_GT(fraction, 0.9);
    }
}

TEST(SequenceRelighter, RefusesBeforeAnyWork) {
  Sheet sheet;
  const EvolvingReader reader = sheet.reader(), bare = sheet.reader("bare.evolving");
  const auto relighter = [&](const EvolvingReader& store, const std::string& textures,
                             const std::string& output, const RelightOptions& options = {}) {
    return SequenceRelighter(store, sheet.frames,
                             {.textures = sheet.path(textures), .output = sheet.path(output)},
                             options, sheet.messages);
  };
  EXPECT_THROW(relighter(reader, "texture_0.png", "out_%d.png"), InvalidInput);
  EXPECT_THROW(relighter(reader, "texture_%d.png", "out.png"), InvalidInput);
  EXPECT_THROW(relighter(bare, "texture_%d.png", "out_%d.png"), InvalidInput);
  EXPECT_THROW(relighter(reader, "none_%d.png", "out_%d.png").rehearse(), IoError);
  EXPECT_NO_THROW(relighter(reader, "texture_%d.png", "out_%d.png").rehearse());
  const RelightOptions too_far{.method = RelightOptions::Method::poisson,
                               .spread = {3e5, Length::Unit::alpha}};
  EXPECT_THROW(relighter(reader, "texture_%d.png", "out_%d.png", too_far).rehearse(), InvalidInput);
  write_image(sheet.numbered("texture_%d.png", 3), test::busy_picture(32, 32));
  EXPECT_THROW(relighter(reader, "texture_%d.png", "out_%d.png").run(), InvalidInput);
  EXPECT_FALSE(std::filesystem::exists(sheet.folder / "out_0.png"));
}

}  // namespace
}  // namespace mq
