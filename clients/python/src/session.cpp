// SPDX-License-Identifier: Apache-2.0
#include "vdrive/client/session.hpp"

#include "arguments.hpp"
#include "axis.hpp"
#include "bench.hpp"
#include "interpreter_lock.hpp"
#include "queues.hpp"
#include "status.hpp"
#include "values.hpp"
#include "vdrive/client/fault_story.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"
#include "vdrive/dictionary/object_text.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::python {
namespace {

using client::Outcome;
using client::Session;
using SessionClass = py::class_<PySession, SharedPySession>;

using Bench = std::optional<std::uint32_t>;  // nothing: the only one
using Texts = std::vector<std::string>;

SharedPySession open_session(std::optional<std::uint32_t> domain, Texts interfaces, Texts peers,
                             Texts discovery_servers, std::string security, Bench bench,
                             bool sends_user_frames, std::int64_t find_timeout,
                             std::int64_t silence, std::int64_t patience,
                             const std::shared_ptr<LocalBench>& local,
                             const std::shared_ptr<OwnBench>& service, std::string program) {
  const client::SessionOptions options{.domain = domain,
                                       .interfaces = std::move(interfaces),
                                       .peers = std::move(peers),
                                       .discovery_servers = std::move(discovery_servers),
                                       .security = std::move(security),
                                       .bench = bench,
                                       .keep_alive = sends_user_frames
                                                         ? client::KeepAlive::user_frames
                                                         : client::KeepAlive::own_thread,
                                       .find_timeout = milliseconds_of(find_timeout),
                                       .silence = milliseconds_of(silence),
                                       .patience = milliseconds_of(patience),
                                       .bus = local ? local->bus() : nullptr,
                                       .program = std::move(program)};
  try {
    if (!local) require_dds();
    const Unlocked unlocked;
    return open_py_session(options, local ? std::shared_ptr<void>(local) : service);
  } catch (const std::runtime_error& error) {
    raise_configuration_error(error.what());
  }
}

/// @return the bench with that number, or the only one: finding out that it is the only one takes
///         150 ms, so it is done once.
std::uint32_t bench_number(const SharedPySession& self, Bench bench) {
  if (bench) return *bench;
  if (!self->only_bench) {
    self->only_bench = value_or_raise(waiting(self, [](Session& session) {
                         return session.find_bench();
                       })).number;
  }
  return *self->only_bench;
}

/// Runs a call that returns a value of a bench, such as the tick reached.
template <auto call, typename... Values>
auto of_bench(const SharedPySession& self, Bench bench, Values... values) {
  const std::uint32_t number = bench_number(self, bench);
  return value_or_raise(waiting(self, [&](Session& session) {
    return (session.*call)(number, values...);
  }));
}

struct PyFollower {
  std::shared_ptr<StepFollower> follower;
  SharedPySession py_session;
  std::chrono::milliseconds patience;
  std::optional<std::uint64_t> left;
  std::vector<client::AxisId> ids;
  py::array kept{};       ///< received by a take() that then raised
  std::size_t given = 0;  ///< samples of `kept` already returned

  /// Reserves samples for one call, because another thread may call at the same time: subtracts
  /// them from `left`, which is what remains of the `count` of follow(). The destructor adds those
  /// not received back to `left`. Guarded by the interpreter lock.
  class Share {
   public:
    /// @param size at most the remaining number
    Share(PyFollower& follower, std::uint64_t size) : follower_(follower), size_(size) {
      if (follower_.left) *follower_.left -= size_;
    }

    ~Share() {
      if (follower_.left) *follower_.left += size_ - received;
    }

    Share(const Share&) = delete;
    Share& operator=(const Share&) = delete;

    std::uint64_t received = 0;

   private:
    PyFollower& follower_;
    std::uint64_t size_;
  };

  client::Observation next() {
    if (count_kept() > 0) return oldest_kept();
    if (left && *left == 0) throw py::stop_iteration();
    client::Observation sample;
    Share one(*this, 1);
    check(waiting_unless(
        [this](const Session& /*session*/) {
          return follower->has_next();
        },
        py_session,
        [this, &sample](Session& /*session*/) {
          return follower->next(patience, sample);
        }));
    one.received = 1;
    return sample;
  }

  client::Observation oldest_kept() {
    client::Observation sample;
    for (const client::AxisId id : ids) sample.axes.emplace_back().id = id;
    FrameView(take_kept(1), ids.size()).read(0, sample);
    return sample;
  }

  [[nodiscard]] std::size_t count_kept() const {
    return kept.ndim() == 2 ? static_cast<std::size_t>(kept.shape(0)) - given : 0;
  }

  /// @return the oldest of the kept samples, without copying.
  py::array take_kept(std::size_t most) {
    const std::size_t end = given + std::min(most, count_kept());
    const py::slice rows(static_cast<py::ssize_t>(given), static_cast<py::ssize_t>(end), 1);
    py::array taken = kept[rows];
    given = end;
    if (count_kept() == 0) kept = py::array();
    return taken;
  }

  /// Does not return to the interpreter between samples; a signal ends the wait for a sample.
  py::array take(std::uint64_t most) {
    if (count_kept() > 0) return take_kept(most);
    const std::uint64_t count = std::min(most, left.value_or(most));
    Frames frames(ids.size());
    frames.expect(count);
    const auto receive = [&](Session& /*session*/) {
      client::Observation sample;
      while (frames.size() < count) {
        if (Outcome seen = follower->next(patience, sample); !seen) return seen;
        frames.add(sample);
      }
      return Outcome();
    };
    Share share(*this, count);
    try {
      check(waiting(py_session, receive));
    } catch (...) {
      share.received = frames.size();
      kept = frames.take(frames.size());
      given = 0;
      throw;
    }
    share.received = count;
    return frames.take(count);
  }
};

PyFollower follow(const SharedPySession& self, const GivenAxes& axes, bool observes,
                  std::int64_t patience, std::optional<std::uint64_t> count) {
  load_numpy();
  std::vector<client::AxisId> ids = ids_of(self, axes);
  auto follower = made_here<StepFollower>(value_or_raise(waiting(self, [&](Session& session) {
    return session.follow(ids, pace_of(observes));
  })));
  self->adopt(follower);
  return {std::move(follower), self, milliseconds_of(patience), count, std::move(ids)};
}

std::shared_ptr<StatusQueue> stream(const SharedPySession& self, const GivenAxes& axes,
                                    std::size_t capacity) {
  load_numpy();
  const std::vector<client::AxisId> ids = ids_of(self, axes);
  auto follower = value_or_raise(waiting(self, [&](Session& session) {
    return session.follow(ids, client::Pace::observe);
  }));
  auto queue = made_here<StatusQueue>(self->session(), std::move(follower), ids, capacity);
  self->adopt(queue);
  return queue;
}

std::shared_ptr<ReportQueue> status_reports(const SharedPySession& self, const GivenAxes& axes,
                                            std::int64_t period) {
  load_numpy();
  auto queue = made_here<ReportQueue>(self, ids_of(self, axes), milliseconds_of(period));
  self->adopt(queue);
  return queue;
}

/// Creates a queue of reports that replaces the previous one of the session.
/// @param place in the session, guarded by the interpreter lock
template <typename Item>
std::shared_ptr<ReportedQueue<Item>> reported(const SharedPySession& self,
                                              std::weak_ptr<Dependent>& place, std::size_t capacity,
                                              typename ReportedQueue<Item>::Observe observe) {
  const std::shared_ptr<Session> session = self->session();
  const auto before = std::static_pointer_cast<ReportedQueue<Item>>(place.lock());
  auto queue = [&] {
    const Unlocked unlocked;
    if (before) before->detach();
    return made_here<ReportedQueue<Item>>(session, capacity, std::move(observe));
  }();
  place = queue;
  self->adopt(queue);
  return queue;
}

std::shared_ptr<EventQueue> events(const SharedPySession& self, bool history,
                                   std::size_t capacity) {
  const auto observe = [history](Session& session, std::shared_ptr<Queue<client::Event>> queue) {
    if (!queue) return session.on_event({});
    session.on_event(
        [queue = std::move(queue)](const client::Event& event) {
          queue->push(event);
        },
        history ? client::EventHistory::kept : client::EventHistory::left_out);
  };
  return reported<client::Event>(self, self->event_stream, capacity, observe);
}

std::shared_ptr<ServiceQueue> service_changes(const SharedPySession& self, std::size_t capacity) {
  using client::ServiceChange;
  const auto observe = [](Session& session, std::shared_ptr<Queue<ServiceChange>> queue) {
    if (!queue) return session.watch_services({});
    session.watch_services([queue = std::move(queue)](const ServiceChange& change) {
      queue->push(change);
    });
  };
  return reported<ServiceChange>(self, self->service_stream, capacity, observe);
}

py::list command_each(const SharedPySession& self, const GivenAxes& axes,
                      const std::string& command, std::int64_t timeout, bool in_force) {
  const client::EachCommand chosen = each_command_of(command);
  const std::vector<client::Axis> commanded = axes_of(self, axes);
  const std::vector<Outcome> outcomes = waiting(self, [&](Session& session) {
    return session.command_each(commanded, chosen, call_options(timeout, in_force));
  });
  py::list results;
  for (const Outcome& outcome : outcomes) {
    results.append(outcome ? py::none() : exception_of(outcome));
  }
  return results;
}

/// @throws py::value_error if the value does not fit in the member of a frame
template <typename Member>
Member member_of(ObjectRow row, std::int64_t value) {
  if (std::in_range<Member>(value)) return static_cast<Member>(value);
  using Limits = std::numeric_limits<Member>;
  throw py::value_error(object_text(vdrive::describe(row).address) + " = " + std::to_string(value) +
                        ": must be from " + std::to_string(Limits::min()) + " to " +
                        std::to_string(Limits::max()));
}

/// Mode, target position and controlword have dedicated members in a frame.
void add_value(client::SetPoint& point, ObjectAddress object, std::int64_t value) {
  using namespace literals;
  if (object == kObjectRows["op_mode_cmd"_object].address) {
    point.mode = static_cast<OperatingMode>(member_of<std::int8_t>("op_mode_cmd"_object, value));
  } else if (object == kObjectRows["position_user_target_value"_object].address) {
    point.position = member_of<std::int32_t>("position_user_target_value"_object, value);
  } else if (object == kObjectRows["ds402_controlword"_object].address) {
    point.controlword = member_of<std::uint16_t>("ds402_controlword"_object, value);
  } else {
    point.objects.push_back({.object = object, .value = value});
  }
}

/// The number of an axis, and the values of its objects.
using SetPointOfAxis =
    std::pair<std::uint16_t, std::vector<std::pair<std::uint32_t, std::int64_t>>>;

void send_set_points(const SharedPySession& self, const std::vector<SetPointOfAxis>& set_points,
                     std::uint64_t tick, bool drops_waiting, Bench bench) {
  client::SetPointFrame frame;
  frame.tick = tick;
  frame.drops_waiting = drops_waiting;
  for (const auto& [axis, values] : set_points) {
    client::SetPoint& point = frame.axes.emplace_back();
    point.axis = axis;
    for (const auto& [object, value] : values) add_value(point, object_of(object), value);
  }
  const std::uint32_t number = bench_number(self, bench);
  check(waiting(self, [&](Session& sending) {
    return sending.send_set_points(number, {&frame, 1});
  }));
}

void add_finding(SessionClass& session) {
  session
      .def("find_benches",
           [](const SharedPySession& self) {
             return waiting(self, [](Session& found) {
               return found.find_benches();
             });
           })
      .def("present_benches",
           [](const SharedPySession& self) {
             return self->session()->present_benches();
           })
      .def("find_bench",
           [](const SharedPySession& self, Bench number) {
             return value_or_raise(waiting(self, [&](Session& found) {
               return found.find_bench(number);
             }));
           })
      .def("axis",
           [](const SharedPySession& self, const std::string& text) {
             return PyAxis{value_or_raise(waiting(self,
                                                  [&](Session& found) {
                                                    return found.axis(text);
                                                  })),
                           self};
           })
      .def("axes", [](const SharedPySession& self, Bench bench) {
        std::vector<PyAxis> handles;
        for (client::Axis& axis : value_or_raise(waiting(self, [&](Session& there) {
               return there.axes(bench);
             }))) {
          handles.emplace_back(std::move(axis), self);
        }
        return handles;
      });
}

std::uint64_t step(const SharedPySession& self, Bench bench, std::uint64_t ticks) {
  const std::uint32_t number = bench_number(self, bench);
  return value_or_raise(waiting_unless(
      [&](const Session& session) {
        return session.steps_at_once(number, ticks);
      },
      self,
      [&](Session& session) {
        return session.step(number, ticks);
      }));
}

py::dict snapshots(const SharedPySession& self, Bench bench) {
  py::dict ticks;
  for (const client::KeptSnapshot& snapshot : of_bench<&Session::snapshots>(self, bench)) {
    ticks[py::int_(snapshot.number)] = snapshot.tick;
  }
  return ticks;
}

py::list causes_of(const client::KeptWindow& window) {
  py::list causes;
  for (const client::WindowCause& cause : window.causes) {
    causes.append(py::make_tuple(client::to_string(cause.kind), cause.axis, cause.code,
                                 cause.session, cause.tick));
  }
  return causes;
}

/// @return a window as a record in the form of vdrive/_faults.py.
py::tuple window_record(std::uint32_t bench, const client::KeptWindow& window) {
  return py::make_tuple(bench, window.number, window.first_tick, window.last_tick, window.is_open,
                        causes_of(window), window.more_causes);
}

py::list windows(const SharedPySession& self, Bench bench) {
  const std::uint32_t number = bench_number(self, bench);
  py::list list;
  for (const client::KeptWindow& window : of_bench<&Session::windows>(self, number)) {
    list.append(window_record(number, window));
  }
  return list;
}

/// @return the record of a window, its frames, writes and events, and what led to its causes.
py::tuple window(const SharedPySession& self, std::uint64_t number, const GivenAxes& axes) {
  load_numpy();
  const std::vector<client::AxisId> ids = ids_of(self, axes);
  const client::Window window = value_or_raise(waiting(self, [&](Session& session) {
    return session.window(number, ids);
  }));
  const std::uint32_t of_bench = ids.front().bench;
  const client::BenchInfo bench = value_or_raise(waiting(self, [&](Session& session) {
    return session.find_bench(of_bench);
  }));
  py::list writes;
  for (const client::AxisWrite& write : window.writes) {
    if (write.kind != client::AxisWrite::Kind::write) continue;
    writes.append(py::make_tuple(write.tick, write.axis,
                                 py::make_tuple(write.object.index, write.object.subindex),
                                 write.value, write.session, write.reason));
  }
  py::list events;
  for (const client::WindowEvent& event : window.events) {
    events.append(
        py::make_tuple(event.tick, to_string(event.kind), event.axis, event.session, event.code));
  }
  const client::SessionText name_of = [&](std::uint64_t session) {
    return client::owner_text(session, waiting(self, [&](Session& known) {
                                return known.known_name(of_bench, session);
                              }));
  };
  py::list stories;
  for (const client::WindowCause& cause : window.kept.causes) {
    client::FaultStory story = client::story_of(window, cause, bench, name_of);
    stories.append(py::make_tuple(story.title, story.lines, story.remedy));
  }
  return py::make_tuple(window_record(of_bench, window.kept),
                        frames_of({window.samples.begin(), window.samples.end()}, ids.size()),
                        writes, events, stories);
}

void add_windows(SessionClass& session) {
  session.def("windows", &windows)
      .def("freeze_window", &of_bench<&Session::freeze_window>)
      .def("window", &window);
}

void add_clock(SessionClass& session) {
  session.def("step", &step)
      .def("wait",
           [](const SharedPySession& self, Bench bench, std::int64_t duration) {
             return of_bench<&Session::wait>(self, bench, std::chrono::nanoseconds(duration));
           })
      .def("wait_for_tick", &of_bench<&Session::wait_for_tick, std::uint64_t>)
      .def("set_rate", &of_bench<&Session::set_rate, double>)
      .def("take_snapshot", &of_bench<&Session::take_snapshot>)
      .def("restore_snapshot", &of_bench<&Session::restore_snapshot, std::uint64_t>)
      .def("snapshots", &snapshots)
      .def("drop_snapshot", [](const SharedPySession& self, Bench bench, std::uint64_t snapshot) {
        const std::uint32_t number = bench_number(self, bench);
        check(waiting(self, [&](Session& kept) {
          return kept.drop_snapshot(number, snapshot);
        }));
      });
}

void add_observing(SessionClass& session) {
  session
      .def("observe",
           [](const SharedPySession& self, const GivenAxes& axes) {
             const std::vector<client::AxisId> ids = ids_of(self, axes);
             return value_or_raise(waiting(self, [&](Session& observed) {
               return observed.observe(ids);
             }));
           })
      .def("follow", &follow)
      .def("stream", &stream)
      .def("status_reports", &status_reports)
      .def("events", &events)
      .def("service_changes", &service_changes);
}

void add_control(SessionClass& session) {
  session.def("command_each", &command_each)
      .def("quick_stop",
           [](const SharedPySession& self, Bench bench, std::int64_t timeout, bool in_force) {
             const std::uint32_t number = bench_number(self, bench);
             check(waiting(self, [&](Session& stopping) {
               return stopping.quick_stop(number, call_options(timeout, in_force));
             }));
           })
      .def("release",
           [](const SharedPySession& self, Bench bench) {
             check(waiting(self, [bench](Session& releasing) {
               return bench ? releasing.release(*bench) : releasing.release();
             }));
           })
      .def("acquire",
           [](const SharedPySession& self, const GivenAxes& axes) {
             const std::vector<client::AxisId> ids = ids_of(self, axes);
             check(waiting(self, [&](Session& taking) {
               return taking.acquire(ids);
             }));
           })
      .def("send_set_points", &send_set_points);
}

void add_ends(SessionClass& session) {
  session
      .def("interrupt",
           [](const PySession& self) {
             self.session()->interrupt();
           })
      .def("end_interrupt",
           [](const PySession& self) {
             self.session()->end_interrupt();
           })
      .def("abandon",
           [](const PySession& self) {
             const std::shared_ptr<Session> abandoned = self.session();
             const Unlocked unlocked;
             abandoned->abandon();
           })
      .def("close", [](PySession& self) {
        const Unlocked unlocked;
        self.close();
      });
}

void add_follower(py::module_& module) {
  py::class_<PyFollower>(module, "Follower")
      .def("__next__", &PyFollower::next)
      .def("take", &PyFollower::take)
      .def("lateness",
           [](const PyFollower& self) {
             const client::Lateness lateness = [&] {
               const Unlocked unlocked;  // a call of another thread may be waiting for a sample
               return self.follower->lateness();
             }();
             return tuple_of(lateness);
           })
      .def("close", [](PyFollower& self) {
        const Unlocked unlocked;
        self.follower->close();
      });
}

}  // namespace

void add_session(py::module_& module) {
  add_follower(module);
  SessionClass session(module, "Session");
  session.def(py::init(&open_session))
      .def("id",
           [](const PySession& self) {
             return self.session()->id();
           })
      .def("is_closed", &PySession::is_closed);
  add_finding(session);
  add_control(session);
  add_ends(session);
  add_clock(session);
  add_windows(session);
  add_observing(session);
}

}  // namespace vdrive::python
