// SPDX-License-Identifier: Apache-2.0
#include "vdrive/client/session.hpp"

#include "arguments.hpp"
#include "axis.hpp"
#include "interpreter_lock.hpp"
#include "local_bench.hpp"
#include "own_bench.hpp"
#include "queues.hpp"
#include "status.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::python {
namespace {

using client::Outcome;
using client::Session;
using SessionClass = py::class_<PySession, SharedPySession>;

client::KeepAlive keep_alive_of(const std::string& name) {
  if (name == "own_thread") return client::KeepAlive::own_thread;
  if (name == "user_frames") return client::KeepAlive::user_frames;
  throw py::value_error(R"(keep_alive is "own_thread" or "user_frames", not )" + in_quotes(name));
}

std::optional<std::uint32_t> number_of_bench(const OptionalNumber& bench) {
  return whole<std::uint32_t>(bench, {"bench"});
}

std::size_t capacity_of(const Number& capacity) {
  return static_cast<std::size_t>(whole_of(capacity, {"capacity"}, 1, kMostCounted));
}

/// @return the name of the file that Python runs; empty where it runs none, such as `python -c`:
///         then the interpreter's own name says who it is.
std::string name_of_script() {
  // A program that embeds Python may have no arguments, and an argument may be no UTF-8.
  const py::list arguments = py::getattr(py::module_::import("sys"), "argv", py::list());
  if (arguments.empty()) return {};
  const auto first = py::module_::import("os").attr("fsencode")(arguments[0]).cast<std::string>();
  return first.starts_with('-') ? std::string() : std::filesystem::path(first).filename().string();
}

SharedPySession open_session(const OptionalNumber& domain, std::vector<std::string> interfaces,
                             std::vector<std::string> peers,
                             std::vector<std::string> discovery_servers, std::string security,
                             const OptionalNumber& bench, const std::string& keep_alive,
                             const Real& find_timeout, const Real& silence, const Real& patience,
                             const std::shared_ptr<LocalBench>& local,
                             const std::shared_ptr<OwnBench>& service, std::string program) {
  const client::SessionOptions options{
      .domain = whole<std::uint32_t>(domain, {"domain"}),
      .interfaces = std::move(interfaces),
      .peers = std::move(peers),
      .discovery_servers = std::move(discovery_servers),
      .security = std::move(security),
      .bench = number_of_bench(bench),
      .keep_alive = keep_alive_of(keep_alive),
      .find_timeout = milliseconds_of(find_timeout, "find_timeout"),
      .silence = milliseconds_of(silence, "silence"),
      .patience = milliseconds_of(patience, "patience"),
      .bus = local ? local->bus() : nullptr,
      .program = program.empty() ? name_of_script() : std::move(program)};
  try {
    if (!local) require_dds();
    const Unlocked unlocked;
    return open_py_session(options, local ? std::shared_ptr<void>(local) : service);
  } catch (const std::runtime_error& error) {
    raise_configuration_error(error.what());
  }
}

void close_session(PySession& self) {
  const Unlocked unlocked;
  self.close();
}

/// @return the bench of that number, or the only one: to find that it is the only one takes 150
///         ms, so it is done once.
std::uint32_t bench_number(const SharedPySession& self, const OptionalNumber& bench) {
  if (const auto number = number_of_bench(bench)) return *number;
  if (!self->only_bench) {
    self->only_bench = value_or_raise(waiting(self, [](Session& session) {
                         return session.find_bench();
                       })).number;
  }
  return *self->only_bench;
}

/// A call that gives a tick or a number of a bench.
template <typename Call>
auto of_bench(const SharedPySession& self, const OptionalNumber& bench, const Call& call) {
  const std::uint32_t number = bench_number(self, bench);
  return value_or_raise(waiting(self, [&](Session& session) {
    return call(session, number);
  }));
}

struct PyFollower {
  std::shared_ptr<StepFollower> follower;
  SharedPySession py_session;
  std::chrono::milliseconds patience;
  std::optional<std::uint64_t> left;
  std::vector<client::AxisId> ids;
  py::array kept{};       ///< what a take() had received when it raised
  std::size_t given = 0;  ///< of these, so many samples were given since

  /// Samples of those that are left for one call; another thread may call meanwhile. Guarded by the
  /// interpreter lock. What was not received is left again at its end.
  class Share {
   public:
    /// @param size at most as many as are left
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

  /// @return the oldest of those that are kept, where they lie.
  py::array take_kept(std::size_t most) {
    const std::size_t end = given + std::min(most, count_kept());
    const py::slice rows(static_cast<py::ssize_t>(given), static_cast<py::ssize_t>(end), 1);
    py::array taken = kept[rows];
    given = end;
    if (count_kept() == 0) kept = py::array();
    return taken;
  }

  /// The interpreter is not asked between the samples: a signal ends the wait for one of them.
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

PyFollower follow(const SharedPySession& self, const py::object& axes, const std::string& pace,
                  const Real& patience, const OptionalNumber& count) {
  load_numpy();
  const client::Pace chosen = pace_of(pace);
  const std::chrono::milliseconds longest = milliseconds_of(patience, "patience");
  const auto most = count ? std::optional(count_of(*count, "count")) : std::nullopt;
  std::vector<client::AxisId> ids = ids_of(axes_of(self, axes));
  auto follower = made_here<StepFollower>(value_or_raise(waiting(self, [&](Session& session) {
    return session.follow(ids, chosen);
  })));
  self->adopt(follower);
  return {std::move(follower), self, longest, most, std::move(ids)};
}

std::shared_ptr<StatusQueue> stream(const SharedPySession& self, const py::object& axes,
                                    const Number& capacity) {
  load_numpy();
  const std::size_t samples = capacity_of(capacity);
  const std::vector<client::AxisId> ids = ids_of(axes_of(self, axes));
  auto follower = value_or_raise(waiting(self, [&](Session& session) {
    return session.follow(ids, client::Pace::observe);
  }));
  auto queue = made_here<StatusQueue>(self->session(), std::move(follower), ids, samples);
  self->adopt(queue);
  return queue;
}

std::shared_ptr<ReportQueue> status_reports(const SharedPySession& self, const py::object& axes,
                                            const Real& period) {
  load_numpy();
  const std::chrono::milliseconds every = milliseconds_of(period, "period");
  if (every.count() == 0) throw py::value_error("period = 0: must be above 0 seconds");
  auto queue = made_here<ReportQueue>(self, ids_of(axes_of(self, axes)), every);
  self->adopt(queue);
  return queue;
}

/// A queue of reports in the place of the one that the session had.
/// @param place in the session, guarded by the interpreter lock
template <typename Item>
std::shared_ptr<ReportedQueue<Item>> reported(const SharedPySession& self,
                                              std::weak_ptr<Dependent>& place, std::size_t capacity,
                                              typename ReportedQueue<Item>::Observe observe) {
  const std::shared_ptr<Session> session = self->session();
  const auto before = std::static_pointer_cast<ReportedQueue<Item>>(place.lock());
  auto queue = [&] {
    const Unlocked unlocked;
    if (before) before->leave_place();
    return made_here<ReportedQueue<Item>>(session, capacity, std::move(observe));
  }();
  place = queue;
  self->adopt(queue);
  return queue;
}

std::shared_ptr<EventQueue> events(const SharedPySession& self, bool history,
                                   const Number& capacity) {
  const auto observe = [history](Session& session, std::shared_ptr<Queue<client::Event>> queue) {
    if (!queue) return session.on_event({});
    session.on_event(
        [queue = std::move(queue)](const client::Event& event) {
          queue->push(event);
        },
        history ? client::EventHistory::kept : client::EventHistory::left_out);
  };
  return reported<client::Event>(self, self->event_stream, capacity_of(capacity), observe);
}

std::shared_ptr<ServiceQueue> service_changes(const SharedPySession& self, const Number& capacity) {
  using client::ServiceChange;
  const auto observe = [](Session& session, std::shared_ptr<Queue<ServiceChange>> queue) {
    if (!queue) return session.watch_services({});
    session.watch_services([queue = std::move(queue)](const ServiceChange& change) {
      queue->push(change);
    });
  };
  return reported<ServiceChange>(self, self->service_stream, capacity_of(capacity), observe);
}

py::list command_each(const SharedPySession& self, const py::object& axes,
                      const std::string& command, const Real& timeout, const std::string& until) {
  const client::EachCommand chosen = each_command_of(command);
  const client::CallOptions options = call_options(timeout, until);
  const std::vector<client::Axis> commanded = axes_of(self, axes);
  const std::vector<Outcome> outcomes = waiting(self, [&](Session& session) {
    return session.command_each(commanded, chosen, options);
  });
  py::list results;
  for (const Outcome& outcome : outcomes) {
    results.append(outcome ? py::none() : exception_of(outcome));
  }
  return results;
}

std::vector<PyAxis> handles_of(const SharedPySession& self, const std::vector<client::Axis>& axes) {
  std::vector<PyAxis> handles;
  handles.reserve(axes.size());
  for (const client::Axis& axis : axes) handles.emplace_back(axis, self);
  return handles;
}

void add_finding(SessionClass& session) {
  session.def(
      "find_benches",
      [](const SharedPySession& self) {
        return waiting(self, [](Session& found) {
          return found.find_benches();
        });
      },
      "Waits until a bench is found; the benches by number, none after `find_timeout`.");
  session.def(
      "present_benches",
      [](const SharedPySession& self) {
        return self->session()->present_benches();
      },
      "The benches that are present now. Does not wait.");
  session.def(
      "find_bench",
      [](const SharedPySession& self, const OptionalNumber& number) {
        const auto wanted = whole<std::uint32_t>(number, {"number"});
        return value_or_raise(waiting(self, [&](Session& found) {
          return found.find_bench(wanted);
        }));
      },
      py::arg("number") = py::none(),
      "The bench of that number; without a number the only present one.");
  session.def(
      "axis",
      [](const SharedPySession& self, const std::string& text) {
        return PyAxis{value_or_raise(waiting(self,
                                             [&](Session& found) {
                                               return found.axis(text);
                                             })),
                      self};
      },
      py::arg("text"), R"(The axis of an address such as "1.2" or "1.lift", or of a name.)");
  session.def(
      "axes",
      [](const SharedPySession& self, const OptionalNumber& bench) {
        const auto number = number_of_bench(bench);
        return handles_of(self, value_or_raise(waiting(self, [&](Session& there) {
                            return there.axes(number);
                          })));
      },
      py::arg("bench") = py::none(), "Every axis of a bench, by number.");
  session.def(
      "_axes_of",
      [](const SharedPySession& self, const py::object& axes) {
        return handles_of(self, axes_of(self, axes));
      },
      py::arg("axes"), "The axes that an argument means; None: all of the only bench.");
}

void add_clock(SessionClass& session) {
  session.def(
      "step",
      [](const SharedPySession& self, const Number& ticks, const OptionalNumber& bench) {
        const std::uint64_t count = count_of(ticks, "ticks");
        const std::uint32_t number = bench_number(self, bench);
        return value_or_raise(waiting_unless(
            [&](const Session& stepped) {
              return stepped.steps_at_once(number, count);
            },
            self,
            [&](Session& stepped) {
              return stepped.step(number, count);
            }));
      },
      py::arg("ticks") = 1, py::kw_only(), py::arg("bench") = py::none(),
      "Steps a lock-step bench. Returns the tick reached.");
  session.def(
      "wait",
      [](const SharedPySession& self, const Real& duration, const OptionalNumber& bench) {
        const std::chrono::nanoseconds time = nanoseconds_of(duration, "duration");
        return of_bench(self, bench, [time](Session& waiter, std::uint32_t number) {
          return waiter.wait(number, time);
        });
      },
      py::arg("duration"), py::kw_only(), py::arg("bench") = py::none(),
      "Waits for drive time, in s; in lock-step by steps. Returns the tick reached.");
  session.def(
      "wait_for_tick",
      [](const SharedPySession& self, const Number& tick, const OptionalNumber& bench) {
        const std::uint64_t awaited = count_of(tick, "tick");
        return of_bench(self, bench, [awaited](Session& waiter, std::uint32_t number) {
          return waiter.wait_for_tick(number, awaited);
        });
      },
      py::arg("tick"), py::kw_only(), py::arg("bench") = py::none(),
      "Waits until the bench has reached a tick; in lock-step steps to it.");
  session.def(
      "set_rate",
      [](const SharedPySession& self, const Real& rate, const OptionalNumber& bench) {
        const double ratio = real_of(rate, {"rate"});
        return of_bench(self, bench, [ratio](Session& set, std::uint32_t number) {
          return set.set_rate(number, ratio);
        });
      },
      py::arg("rate"), py::kw_only(), py::arg("bench") = py::none(),
      "Drive time over wall time of a realtime bench, for all programs: 0 = pause, 0.1 to 100.");
}

void add_snapshots(SessionClass& session) {
  session.def(
      "take_snapshot",
      [](const SharedPySession& self, const OptionalNumber& bench) {
        return of_bench(self, bench, [](Session& taken, std::uint32_t number) {
          return taken.take_snapshot(number);
        });
      },
      py::kw_only(), py::arg("bench") = py::none(),
      "Saves the state of all axes of a bench whose time stands still. Returns its number.");
  session.def(
      "restore_snapshot",
      [](const SharedPySession& self, const Number& snapshot, const OptionalNumber& bench) {
        const std::uint64_t kept = count_of(snapshot, "snapshot");
        return of_bench(self, bench, [kept](Session& restored, std::uint32_t number) {
          return restored.restore_snapshot(number, kept);
        });
      },
      py::arg("snapshot"), py::kw_only(), py::arg("bench") = py::none(),
      "Restores all axes to that state. Returns the tick, which continues.");
  session.def(
      "snapshots",
      [](const SharedPySession& self, const OptionalNumber& bench) {
        const auto kept = of_bench(self, bench, [](Session& listed, std::uint32_t number) {
          return listed.snapshots(number);
        });
        py::dict ticks;
        for (const client::KeptSnapshot& snapshot : kept) {
          ticks[py::int_(snapshot.number)] = snapshot.tick;
        }
        return ticks;
      },
      py::kw_only(), py::arg("bench") = py::none(),
      "The snapshots that a bench keeps: {number: tick}.");
  session.def(
      "drop_snapshot",
      [](const SharedPySession& self, const Number& snapshot, const OptionalNumber& bench) {
        const std::uint64_t kept = count_of(snapshot, "snapshot");
        const std::uint32_t number = bench_number(self, bench);
        check(waiting(self, [&](Session& forgetting) {
          return forgetting.drop_snapshot(number, kept);
        }));
      },
      py::arg("snapshot"), py::kw_only(), py::arg("bench") = py::none(), "Forgets a snapshot.");
}

void add_session_observing(SessionClass& session) {
  session.def(
      "observe",
      [](const SharedPySession& self, const py::object& axes) {
        const std::vector<client::AxisId> ids = ids_of(axes_of(self, axes));
        return value_or_raise(waiting(self, [&](Session& observed) {
          return observed.observe(ids);
        }));
      },
      py::arg("axes") = py::none(),
      "The present state of some axes of one bench; without any, all of the only bench.");
  session.def(
      "follow", &follow, py::arg("axes") = py::none(), py::kw_only(), py::arg("pace") = "drive",
      py::arg("patience") = 10.0, py::arg("count") = py::none(),
      R"(Iterates over the ticks of axes of one bench. With pace "drive" each sample of a )"
      R"(lock-step bench is a step of one tick; "observe" takes what is published. It raises )"
      "TimedOut when no sample comes for `patience` s of wall time.");
  session.def(
      "stream", &stream, py::arg("axes") = py::none(), py::kw_only(), py::arg("capacity") = 10000,
      py::keep_alive<0, 1>(),
      "Receives every published sample of axes of one bench in a thread of its own; keeps the "
      "newest `capacity`.");
  session.def("_status_reports", &status_reports, py::arg("axes"), py::arg("period"),
              py::keep_alive<0, 1>(), "What on_status() takes for each bench.");
  session.def(
      "events", &events, py::kw_only(), py::arg("history") = false, py::arg("capacity") = 10000,
      py::keep_alive<0, 1>(),
      "The events of the benches that this session finds; with `history` from the oldest on "
      "that each bench still has. A second stream takes the place of the first.");
  session.def(
      "service_changes", &service_changes, py::kw_only(), py::arg("capacity") = 10000,
      py::keep_alive<0, 1>(),
      "What happens to the services that this session sees: found, silent, restarted, offline. "
      "First comes what is there. A second stream takes the place of the first.");
}

void add_control(SessionClass& session) {
  session.def(
      "command_each", &command_each, py::arg("axes"), py::arg("command"), py::kw_only(),
      py::arg("timeout") = 60.0, py::arg("until") = "done",
      "Sends axes the same command: enable, disable, halt, resume, quick_stop, reset_fault or "
      "power_cycle. Returns for each axis None or the exception with the reason.");
  session.def(
      "quick_stop",
      [](const SharedPySession& self, const OptionalNumber& bench, const Real& timeout,
         const std::string& until) {
        const client::CallOptions options = call_options(timeout, until);
        const std::uint32_t number = bench_number(self, bench);
        check(waiting(self, [&](Session& stopping) {
          return stopping.quick_stop(number, options);
        }));
      },
      py::arg("bench") = py::none(), py::kw_only(), py::arg("timeout") = 60.0,
      py::arg("until") = "done",
      "Quick stop of every axis of a bench that has no fault, also of other sessions.");
  session.def(
      "release",
      [](const SharedPySession& self, const OptionalNumber& bench) {
        const auto number = number_of_bench(bench);
        check(waiting(self, [number](Session& releasing) {
          return number ? releasing.release(*number) : releasing.release();
        }));
      },
      py::arg("bench") = py::none(),
      "Releases all axes, or those of one bench. Their state does not change.");
  session.def(
      "acquire",
      [](const SharedPySession& self, const py::object& axes) {
        const std::vector<client::AxisId> ids = ids_of(axes_of(self, axes));
        check(waiting(self, [&](Session& taking) {
          return taking.acquire(ids);
        }));
      },
      py::arg("axes") = py::none(),
      "Takes control of axes of one bench: of all of them, or of none when one is refused.");
  session.def(
      "send_set_points",
      [](const SharedPySession& self, const py::dict& set_points, const Number& tick,
         bool drops_waiting, const OptionalNumber& bench) {
        client::SetPointFrame frame = frame_of(set_points);
        frame.tick = count_of(tick, "tick");
        frame.drops_waiting = drops_waiting;
        const std::uint32_t number = bench_number(self, bench);
        check(waiting(self, [&](Session& sending) {
          return sending.send_set_points(number, {&frame, 1});
        }));
      },
      py::arg("set_points"), py::kw_only(), py::arg("tick") = 0, py::arg("drops_waiting") = false,
      py::arg("bench") = py::none(),
      "Sends values of objects to axes that the session holds, by their numbers on the bench, and "
      "waits for no answer: the status and the events show what became of them. They are in force "
      "in `tick` (0 = the next), up to 10 s ahead; the controlword (6040h) acts last. Beside mode, "
      "target position and controlword an axis takes 8 objects. With `drops_waiting` the frames of "
      "the session that wait for their tick are dropped first.");
}

void add_ends(SessionClass& session) {
  session.def(
      "interrupt",
      [](const PySession& self) {
        self.session()->interrupt();
      },
      "Ends all waiting calls, now and later, with Failed, until end_interrupt(). From any "
      "thread.");
  session.def(
      "end_interrupt",
      [](const PySession& self) {
        self.session()->end_interrupt();
      },
      "Calls from now on wait again.");
  session.def(
      "abandon",
      [](const PySession& self) {
        const std::shared_ptr<Session> abandoned = self.session();
        const Unlocked unlocked;
        abandoned->abandon();
      },
      "Ends the session as a kill of its program would: it sends nothing any more and releases no "
      "axis, every call fails, and the axes on a bench in realtime react as 6007h says. From any "
      "thread; close() frees what is left.");
  session.def("close", &close_session, "Releases all axes and ends the session.");
}

void add_lateness(py::module_& module) {
  using client::Lateness;
  py::class_<Lateness>(module, "Lateness",
                       "How far the samples of a Follower were behind the time of their bench, the "
                       "newest tick that the session had received from it, when the program got "
                       "them. Of a program that takes samples slower than they come.")
      .def_readonly("samples", &Lateness::samples, "Samples that the follower gave.")
      .def_readonly("late", &Lateness::late,
                    "Of these, those after which a later one was due already.")
      .def_property_readonly(
          "last",
          [](const Lateness& lateness) {
            return seconds_of(lateness.last);
          },
          "Of the newest sample, in s of drive time.")
      .def_property_readonly(
          "longest",
          [](const Lateness& lateness) {
            return seconds_of(lateness.longest);
          },
          "The longest, in s of drive time.")
      .def("__repr__", [](const Lateness& lateness) {
        return "<vdrive.Lateness: " + std::to_string(lateness.late) + " of " +
               std::to_string(lateness.samples) + " samples, at most " +
               to_text(seconds_of(lateness.longest)) + " s>";
      });
}

void add_follower(py::module_& module) {
  add_lateness(module);
  py::class_<PyFollower>(module, "Follower",
                         "Axes tick by tick: an iterator of observations, see Session.follow().")
      .def("__iter__",
           [](py::object self) {
             return self;
           })
      .def("__next__", &PyFollower::next)
      .def(
          "take",
          [](PyFollower& self, const Number& count) {
            return self.take(count_of(count, "count"));
          },
          py::arg("count"),
          "Waits for that many observations, or for those that are left of the count of follow(): "
          "a numpy array of records, a row per sample, a column per axis. What it had received "
          "when "
          "it raised is what the next call returns, at once.")
      .def_property_readonly(
          "lateness",
          [](const PyFollower& self) {
            const Unlocked unlocked;  // a call of another thread may wait for a sample
            return self.follower->lateness();
          },
          "How far its samples were behind the bench: a Lateness.")
      .def(
          "close",
          [](PyFollower& self) {
            const Unlocked unlocked;
            self.follower->close();
          },
          "Ends it.");
}

}  // namespace

void add_session(py::module_& module) {
  add_follower(module);
  SessionClass session(
      module, "Session",
      "A program's presence on a DDS domain: finds benches, reads, writes, commands their axes. It "
      "keeps the axes that it commands, and releases them when it is closed. `with` closes it. "
      "Calls may come from several threads; those that step one bench from one at a time.");
  session.def(
      py::init(&open_session), py::kw_only(), py::arg("domain") = py::none(),
      py::arg("interfaces") = std::vector<std::string>{},
      py::arg("peers") = std::vector<std::string>{},
      py::arg("discovery_servers") = std::vector<std::string>{}, py::arg("security") = "",
      py::arg("bench") = py::none(), py::arg("keep_alive") = "own_thread",
      py::arg("find_timeout") = 2.0, py::arg("silence") = 1.5, py::arg("patience") = 10.0,
      py::arg("local") = py::none(), py::arg("service") = py::none(), py::arg("program") = "",
      "domain: 0 to 232, by default that of VDRIVE_DOMAIN, else 0. interfaces: own addresses, "
      "by default loopback only. security: directory of the closed mode's credentials. bench: find "
      "this one only. find_timeout, silence, patience: wall time in s. A call raises Lost when a "
      "service was silent for `silence`; what follows a bench (wait, follow, stream, on_status) "
      "when it was silent for `patience`. local: a bench of this process, of vdrive.Bench; then no "
      "option of the network counts. service: that of a vdrive.Bench over DDS. Both live at least "
      "until the session is closed. program: what others read of who controls an axis, by default "
      "the name of the file that Python runs.");
  session
      .def_property_readonly(
          "id",
          [](const PySession& self) {
            return self.session()->id();
          },
          "Number of the session: the owner that an axis shows while this session holds it.")
      .def_property_readonly("is_closed", &PySession::is_closed, "Whether close() was called.")
      .def("__enter__",
           [](py::object self) {
             return self;
           })
      .def("__exit__",
           [](PySession& self, const py::args& /*exception*/) {
             close_session(self);
           })
      .def("__repr__", [](const PySession& self) {
        return std::string(self.is_closed() ? "<vdrive.Session, closed>" : "<vdrive.Session>");
      });
  add_finding(session);
  add_control(session);
  add_ends(session);
  add_clock(session);
  add_snapshots(session);
  add_session_observing(session);
}

}  // namespace vdrive::python
