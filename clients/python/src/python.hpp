// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

/// What every file of the module has in common. The module is private: the classes of the package
/// (vdrive/*.py) have the signatures and texts, check what a program gives, and call it with plain
/// values by position. Times are whole nanoseconds, objects of the dictionary are numbers: see
/// arguments.hpp.
namespace vdrive::python {

namespace py = pybind11;

/// Imports numpy, unless it is imported. Each call whose result may give arrays begins with it. The
/// module does not import numpy: that takes most of the time of `import vdrive`.
/// pybind11 would import numpy at the first array, under the guard of a static variable. Then two
/// threads can stop each other: one waits for the guard and holds the interpreter's lock, the other
/// holds the guard and waits for that lock.
/// @throws py::error_already_set also with what a signal handler raised
inline void load_numpy() {
  py::module_::import("numpy.core.multiarray");
}

// Each adds the classes of its topic to the module.
void add_bench(py::module_& module);
void add_values(py::module_& module);
void add_program(py::module_& module);
void add_status(py::module_& module);
void add_axis(py::module_& module);
void add_axis_bank(py::module_& module);
void add_queues(py::module_& module);
void add_session(py::module_& module);
void add_group(py::module_& module);
void add_step_clock(py::module_& module);
void add_recording(py::module_& module);
void add_judge(py::module_& module);

}  // namespace vdrive::python
