// SPDX-License-Identifier: Apache-2.0
#include "axis.hpp"

#include "arguments.hpp"
#include "values.hpp"
#include "vdrive/client/disturbance.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdrive::python {
namespace {

using client::Axis;
using client::AxisSnapshot;
using client::EachCommand;
using client::Outcome;
using client::Session;
using std::chrono::nanoseconds;

struct CommandRow {
  std::string_view name;
  EachCommand each;
  Outcome (Axis::*command)(const client::CallOptions&);
};

constexpr std::array kCommands{
    CommandRow{"enable", EachCommand::enable, &Axis::enable},
    CommandRow{"disable", EachCommand::disable, &Axis::disable},
    CommandRow{"halt", EachCommand::halt, &Axis::halt},
    CommandRow{"resume", EachCommand::resume, &Axis::resume},
    CommandRow{"quick_stop", EachCommand::quick_stop, &Axis::quick_stop},
    CommandRow{"reset_fault", EachCommand::reset_fault, &Axis::reset_fault},
    CommandRow{"power_cycle", EachCommand::power_cycle, &Axis::power_cycle},
};

/// @throws py::value_error
const CommandRow& command_named(const std::string& name) {
  const auto* const row = std::ranges::find(kCommands, name, &CommandRow::name);
  if (row == kCommands.end()) {
    throw py::value_error("no command " + in_quotes(name) + " for several axes");
  }
  return *row;
}

client::Disturbance disturbance_named(std::string_view name) {
  std::string known;
  for (const client::DisturbanceRow& row : client::kDisturbances) {
    if (row.name == name) return row.disturbance;
    known.append(known.empty() ? "" : ", ").append(row.name);
  }
  throw py::value_error("no disturbance " + in_quotes(name) + ": " + known);
}

using PyMotion = PartOfSession<client::Motion>;

template <Outcome (Axis::*call)()>
void run_plain(PyAxis& self) {
  run(self, [](Axis& axis) {
    return (axis.*call)();
  });
}

void command(PyAxis& self, const std::string& name, std::int64_t timeout, bool in_force,
             bool keep_target) {
  const CommandRow& row = command_named(name);
  client::CallOptions options = call_options(timeout, in_force);
  options.keep_target = keep_target;
  run(self, [&](Axis& axis) {
    return (axis.*row.command)(options);
  });
}

using Speed = std::optional<std::uint32_t>;  // [UU/s] or [UU/s²]

template <Outcome (Axis::*call)(std::int32_t, const client::MoveOptions&)>
void move(PyAxis& self, std::int32_t aim, Speed velocity, Speed acceleration, Speed deceleration,
          bool queue, std::int64_t timeout, bool in_force) {
  const client::MoveOptions options{.velocity = velocity,
                                    .acceleration = acceleration,
                                    .deceleration = deceleration,
                                    .queue = queue,
                                    .call = call_options(timeout, in_force)};
  run(self, [&](Axis& axis) {
    return (axis.*call)(aim, options);
  });
}

PyMotion start_move(PyAxis& self, std::int32_t position, Speed velocity, Speed acceleration,
                    Speed deceleration, bool queue) {
  const client::MoveOptions options{.velocity = velocity,
                                    .acceleration = acceleration,
                                    .deceleration = deceleration,
                                    .queue = queue,
                                    .call = {}};
  return {get(self,
              [&](Axis& axis) {
                return axis.start_move(position, options);
              }),
          self.py_session};
}

void home(PyAxis& self, std::optional<std::int8_t> method, std::optional<std::int32_t> offset,
          Speed search_speed, Speed creep_speed, Speed acceleration, std::int64_t timeout,
          bool in_force) {
  const client::HomingOptions options{.method = method,
                                      .offset = offset,
                                      .search_speed = search_speed,
                                      .creep_speed = creep_speed,
                                      .acceleration = acceleration,
                                      .call = call_options(timeout, in_force)};
  run(self, [&](Axis& axis) {
    return axis.home(options);
  });
}

void run_at(PyAxis& self, std::int32_t velocity, Speed acceleration, Speed deceleration,
            std::int64_t timeout, bool in_force) {
  const client::VelocityOptions options{.acceleration = acceleration,
                                        .deceleration = deceleration,
                                        .call = call_options(timeout, in_force)};
  run(self, [&](Axis& axis) {
    return axis.run_at(velocity, options);
  });
}

void apply_torque(PyAxis& self, std::int16_t torque, std::optional<std::uint32_t> slope,
                  std::int64_t timeout, bool in_force) {
  const client::TorqueOptions options{.slope = slope, .call = call_options(timeout, in_force)};
  run(self, [&](Axis& axis) {
    return axis.apply_torque(torque, options);
  });
}

void jog(PyAxis& self, std::int32_t velocity, const py::function& held, Speed acceleration,
         Speed deceleration, std::int64_t timeout) {
  const client::VelocityOptions options{.acceleration = acceleration,
                                        .deceleration = deceleration,
                                        .call = call_options(timeout, false)};
  KeptException kept;
  const Outcome outcome = waiting(self.py_session, [&](Session& /*session*/) {
    return self.part.jog(
        velocity,
        [&](const AxisSnapshot& status) {
          return kept.run(false, [&] {
            return is_true(held(tuple_of(status)));
          });
        },
        options);
  });
  kept.raise_again();
  check(outcome);
}

py::tuple wait_until(PyAxis& self, const py::function& condition, std::int64_t timeout) {
  KeptException kept;
  client::Result<AxisSnapshot> result = waiting(self.py_session, [&](Session& /*session*/) {
    return self.part.wait_until(
        [&](const AxisSnapshot& status) {
          return kept.run(true, [&] {
            return is_true(condition(tuple_of(status)));
          });
        },
        nanoseconds(timeout));
  });
  kept.raise_again();
  return tuple_of(value_or_raise(std::move(result)));
}

py::list read_many(PyAxis& self, const std::vector<std::uint32_t>& objects) {
  std::vector<ObjectAddress> addresses;
  addresses.reserve(objects.size());
  for (const std::uint32_t object : objects) addresses.push_back(object_of(object));
  const client::Readings readings = get(self, [&](Axis& axis) {
    return axis.read(addresses);
  });
  py::list values;
  for (const client::ObjectReading& reading : readings.objects) {
    if (reading.code == AbortCode::none) {
      values.append(reading.value);
    } else {
      values.append(exception_of(Outcome::refused(
          wire_code(reading.code), "read of " + object_text(reading.object) + " refused")));
    }
  }
  return values;
}

void add_motion(py::module_& module) {
  py::class_<PyMotion>(module, "Motion")
      .def("wait",
           [](PyMotion& self, std::int64_t timeout) {
             run(self, [timeout](client::Motion& motion) {
               return motion.wait(nanoseconds(timeout));
             });
           })
      .def("has_ended", [](PyMotion& self) {
        return get(self, [](client::Motion& motion) {
          return motion.has_ended();
        });
      });
}

void add_disturbances(py::module_& module) {
  py::dict texts;
  for (const client::DisturbanceRow& row : client::kDisturbances) {
    texts[py::str(std::string(row.name))] = text_of(row);
  }
  module.attr("DISTURBANCES") = texts;
}

}  // namespace

std::vector<Axis> axes_of(const SharedPySession& py_session, const GivenAxes& axes) {
  if (!axes) {
    return value_or_raise(waiting(py_session, [](Session& session) {
      return session.axes();
    }));
  }
  std::vector<Axis> found;
  found.reserve(axes->size());
  for (const PyAxis* const axis : *axes) found.push_back(axis->part);
  return found;
}

std::vector<client::AxisId> ids_of(const SharedPySession& py_session, const GivenAxes& axes) {
  std::vector<client::AxisId> ids;
  for (const Axis& axis : axes_of(py_session, axes)) ids.push_back(axis.id());
  return ids;
}

EachCommand each_command_of(const std::string& name) {
  return command_named(name).each;
}

void add_axis(py::module_& module) {
  add_disturbances(module);
  add_motion(module);
  py::class_<PyAxis>(module, "Axis")
      .def("place",
           [](const PyAxis& self) {
             return py::make_tuple(self.part.id().bench, self.part.id().axis);
           })
      .def("name",
           [](const PyAxis& self) {
             return self.part.name();
           })
      .def("unit",
           [](const PyAxis& self) {
             return tuple_of(self.part.unit());
           })
      .def("acquire", &run_plain<&Axis::acquire>)
      .def("take_over", &run_plain<&Axis::take_over>)
      .def("store", &run_plain<&Axis::store>)
      .def("restore_defaults", &run_plain<&Axis::restore_defaults>)
      .def("end_disturbances", &run_plain<&Axis::end_disturbances>)
      .def("command", &command)
      .def("move_to", &move<&Axis::move_to>)
      .def("move_by", &move<&Axis::move_by>)
      .def("start_move", &start_move)
      .def("home", &home)
      .def("run_at", &run_at)
      .def("apply_torque", &apply_torque)
      .def("jog", &jog)
      .def("read",
           [](PyAxis& self, std::uint32_t object) {
             return get(self, [&](Axis& axis) {
               return axis.read(object_of(object));
             });
           })
      .def("read_many", &read_many)
      .def("write",
           [](PyAxis& self, std::uint32_t object, std::int64_t value) {
             return get(self, [&](Axis& axis) {
               return axis.write(object_of(object), value);
             });
           })
      .def("disturb",
           [](PyAxis& self, const std::string& disturbance, std::int64_t value) {
             const client::Disturbance chosen = disturbance_named(disturbance);
             return get(self, [&](Axis& axis) {
               return axis.disturb(chosen, value);
             });
           })
      .def("status",
           [](PyAxis& self) {
             return tuple_of(get(self, [](Axis& axis) {
               return axis.status();
             }));
           })
      .def("wait_until", &wait_until);
}

}  // namespace vdrive::python
