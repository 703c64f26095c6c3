// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

/// What every file of the module has in common.
namespace vdrive::python {

namespace py = pybind11;

// Each adds the classes of its topic to the module.
void add_bench(py::module_& module);
void add_local_bench(py::module_& module);
void add_status(py::module_& module);
void add_axis(py::module_& module);
void add_axis_bank(py::module_& module);
void add_queues(py::module_& module);
void add_session(py::module_& module);
void add_group(py::module_& module);
void add_step_clock(py::module_& module);
void add_recording(py::module_& module);

}  // namespace vdrive::python
