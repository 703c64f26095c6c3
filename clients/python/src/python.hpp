// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

/// Shared by all files of the module. The module is private: the classes of the package
/// (vdrive/*.py) provide signatures and docstrings, check arguments, and call the module with plain
/// values by position. Times are integer nanoseconds, objects of the dictionary are numbers: see
/// arguments.hpp.
namespace vdrive::python {

namespace py = pybind11;

/// Imports numpy unless it is imported already. To be called first in every call whose result may
/// contain arrays. The module itself does not import numpy, which takes most of the time of `import
/// vdrive`.
///
/// Without this, pybind11 would import numpy at the first array, under the guard of a static
/// variable. Two threads could then deadlock: one waits for the guard and holds the interpreter
/// lock, the other holds the guard and waits for that lock.
/// @throws py::error_already_set, also with the exception of a signal handler
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
