#pragma once
/// Progress of nested steps, and the one way to stop them.
///
/// A `Progress` is the last parameter of everything that can take longer than a moment. It covers a
/// part of the whole, [0, 1] at the root; `step` carves the next share of it for a part of the work:
///
///     Matrix assemble(const Mesh& mesh, const Progress& progress) {
///       auto clip = progress.step("clip triangles", 0.7);
///       for (...) clip.at(double(i) / n);       // reports; throws Cancelled when asked to stop
///       progress.step("sum rows", 0.3).at(1);
///     }
///
/// A default-constructed `Progress` is silent and never cancels. Any thread may call `at` and
/// `check`; `step` belongs to the thread that owns the object.

#include <atomic>
#include <functional>
#include <memory>
#include <string>

namespace mq {

/// What a listener is told: the path of step names, outermost first, and the fraction of the whole.
struct ProgressEvent {
  std::string step;  ///< names joined by " / "
  double fraction;   ///< of all the work, in [0, 1]; never decreases
  std::string detail;  ///< how the step is doing, "residual 3e-04"; mostly empty
};

class Progress {
 public:
  using Listener = std::function<void(const ProgressEvent&)>;

  /// Silent; never cancels.
  Progress() = default;

  /// Reports to `listener` (called from any thread, one call at a time) and stops when `*cancel`
  /// becomes true. `cancel` may be null and must outlive the object.
  explicit Progress(Listener listener, const std::atomic<bool>* cancel = nullptr);

  /// The next `share` (of 1) of this step's own range, as a step of its own.
  /// Shares given out beyond 1 are cut off.
  Progress step(const std::string& name, double share) const;

  /// Says how far this step has come, 0 to 1, and how it is doing if that is worth a word. Throws
  /// `Cancelled` when asked to stop.
  void at(double fraction, const std::string& detail = {}) const;

  /// Throws `Cancelled` when asked to stop; reports nothing. Cheap enough for inner loops.
  void check() const;

 private:
  struct Root;
  std::shared_ptr<Root> root_;
  std::string path_;
  double begin_ = 0;
  double length_ = 1;
  mutable double given_ = 0;
};

}  // namespace mq
