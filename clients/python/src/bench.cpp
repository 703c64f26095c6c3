// SPDX-License-Identifier: Apache-2.0
// What benches are: their descriptions, units, and a private one.
#include "vdrive/client/bench.hpp"

#include "arguments.hpp"
#include "own_bench.hpp"
#include "py_session.hpp"

#include <pybind11/operators.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::python {
namespace {

std::string name_or_number(const client::BenchInfo& bench) {
  return "<vdrive.BenchInfo " + std::to_string(bench.number) + ", " +
         std::to_string(bench.axes.size()) + " axes, " + std::string(to_string(bench.clock_mode)) +
         ">";
}

void add_unit(py::module_& module) {
  py::class_<Unit>(module, "Unit", "The physical unit of the user units (UU) of an axis.")
      .def_property_readonly(
          "kind",
          [](const Unit& unit) {
            return std::string(to_string(unit.kind));
          },
          R"("rotary" or "linear".)")
      .def_readonly("name", &Unit::name,
                    R"(The unit in which positions are shown, such as "deg" or "mm".)")
      .def_readonly("size", &Unit::size, "UU of a revolution; linear: of one `name`.")
      .def(
          "to_user_units",
          [](const Unit& unit, const Number& value) {
            return whole<std::int64_t>(value, {"value", "UU"},
                                       GivenUnit{unit.name, to_user_units(1.0, unit)});
          },
          py::arg("value"),
          "A position in `name`, or a speed or acceleration in it per s or s^2, in UU: rounded to "
          "the nearest.")
      .def(
          "from_user_units",
          [](const Unit& unit, const Real& user_units) {
            return from_user_units(real_of(user_units, {"user_units"}), unit);
          },
          py::arg("user_units"),
          "A position in UU, or a speed or acceleration in UU per s or s^2, in `name`.")
      .def(py::self == py::self, py::arg("other"))
      .def("__hash__",
           [](const Unit& unit) {
             return py::hash(py::make_tuple(unit.name, unit.size));
           })
      .def("__repr__", [](const Unit& unit) {
        return "<vdrive.Unit " + unit.name + ">";
      });
}

void add_axis_info(py::module_& module) {
  using client::AxisInfo;
  py::class_<AxisInfo>(module, "AxisInfo", "The description of an axis that its bench publishes.")
      .def_property_readonly(
          "id",
          [](const AxisInfo& axis) {
            return to_string(axis.id);
          },
          R"(Address, such as "1.2".)")
      .def_readonly("name", &AxisInfo::name, "Its name.")
      .def_readonly("supported_drive_modes", &AxisInfo::supported_drive_modes, "6502h.")
      .def_readonly("user_position_lower_limit", &AxisInfo::user_position_lower_limit,
                    "607Dh:1 at power-up, in UU.")
      .def_readonly("user_position_upper_limit", &AxisInfo::user_position_upper_limit,
                    "607Dh:2 at power-up, in UU.")
      .def_readonly("app_speed_limit", &AxisInfo::app_speed_limit, "607Fh at power-up, in UU/s.")
      .def_readonly("unit", &AxisInfo::unit, "The unit of its user units.")
      .def(py::self == py::self, py::arg("other"))
      .def("__hash__",
           [](const AxisInfo& axis) {
             return py::hash(py::make_tuple(axis.id.bench, axis.id.axis));
           })
      .def("__repr__", [](const AxisInfo& axis) {
        return "<vdrive.AxisInfo " + to_string(axis.id) + " " + axis.name + ">";
      });
}

void add_bench_info(py::module_& module) {
  using client::BenchInfo;
  py::class_<BenchInfo>(module, "BenchInfo", "The description of a bench that it publishes.")
      .def_readonly("number", &BenchInfo::number, "Its number on the domain.")
      .def_readonly("incarnation", &BenchInfo::incarnation,
                    "Of the service: another number after a restart.")
      .def_readonly("name", &BenchInfo::name, "Its name.")
      .def_property_readonly(
          "clock_mode",
          [](const BenchInfo& bench) {
            return std::string(to_string(bench.clock_mode));
          },
          R"("realtime", "lockstep" or "freerun".)")
      .def_property_readonly(
          "period",
          [](const BenchInfo& bench) {
            return seconds_of(bench.period);
          },
          "Drive time of a tick, in s.")
      .def_readonly("status_every_ticks", &BenchInfo::status_every_ticks,
                    "Ticks from one sample of the status stream to the next.")
      .def_readonly("tick", &BenchInfo::tick, "Newest tick received.")
      .def_property_readonly(
          "sample_age",
          [](const BenchInfo& bench) {
            return seconds_of(bench.sample_age);
          },
          "Wall time since its newest sample, in s, at the time of the search.")
      .def_readonly("rate", &BenchInfo::rate, "Drive time over wall time; 0 = paused.")
      .def_property_readonly(
          "figures",
          [](const BenchInfo& bench) {
            py::dict figures;
            for (const client::Figure& figure : bench.figures) {
              figures[py::str(figure.name.data(), figure.name.size())] = figure.value;
            }
            return figures;
          },
          "What it has counted and measured since its start, by the names of bench_state; 0 = not "
          "known yet.")
      .def_readonly("wire_starts", &BenchInfo::wire_starts,
                    "Starts of its network process; 0 = not known yet.")
      .def_property_readonly(
          "longest_silence",
          [](const BenchInfo& bench) {
            return seconds_of(bench.longest_silence);
          },
          "Drive time without a message from an owner after which it loses its axes, in s.")
      .def_readonly("user_units_per_revolution", &BenchInfo::user_units_per_revolution,
                    "UU of a revolution.")
      .def_readonly("dictionary_version", &BenchInfo::dictionary_version,
                    "Version of its object dictionary.")
      .def_readonly("service_version", &BenchInfo::service_version, "Version of vdrived.")
      .def_readonly("axes", &BenchInfo::axes, "Its axes, by number.")
      .def("__repr__", &name_or_number);
}

}  // namespace

void OwnBench::wait_until_ready() {
  const std::optional<std::string> problem = interruptible(
      [this] {
        bench_.get()->end();
      },
      [] {},
      [this] {
        return bench_.get()->wait_until_ready();
      });
  if (problem) raise(client::Outcome::failed(*problem));
}

void add_bench(py::module_& module) {
  add_unit(module);
  add_axis_info(module);
  add_bench_info(module);
  py::class_<OwnBench, std::shared_ptr<OwnBench>>(
      module, "PrivateBench", "A service of this process; use it through vdrive.Bench.")
      .def(py::init(&made_here<OwnBench, const std::string&, const std::vector<std::string>&,
                               std::optional<std::uint32_t>>),
           py::arg("service"), py::arg("arguments"), py::arg("domain") = py::none(),
           "Starts the program `service` and waits until it runs. Without `domain` it has one that "
           "no "
           "other program uses.")
      .def_property_readonly("domain", &OwnBench::domain, "The DDS domain.")
      .def("close", &OwnBench::close, "Ends the service.");
  module.attr("HIGHEST_DOMAIN") = process::PrivateBench::highest_domain();
  module.def("find_service", &process::find_service,
             "The path of vdrived beside the interpreter or in PATH, else None.");
}

}  // namespace vdrive::python
