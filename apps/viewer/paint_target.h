#pragma once
/// What the brush of the filter paints on: a model's textures, or its colours at vertices.

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mq/filter/halo_limit.h"
#include "mq/filter/live_modulation.h"
#include "shell/results.h"
#include "session.h"
#include "options/signal_options.h"

namespace mq::view {

/// The signal before, the one that is solved for, how much of the difference is shown, and what halos may be: with a
/// limit, what is solved for holds the channels for texture's part behind the others (`LiveOptions::texture`).
struct ShownSignal {
  const Signal& before;
  const Signal& solved;
  double gain;
  const HaloLimit* limit = nullptr;

  double operator()(std::int64_t unknown, int channel) const {
    const double was = before(unknown, channel);
    if (gain == 0) return was;
    const double all = solved(unknown, channel) - was;
    if (!limit || gain < 0) return was + gain * all;
    const double texture = solved(unknown, before.cols() + channel) - was;
    return limit->limited(unknown, channel, was, gain * (all - texture)) + gain * texture;
  }
};

class PaintTarget {
 public:
  virtual ~PaintTarget() = default;

  /// "texels" or "vertices".
  virtual std::string unknowns() const = 0;
  virtual const ModelSignal& target() const = 0;
  virtual Vector3 place(int unknown) const = 0;
  virtual Outputs::Kind kind() const = 0;

  /// The unknowns nearer than `radius` to a place of the surface that are joined to it there;
  /// increasing. One call at a time.
  virtual std::vector<int> reach(const Vector3& place, double radius) = 0;

  virtual LiveModulation live(double weight, const Signal& before, const LiveOptions& options,
                              const Progress& progress) const = 0;

  /// Takes over the values at some unknowns, or at all; on the thread that solves.
  virtual void show(const ShownSignal& values, std::optional<std::span<const int>> some) = 0;
  /// Shows what was taken over; on the window's thread, once a picture.
  virtual void present() {}

  /// Throws `InvalidInput` where a file cannot hold a mask, which may be below 0 where `smooths`.
  virtual void require_mask_name(const std::filesystem::path& file, bool smooths) const = 0;
  /// Writes a mask in parts of `full`, as `filter --mask` reads it, a file for each texture or one.
  virtual void write_mask(std::span<const int> mask, int full, bool smooths,
                          const std::vector<std::filesystem::path>& files) const = 0;
};

/// Whether there is something to paint on: pictures, or colours at vertices of a model without
/// texture coordinates.
bool can_be_painted(const Session& session);

/// Takes the time that assembling takes. The session must outlive it.
std::unique_ptr<PaintTarget> make_paint_target(Session& session, app::Run& run,
                                               const Progress& progress);

}  // namespace mq::view
