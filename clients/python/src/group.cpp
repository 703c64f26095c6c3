// SPDX-License-Identifier: Apache-2.0
// Axes that move together.
#include "arguments.hpp"
#include "axis.hpp"
#include "py_session.hpp"
#include "values.hpp"
#include "vdrive/client/axis_group.hpp"

#include <pybind11/eigen.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
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
using Timeout = std::optional<std::int64_t>;  // [ns] nothing: the default of the call
using Vector = Eigen::VectorXd;

using PyGroup = PartOfSession<AxisGroup>;

/// The options of a call, and the exception that its Python observer may raise.
class GroupCall {
 public:
  GroupCall(const PyGroup& group, Timeout timeout, bool in_force, Progress progress)
      : progress_(std::move(progress)), py_session_(group.py_session) {
    if (timeout) options.timeout = std::chrono::nanoseconds(*timeout);
    if (in_force) options.until = client::Until::in_force;
    if (!progress_) return;
    options.progress = [this](const client::GroupProgress& seen) {
      observe(seen);
    };
  }

  GroupCallOptions options;

  /// Runs the call.
  /// @throws py::error_already_set with the exception of the observer; otherwise if the call failed
  template <typename Call>
  void run(PyGroup& group, const Call& call) {
    const Outcome outcome = waiting(group.py_session, [&](Session& /*session*/) {
      return call(group.part);
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

PyGroup open_group(const SharedPySession& py_session, const GivenAxes& axes) {
  load_numpy();
  const std::vector<client::Axis> found = axes_of(py_session, axes);
  return {value_or_raise(waiting(py_session,
                                 [&](Session& session) {
                                   return AxisGroup::create(session, found);
                                 })),
          py_session};
}

/// @throws py::value_error unless there is one number per axis
Vector vector_for(const PyGroup& group, const std::vector<double>& numbers) {
  const std::size_t axes = group.part.axes().size();
  if (numbers.size() != axes) {
    throw py::value_error("the group has " + std::to_string(axes) + " axes, not " +
                          std::to_string(numbers.size()));
  }
  return Eigen::Map<const Vector>(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
}

client::Streamed streamed_of(const std::string& what) {
  if (what == "velocities") return client::Streamed::velocities;
  return what == "torques" ? client::Streamed::torques : client::Streamed::positions;
}

std::vector<std::string> names_of(const std::vector<client::AxisId>& axes) {
  std::vector<std::string> names;
  names.reserve(axes.size());
  for (const client::AxisId& axis : axes) names.push_back(to_string(axis));
  return names;
}

template <Outcome (AxisGroup::*call)(const GroupCallOptions&)>
void run_call(PyGroup& self, Timeout timeout, bool in_force, Progress progress) {
  GroupCall made(self, timeout, in_force, std::move(progress));
  made.run(self, [&](AxisGroup& group) {
    return (group.*call)(made.options);
  });
}

void enable_all(PyGroup& self, Timeout timeout, bool in_force, Progress progress,
                bool keep_target) {
  GroupCall made(self, timeout, in_force, std::move(progress));
  made.options.keep_target = keep_target;
  made.run(self, [&](AxisGroup& group) {
    return group.enable_all(made.options);
  });
}

/// Factors of velocity, acceleration and deceleration for a group.
using Factors = std::array<double, 3>;

GroupMoveOptions move_options(const Factors& factors, const GroupCallOptions& call) {
  const auto& [velocity, acceleration, deceleration] = factors;
  return {.velocity_factor = velocity,
          .acceleration_factor = acceleration,
          .deceleration_factor = deceleration,
          .call = call};
}

template <Outcome (AxisGroup::*move)(const Vector&, const GroupMoveOptions&)>
void run_move(PyGroup& self, const std::vector<double>& aims, const Factors& factors,
              Timeout timeout, bool in_force, Progress progress) {
  GroupCall made(self, timeout, in_force, std::move(progress));
  const Vector vector = vector_for(self, aims);
  const GroupMoveOptions options = move_options(factors, made.options);
  made.run(self, [&](AxisGroup& group) {
    return (group.*move)(vector, options);
  });
}

template <auto call, typename... Values>
GroupStatus status_from(PyGroup& self, const Values&... values) {
  return get(self, [&](AxisGroup& group) {
    return (group.*call)(values...);
  });
}

void add_group_status(py::module_& module) {
  py::class_<GroupStatus>(module, "GroupStatus")
      .def_readonly("tick", &GroupStatus::tick)
      .def("state",
           [](const GroupStatus& status) {
             return to_string(status.state);
           })
      .def_readonly("queued", &GroupStatus::queued)
      .def("axes",
           [](const GroupStatus& status) {
             return tuples_of(status.axes);
           })
      .def("demand", &GroupStatus::demand)
      .def("actual", &GroupStatus::actual)
      .def("not_following", [](const GroupStatus& status) {
        return names_of(status.not_following());
      });
}

}  // namespace

void add_group(py::module_& module) {
  add_group_status(module);
  py::class_<PyGroup>(module, "AxisGroup")
      .def(py::init(&open_group))
      .def("axes",
           [](const PyGroup& self) {
             return names_of(self.part.axes());
           })
      .def("enable_all", &enable_all)
      .def("disable_all", &run_call<&AxisGroup::disable_all>)
      .def("wait_all", &run_call<&AxisGroup::wait_all>)
      .def("halt_all", &run_call<&AxisGroup::halt_all>)
      .def("resume_all", &run_call<&AxisGroup::resume_all>)
      .def("quick_stop_all", &run_call<&AxisGroup::quick_stop_all>)
      .def("reset_all", &run_call<&AxisGroup::reset_all>)
      .def("stop_streaming", &run_call<&AxisGroup::stop_streaming>)
      .def("move_together", &run_move<&AxisGroup::move_together>)
      .def("move_by", &run_move<&AxisGroup::move_by>)
      .def("queue_move",
           [](PyGroup& self, const std::vector<double>& targets, const Factors& factors) {
             const Vector aims = vector_for(self, targets);
             run(self, [&](AxisGroup& group) {
               return group.queue_move(aims, move_options(factors, {}));
             });
           })
      .def("take_over",
           [](PyGroup& self) {
             run(self, [](AxisGroup& group) {
               return group.take_over();
             });
           })
      .def("status", &status_from<&AxisGroup::status>)
      .def("poll", &status_from<&AxisGroup::poll>)
      .def("monitor",
           [](PyGroup& self, bool on) {
             run(self, [on](AxisGroup& group) {
               return group.monitor(on);
             });
           })
      .def("start_streaming",
           [](PyGroup& self, std::int64_t lead, bool observes, const std::string& what) {
             const client::StreamOptions options{.lead = std::chrono::nanoseconds(lead),
                                                 .pace = pace_of(observes),
                                                 .what = streamed_of(what)};
             run(self, [&](AxisGroup& group) {
               return group.start_streaming(options);
             });
           })
      .def("stream", [](PyGroup& self, const std::vector<double>& set_points) {
        return status_from<&AxisGroup::stream>(self, vector_for(self, set_points));
      });
}

}  // namespace vdrive::python
