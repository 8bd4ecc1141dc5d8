#pragma once
/// From place to place where the textures differ from those that were opened, that where they do most first.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "background.h"
#include "mq/draw/camera.h"
#include "mq/draw/texture_difference.h"
#include "session.h"

namespace mq::view {

/// The places are found behind the window, and kept until something changes.
class DifferenceTour {
 public:
  explicit DifferenceTour(Session& session) : session_(session) {}
  ~DifferenceTour() { stop(); }

  /// Asks for the next place, the first one where `state` is another than when it was last asked; throws
  /// `InvalidInput` where there are no two versions of textures.
  void next(const std::vector<double>& state);

  struct Stop {
    DifferencePlace place;
    View view;  ///< with target and extent
  };
  /// Once per frame: where one that was asked for is now. Throws why it could not be found; `InvalidInput`
  /// where nothing differs.
  std::optional<Stop> arrived(View::Up up);

  bool busy() const { return background_.busy(); }
  double fraction() const { return background_.fraction(); }
  /// "place 2 of 17: 23.1 of 255 apart"; empty: at none.
  std::string words() const;
  bool is_at_first() const { return at_ == 0; }
  void cancel() {
    background_.cancel();
    asked_ = false;
    state_.clear();
  }
  /// Forgets all, and waits until nothing is looked for: before the session's textures become others.
  void stop();

 private:
  void find(const Progress& progress);

  Session& session_;
  std::vector<double> state_;  ///< of which the places are
  std::shared_ptr<TextureSet> result_;  ///< of which they are being found, held as long
  TextureDifference found_;  ///< the other thread's while it works
  int at_ = -1;              ///< which of the places; -1: none yet
  bool asked_ = false;       ///< for the next one
  Background background_;    ///< last: it ends before what it works on
};

}  // namespace mq::view
