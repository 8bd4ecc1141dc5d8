#pragma once
/// How long something will live on, learned from what lived so far.

#include <cstdint>
#include <vector>

namespace mq {

/// A life of so many frames, at least one.
struct KnownLife {
  enum class End {
    seen,    ///< that was its last frame
    to_come  ///< it was there in the last frame that is known
  };
  int frames = 1;
  End end = End::to_come;
};

/// Kaplan's and Meier's estimate [kaplan1958nonparametric]: of those that were there for a frames, and of which it
/// is known whether they were there for one more, the share h(a) that was not is the hazard of that age. What has
/// been there for a frames has
///
///   Σ_{u=1…horizon} Π_{j=a…a+u−1} (1 − h(j))
///
/// frames to come. An age that none is known to have passed has the hazard of all ages together; where nothing
/// ended, all live on. The thesis wants statistics that anticipate remeshing, and does not say which (chapter 7).
class Survival {
 public:
  explicit Survival(const std::vector<KnownLife>& lives);

  /// Frames to come of what has been there for so many, at most `horizon`.
  double expected_after(int frames, int horizon) const;

 private:
  std::vector<double> hazard_;  // per age
  double hazard_of_all_ = 0;
};

}  // namespace mq
