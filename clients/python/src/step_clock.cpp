// SPDX-License-Identifier: Apache-2.0
#include "vdrive/client/step_clock.hpp"

#include "arguments.hpp"
#include "py_session.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

namespace vdrive::python {
namespace {

using client::Outcome;
using client::Session;
using client::StepClock;
using Ticks = client::Result<std::vector<std::uint64_t>>;

// Wall time after which a step that waits for others checks whether it must end.
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

  /// @param step called again with the rest of `patience` while it times out
  template <typename Step>
  std::vector<std::uint64_t> step(std::int64_t patience, const Step& step) {
    return value_or_raise(waiting(py_session_, [&](Session& session) {
      return steps(session, milliseconds_of(patience), step);
    }));
  }

  [[nodiscard]] double now() {
    origin.require_own("the clock");
    return value_or_raise([this]() -> client::Result<double> {
      const Unlocked unlocked;  // a step of another thread may be in progress
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
      // Granted ticks stay granted: the same call again continues with them.
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

std::shared_ptr<OwnClock> join(const SharedPySession& py_session,
                               const std::vector<std::uint32_t>& benches, std::uint32_t steppers) {
  auto clock =
      made_here<OwnClock>(py_session, value_or_raise(waiting(py_session, [&](Session& session) {
                            return StepClock::join(session, benches, steppers);
                          })));
  py_session->adopt(clock);
  return clock;
}

}  // namespace

void add_step_clock(py::module_& module) {
  py::class_<OwnClock, std::shared_ptr<OwnClock>>(module, "StepClock")
      .def(py::init(&join))
      .def("step",
           [](OwnClock& self, std::uint64_t ticks, std::int64_t patience) {
             return self.step(patience, [ticks](StepClock& clock, std::chrono::milliseconds left) {
               return clock.step(ticks, left);
             });
           })
      .def("step_for",
           [](OwnClock& self, std::int64_t duration, std::int64_t patience) {
             const std::chrono::nanoseconds time(duration);
             return self.step(patience, [time](StepClock& clock, std::chrono::milliseconds left) {
               return clock.step_for(time, left);
             });
           })
      .def("now", &OwnClock::now)
      .def("close", [](OwnClock& self) {
        const Unlocked unlocked;
        self.close();
      });
}

}  // namespace vdrive::python
