// SPDX-License-Identifier: Apache-2.0
#include "vdrive/client/step_clock.hpp"

#include "arguments.hpp"
#include "py_session.hpp"

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

namespace vdrive::python {
namespace {

using client::Outcome;
using client::Session;
using client::StepClock;
using Ticks = client::Result<std::vector<std::uint64_t>>;

// Wall time after which a step that waits for others checks whether it has to end.
constexpr std::chrono::milliseconds kSliceOfStep{100};

class OwnClock final : public Dependent {
 public:
  OwnClock(SharedPySession py_session, StepClock clock)
      : py_session_(std::move(py_session)), clock_(std::move(clock)) {}

  void close() noexcept override {
    if (origin.is_inherited()) return;
    const std::scoped_lock lock(mutex_);
    clock_.reset();
  }

  /// @param step called again with what is left of `patience` while it times out
  template <typename Step>
  std::vector<std::uint64_t> step(const Real& patience, const Step& step) {
    const std::chrono::milliseconds limit = milliseconds_of(patience, "patience");
    return value_or_raise(waiting(py_session_, [&](Session& session) {
      return steps(session, limit, step);
    }));
  }

  [[nodiscard]] double now() {
    origin.require_own("the clock");
    return value_or_raise([this]() -> client::Result<double> {
      const Unlocked unlocked;  // a step of another thread may be under way
      const std::scoped_lock lock(mutex_);
      if (!clock_) return Outcome::failed("the clock is closed");
      return seconds_of(clock_->now());
    }());
  }

 private:
  template <typename Step>
  Ticks steps(Session& session, std::chrono::milliseconds patience, const Step& step) {
    const auto deadline = std::chrono::steady_clock::now() + patience;
    while (true) {
      const std::scoped_lock lock(mutex_);
      if (!clock_) return Outcome::failed("the clock is closed");
      const auto left =
          std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
      // What was granted stays granted: the same call again continues with it.
      Ticks reached = step(*clock_, std::clamp(left, std::chrono::milliseconds(0), kSliceOfStep));
      const bool waits = reached.outcome().kind() == client::OutcomeKind::timed_out;
      if (!waits || left <= kSliceOfStep) return reached;
      if (session.is_interrupted()) return Outcome::failed("the wait was interrupted");
    }
  }

  SharedPySession py_session_;
  std::mutex mutex_;
  std::optional<StepClock> clock_;
};

std::shared_ptr<OwnClock> join(const SharedPySession& py_session, const py::iterable& benches,
                               const Number& steppers) {
  const auto awaited = whole<std::uint32_t>(steppers, {"steppers"});
  std::vector<std::uint32_t> numbers;
  for_each_in(benches, "benches", [&numbers](const py::object& number, const char* name) {
    numbers.push_back(whole<std::uint32_t>(Number{number}, {name}));
  });
  auto clock =
      made_here<OwnClock>(py_session, value_or_raise(waiting(py_session, [&](Session& session) {
                            return StepClock::join(session, numbers, awaited);
                          })));
  py_session->adopt(clock);
  return clock;
}

constexpr double kPatience = std::chrono::duration<double>(StepClock::kPatience).count();

}  // namespace

void add_step_clock(py::module_& module) {
  py::class_<OwnClock, std::shared_ptr<OwnClock>>(
      module, "StepClock",
      "One clock for several lock-step benches, shared with other programs that step them. `with` "
      "leaves it.")
      .def(py::init(&join), py::arg("session").none(false), py::arg("benches"), py::kw_only(),
           py::arg("steppers") = 0,
           "Joins the clock of each bench, by its number. Time stands until `steppers` programs, "
           "with this one, have joined it; 0 = as the bench is configured.")
      .def(
          "step",
          [](OwnClock& self, const Number& ticks, const Real& patience) {
            const std::uint64_t count = count_of(ticks, "ticks");
            return self.step(patience, [count](StepClock& clock, std::chrono::milliseconds left) {
              return clock.step(count, left);
            });
          },
          py::arg("ticks") = 1, py::kw_only(), py::arg("patience") = kPatience,
          "Steps all benches and waits for them, `patience` s of wall time. Returns the tick of "
          "each.")
      .def(
          "step_for",
          [](OwnClock& self, const Real& duration, const Real& patience) {
            const std::chrono::nanoseconds time = nanoseconds_of(duration, "duration");
            return self.step(patience, [time](StepClock& clock, std::chrono::milliseconds left) {
              return clock.step_for(time, left);
            });
          },
          py::arg("duration"), py::kw_only(), py::arg("patience") = kPatience,
          "The same by drive time in s, a multiple of the period of every bench.")
      .def_property_readonly("now", &OwnClock::now,
                             "Drive time that this clock has advanced on all benches, in s.")
      .def(
          "close",
          [](OwnClock& self) {
            const Unlocked unlocked;
            self.close();
          },
          "Leaves the clock of each bench.")
      .def("__enter__",
           [](py::object self) {
             return self;
           })
      .def("__exit__", [](OwnClock& self, const py::args& /*exception*/) {
        const Unlocked unlocked;
        self.close();
      });
}

}  // namespace vdrive::python
