#pragma once
/// The library called from Python: without the interpreter's lock, stopped by Ctrl-C, with progress and
/// messages handed to Python by the thread that called.

#include <pybind11/pybind11.h>

#include <functional>
#include <string>

#include "mq/base/progress.h"

namespace mq::python {

namespace py = pybind11;

/// What work that is under way has to say; from any thread.
class Mailbox {
 public:
  virtual ~Mailbox() = default;
  virtual void remark(const std::string& text) = 0;
  virtual void warning(const std::string& text) = 0;
};

/// Whom to tell: callables of Python, or None.
struct Listeners {
  py::object progress = py::none();  ///< (fraction, step); (1, "done") where the work was
  py::object remark = py::none();    ///< (text)
  py::object warning = py::none();   ///< (text)
};

/// Does `work` in another thread while this one waits without the lock, calls the listeners and looks for
/// signals. An exception of a listener or a signal's handler stops the work and is thrown when it has
/// stopped; otherwise what the work throws is. `work` must not touch Python.
void call(const Listeners& listeners, const std::function<void(const Progress&, Mailbox&)>& work);

/// The same with a listener for progress alone.
void call(const py::object& progress, const std::function<void(const Progress&)>& work);

/// A text of the library, which may hold names of files in any encoding: bytes that are not UTF-8 are written \xfc.
py::str shown_text(const std::string& text);

/// Makes errors of the library those of marquetry._errors.
void register_errors(py::module_& module);

}  // namespace mq::python
