#pragma once
/// What each source adds to the module.

#include <pybind11/pybind11.h>

namespace mq::python {

void add_held_files(pybind11::module_& module);
void add_verbs(pybind11::module_& module);
void add_spaces(pybind11::module_& module);
void add_equations(pybind11::module_& module);

}  // namespace mq::python
