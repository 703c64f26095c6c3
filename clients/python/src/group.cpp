// SPDX-License-Identifier: Apache-2.0
// Axes that move together.
#include "arguments.hpp"
#include "axis.hpp"
#include "py_session.hpp"
#include "vdrive/client/axis_group.hpp"
#include "vdrive/text.hpp"

#include <pybind11/eigen.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::python {
namespace {

using client::AxisGroup;
using client::GroupCallOptions;
using client::GroupMoveOptions;
using client::GroupStatus;
using client::Outcome;
using client::Session;
using Progress = std::optional<py::function>;
using Vector = Eigen::VectorXd;

struct PyGroup {
  PyGroup(AxisGroup handle, SharedPySession keeper)
      : group(std::move(handle)), py_session(std::move(keeper)) {}

  ~PyGroup() {
    if (py_session && py_session->is_inherited()) leave(std::move(group));
  }

  PyGroup(const PyGroup&) = default;
  PyGroup(PyGroup&&) noexcept = default;
  PyGroup& operator=(const PyGroup&) = default;
  PyGroup& operator=(PyGroup&&) noexcept = default;

  AxisGroup group;
  SharedPySession py_session;
};

using GroupClass = py::class_<PyGroup>;

/// The options of a call, with the exception that its observer in Python may raise.
class GroupCall {
 public:
  GroupCall(const PyGroup& group, const OptionalReal& timeout, const std::string& until,
            Progress progress)
      : progress_(std::move(progress)), py_session_(group.py_session) {
    if (timeout) options.timeout = nanoseconds_of(*timeout, "timeout");
    options.until = until_of(until);
    if (!progress_) return;
    options.progress = [this](const client::GroupProgress& seen) {
      observe(seen);
    };
  }

  GroupCallOptions options;

  /// Runs the call. @throws py::error_already_set with what the observer raised, else when it
  /// failed
  template <typename Call>
  void run(PyGroup& group, const Call& call) {
    const Outcome outcome = waiting(group.py_session, [&](Session& /*session*/) {
      return call(group.group);
    });
    if (has_raised_) py_session_->end_interrupt();
    kept_.raise_again();
    check(outcome);
  }

 private:
  void observe(const client::GroupProgress& seen) {
    const bool goes_on = kept_.run(false, [&] {
      (*progress_)(seen.tick, seen.fraction);
      return true;
    });
    if (goes_on || has_raised_) return;
    has_raised_ = true;
    py_session_->interrupt();
  }

  Progress progress_;
  SharedPySession py_session_;
  KeptException kept_;
  bool has_raised_ = false;
};

PyGroup open_group(const SharedPySession& py_session, const py::object& axes) {
  load_numpy();
  const std::vector<client::Axis> found = axes_of(py_session, axes);
  if (found.empty()) throw py::value_error("axes = " + shown(axes) + ": needs at least one axis");
  return {value_or_raise(waiting(py_session,
                                 [&](Session& session) {
                                   return AxisGroup::create(session, found);
                                 })),
          py_session};
}

/// @throws py::value_error unless there is a number for each axis
Vector vector_for(const PyGroup& group, const std::vector<double>& numbers) {
  const std::size_t axes = group.group.axes().size();
  if (numbers.size() != axes) {
    throw py::value_error("the group has " + std::to_string(axes) + " axes, not " +
                          std::to_string(numbers.size()));
  }
  return Eigen::Map<const Vector>(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
}

/// The positions or distances of a line, as those of a single axis: a fraction is refused.
Vector whole_positions(const PyGroup& group, const py::iterable& row, const char* argument) {
  std::vector<double> positions;
  for_each_in(row, argument, [&positions](const py::object& number, const char* name) {
    positions.push_back(whole<std::int32_t>(Number{number}, {name, "UU"}));
  });
  return vector_for(group, positions);
}

/// The set-points that a program calculates: they are rounded.
Vector set_points_of(const PyGroup& group, const py::iterable& row) {
  std::vector<double> set_points;
  for_each_in(row, "set_points", [&set_points](const py::object& number, const char* name) {
    set_points.push_back(real_of(Real{number}, {name}));
  });
  return vector_for(group, set_points);
}

client::Streamed streamed_of(const std::string& what) {
  if (what == "positions") return client::Streamed::positions;
  if (what == "velocities") return client::Streamed::velocities;
  if (what == "torques") return client::Streamed::torques;
  throw py::value_error(R"(what is "positions", "velocities" or "torques", not )" +
                        in_quotes(what));
}

double factor_of(const Real& factor, const char* name) {
  const double number = real_of(factor, {name});
  if (number > 0.0 && number <= 1.0) return number;
  throw py::value_error(std::string(name) + " = " + shown(factor.value) +
                        ": must be above 0 and at most 1");
}

/// How fast a group moves, as a program gives it.
struct GivenFactors {
  Real velocity;
  Real acceleration;
  Real deceleration;

  [[nodiscard]] GroupMoveOptions options(const GroupCallOptions& call) const {
    return {.velocity_factor = factor_of(velocity, "velocity_factor"),
            .acceleration_factor = factor_of(acceleration, "acceleration_factor"),
            .deceleration_factor = factor_of(deceleration, "deceleration_factor"),
            .call = call};
  }
};

void add_call(GroupClass& group, const char* name,
              Outcome (AxisGroup::*call)(const GroupCallOptions&), const char* text) {
  group.def(
      name,
      [call](PyGroup& self, const OptionalReal& timeout, const std::string& until,
             Progress progress) {
        GroupCall made(self, timeout, until, std::move(progress));
        made.run(self, [&](AxisGroup& called) {
          return (called.*call)(made.options);
        });
      },
      py::kw_only(), py::arg("timeout") = py::none(), py::arg("until") = "done",
      py::arg("progress") = py::none(), text);
}

void add_group_move(GroupClass& group, const char* name, const char* numbers,
                    Outcome (AxisGroup::*move)(const Vector&, const GroupMoveOptions&),
                    const char* text) {
  group.def(
      name,
      [move, numbers](PyGroup& self, const py::iterable& row, const Real& velocity_factor,
                      const Real& acceleration_factor, const Real& deceleration_factor,
                      const OptionalReal& timeout, const std::string& until, Progress progress) {
        const Vector aims = whole_positions(self, row, numbers);
        GroupCall made(self, timeout, until, std::move(progress));
        const GroupMoveOptions options =
            GivenFactors{velocity_factor, acceleration_factor, deceleration_factor}.options(
                made.options);
        made.run(self, [&](AxisGroup& moved) {
          return (moved.*move)(aims, options);
        });
      },
      py::arg(numbers), py::kw_only(), py::arg("velocity_factor") = 1.0,
      py::arg("acceleration_factor") = 1.0, py::arg("deceleration_factor") = 1.0,
      py::arg("timeout") = py::none(), py::arg("until") = "done", py::arg("progress") = py::none(),
      text);
}

void add_calls(GroupClass& group) {
  group.def(
      "enable_all",
      [](PyGroup& self, const OptionalReal& timeout, const std::string& until, Progress progress,
         bool keep_target) {
        GroupCall made(self, timeout, until, std::move(progress));
        made.options.keep_target = keep_target;
        made.run(self, [&](AxisGroup& called) {
          return called.enable_all(made.options);
        });
      },
      py::kw_only(), py::arg("timeout") = py::none(), py::arg("until") = "done",
      py::arg("progress") = py::none(), py::arg("keep_target") = false,
      "Brings every axis to Operation enabled, at rest, as Axis.enable() does.");
  add_call(group, "disable_all", &AxisGroup::disable_all,
           "Shutdown of every axis without a fault. Drops the queue.");
  add_call(group, "wait_all", &AxisGroup::wait_all,
           "Waits until the present move and the queue have ended.");
  add_call(group, "halt_all", &AxisGroup::halt_all,
           "Brakes to standstill; the move and the queue stay.");
  add_call(group, "resume_all", &AxisGroup::resume_all, "Continues a halted move.");
  add_call(group, "quick_stop_all", &AxisGroup::quick_stop_all,
           "Quick stop of every axis without a fault. Drops the queue.");
  add_call(group, "reset_all", &AxisGroup::reset_all,
           "Resets the fault of every axis that has one.");
  add_call(group, "stop_streaming", &AxisGroup::stop_streaming,
           "Back to profile position mode; the axes brake to rest.");
  group.def(
      "take_over",
      [](PyGroup& self) {
        check(waiting(self.py_session, [&](Session& /*session*/) {
          return self.group.take_over();
        }));
      },
      "Takes control of every axis, also from other sessions.");
}

void add_group_moves(GroupClass& group) {
  add_group_move(
      group, "move_together", "targets", &AxisGroup::move_together,
      "A straight line to absolute positions (whole UU): all axes start on one tick and arrive on "
      "one tick. progress(tick, fraction) is called at every tick that the call observes.");
  add_group_move(group, "move_by", "displacements", &AxisGroup::move_by,
                 "The same by displacements (whole UU) from the demand positions.");
  group.def(
      "queue_move",
      [](PyGroup& self, const py::iterable& targets, const Real& velocity_factor,
         const Real& acceleration_factor, const Real& deceleration_factor) {
        const Vector aims = whole_positions(self, targets, "targets");
        const GroupMoveOptions options =
            GivenFactors{velocity_factor, acceleration_factor, deceleration_factor}.options({});
        check(waiting(self.py_session, [&](Session& /*session*/) {
          return self.group.queue_move(aims, options);
        }));
      },
      py::arg("targets"), py::kw_only(), py::arg("velocity_factor") = 1.0,
      py::arg("acceleration_factor") = 1.0, py::arg("deceleration_factor") = 1.0,
      "Appends a move_together(). It starts in wait_all() or poll().");
}

GroupStatus status_from(PyGroup& self, client::Result<GroupStatus> (*call)(AxisGroup&)) {
  return value_or_raise(waiting(self.py_session, [&](Session& /*session*/) {
    return call(self.group);
  }));
}

void add_state(GroupClass& group) {
  group.def(
      "status",
      [](PyGroup& self) {
        return status_from(self, [](AxisGroup& shown) {
          return shown.status();
        });
      },
      "The present state of all axes.");
  group.def(
      "poll",
      [](PyGroup& self) {
        return status_from(self, [](AxisGroup& polled) {
          return polled.poll();
        });
      },
      "Checks the group once: stops the others when an axis failed, starts the next move.");
  group.def(
      "monitor",
      [](PyGroup& self, bool on) {
        check(waiting(self.py_session, [&](Session& /*session*/) {
          return self.group.monitor(on);
        }));
      },
      py::arg("on"), "Real time: checks for faults in a separate thread while no call waits.");
}

void add_streaming(GroupClass& group) {
  group.def(
      "start_streaming",
      [](PyGroup& self, const Real& lead, const std::string& pace, const std::string& what) {
        const client::StreamOptions options{
            .lead = nanoseconds_of(lead, "lead"), .pace = pace_of(pace), .what = streamed_of(what)};
        check(waiting(self.py_session, [&](Session& /*session*/) {
          return self.group.start_streaming(options);
        }));
      },
      py::kw_only(), py::arg("lead") = 0.01, py::arg("pace") = "drive",
      py::arg("what") = "positions",
      "The cyclic synchronous mode of `what` on every axis, from rest: \"positions\" (UU), "
      "\"velocities\" (UU/s) or \"torques\" (per mille of rated). `lead`: s ahead in real time.");
  group.def(
      "stream",
      [](PyGroup& self, const py::iterable& set_points) {
        const Vector next = set_points_of(self, set_points);
        return value_or_raise(waiting(self.py_session, [&](Session& /*session*/) {
          return self.group.stream(next);
        }));
      },
      py::arg("set_points"),
      "The set-points of the next tick, rounded to whole ones. In lock-step it steps one tick.");
}

void add_group_status(py::module_& module) {
  py::class_<GroupStatus>(module, "GroupStatus", "All axes of a group after one tick.")
      .def_readonly("tick", &GroupStatus::tick, "The tick, of the first axis' bench.")
      .def_property_readonly(
          "state",
          [](const GroupStatus& status) {
            return std::string(to_string(status.state));
          },
          R"("disabled", "standby", "moving", "stopping" or "error_stop".)")
      .def_readonly("queued", &GroupStatus::queued, "Moves that have not started yet.")
      .def_readonly("axes", &GroupStatus::axes, "Status of each axis.")
      .def_property_readonly("demand", &GroupStatus::demand, "6062h of each axis (UU), numpy.")
      .def_property_readonly("actual", &GroupStatus::actual, "6064h of each axis (UU), numpy.")
      .def_property_readonly(
          "not_following",
          [](const GroupStatus& status) {
            std::vector<std::string> axes;
            for (const client::AxisId& axis : status.not_following())
              axes.push_back(to_string(axis));
            return axes;
          },
          "In cyclic streaming: the axes whose demand is not the streamed position.")
      .def("__repr__", [](const GroupStatus& status) {
        return "<vdrive.GroupStatus tick " + std::to_string(status.tick) + ", " +
               std::string(to_string(status.state)) + ">";
      });
}

}  // namespace

void add_group(py::module_& module) {
  add_group_status(module);
  GroupClass group(
      module, "AxisGroup",
      "Axes that move together, on one bench or on several that share a clock. When one "
      "fails the others are stopped. Positions are numpy arrays in UU, in the order of the "
      "group. `timeout` is drive time in s: by default 60, for a move its duration and 5.");
  group
      .def(py::init(&open_group), py::arg("session").none(false), py::arg("axes"),
           "axes: addresses, names or axes, each once.")
      .def_property_readonly(
          "axes",
          [](const PyGroup& self) {
            std::vector<std::string> axes;
            for (const client::AxisId& axis : self.group.axes()) axes.push_back(to_string(axis));
            return axes;
          },
          "Addresses of the axes, in the order of the group.")
      .def("__repr__", [](const PyGroup& self) {
        return "<vdrive.AxisGroup of " + std::to_string(self.group.axes().size()) + " axes>";
      });
  add_calls(group);
  add_group_moves(group);
  add_state(group);
  add_streaming(group);
}

}  // namespace vdrive::python
