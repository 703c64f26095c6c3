// SPDX-License-Identifier: Apache-2.0
#include "values.hpp"

#include "arguments.hpp"

#include <span>
#include <string>

namespace vdrive::python {
namespace {

py::tuple plain(const client::BenchInfo& bench) {
  py::dict figures;
  for (const client::Figure& figure : bench.figures) {
    figures[py::str(figure.name.data(), figure.name.size())] = figure.value;
  }
  return py::make_tuple(bench.number, bench.incarnation, bench.name, to_string(bench.clock_mode),
                        seconds_of(bench.period), bench.status_every_ticks, bench.tick,
                        seconds_of(bench.sample_age), bench.rate, figures, bench.wire_starts,
                        seconds_of(bench.longest_silence), bench.user_units_per_revolution,
                        bench.dictionary_version, bench.service_version, bench.host);
}

py::list axes_of_bench(const client::BenchInfo& bench) {
  py::list axes;
  for (const client::AxisInfo& axis : bench.axes) {
    axes.append(py::make_tuple(to_string(axis.id), axis.name, axis.supported_drive_modes,
                               axis.user_position_lower_limit, axis.user_position_upper_limit,
                               axis.app_speed_limit, tuple_of(axis.unit)));
  }
  return axes;
}

}  // namespace

py::tuple tuple_of(const Unit& unit) {
  py::dict sizes;
  sizes["UU"] = 1.0;
  for (const std::string& name : units_of(unit)) sizes[py::str(name)] = user_units_in(unit, name);
  return py::make_tuple(to_string(unit.kind), unit.name, unit.size, sizes);
}

py::tuple tuple_of(const client::AxisSnapshot& axis) {
  const auto image = std::as_bytes(std::span(&axis.status, 1));
  const py::bytes status(reinterpret_cast<const char*>(image.data()),  // NOLINT(*-reinterpret-cast)
                         image.size());
  return py::make_tuple(axis.id.bench, axis.id.axis, axis.tick, axis.owner_session,
                        axis.owner_epoch, axis.last_sequence, axis.skipped, status);
}

py::tuple tuple_of(const client::Event& event) {
  return py::make_tuple(event.bench, event.incarnation, event.axis, to_string(event.kind),
                        event.tick, event.session, event.code, event.error_register,
                        event.suppressed, event.text);
}

py::tuple tuple_of(const client::ServiceChange& change) {
  return py::make_tuple(change.bench, client::to_string(change.news), seconds_of(change.silence),
                        change.text);
}

py::tuple tuple_of(const client::Lateness& lateness) {
  return py::make_tuple(lateness.samples, lateness.late, seconds_of(lateness.last),
                        seconds_of(lateness.longest));
}

void add_values(py::module_& module) {
  py::class_<client::BenchInfo>(module, "BenchInfo")
      .def("plain", &plain)
      .def("axes", &axes_of_bench)
      .def("size", [](const client::BenchInfo& bench) {
        return bench.axes.size();
      });
}

}  // namespace vdrive::python
