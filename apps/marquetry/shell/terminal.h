#pragma once
/// What is said on standard error while a verb runs: progress, remarks, warnings, errors.
///
/// On a terminal progress is one line with a bar and an estimate of the time left, redrawn in
/// place; elsewhere it is a plain line now and then. Nothing is shown of work that takes less than
/// a second. Colours only on a terminal, and not when NO_COLOR is set. For programs that start this one,
/// all of it can be lines of JSON instead, of work of any length.

#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "mq/base/progress.h"
#include "mq/model/messages.h"
#include "shell/duration.h"

namespace mq::app {

/// `text` with `to` in every place of `from`, which is not empty.
std::string replaced(std::string text, const std::string& from, const std::string& to);

class Terminal : public Messages {
 public:
  enum class Voice { normal, quiet };

  /// Of a verb, or of the program where there is none, which begins every line.
  explicit Terminal(const std::string& verb, const std::string& program = "marquetry");
  ~Terminal() override;

  /// Quiet: only errors are shown.
  void set_voice(Voice voice) { voice_ = voice; }

  /// json: a line for each thing that is said, an object with "event": "progress" (with "fraction" of the
  /// whole, "step", "detail", "elapsed" and "left" in seconds, null while it cannot be known; at most ten a
  /// second), "remark", "warning" or "error" (with "text").
  enum class Form { text, json };
  void set_form(Form form) { form_ = form; }

  /// Told every remark and warning, from any thread, also where the voice is quiet; empty: nobody is.
  using Listener = std::function<void(const std::string& text)>;
  void set_listener(Listener listener);

  /// From now on this name stands in all that is said for a file that the user does not know of. Before
  /// there are threads that say anything.
  void rename(const std::string& file, const std::string& name);
  std::string renamed(std::string text) const;

  /// From now on what is said is of a part of the work, such as "job 2": it stands before texts, and as
  /// "part" in lines of JSON. Empty: of the whole.
  void set_part(const std::string& part);

  /// That the verb check knows more of this file than was said: for `say_where_more_is` to say once, of the
  /// first such file, when the work is done. Not of a file that the user does not know of.
  void point_to_check(const std::string& file);
  void say_where_more_is();

  /// The innermost step that was last reported, with the frame it belongs to: "frame 3, solve".
  std::string step();

  void progress(const ProgressEvent& event);

  /// That all the rest of the work will take so long, as far as one can know now: estimates go by that.
  void foresee(double seconds);

  void remark(const std::string& text) override;
  void warning(const std::string& text) override;
  void safe(const std::string& text) override;
  std::string what_is_safe();  ///< as it was last said, from any thread
  void error(const std::string& text);

 private:
  using Clock = std::chrono::steady_clock;

  void say(const char* event, const char* color, const std::string& said);
  void line(const char* color, const std::string& message);
  void progress_line(double fraction, double elapsed);
  void tell(const std::string& text);
  void erase_bar();
  void draw_bar(double fraction, double elapsed);

  std::string prefix_;  ///< "marquetry filter: "
  std::string part_;    ///< as it was set
  std::atomic<Voice> voice_ = Voice::normal;
  std::atomic<Form> form_ = Form::text;
  bool is_terminal_;
  bool colored_;
  bool bar_shown_ = false;
  std::string path_ = "work";  ///< of the step last reported
  std::string detail_;         ///< of the same
  Clock::time_point start_ = Clock::now();
  Clock::time_point last_ = start_;
  double fraction_ = 0;  ///< last reported
  TimeLeft left_;
  std::string safe_;
  std::string to_check_;  ///< a file of which check knows more
  std::mutex mutex_, listener_mutex_, safe_mutex_;
  Listener listener_;
  std::vector<std::pair<std::string, std::string>> names_;
};

}  // namespace mq::app
