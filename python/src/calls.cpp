// The work is in a thread of its own, so that the thread that Python called can go on answering: signals reach
// Python's handlers there and nowhere else, and callables are called where their caller expects it.
#include "calls.h"

#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "mq/base/error.h"

namespace mq::python {
namespace {

constexpr std::chrono::milliseconds patience{10};  ///< between looks for signals

struct Message {
  enum class Kind { remark, warning } kind;
  std::string text;
};

class Mail final : public Mailbox {
 public:
  void remark(const std::string& text) override { add({Message::Kind::remark, text}); }
  void warning(const std::string& text) override { add({Message::Kind::warning, text}); }

  void progress(const ProgressEvent& event) {
    const std::lock_guard lock(mutex_);
    event_ = event;
    changed_.notify_all();
  }

  void finish() {
    const std::lock_guard lock(mutex_);
    done_ = true;
    changed_.notify_all();
  }

  /// Waits for anything new, for a while. Whether the work is done.
  bool wait() {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, patience, [&] { return done_ || !messages_.empty() || event_; });
    return done_;
  }

  std::deque<Message> take_messages() {
    const std::lock_guard lock(mutex_);
    return std::exchange(messages_, {});
  }

  std::optional<ProgressEvent> take_event() {
    const std::lock_guard lock(mutex_);
    return std::exchange(event_, {});
  }

 private:
  void add(Message message) {
    const std::lock_guard lock(mutex_);
    messages_.push_back(std::move(message));
    changed_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Message> messages_;
  std::optional<ProgressEvent> event_;
  bool done_ = false;
};

/// Gives back to the system what was freed. The program has glibc do that at once for whatever is large
/// (program.cpp); here that would hold for everything in the process, and for good, so that it is asked for again and
/// again while work goes on, for a hundredth of the time at most: it takes longer where others have freed much.
class FreedMemory {
 public:
  void give_back() {
#ifdef __GLIBC__
    const auto begin = Clock::now();
    if (begin < next_) return;
    malloc_trim(0);
    const auto end = Clock::now();
    next_ = end + std::max<Clock::duration>(shortest, 100 * (end - begin));
#endif
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds shortest{5};
  Clock::time_point next_ = Clock::now() + patience;
};

/// With the lock held. Throws what the listeners and handlers of signals throw.
void deliver(Mail& mail, const Listeners& listeners) {
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  for (const Message& message : mail.take_messages()) {
    const bool warns = message.kind == Message::Kind::warning;
    const py::object& listener = warns ? listeners.warning : listeners.remark;
    if (!listener.is_none()) listener(shown_text(message.text));
  }
  if (const auto event = mail.take_event(); event && !listeners.progress.is_none())
    listeners.progress(event->fraction, shown_text(event->step));
}

}  // namespace

py::str shown_text(const std::string& text) {
  return py::reinterpret_steal<py::str>(
      PyUnicode_DecodeUTF8(text.data(), Py_ssize_t(text.size()), "backslashreplace"));
}

void call(const Listeners& listeners, const std::function<void(const Progress&, Mailbox&)>& work) {
  Mail mail;
  std::atomic<bool> cancel = false;
  std::exception_ptr failure, stopped;
  const Progress progress(listeners.progress.is_none()
                              ? Progress::Listener()
                              : [&](const ProgressEvent& event) { mail.progress(event); },
                          &cancel);
  std::thread worker([&] {
    try {
      work(progress, mail);
    } catch (...) {
      failure = std::current_exception();
    }
    mail.finish();
  });
  FreedMemory freed;
  for (bool done = false; !done;) {
    {
      const py::gil_scoped_release released;
      done = mail.wait();
      if (done) worker.join();
      freed.give_back();
    }
    if (stopped) continue;
    try {
      deliver(mail, listeners);
    } catch (...) {
      stopped = std::current_exception();
      cancel = true;
    }
  }
  if (stopped) std::rethrow_exception(stopped);
  if (failure) std::rethrow_exception(failure);
  if (!listeners.progress.is_none()) listeners.progress(1.0, "done");
}

void call(const py::object& progress, const std::function<void(const Progress&)>& work) {
  call(Listeners{.progress = progress},
       [&](const Progress& inner, Mailbox&) { work(inner); });
}

namespace {

void raise_as(const char* name, const std::exception& error) {
  const py::object type = py::module_::import("marquetry._errors").attr(name);
  PyErr_SetObject(type.ptr(), shown_text(error.what()).ptr());
}

}  // namespace

void register_errors(py::module_&) {
  py::register_exception_translator([](std::exception_ptr pointer) {
    try {
      if (pointer) std::rethrow_exception(pointer);
    } catch (const InvalidInput& error) {
      raise_as("InvalidInput", error);
    } catch (const IoError& error) {
      raise_as("IoError", error);
    } catch (const SolverError& error) {
      raise_as("SolverError", error);
    } catch (const OutOfMemory& error) {
      raise_as("OutOfMemory", error);
    } catch (const Unsupported& error) {
      raise_as("Unsupported", error);
    } catch (const Cancelled& error) {
      raise_as("Cancelled", error);
    } catch (const Error& error) {
      raise_as("Error", error);
    }
  });
}

}  // namespace mq::python
