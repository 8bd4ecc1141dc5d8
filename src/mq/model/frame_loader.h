#pragma once
/// Where the frames of a sequence come from: files, or models in memory.

#include <filesystem>
#include <string>
#include <vector>

#include "mq/io/followed_frame.h"
#include "mq/io/frame_files.h"
#include "mq/io/model.h"
#include "mq/model/messages.h"

namespace mq {

/// The frames of a sequence by increasing number, read when they are asked for.
class FrameLoader {
 public:
  virtual ~FrameLoader() = default;

  virtual int count() const = 0;
  virtual int number(int frame) const = 0;        ///< as it is called
  virtual std::string name(int frame) const = 0;  ///< for messages
  virtual std::string sequence() const = 0;       ///< what messages call all of it

  /// Numbers of frames that are wanted and not there, between this one and the one before it;
  /// `frame` may be `count()`.
  virtual std::vector<int> missing_before(int frame) const;

  /// Throws where it cannot be read.
  virtual Model read(int frame) const = 0;

  /// A mesh with the triangles of the frame whose positions are where its material is at rest.
  /// Throws `InvalidInput` where that is not known.
  virtual Mesh material(int frame) const;
  virtual std::string material_name(int frame) const;  ///< for messages

  /// The files that `model`, this frame as it was read, came from.
  virtual std::vector<KnownFile> files(int frame, const Model& model) const;

  /// Whether a frame's files are not those that a store remembers. One that remembers none is
  /// believed.
  virtual bool is_changed(int frame, const std::vector<KnownFile>& known) const;

  /// The place of the frame with this number, −1: there is none.
  int index_of(int number) const;
};

struct FileFramesOptions {
  std::vector<int> numbers = {};  ///< of the frames that are wanted (`parse_frames`); empty: all
  MissingFrames missing = MissingFrames::refused;
  std::string textures = {};  ///< pictures instead of those the frames name, %04d for the number
  std::string material = {};  ///< meshes for `material`, as `find_frames` takes them; empty: none
  ReadModelOptions::Pictures pictures = ReadModelOptions::Pictures::skip;
};

/// Frames that are files, as `find_frames` finds them.
class FileFrames : public FrameLoader {
 public:
  /// Reads nothing. Throws `IoError` where `find_frames` does, and where frames are not to be left
  /// out and a picture of `textures` is not there. Remarks steps between numbers that are longer
  /// than the shortest; warns of frames that are missing.
  FileFrames(std::string sequence, FileFramesOptions options, Messages& messages);

  int count() const override { return int(files_.size()); }
  int number(int frame) const override { return file(frame).number; }
  std::string name(int frame) const override { return file(frame).path.string(); }
  std::string sequence() const override { return sequence_; }
  std::vector<int> missing_before(int frame) const override;
  Model read(int frame) const override;
  Mesh material(int frame) const override;
  std::string material_name(int frame) const override;
  std::vector<KnownFile> files(int frame, const Model& model) const override;
  bool is_changed(int frame, const std::vector<KnownFile>& known) const override;

  /// As the file says it, for people to look at.
  Model with_pictures(int frame) const;

  /// The files that frames are read from, as far as their names are known: meshes, pictures of
  /// `textures`, and `material`.
  std::vector<std::filesystem::path> paths() const;

 private:
  const FrameFile& file(int frame) const { return files_[std::size_t(frame)]; }
  Model read_with(int frame, ReadModelOptions::Pictures pictures) const;
  void require_textures() const;
  void warn_of_missing(Messages& messages) const;
  void remark_gaps(Messages& messages) const;

  std::string sequence_;
  FileFramesOptions options_;
  std::vector<FrameFile> files_, materials_;
};

/// Frames that are there already.
class MemoryFrames : public FrameLoader {
 public:
  struct Frame {
    int number = 0;
    Model model;
    std::vector<Vector3> material = {};  ///< per vertex where it is at rest; empty: not known
  };

  /// Throws `InvalidInput` unless numbers increase.
  explicit MemoryFrames(std::vector<Frame> frames, std::string sequence = "the sequence");

  int count() const override { return int(frames_.size()); }
  int number(int frame) const override { return frames_[std::size_t(frame)].number; }
  std::string name(int frame) const override;
  std::string sequence() const override { return sequence_; }
  Model read(int frame) const override { return frames_[std::size_t(frame)].model; }
  Mesh material(int frame) const override;

 private:
  std::vector<Frame> frames_;
  std::string sequence_;
};

}  // namespace mq
