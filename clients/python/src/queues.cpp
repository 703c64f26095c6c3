// SPDX-License-Identifier: Apache-2.0
// Status streams and events.
#include "queues.hpp"

#include "interpreter_lock.hpp"
#include "status.hpp"
#include "values.hpp"

#include <pybind11/numpy.h>

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <type_traits>

namespace vdrive::python {
namespace {

using client::Observation;
using client::Outcome;
using client::OutcomeKind;
using client::Session;

// Interval at which a thread checks whether it must end.
constexpr std::chrono::milliseconds kSlice{100};
constexpr std::chrono::milliseconds kPause{10};

// Longer than any program runs.
constexpr std::chrono::seconds kWithoutTimeout{1'000'000'000};

/// Waits for kPause, or until the thread must end, for example because its session is closed.
void rest(const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  never.wait_for(lock, stop, kPause, [] {
    return false;
  });
}

using Timeout = std::optional<std::int64_t>;  // [ns] nothing: unlimited

/// Takes items from a queue of any kind, for Python.
template <typename Source, typename Item>
std::deque<Item> take(Source& source, std::size_t most, Timeout timeout) {
  const std::chrono::nanoseconds patience =
      timeout ? std::chrono::nanoseconds(*timeout) : kWithoutTimeout;
  Queue<Item>& queue = source.queue();
  bool is_interrupted = false;
  std::deque<Item> items = interruptible(
      [&queue] {
        queue.wake();
      },
      [&] {
        queue.wait_again();
        is_interrupted = true;
      },
      [&] {
        return queue.take(most, patience);
      });
  if (!items.empty()) return items;
  if (const auto outcome = queue.ended(); outcome) {
    check(*outcome);
  } else if (is_interrupted && patience > std::chrono::nanoseconds(0)) {
    raise(Outcome::failed("the wait was interrupted"));
  }
  return items;
}

/// @return whether the program has closed the queue and nothing is left. If the queue ended for
///         another reason, take() raises an exception.
template <typename Source>
bool is_closed(Source& source) {
  const auto outcome = source.queue().ended();
  return outcome && *outcome;
}

template <typename Source>
void check_open(Source& source) {
  if (is_closed(source)) raise(Outcome::failed("the stream is closed"));
}

/// @return the next item; nothing if none arrived within `timeout`, or if it is closed.
template <typename Source, typename Item>
std::optional<py::object> take_one(Source& source, Timeout timeout) {
  std::deque<Item> items = take<Source, Item>(source, 1, timeout);
  if (items.empty()) return std::nullopt;
  if constexpr (std::is_same_v<Item, Observation>) {
    return py::cast(std::move(items.front()));
  } else {
    return tuple_of(items.front());
  }
}

template <typename Source, typename Item>
std::optional<py::object> next_within(Source& source, Timeout timeout) {
  auto item = take_one<Source, Item>(source, timeout);
  if (!item) check_open(source);
  return item;
}

/// @throws py::stop_iteration at the end
template <typename Source, typename Item>
py::object next_of(Source& source) {
  while (true) {
    if (auto item = take_one<Source, Item>(source, std::nullopt)) return *item;
    if (is_closed(source)) throw py::stop_iteration();
  }
}

template <typename Source>
void close_source(Source& source) {
  const Unlocked unlocked;
  source.close();
}

template <typename Item, typename Source>
py::class_<Source, std::shared_ptr<Source>> add_queue(py::module_& module, const char* name) {
  return py::class_<Source, std::shared_ptr<Source>>(module, name)
      .def("next", &next_within<Source, Item>)
      .def("__next__", &next_of<Source, Item>)
      .def("is_closed", &is_closed<Source>)
      .def("close", &close_source<Source>)
      .def("fileno",
           [](Source& source) {
             return source.queue().file();
           })
      .def("dropped", [](Source& source) {
        return source.queue().dropped();
      });
}

py::array take_frames(StatusQueue& source, Timeout timeout, std::uint64_t most) {
  const std::deque<Observation> samples = take<StatusQueue, Observation>(source, most, timeout);
  if (samples.empty()) check_open(source);
  return frames_of(samples, source.axes().size());
}

std::vector<std::string> axes_of_stream(const StatusQueue& source) {
  std::vector<std::string> names;
  names.reserve(source.axes().size());
  for (const client::AxisId& axis : source.axes()) names.push_back(to_string(axis));
  return names;
}

}  // namespace

StatusQueue::StatusQueue(std::shared_ptr<Session> session, client::Follower follower,
                         std::vector<client::AxisId> axes, std::size_t capacity)
    : axes_(std::move(axes)),
      queue_(capacity),
      session_(std::move(session)),
      follower_(std::move(follower)),
      thread_([this](const std::stop_token& stop) {
        run(stop);
      }) {}

StatusQueue::~StatusQueue() {
  close();
}

void StatusQueue::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    auto sample = follower_->next(kSlice);
    if (sample) {
      queue_.push(std::move(*sample));
    } else if (sample.outcome().kind() == OutcomeKind::failed) {
      rest(stop);  // Ctrl-C ends other calls of the session, not this one
    } else if (sample.outcome().kind() != OutcomeKind::timed_out) {
      queue_.end(sample.outcome());
      return;
    }
  }
}

void StatusQueue::close() noexcept {
  if (origin.is_inherited()) return;
  const std::scoped_lock lock(closing_);
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  follower_.reset();
  session_.reset();
  queue_.end({});
}

ReportQueue::ReportQueue(const SharedPySession& py_session, const std::vector<client::AxisId>& axes,
                         std::chrono::milliseconds period)
    : queue_(std::make_shared<Queue<Observation>>(1)),
      session_(py_session->session()),
      reports_(value_or_raise(waiting(py_session, [&](Session& session) {
        return session.report_status(
            axes, period,
            [queue = queue_](const Observation& sample) {
              queue->push(sample);
            },
            [queue = queue_](const Outcome& why) {
              queue->end(why);
            });
      }))) {}

ReportQueue::~ReportQueue() {
  close();
}

void ReportQueue::close() noexcept {
  if (origin.is_inherited()) return;
  const std::scoped_lock lock(mutex_);
  reports_.reset();
  session_.reset();
  queue_->end({});
}

StepFollower::StepFollower(client::Follower follower) : follower_(std::move(follower)) {}

void StepFollower::close() noexcept {
  if (origin.is_inherited()) return;
  const std::scoped_lock lock(mutex_);
  if (follower_) last_lateness_ = follower_->lateness();
  follower_.reset();
}

Outcome StepFollower::next(std::chrono::milliseconds patience, Observation& sample) {
  const std::scoped_lock lock(mutex_);
  if (!follower_) return Outcome::failed("the follower is closed");
  return follower_->next(patience, sample);
}

bool StepFollower::has_next() {
  const std::unique_lock lock(mutex_, std::try_to_lock);
  return lock && (!follower_ || follower_->has_next());
}

client::Lateness StepFollower::lateness() {
  const std::scoped_lock lock(mutex_);
  return follower_ ? follower_->lateness() : last_lateness_;
}

void add_queues(py::module_& module) {
  add_queue<Observation, StatusQueue>(module, "StatusStream")
      .def("take", &take_frames)
      .def("axes", &axes_of_stream);
  add_queue<client::Event, EventQueue>(module, "EventStream");
  add_queue<client::ServiceChange, ServiceQueue>(module, "ServiceStream");
  add_queue<Observation, ReportQueue>(module, "StatusReports");
}

}  // namespace vdrive::python
