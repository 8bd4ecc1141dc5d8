// Sequences that are files, and the store that other programs read.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/folder.h"
#include "model/sequences.h"
#include "mq/base/error.h"
#include "mq/io/evolving_file.h"
#include "mq/model/sequence_tracker.h"
#include "mq/model/stored_frames.h"

namespace mq {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using Resume = SequenceTrackerOptions::Resume;

class FileSequence : public FolderTest {
 protected:
  /// frame_0000.ply and so on, and material/frame_0000.ply.
  void write(const std::vector<MemoryFrames::Frame>& frames) const {
    fs::create_directories(folder / "material");
    for (const MemoryFrames::Frame& frame : frames) {
      write_model(path(frame.number), frame.model);
      Model rest;
      rest.mesh = {frame.material, frame.model.mesh.triangles, {}, {}, {}};
      write_model(folder / "material" / path(frame.number).filename(), rest);
    }
  }
  fs::path path(int number) const { return folder / frame_name("frame_%04d.ply", number); }
  FileFrames frames(FileFramesOptions options = {}) { return {folder.string(), options, heard}; }
  std::string blocks(const std::string& name = "body") const { return get(name + ".blocks"); }

  Heard heard;
};

TEST_F(FileSequence, IsReadAsItIsWritten) {
  const std::vector<MemoryFrames::Frame> made = bending(2);
  write(made);
  const FileFrames read = frames({.material = (folder / "material").string()});
  ASSERT_EQ(read.count(), 2);
  EXPECT_EQ(read.number(1), 1);
  EXPECT_EQ(read.name(1), path(1).string());
  EXPECT_EQ(read.index_of(1), 1);
  EXPECT_EQ(read.index_of(2), -1);
  EXPECT_EQ(read.read(1).mesh.triangles, made[1].model.mesh.triangles);
  EXPECT_EQ(read.material(1).triangles, made[1].model.mesh.triangles);
  EXPECT_THAT(read.paths(), ElementsAre(path(0), folder / "material/frame_0000.ply", path(1),
                                        folder / "material/frame_0001.ply"));
  EXPECT_THROW(frames().material(0), InvalidInput);
}

TEST_F(FileSequence, SaysWhichFramesAreMissing) {
  const std::vector<MemoryFrames::Frame> made = bending(1);
  for (const int number : {0, 2, 4, 8, 12}) write_model(path(number), made[0].model);
  frames();
  EXPECT_THAT(heard.remarks,
              HasSubstr("frames are missing in 2 places, the first between 4 and 8"));
  const FileFrames some = frames({.numbers = {1, 2, 3, 4, 5}, .missing = MissingFrames::left_out});
  EXPECT_THAT(heard.warnings,
              HasSubstr("3 of 5 frames are missing, the first is frame 1; they are left out"));
  EXPECT_THAT(some.missing_before(0), ElementsAre(1));
  EXPECT_THAT(some.missing_before(1), ElementsAre(3));
  EXPECT_THAT(some.missing_before(2), ElementsAre(5));
  EXPECT_THAT(io_error_of([&] { frames({.numbers = {1, 2}}); }), HasSubstr("frame 1"));
  EXPECT_THAT(io_error_of([&] { frames({.textures = (folder / "t_%d.png").string()}); }),
              HasSubstr("t_0.png is not there, the picture of"));
}

TEST_F(FileSequence, KnowsTheFilesThatItWasReadFrom) {
  write(bending(2));
  const FileFrames read = frames();
  const std::vector<KnownFile> known = read.files(0, read.read(0));
  ASSERT_EQ(known.size(), 1U);
  EXPECT_EQ(known[0].name, "frame_0000.ply");
  EXPECT_FALSE(read.is_changed(0, known));
  EXPECT_FALSE(read.is_changed(0, {}));
  EXPECT_TRUE(read.is_changed(1, known));
  put("frame_0000.ply", get("frame_0000.ply") + " ");
  EXPECT_TRUE(read.is_changed(0, known));
  fs::remove(path(0));
  EXPECT_TRUE(read.is_changed(0, known));
}

TEST_F(FileSequence, IsStoredFrameAfterFrameAndTakenUpBeforeWhatWasDamaged) {
  write(bending(3));
  const FileFrames read = frames();
  const SequenceTrackerOptions options = coarse({.resume = Resume::where_possible});
  const auto follow = [&] {
    EvolvingStore store(folder / "body.evolving", R"({"verb":"test"})");
    return SequenceTracker(read, store, options, heard).run();
  };
  follow();
  const std::string sound = blocks();
  {
    const EvolvingReader reader(folder / "body.evolving");
    EXPECT_EQ(reader.about(), R"({"verb":"test"})");
    EXPECT_EQ(reader.broken(), "");
    EXPECT_EQ(followed_frames(reader)[2].match.has_value(), true);
  }
  // A bit of the second frame, and a file that ends within the third.
  const auto offset = [&](int frame) {
    return std::size_t(EvolvingReader(folder / "body.evolving").frames()[frame].offset);
  };
  std::string damaged = sound;
  damaged[offset(1) + 5] ^= 1;
  const std::string cut = sound.substr(0, offset(2) + 5);
  put("body.blocks", damaged);
  EXPECT_EQ(follow().frames.size(), 3U);
  EXPECT_THAT(heard.warnings, HasSubstr("cannot give frame 1, 2;"));  // which needs frame 1
  EXPECT_THAT(heard.remarks, HasSubstr("goes on after frame 0"));
  EXPECT_EQ(blocks(), sound);
  put("body.blocks", cut);
  EXPECT_EQ(follow().frames.size(), 3U);
  EXPECT_THAT(heard.remarks, HasSubstr("goes on after frame 1"));
  EXPECT_EQ(blocks(), sound);
}

TEST_F(FileSequence, KeepsTheStoreThatIsThereUntilAFrameIsFollowed) {
  write(bending(1));
  put("body.evolving", "mine");
  put("frame_0000.ply", "ply\nformat");
  EvolvingStore store(folder / "body.evolving");
  const FileFrames read = frames();
  EXPECT_THROW(SequenceTracker(read, store).run(), InvalidInput);
  EXPECT_EQ(get("body.evolving"), "mine");
}

TEST_F(FileSequence, IsGoneOnWithOnlyByAStoreOfTheSameMaker) {
  write(bending(2));
  const FileFrames read = frames({.numbers = {0}});
  EvolvingStore first(folder / "body.evolving");
  SequenceTracker(read, first, coarse()).run();
  const std::string sound = blocks();
  EvolvingStore other(folder / "body.evolving", "{}",
                      [](const EvolvingReader&) { throw InvalidInput("made otherwise"); });
  const FileFrames all = frames();
  EXPECT_THROW(SequenceTracker(all, other, coarse({.resume = Resume::where_possible})).run(),
               InvalidInput);
  EXPECT_EQ(blocks(), sound);
}

TEST_F(FileSequence, HasFramesThatAreMeantByTheirNumbers) {
  write(bending(3));
  EvolvingStore store(folder / "body.evolving");
  const FileFrames read = frames({.numbers = {0, 2}});
  SequenceTracker(read, store, coarse()).run();
  const EvolvingReader reader(folder / "body.evolving");
  EXPECT_THAT(frames_with(reader, {}), ElementsAre(0, 1));
  EXPECT_THAT(frames_with(reader, {2, 0}), ElementsAre(1, 0));
  EXPECT_THAT(numbers_of(reader, {0, 1}), ElementsAre(0, 2));
  EXPECT_THROW(frames_with(reader, {1}), InvalidInput);
  EXPECT_FALSE(has_atlas(reader));
  EXPECT_THROW(require_atlas(reader), InvalidInput);
}

}  // namespace
}  // namespace mq
