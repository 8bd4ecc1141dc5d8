#pragma once
/// The frames of a model that moves: a store of an evolving mesh, or numbered files, each with its
/// textures.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "mq/base/options.h"
#include "mq/image/colour.h"
#include "options/model_options.h"

namespace mq::view {

class Sequence {
 public:
  virtual ~Sequence() = default;

  virtual int count() const = 0;
  virtual int number(int frame) const = 0;  ///< of a frame, counted from 0, as its file says
  /// From any thread.
  virtual TexturedModel scene(int frame, const Progress& progress) const = 0;
  /// Names the files of a frame, its mesh and its textures, in the options of a verb.
  virtual void name(int frame, OptionValues& options) const = 0;
  virtual bool has_lifespans() const = 0;
  /// Per triangle how long it lives (`lifespan_colour`); empty where frames have nothing in common.
  virtual std::vector<Colour> lifespans(int frame) const = 0;
};

/// Whether a name is that of a store, NAME.evolving, of a folder, or has a place for a number,
/// frame_%04d.ply.
bool names_sequence(const std::string& name);

/// Textures with a place for a number are another picture for each frame. Throws `IoError` where it
/// cannot be read, has no frames, or a frame has no picture.
std::shared_ptr<Sequence> open_sequence(app::Run& run);

}  // namespace mq::view
