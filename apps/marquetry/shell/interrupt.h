#pragma once
/// Ctrl-C: the first asks the work to stop, the second ends the program at once.

#include <atomic>
#include <string>
#include <thread>

#include "shell/terminal.h"

namespace mq::app {

/// What a run that is stopped leaves: "nothing half-written is left", and how many files it had
/// finished by then; or, as some of them may not be finished then, what the terminal was told to be
/// safe, if it was.
std::string what_is_left(Terminal& terminal);

/// While one exists, SIGINT, SIGTERM and SIGHUP (unless that is ignored, as under nohup) are
/// answered so: the first sets `requested`, which the library's `Progress` looks at; where the work
/// does not stop within half a second, the terminal says what it is finishing. The second removes
/// half-written files and ends the program with status 130. A third ends it as the system does. At
/// most one exists at a time.
class Interrupt {
 public:
  explicit Interrupt(Terminal& terminal);
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  static const std::atomic<bool>& requested();

 private:
  void answer();

  Terminal& terminal_;
  int read_end_ = -1;
  std::thread thread_;
};

}  // namespace mq::app
