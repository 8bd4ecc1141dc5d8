#pragma once
/// How the surface of a sequence moves, where that is known before it is followed: parts of the sequence
/// were followed by themselves, on other machines or at another time.

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mq/io/evolving_file.h"
#include "mq/io/followed_frame.h"

namespace mq {

/// Frames are called by their numbers.
class KnownMotion {
 public:
  virtual ~KnownMotion() = default;

  /// Whether a part has this frame.
  virtual bool has(int frame) const = 0;

  /// Where points near the surface as it is in frame `before` are in frame `after`. Nothing where no part followed one
  /// from the other, as at the first frame of a part, or where it replaced what came or went.
  virtual std::optional<std::vector<Vector3>> moved(int before, int after, std::span<const Vector3> points) const = 0;

  /// Throws `InvalidInput` where a part followed this frame from other files than these.
  virtual void require_made_of(int frame, const std::vector<KnownFile>& files) const = 0;
};

/// That of stores. A point moves as the nearest point of what followed its frame does:
///
///     p ↦ p + x′(q) − x(q),   q the point of the surface nearest to p, x and x′ where it is before and after.
///
/// Where a part only replaced what was distorted vertices that stayed say so, and those that are gone moved as their
/// neighbours along edges did.
///
/// Costs a search for each point, in parallel, and the decoding of both frames.
class StoredMotion : public KnownMotion {
 public:
  /// Throws `InvalidInput` where two stores have one frame, or one is broken; what `EvolvingReader` throws.
  explicit StoredMotion(const std::vector<std::filesystem::path>& stores);

  bool has(int frame) const override { return places_.contains(frame); }
  std::optional<std::vector<Vector3>> moved(int before, int after, std::span<const Vector3> points) const override;
  void require_made_of(int frame, const std::vector<KnownFile>& files) const override;

 private:
  struct Place {
    int store = 0, frame = 0;
  };

  std::vector<std::unique_ptr<EvolvingReader>> stores_;
  std::map<int, Place> places_;  ///< of each frame's number
};

}  // namespace mq
