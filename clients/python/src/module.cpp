// SPDX-License-Identifier: Apache-2.0
#include "fork.hpp"
#include "interpreter_lock.hpp"
#include "python.hpp"
#include "vdrive/client/session.hpp"

PYBIND11_MODULE(_vdrive, module) {
  namespace py = pybind11;
  module.attr("__version__") = VDRIVE_VERSION;
  vdrive::python::add_bench(module);
  vdrive::python::add_values(module);
  vdrive::python::add_program(module);
  vdrive::python::add_status(module);
  vdrive::python::add_axis(module);
  vdrive::python::add_axis_bank(module);
  vdrive::python::add_queues(module);
  vdrive::python::add_session(module);
  vdrive::python::add_group(module);
  vdrive::python::add_step_clock(module);
  vdrive::python::add_recording(module);
  vdrive::python::add_judge(module);
  module.def("default_domain", &vdrive::client::default_domain);
  vdrive::python::watch_forks();
  // At the start of Python's shutdown: releases axes and ends threads.
  py::module_::import("atexit").attr("register")(py::cpp_function(&vdrive::python::end_calls));
}
