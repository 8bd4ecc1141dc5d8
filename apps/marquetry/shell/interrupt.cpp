// A signal's handler may do next to nothing, so it writes a byte into a pipe, and a thread at the
// other end does what there is to do.
#include "shell/interrupt.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/io/atomic_file.h"
#include "shell/verb.h"

namespace mq::app {
namespace {

constexpr int patience_ms = 500;  ///< work that looks up often stops before anyone must be told

std::atomic<bool> stop_requested{false};
std::atomic<int> write_end{-1};
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free);

void on_signal(int signal) {
  const int error = errno;
  if (stop_requested.exchange(true)) std::signal(signal, SIG_DFL);
  const char byte = 0;
  [[maybe_unused]] const ssize_t written = ::write(write_end, &byte, 1);
  errno = error;
}

void answer_signals_with(void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = SA_RESTART;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  // The terminal was closed; not where nohup lets a run outlive it.
  struct sigaction before {};
  sigaction(SIGHUP, nullptr, &before);
  if (before.sa_handler != SIG_IGN) sigaction(SIGHUP, &action, nullptr);
}

/// Waits for the next signal; false when there will be none.
bool next_signal(int pipe) {
  char byte = 0;
  ssize_t got = 0;
  while ((got = ::read(pipe, &byte, 1)) < 0 && errno == EINTR) continue;
  return got == 1;
}

/// "the factorisation", or "'find seams'".
std::string step_in_a_sentence(const std::string& step) {
  return step.find(' ') == std::string::npos ? "the " + step : "'" + step + "'";
}

}  // namespace

std::string what_is_left(Terminal& terminal) {
  const WrittenFiles written = written_files();
  const std::string nothing = "nothing half-written is left";
  if (const std::string safe = terminal.what_is_safe(); !safe.empty()) return nothing + "; " + safe;
  if (written.count == 0) return nothing;
  return fmt::format("{}; {} complete, the last of them {}", nothing,
                     counted(written.count, "file") + (written.count == 1 ? " is" : " are"),
                     written.last.string());
}

namespace {

/// Whether nothing happens for a while.
bool still_working(int pipe) {
  pollfd entry{pipe, POLLIN, 0};
  return ::poll(&entry, 1, patience_ms) == 0;
}

}  // namespace

Interrupt::Interrupt(Terminal& terminal) : terminal_(terminal) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) throw IoError("no pipe can be opened: too many open files");
  read_end_ = ends[0];
  write_end = ends[1];
  thread_ = std::thread([this] { answer(); });
  answer_signals_with(on_signal);
}

Interrupt::~Interrupt() {
  answer_signals_with(SIG_DFL);
  ::close(write_end.exchange(-1));
  thread_.join();
  ::close(read_end_);
}

const std::atomic<bool>& Interrupt::requested() { return stop_requested; }

void Interrupt::answer() {
  if (!next_signal(read_end_)) return;
  if (still_working(read_end_))
    terminal_.remark(fmt::format("finishing {}; press Ctrl-C again to stop at once",
                                 step_in_a_sentence(terminal_.step())));
  if (!next_signal(read_end_)) return;
  const std::string stopped = "stopped at once, " + what_is_left(terminal_);
  const auto no_new_files = remove_unfinished_files();
  terminal_.error(stopped);
  ::_exit(int(Exit::cancelled));
}

}  // namespace mq::app
