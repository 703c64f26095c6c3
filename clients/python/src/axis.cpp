// SPDX-License-Identifier: Apache-2.0
#include "axis.hpp"

#include "arguments.hpp"
#include "vdrive/client/disturbance.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/text.hpp"
#include "vdrive/unit.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

namespace vdrive::python {
namespace {

using client::Axis;
using client::AxisSnapshot;
using client::EachCommand;
using client::Outcome;
using client::Session;

struct CommandName {
  std::string_view name;
  EachCommand command;
};

constexpr std::array kCommandNames{
    CommandName{"enable", EachCommand::enable},
    CommandName{"disable", EachCommand::disable},
    CommandName{"halt", EachCommand::halt},
    CommandName{"resume", EachCommand::resume},
    CommandName{"quick_stop", EachCommand::quick_stop},
    CommandName{"reset_fault", EachCommand::reset_fault},
    CommandName{"power_cycle", EachCommand::power_cycle},
};

struct PyMotion {
  PyMotion(client::Motion handle, PyAxis moved)
      : motion(std::move(handle)), axis(std::move(moved)) {}

  ~PyMotion() {
    if (axis.py_session && axis.py_session->is_inherited()) leave(std::move(motion));
  }

  PyMotion(const PyMotion&) = default;
  PyMotion(PyMotion&&) noexcept = default;
  PyMotion& operator=(const PyMotion&) = default;
  PyMotion& operator=(PyMotion&&) noexcept = default;

  client::Motion motion;
  PyAxis axis;
};

client::Disturbance disturbance_named(std::string_view name) {
  std::string known;
  for (const client::DisturbanceRow& row : client::kDisturbances) {
    if (row.name == name) return row.disturbance;
    known.append(known.empty() ? "" : ", ").append(row.name);
  }
  throw py::value_error("no disturbance " + in_quotes(name) + ": " + known);
}

/// Runs a call of the axis that ends with an outcome.
template <typename Call>
void run(PyAxis& self, const Call& call) {
  check(waiting(self.py_session, [&](Session& /*session*/) {
    return call(self.axis);
  }));
}

/// Runs a call of the axis that gives a value.
template <typename Call>
auto get(PyAxis& self, const Call& call) {
  return value_or_raise(waiting(self.py_session, [&](Session& /*session*/) {
    return call(self.axis);
  }));
}

bool are_the_same(const PyAxis& axis, const PyAxis& other) {
  return axis.py_session == other.py_session && axis.axis.id() == other.axis.id();
}

using AxisClass = py::class_<PyAxis>;

/// A command that has nothing but a time-out and what it waits for.
void add_command(AxisClass& axis, const char* name,
                 Outcome (Axis::*command)(const client::CallOptions&), const char* text) {
  axis.def(
      name,
      [command](PyAxis& self, const Real& timeout, const std::string& until) {
        const client::CallOptions options = call_options(timeout, until);
        run(self, [&](Axis& target) {
          return (target.*command)(options);
        });
      },
      py::kw_only(), py::arg("timeout") = 60.0, py::arg("until") = "done", text);
}

void add_commands(AxisClass& axis) {
  axis.def(
      "enable",
      [](PyAxis& self, const Real& timeout, const std::string& until, bool keep_target) {
        client::CallOptions options = call_options(timeout, until);
        options.keep_target = keep_target;
        run(self, [&](Axis& target) {
          return target.enable(options);
        });
      },
      py::kw_only(), py::arg("timeout") = 60.0, py::arg("until") = "done",
      py::arg("keep_target") = false,
      "Goes to Operation enabled and keeps the axis at rest: 60FFh, 6042h and 6071h become 0 "
      "unless keep_target is true. Refused in a fault: reset it first.");
  add_command(axis, "disable", &Axis::disable, "Goes to Ready to switch on.");
  add_command(
      axis, "halt", &Axis::halt,
      "Brakes to standstill; the set-point stays. Also of an axis that another session holds.");
  add_command(axis, "resume", &Axis::resume, "Ends a halt and continues the set-point.");
  add_command(axis, "quick_stop", &Axis::quick_stop,
              "Quick stop. Also of an axis that another session holds.");
  add_command(axis, "reset_fault", &Axis::reset_fault,
              "Resets a fault. Refused while its cause persists.");
  add_command(axis, "power_cycle", &Axis::power_cycle, "Switches the axis off and on again.");
}

/// @return the unit of that name; nothing where the program names none. @throws py::value_error
std::optional<GivenUnit> unit_named(const PyAxis& self, const std::optional<std::string>& name) {
  if (!name) return std::nullopt;
  const Unit unit = self.axis.unit();
  if (const auto size = user_units_in(unit, *name)) return GivenUnit{*name, *size};
  std::string known = "UU";
  for (const std::string& other : units_of(unit)) known += ", " + other;
  throw py::value_error("axis " + to_string(self.axis.id()) + " has no unit " + in_quotes(*name) +
                        ": " + known);
}

/// The speeds and ramps of a call, in UU or in the unit of the call, per s and s^2.
class Speeds {
 public:
  explicit Speeds(std::optional<GivenUnit> unit) : unit_(std::move(unit)) {}

  [[nodiscard]] std::optional<std::uint32_t> speed(const OptionalNumber& number,
                                                   const char* name) const {
    return whole<std::uint32_t>(number, {name, "UU/s"}, per(" per s"));
  }

  [[nodiscard]] std::optional<std::uint32_t> ramp(const OptionalNumber& number,
                                                  const char* name) const {
    return whole<std::uint32_t>(number, {name, "UU/s^2"}, per(" per s^2"));
  }

  [[nodiscard]] std::int32_t velocity(const Number& number) const {
    return whole<std::int32_t>(number, {"velocity", "UU/s"}, per(" per s"));
  }

 private:
  [[nodiscard]] std::optional<GivenUnit> per(const char* time) const {
    if (!unit_) return std::nullopt;
    return GivenUnit{unit_->name + time, unit_->size};
  }

  std::optional<GivenUnit> unit_;
};

/// The numbers of a move, as a program gives them.
struct GivenMove {
  OptionalNumber velocity;
  OptionalNumber acceleration;
  OptionalNumber deceleration;
  bool queue = false;

  [[nodiscard]] client::MoveOptions options(const std::optional<GivenUnit>& unit,
                                            const client::CallOptions& call) const {
    const Speeds speeds(unit);
    return {.velocity = speeds.speed(velocity, "velocity"),
            .acceleration = speeds.ramp(acceleration, "acceleration"),
            .deceleration = speeds.ramp(deceleration, "deceleration"),
            .queue = queue,
            .call = call};
  }
};

void add_move(AxisClass& axis, const char* name, const char* target,
              Outcome (Axis::*move)(std::int32_t, const client::MoveOptions&), const char* text) {
  axis.def(
      name,
      [move, target](PyAxis& self, const Number& aim, const OptionalNumber& velocity,
                     const OptionalNumber& acceleration, const OptionalNumber& deceleration,
                     const std::optional<std::string>& unit, bool queue, const Real& timeout,
                     const std::string& until) {
        const auto given = unit_named(self, unit);
        const client::MoveOptions options =
            GivenMove{velocity, acceleration, deceleration, queue}.options(
                given, call_options(timeout, until));
        const auto place = whole<std::int32_t>(aim, {target, "UU"}, given);
        run(self, [&](Axis& moved) {
          return (moved.*move)(place, options);
        });
      },
      py::arg(target), py::kw_only(), py::arg("velocity") = py::none(),
      py::arg("acceleration") = py::none(), py::arg("deceleration") = py::none(),
      py::arg("unit") = py::none(), py::arg("queue") = false, py::arg("timeout") = 60.0,
      py::arg("until") = "done", text);
}

void add_moves(AxisClass& axis) {
  add_move(axis, "move_to", "position", &Axis::move_to,
           "Moves to a position in UU. Speed (UU/s) and ramps (UU/s^2) are for this move. With "
           R"(`unit`, such as "deg", all of them are in it, and rounded to UU.)");
  add_move(axis, "move_by", "distance", &Axis::move_by,
           "Moves by a distance in UU, from the base that 60F2h chooses. `unit` as in move_to().");
  axis.def(
      "start_move",
      [](PyAxis& self, const Number& position, const OptionalNumber& velocity,
         const OptionalNumber& acceleration, const OptionalNumber& deceleration,
         const std::optional<std::string>& unit, bool queue) {
        const auto given = unit_named(self, unit);
        const client::MoveOptions options =
            GivenMove{velocity, acceleration, deceleration, queue}.options(given, {});
        const auto place = whole<std::int32_t>(position, {"position", "UU"}, given);
        return PyMotion{get(self,
                            [&](Axis& moved) {
                              return moved.start_move(place, options);
                            }),
                        self};
      },
      py::arg("position"), py::kw_only(), py::arg("velocity") = py::none(),
      py::arg("acceleration") = py::none(), py::arg("deceleration") = py::none(),
      py::arg("unit") = py::none(), py::arg("queue") = false,
      "Starts move_to() and returns when the drive has acknowledged the set-point.");
}

void add_homing(AxisClass& axis) {
  axis.def(
      "home",
      [](PyAxis& self, const OptionalNumber& method, const OptionalNumber& offset,
         const OptionalNumber& search_speed, const OptionalNumber& creep_speed,
         const OptionalNumber& acceleration, const std::optional<std::string>& unit,
         const Real& timeout, const std::string& until) {
        const auto given = unit_named(self, unit);
        const Speeds speeds(given);
        const client::HomingOptions options{
            .method = whole<std::int8_t>(method, {"method"}),
            .offset = whole<std::int32_t>(offset, {"offset", "UU"}, given),
            .search_speed = speeds.speed(search_speed, "search_speed"),
            .creep_speed = speeds.speed(creep_speed, "creep_speed"),
            .acceleration = speeds.ramp(acceleration, "acceleration"),
            .call = call_options(timeout, until)};
        run(self, [&](Axis& homed) {
          return homed.home(options);
        });
      },
      py::kw_only(), py::arg("method") = py::none(), py::arg("offset") = py::none(),
      py::arg("search_speed") = py::none(), py::arg("creep_speed") = py::none(),
      py::arg("acceleration") = py::none(), py::arg("unit") = py::none(), py::arg("timeout") = 60.0,
      py::arg("until") = "done",
      "A homing run: waits until the axis is homed. `unit` as in move_to(), not for the method.");
}

void add_velocity_and_torque(AxisClass& axis) {
  axis.def(
      "run_at",
      [](PyAxis& self, const Number& velocity, const OptionalNumber& acceleration,
         const OptionalNumber& deceleration, const std::optional<std::string>& unit,
         const Real& timeout, const std::string& until) {
        const Speeds speeds(unit_named(self, unit));
        const client::VelocityOptions options{
            .acceleration = speeds.ramp(acceleration, "acceleration"),
            .deceleration = speeds.ramp(deceleration, "deceleration"),
            .call = call_options(timeout, until)};
        const std::int32_t speed = speeds.velocity(velocity);
        run(self, [&](Axis& target) {
          return target.run_at(speed, options);
        });
      },
      py::arg("velocity"), py::kw_only(), py::arg("acceleration") = py::none(),
      py::arg("deceleration") = py::none(), py::arg("unit") = py::none(), py::arg("timeout") = 60.0,
      py::arg("until") = "done",
      "Profile velocity mode: waits until `velocity` (UU/s) is reached. The axis continues to "
      "run. `unit` as in move_to().");
  axis.def(
      "apply_torque",
      [](PyAxis& self, const Number& torque, const OptionalNumber& slope, const Real& timeout,
         const std::string& until) {
        const client::TorqueOptions options{
            .slope = whole<std::uint32_t>(slope, {"slope", "parts of 1,000 per s"}),
            .call = call_options(timeout, until)};
        const auto aim = whole<std::int16_t>(torque, {"torque", "parts of 1,000"});
        run(self, [&](Axis& target) {
          return target.apply_torque(aim, options);
        });
      },
      py::arg("torque"), py::kw_only(), py::arg("slope") = py::none(), py::arg("timeout") = 60.0,
      py::arg("until") = "done",
      "Profile torque mode: waits until `torque` (parts of 1,000 of the rated) is reached. It "
      "stays.");
}

void add_jog(AxisClass& axis) {
  axis.def(
      "jog",
      [](PyAxis& self, const Number& velocity, const py::function& held,
         const OptionalNumber& acceleration, const OptionalNumber& deceleration,
         const std::optional<std::string>& unit, const Real& timeout) {
        const Speeds speeds(unit_named(self, unit));
        const client::VelocityOptions options{
            .acceleration = speeds.ramp(acceleration, "acceleration"),
            .deceleration = speeds.ramp(deceleration, "deceleration"),
            .call = call_options(timeout, "done")};
        const std::int32_t speed = speeds.velocity(velocity);
        KeptException kept;
        const Outcome outcome = waiting(self.py_session, [&](Session& /*session*/) {
          return self.axis.jog(
              speed,
              [&](const AxisSnapshot& status) {
                return kept.run(false, [&] {
                  return is_true(held(status));
                });
              },
              options);
        });
        kept.raise_again();
        check(outcome);
      },
      py::arg("velocity"), py::arg("held"), py::kw_only(), py::arg("acceleration") = py::none(),
      py::arg("deceleration") = py::none(), py::arg("unit") = py::none(), py::arg("timeout") = 60.0,
      "Runs at `velocity` (UU/s) while `held(status)` is true, called every tick, then brakes.");
}

void add_ownership(AxisClass& axis) {
  const auto add = [&axis](const char* name, Outcome (Axis::*call)(), const char* text) {
    axis.def(
        name,
        [call](PyAxis& self) {
          run(self, [call](Axis& target) {
            return (target.*call)();
          });
        },
        text);
  };
  add("acquire", &Axis::acquire, "Takes control. Refused while another session holds the axis.");
  add("take_over", &Axis::take_over, "Takes control, also from another session, which loses it.");
  add("store", &Axis::store, "Stores the parameters (1010h); returns when they are durable.");
  add("restore_defaults", &Axis::restore_defaults,
      "Removes the stored values (1011h), from the next power cycle on.");
  add("end_disturbances", &Axis::end_disturbances, "Ends every disturbance of the axis.");
}

std::string help_of_disturbances() {
  std::string help =
      "Sets an input of the test bench: 1 = on, 0 = off; load_torque in mN.m. Returns the tick in "
      "which it is in force.\n";
  for (const client::DisturbanceRow& row : client::kDisturbances) {
    help.append("\n").append(row.name).append("\n    ").append(text_of(row));
  }
  return help;
}

py::list read_many(PyAxis& self, const py::iterable& objects) {
  std::vector<ObjectAddress> addresses;
  for (const py::handle object : objects) {
    addresses.push_back(object_of(py::reinterpret_borrow<py::object>(object)));
  }
  const client::Readings readings = get(self, [&](Axis& read) {
    return read.read(addresses);
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

void add_objects(AxisClass& axis) {
  axis.def(
      "read",
      [](PyAxis& self, const py::object& object) {
        const ObjectAddress address = object_of(object);
        return get(self, [&](Axis& read) {
          return read.read(address);
        });
      },
      py::arg("object"),
      R"(Reads an object: an index, (index, subindex), or a text such as "profile_velocity" or )"
      R"("0x607D:1".)");
  axis.def("read_many", &read_many, py::arg("objects"),
           "Reads up to 64 objects in one tick. One that is refused is an exception in the list.");
  axis.def(
      "write",
      [](PyAxis& self, const py::object& object, const Number& value) {
        const ObjectAddress address = object_of(object);
        const auto number = whole<std::int64_t>(value, {"value"});
        return get(self, [&](Axis& written) {
          return written.write(address, number);
        });
      },
      py::arg("object"), py::arg("value"),
      "Writes an object. Returns the tick in which the value is in force.");
  axis.def(
      "disturb",
      [](PyAxis& self, const std::string& disturbance, const py::object& value) {
        const client::Disturbance chosen = disturbance_named(disturbance);
        // True and False are what most of the inputs are.
        const auto number = py::isinstance<py::bool_>(value)
                                ? std::int64_t{value.cast<bool>()}
                                : whole<std::int64_t>(Number{value}, {"value"});
        return get(self, [&](Axis& disturbed) {
          return disturbed.disturb(chosen, number);
        });
      },
      py::arg("disturbance"), py::arg("value") = 1, help_of_disturbances().c_str());
}

void add_observing(AxisClass& axis) {
  axis.def(
      "status",
      [](PyAxis& self) {
        return get(self, [](Axis& shown) {
          return shown.status();
        });
      },
      "The present state.");
  axis.def(
      "wait_until",
      [](PyAxis& self, const py::function& condition, const Real& timeout) {
        const std::chrono::nanoseconds limit = nanoseconds_of(timeout, "timeout");
        KeptException kept;
        client::Result<AxisSnapshot> result = waiting(self.py_session, [&](Session& /*session*/) {
          return self.axis.wait_until(
              [&](const AxisSnapshot& status) {
                return kept.run(true, [&] {
                  return is_true(condition(status));
                });
              },
              limit);
        });
        kept.raise_again();
        return value_or_raise(std::move(result));
      },
      py::arg("condition"), py::arg("timeout") = 60.0,
      "Checks every tick until `condition(status)` is true; returns that status. `timeout` in s of "
      "drive time.");
}

void add_motion(py::module_& module) {
  py::class_<PyMotion>(module, "Motion", "A move that was started.")
      .def(
          "wait",
          [](PyMotion& self, const Real& timeout) {
            const std::chrono::nanoseconds limit = nanoseconds_of(timeout, "timeout");
            check(waiting(self.axis.py_session, [&](Session& /*session*/) {
              return self.motion.wait(limit);
            }));
          },
          py::arg("timeout") = 60.0,
          "Waits until the axis is at its target. `timeout` in s of drive time.")
      .def(
          "has_ended",
          [](PyMotion& self) {
            return value_or_raise(waiting(self.axis.py_session, [&](Session& /*session*/) {
              return self.motion.has_ended();
            }));
          },
          "Whether the axis is at its target. Does not wait.")
      .def_property_readonly(
          "axis",
          [](const PyMotion& self) {
            return self.axis;
          },
          "The axis that moves.");
}

[[noreturn]] void refuse_axes(const py::handle& axes) {
  throw py::type_error("axes = " + shown(axes) +
                       ": must be an address, a name, an Axis, or a list of these");
}

client::Axis axis_of(const SharedPySession& py_session, const py::handle& axis) {
  if (py::isinstance<PyAxis>(axis)) {
    const auto& handle = axis.cast<const PyAxis&>();
    if (handle.py_session == py_session) return handle.axis;
    throw py::value_error("axis " + to_string(handle.axis.id()) + " belongs to another session");
  }
  if (!py::isinstance<py::str>(axis)) refuse_axes(axis);
  const auto text = axis.cast<std::string>();
  return value_or_raise(waiting(py_session, [&](Session& session) {
    return session.axis(text);
  }));
}

}  // namespace

std::vector<Axis> axes_of(const SharedPySession& py_session, const py::object& axes) {
  if (axes.is_none()) {
    return value_or_raise(waiting(py_session, [](Session& session) {
      return session.axes();
    }));
  }
  std::vector<Axis> found;
  if (py::isinstance<PyAxis>(axes) || py::isinstance<py::str>(axes)) {
    found.push_back(axis_of(py_session, axes));
    return found;
  }
  if (!py::isinstance<py::iterable>(axes)) refuse_axes(axes);
  for (const py::handle axis : axes) found.push_back(axis_of(py_session, axis));
  return found;
}

std::vector<client::AxisId> ids_of(const std::vector<Axis>& axes) {
  std::vector<client::AxisId> ids;
  ids.reserve(axes.size());
  for (const Axis& axis : axes) ids.push_back(axis.id());
  return ids;
}

EachCommand each_command_of(const std::string& name) {
  const auto* const row = std::ranges::find(kCommandNames, name, &CommandName::name);
  if (row == kCommandNames.end())
    throw py::value_error("no command " + in_quotes(name) + " for several axes");
  return row->command;
}

void add_axis(py::module_& module) {
  py::tuple commands(kCommandNames.size());
  for (std::size_t i = 0; i < kCommandNames.size(); ++i) commands[i] = kCommandNames.at(i).name;
  module.attr("COMMANDS") = commands;
  add_motion(module);
  AxisClass axis(
      module, "Axis",
      "One axis of a bench. A handle: Session.axis() gives it, and several may mean the same "
      "axis. Commands take control of the axis. `timeout` is drive time in s; `until` is "
      R"("done" or "in_force": the drive has acted on the command.)");
  axis.def_property_readonly(
          "id",
          [](const PyAxis& self) {
            return to_string(self.axis.id());
          },
          R"(Address, such as "1.2".)")
      .def_property_readonly(
          "bench",
          [](const PyAxis& self) {
            return self.axis.id().bench;
          },
          "Number of its bench.")
      .def_property_readonly(
          "name",
          [](const PyAxis& self) {
            return self.axis.name();
          },
          "Its name.")
      .def_property_readonly(
          "unit",
          [](const PyAxis& self) {
            return self.axis.unit();
          },
          "The unit of its user units.")
      .def(
          "__eq__",
          [](const PyAxis& self, const py::object& other) {
            return py::isinstance<PyAxis>(other) && are_the_same(self, other.cast<const PyAxis&>());
          },
          "Whether both handles are of one session and mean the same axis.")
      .def("__hash__",
           [](const PyAxis& self) {
             return py::hash(py::make_tuple(self.axis.id().bench, self.axis.id().axis));
           })
      .def("__repr__", [](const PyAxis& self) {
        return "<vdrive.Axis " + to_string(self.axis.id()) + " " + self.axis.name() + ">";
      });
  add_ownership(axis);
  add_commands(axis);
  add_moves(axis);
  add_homing(axis);
  add_velocity_and_torque(axis);
  add_jog(axis);
  add_objects(axis);
  add_observing(axis);
}

}  // namespace vdrive::python
