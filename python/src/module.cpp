// _marquetry: the library and the verbs of the program as Python sees them. The package marquetry, Python
// sources beside it, is what users import; checks of what users give are in both.
#include <pybind11/pybind11.h>

#include "calls.h"
#include "mq/version.h"
#include "parts.h"

PYBIND11_MODULE(_marquetry, module) {
  module.doc() = "The library; see the package marquetry.";
  module.attr("version") = mq::version;
  mq::python::register_errors(module);
  mq::python::add_held_files(module);
  mq::python::add_verbs(module);
  mq::python::add_spaces(module);
  mq::python::add_equations(module);
}
