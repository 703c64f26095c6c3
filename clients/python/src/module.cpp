// SPDX-License-Identifier: Apache-2.0
#include "fork.hpp"
#include "interpreter_lock.hpp"
#include "python.hpp"
#include "vdrive/client/disturbance.hpp"
#include "vdrive/client/session.hpp"

#include <string>

PYBIND11_MODULE(_vdrive, module) {
  namespace py = pybind11;
  module.doc() = "The C++ part of `import vdrive`: the client library of vdrive.";
  module.attr("__version__") = VDRIVE_VERSION;
  vdrive::python::add_arguments(module);
  vdrive::python::add_bench(module);
  vdrive::python::add_local_bench(module);
  vdrive::python::add_program(module);
  vdrive::python::add_status(module);
  vdrive::python::add_axis(module);
  vdrive::python::add_axis_bank(module);
  vdrive::python::add_queues(module);
  vdrive::python::add_session(module);
  vdrive::python::add_group(module);
  vdrive::python::add_step_clock(module);
  vdrive::python::add_recording(module);
  py::tuple disturbances(vdrive::client::kDisturbances.size());
  for (std::size_t i = 0; i < disturbances.size(); ++i) {
    disturbances[i] = std::string(vdrive::client::kDisturbances.at(i).name);
  }
  module.attr("DISTURBANCES") = disturbances;
  module.def("default_domain", &vdrive::client::default_domain,
             "The DDS domain that VDRIVE_DOMAIN names, 0 when it is not set.");
  vdrive::python::complete_classes(module);
  vdrive::python::watch_forks();
  // Python's last act before it takes itself apart: axes are given back, threads have ended.
  py::module_::import("atexit").attr("register")(py::cpp_function(&vdrive::python::end_calls));
}
