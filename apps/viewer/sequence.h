#pragma once
/// The frames of a model that moves: a store of an evolving mesh, or numbered files.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "mq/image/colour.h"
#include "scene.h"

namespace mq::view {

class Sequence {
 public:
  virtual ~Sequence() = default;

  virtual int count() const = 0;
  virtual int number(int frame) const = 0;  ///< of a frame, counted from 0, as its file says
  /// From any thread.
  virtual app::Scene scene(int frame, const Progress& progress) const = 0;
  virtual bool has_lifespans() const = 0;
  /// Per triangle how long it lives (`lifespan_colour`); empty where frames have nothing in common.
  virtual std::vector<Colour> lifespans(int frame) const = 0;
};

/// Whether a name is that of a store, NAME.evolving, or has a place for a number, frame_%04d.ply.
bool names_sequence(const std::string& name);

/// Throws `IoError` where it cannot be read, or has no frames.
std::shared_ptr<Sequence> open_sequence(app::Run& run);

}  // namespace mq::view
