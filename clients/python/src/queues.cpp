// SPDX-License-Identifier: Apache-2.0
// Status streams and events.
#include "queues.hpp"

#include "axis.hpp"
#include "interpreter_lock.hpp"
#include "status.hpp"

#include <pybind11/numpy.h>
#include <pybind11/operators.h>

#include <condition_variable>
#include <mutex>
#include <stop_token>
#include <string>

namespace vdrive::python {
namespace {

using client::Event;
using client::Observation;
using client::Outcome;
using client::OutcomeKind;
using client::Session;

// In which a thread sees that it is to end.
constexpr std::chrono::milliseconds kSlice{100};
constexpr std::chrono::milliseconds kPause{10};

// More than any program runs.
constexpr std::chrono::seconds kWithoutTimeout{1'000'000'000};

/// Waits for kPause; ends at once with the thread, as when its session is closed.
void rest(const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  never.wait_for(lock, stop, kPause, [] {
    return false;
  });
}

/// What Python calls on a queue of either kind.
template <typename Source, typename Item>
std::deque<Item> take(Source& source, std::size_t most, const OptionalReal& timeout) {
  const std::chrono::nanoseconds patience =
      timeout ? nanoseconds_of(*timeout, "timeout") : kWithoutTimeout;
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

/// @return whether the program has closed it and nothing is left; any other end is raised.
template <typename Source>
bool is_closed(Source& source) {
  const auto outcome = source.queue().ended();
  return outcome && *outcome;
}

template <typename Source>
void check_open(Source& source) {
  if (is_closed(source)) raise(Outcome::failed("the stream is closed"));
}

/// @return the next item; nothing when none has come within `timeout`, or it is closed.
template <typename Source, typename Item>
std::optional<Item> take_one(Source& source, const OptionalReal& timeout) {
  std::deque<Item> items = take<Source, Item>(source, 1, timeout);
  if (items.empty()) return std::nullopt;
  return std::move(items.front());
}

template <typename Source, typename Item>
std::optional<Item> next_within(Source& source, const OptionalReal& timeout) {
  auto item = take_one<Source, Item>(source, timeout);
  if (!item) check_open(source);
  return item;
}

/// @throws py::stop_iteration at the end
template <typename Source, typename Item>
Item next_of(Source& source) {
  while (true) {
    if (auto item = take_one<Source, Item>(source, std::nullopt)) return std::move(*item);
    if (is_closed(source)) throw py::stop_iteration();
  }
}

template <typename Source>
void close_source(Source& source) {
  const Unlocked unlocked;
  source.close();
}

template <typename Source, typename Item>
void add_queue(py::class_<Source, std::shared_ptr<Source>>& queue) {
  queue.def(
      "next", &next_within<Source, Item>, py::arg("timeout") = py::none(),
      "Waits for the next one, at most for `timeout` s; None when none has come. Raises Failed "
      "after close().");
  queue.def_property_readonly(
      "is_closed", &is_closed<Source>,
      "Whether it was closed and everything that had arrived has been taken.");
  queue.def("close", &close_source<Source>, "Ends it.");
  queue.def(
      "fileno",
      [](Source& source) {
        return source.queue().file();
      },
      "A file that is readable while a value waits, for select, asyncio and similar.");
  queue.def_property_readonly(
      "dropped",
      [](Source& source) {
        return source.queue().dropped();
      },
      "The number of dropped values, the oldest first, because the program did not take them.");
  queue.def("__iter__", [](py::object self) {
    return self;
  });
  queue.def("__next__", &next_of<Source, Item>);
  queue.def("__enter__", [](py::object self) {
    return self;
  });
  queue.def("__exit__", [](Source& source, const py::args& /*exception*/) {
    close_source(source);
  });
}

py::object take_frames(StatusQueue& source, const OptionalReal& timeout, const Number& most) {
  const std::deque<Observation> samples =
      take<StatusQueue, Observation>(source, count_of(most, "most"), timeout);
  if (samples.empty()) check_open(source);
  return frames_of(samples, source.axes().size());
}

void add_status_queue(py::module_& module) {
  py::class_<StatusQueue, std::shared_ptr<StatusQueue>> queue(
      module, "StatusStream",
      "Status of axes as it comes, received by a thread of its own. An iterator of observations.");
  add_queue<StatusQueue, Observation>(queue);
  queue.def(
      "take", &take_frames, py::arg("timeout") = py::none(), py::arg("most") = kMostCounted,
      "Waits for samples, at most for `timeout` s, and takes at most `most` of those that are "
      "there: a numpy array of records, a row per sample, a column per axis.");
  queue.def_property_readonly(
      "axes",
      [](const StatusQueue& source) {
        std::vector<std::string> names;
        names.reserve(source.axes().size());
        for (const client::AxisId& axis : source.axes()) names.push_back(to_string(axis));
        return names;
      },
      "Addresses of the axes, in the order of the columns.");
}

void add_event(py::module_& module) {
  py::class_<Event>(module, "Event", "An event of a bench.")
      .def_readonly("bench", &Event::bench, "Number of the bench.")
      .def_readonly("incarnation", &Event::incarnation,
                    "Another one is another run of its service.")
      .def_readonly("axis", &Event::axis, "Number of the axis; 0 = the bench, or several axes.")
      .def_property_readonly(
          "kind",
          [](const Event& event) {
            return std::string(to_string(event.kind));
          },
          R"(The kind of event, such as "fault".)")
      .def_readonly("tick", &Event::tick, "The tick.")
      .def_readonly("session", &Event::session, "The session of the command, 0 = none.")
      .def_readonly("code", &Event::code, "Of a fault 603Fh; see docs/reference/wire.md.")
      .def_readonly("error_register", &Event::error_register, "1001h of a fault.")
      .def_readonly("suppressed", &Event::suppressed, "Equal events left out before this one.")
      .def_readonly("text", &Event::text, "Text for people.")
      .def(py::self == py::self, py::arg("other"))
      .def("__hash__",
           [](const Event& event) {
             return py::hash(py::make_tuple(event.bench, event.axis, event.tick, event.text));
           })
      .def("__repr__", [](const Event& event) {
        return "<vdrive.Event " + std::string(to_string(event.kind)) + " tick " +
               std::to_string(event.tick) + ": " + event.text + ">";
      });
}

void add_event_queue(py::module_& module) {
  add_event(module);
  py::class_<EventQueue, std::shared_ptr<EventQueue>> queue(
      module, "EventStream", "Events of benches as they come. An iterator of events.");
  add_queue<EventQueue, Event>(queue);
}

void add_service_queue(py::module_& module) {
  using client::ServiceChange;
  py::class_<ServiceChange>(module, "ServiceChange", "What has happened to a service.")
      .def_readonly("bench", &ServiceChange::bench, "Number of its bench.")
      .def_property_readonly(
          "news",
          [](const ServiceChange& change) {
            return std::string(client::to_string(change.news));
          },
          R"("found", "fell_silent", "sends_again", "restarted" or "went_offline".)")
      .def_property_readonly(
          "silence",
          [](const ServiceChange& change) {
            return seconds_of(change.silence);
          },
          "Age of its newest sample, in s of wall time.")
      .def_readonly("text", &ServiceChange::text, "Text for people.")
      .def("__repr__", [](const ServiceChange& change) {
        return "<vdrive.ServiceChange " + std::string(client::to_string(change.news)) + ": " +
               change.text + ">";
      });
  py::class_<ServiceQueue, std::shared_ptr<ServiceQueue>> queue(
      module, "ServiceStream", "What happens to services, as it comes. An iterator of changes.");
  add_queue<ServiceQueue, ServiceChange>(queue);
}

void add_report_queue(py::module_& module) {
  py::class_<ReportQueue, std::shared_ptr<ReportQueue>> queue(
      module, "StatusReports", "The newest state of axes at a rate; use it through on_status().");
  add_queue<ReportQueue, Observation>(queue);
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
  add_status_queue(module);
  add_event_queue(module);
  add_report_queue(module);
  add_service_queue(module);
}

}  // namespace vdrive::python
