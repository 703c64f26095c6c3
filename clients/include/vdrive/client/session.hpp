// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/axis.hpp"
#include "vdrive/client/axis_snapshot.hpp"
#include "vdrive/client/bench.hpp"
#include "vdrive/client/event.hpp"
#include "vdrive/client/history.hpp"
#include "vdrive/client/outcome.hpp"
#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/dictionary/object.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::wire {
class LocalBus;  ///< opaque: created by a bench in this process
}  // namespace vdrive::wire

namespace vdrive::client {

class AxisGroup;
class SessionCore;
class StepClock;

/// The source of the keep-alives that this program sends while it holds axes.
enum class KeepAlive : std::uint8_t {
  own_thread,   ///< a thread of the session, every 25 ms while the bench runs in realtime
  user_frames,  ///< only the user's own commands: a program that hangs loses its axes
};

/// @return the DDS domain in the environment variable VDRIVE_DOMAIN, 0 if it is not set.
/// @throws std::runtime_error if it is set, but not to a number from 0 to 232
[[nodiscard]] std::uint32_t default_domain();

/// Where to look for benches, and how. The defaults find every bench of this machine on the default
/// domain.
struct SessionOptions {
  /// Longer than the default, because a session that misses the first message of an authentication
  /// gets the next one a second later.
  static constexpr std::chrono::milliseconds kFindTimeoutOfClosedMode{5'000};

  std::optional<std::uint32_t> domain{};  ///< DDS domain, 0 to 232; none = default_domain()
  std::vector<std::string> interfaces{};  ///< networks to use: own addresses, or names such as
                                          ///< eth0; empty = loopback only
  std::vector<std::string> peers{};       ///< hosts searched for benches in addition to multicast
  std::vector<std::string>
      discovery_servers{};  ///< such as "10.0.0.9:11811", instead of multicast and peers
  std::string security{};   ///< directory with the material of the closed mode; empty = open
  std::optional<std::uint32_t> bench{};  ///< find this bench only
  KeepAlive keep_alive = KeepAlive::own_thread;
  /// Wall time allowed for finding a service; in the closed mode use kFindTimeoutOfClosedMode. If a
  /// service has announced itself, or on a busy machine, a search may take longer: see
  /// find_benches().
  std::chrono::milliseconds find_timeout{2000};
  /// A call that waits reports a service as lost when its newest sample is older than this [wall
  /// time, 50 ms or more]. The default is this long because a busy machine may stop a process for
  /// some hundred milliseconds, and a service sends nothing while its wire process restarts.
  /// Session::watch_services reports the silence earlier.
  std::chrono::milliseconds silence{1500};
  /// Calls that follow a bench (Follower, Session::wait, wait_for_tick, on_status) continue after a
  /// silence up to this [wall time], so that they survive a restart of the wire process; a follower
  /// counts the samples it missed. Values below `silence` act as `silence`. Time in which this
  /// program itself did not run (stopped, or without a processor) counts towards neither limit.
  std::chrono::milliseconds patience{10'000};
  /// The benches of this process that the session sees (vdrive::bench::Bench::bus); null = those of
  /// the network. With a bus, no network option applies, and a bench is either there or not:
  /// `silence` and `patience` have no effect either. A `silence` out of range is still refused.
  std::shared_ptr<wire::LocalBus> bus{};
  /// Name under which others see this program as the owner of an axis, together with the number of
  /// this process and the name of its host. At most 64 bytes of UTF-8; empty = the file name of the
  /// program.
  std::string program{};
  /// For a program that only observes: an idle session takes what has arrived only this often [wall
  /// time, 0 to 20 ms]. One wakeup then serves many samples, but every answer may arrive later by
  /// up to this time. 0 = immediately. No effect on a bus of this process.
  std::chrono::milliseconds receive_coalescing{0};
};

/// A change in the presence of a service.
enum class ServiceNews : std::uint8_t {
  found,         ///< it is there
  fell_silent,   ///< no sample arrived: it ended, hangs, or the network is down
  sends_again,   ///< the same run of the service as before
  restarted,     ///< another run: no session holds any of its axes, and every axis is disabled
  went_offline,  ///< it announced its end
};

/// @return the news as one word, such as "fell_silent".
[[nodiscard]] std::string_view to_string(ServiceNews news) noexcept;

/// One change reported by Session::watch_services.
struct ServiceChange {
  std::uint32_t bench = 0;
  ServiceNews news = ServiceNews::found;
  std::chrono::milliseconds silence{};  ///< age of its newest sample
  std::string text;                     ///< such as "bench 1 stopped sending 83 ms ago"
};

/// Maximum number of objects in one set-point, besides position, mode and controlword.
inline constexpr std::size_t kMostObjectsOfSetPoint = 8;

/// A value for an object of an axis.
struct ObjectValue {
  ObjectAddress object;
  std::int64_t value = 0;  ///< in the unit of the object
};

/// The contents of a frame of set-points for one axis. Members without a value change nothing.
struct SetPoint {
  std::uint16_t axis = 0;                      ///< number on the bench
  std::optional<OperatingMode> mode{};         ///< 6060h
  std::optional<std::int32_t> position{};      ///< 607Ah [UU]
  std::optional<std::int32_t> velocity{};      ///< 60FFh [UU/s]
  std::optional<std::int16_t> torque{};        ///< 6071h [‰ of rated torque]
  std::optional<std::uint16_t> controlword{};  ///< 6040h, takes effect last
  /// Further objects, written in this order after the members above and before the controlword;
  /// velocity, torque and these together at most kMostObjectsOfSetPoint. The bench refuses an
  /// object that it does not have, that is not writable, or that acts on power or memory, such as
  /// 1010h.
  std::vector<ObjectValue> objects{};
};

/// The objects to set to 0 before a stream of one set-point per tick, because another master may
/// have set them: 60C2h:01 and the offsets 60B0h, 60B1h and 60B2h.
[[nodiscard]] std::vector<ObjectValue> objects_before_stream();

/// Set-points that take effect in one tick.
struct SetPointFrame {
  std::uint64_t tick = 0;      ///< 0 = the next
  bool drops_waiting = false;  ///< first drop this session's frames that are waiting for their tick
  std::vector<SetPoint> axes{};  ///< each once; more than kMostAxesAtOnce are sent as several
};

/// A value in a set-point that the drive refused: the object keeps its old value.
struct SetPointRefusal {
  AxisId axis;
  ObjectAddress object;
  AbortCode code = AbortCode::none;

  friend auto operator<=>(const SetPointRefusal&, const SetPointRefusal&) = default;
};

/// A saved state of all axes of a bench, kept by the bench.
struct KeptSnapshot {
  std::uint64_t number = 0;
  std::uint64_t tick = 0;  ///< in which it was taken
};

/// Whether a follower advances the clock of a lock-step bench.
enum class Pace : std::uint8_t {
  drive,    ///< in lock-step each sample steps one tick; otherwise follows the status stream
  observe,  ///< follows the status stream, whoever advances the clock, also while it is paused
};

/// How far the samples of a follower lagged behind the time of their bench when the program got
/// them. The time of the bench is the newest tick that the session has received from the bench, in
/// a status or a state message. This reveals a program that takes samples more slowly than they
/// arrive, but not a constant network delay. Differences of the tick number count as drive time,
/// including jumps of the number. A sample from a step of the follower itself (lock-step with
/// Pace::drive) is never late.
struct Lateness {
  std::uint64_t samples = 0;        ///< returned by the follower
  std::uint64_t late = 0;           ///< of these, those returned when a later one was already due
  std::chrono::nanoseconds last{};  ///< [drive time] of the newest sample
  std::chrono::nanoseconds longest{};  ///< [drive time]
};

/// Follows axes of one bench tick by tick. Made by Session::follow; must not outlive the session.
class Follower {
 public:
  ~Follower();
  Follower(const Follower&) = delete;
  Follower& operator=(const Follower&) = delete;
  Follower(Follower&&) noexcept;
  Follower& operator=(Follower&&) noexcept;

  /// Waits for the next tick with all axes; in lock-step with Pace::drive, steps to it.
  /// @param patience wall time to wait for a sample
  /// @return timed_out after `patience`; lost if the service was silent for
  ///         SessionOptions::patience, has ended or was restarted; failed if interrupted or, with
  ///         Pace::drive, if the bench is paused. After a silence, next() can be called again.
  Result<Observation> next(std::chrono::milliseconds patience);

  /// As above, reusing the memory of an earlier sample: a program that passes each sample back
  /// follows thousands of axes without an allocation per tick.
  /// @param sample set to the next one on success, otherwise unchanged
  Outcome next(std::chrono::milliseconds patience, Observation& sample);

  /// @return whether next() would return without waiting for time or other steppers: a sample is
  ///         available, or this session alone steps the bench. An interrupt does not end next()
  ///         then.
  [[nodiscard]] bool has_next() const;

  /// @return the figures since the follower was made.
  [[nodiscard]] Lateness lateness() const noexcept;

 private:
  friend class SessionCore;
  struct State;
  explicit Follower(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// Reports the states of axes to an observer until this object is destroyed. Made by
/// Session::report_status; must not outlive the session.
class StatusReports {
 public:
  /// Waits for a report in progress. The observer itself may also destroy this object: then the
  /// report in progress is the last one.
  ~StatusReports();
  StatusReports(const StatusReports&) = delete;
  StatusReports& operator=(const StatusReports&) = delete;
  StatusReports(StatusReports&&) noexcept;
  StatusReports& operator=(StatusReports&&) noexcept;

 private:
  friend class Session;
  struct State;

  struct End {
    void operator()(State* state) const noexcept;
  };

  explicit StatusReports(std::unique_ptr<State, End> state);
  std::unique_ptr<State, End> state_;
};

/// A program's presence on a domain: finds benches, and reads, writes and commands their axes.
///
/// A session is identified by a random 64-bit number. It acquires an axis with its first command to
/// that axis, keeps all its axes until the session ends, and then releases them; releasing an axis
/// does not affect the motion of the axis. The session does not release an axis that one of its
/// calls has set in endless motion (a velocity, a torque, a stream, set-points) and that it has not
/// seen stop since, because nothing would stop a free axis. That axis stays with the session, and
/// the watchdog of the bench stops it when the session falls silent. Once run_at() or
/// apply_torque() has reached its velocity or torque, the axis runs on as the program wanted, and
/// is released.
///
/// Time-outs of motion are drive time, counted in ticks that are run: a jump of the tick number
/// uses up none of it. In freerun they count from the tick in which the last command of the call
/// took effect, because the bench may run minutes of drive time before a command arrives. Time-outs
/// for finding a service and for noticing its silence are wall time. A call that waits for drive
/// time fails when its bench is paused. In lock-step, calls that wait step the clock themselves;
/// while the session has joined the clock (StepClock), they grant their ticks and wait for the
/// other steppers, up to 10 s of wall time for the next tick.
///
/// In the closed mode the session may have the identity of a viewer: it can read everything
/// published, and every call that would send something to a bench is refused with kNotPermitted.
///
/// When the wire process of a service restarts, or the network link comes back, calls that wait
/// continue: unanswered requests are sent again and take effect once. Axes that the bench took away
/// in the meantime are not acquired again.
///
/// Calls may come from several threads. If several threads step a lock-step bench at the same time,
/// the steps run one after the other; each call returns the tick that it reached.
///
/// Observers (watch_services, on_event, on_status, report_status) run on threads of the session,
/// never within a call of the program. They may call the session, wait, and end or replace their
/// own reports. An exception that leaves an observer ends its reports and is rethrown, once, by the
/// next call of the session, its axes, groups, followers or step clocks that needs a bench; if
/// several observers threw, each call rethrows one exception. These calls rethrow nothing: those
/// that stop axes (see interrupt()) or release them, present_benches, no_bench_found,
/// network_troubles, find_name, known_name, steps_at_once, on_event, on_set_point_refusal,
/// watch_services, abandon, AxisGroup::queue_move, and calls from an observer of the same session.
///
/// A forked process cannot use the session of its parent: there, calls return lost, calls without
/// an outcome throw OutcomeError or do nothing, and the destructor releases nothing.
class Session {
 public:
  /// @throws std::runtime_error if the domain or `silence` is out of range, VDRIVE_DOMAIN is needed
  ///         but is not a domain, the security material is not valid, or DDS cannot be set up.
  explicit Session(const SessionOptions& options = {});

  /// Releases all axes. Axes and groups of the session, and their copies, can command nothing from
  /// then on.
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// The session's number: the owner that an axis shows while this session holds it.
  [[nodiscard]] std::uint64_t id() const noexcept;

  /// @return the name of a session, such as the owner of an axis, as its program stated it on first
  ///         acquiring an axis of the bench; nothing for a session without a name, such as a client
  ///         of another vendor. Waits up to a second for the names from the bench to arrive; later
  ///         calls wait up to 100 ms for the name of a session that was not asked for before.
  [[nodiscard]] std::optional<SessionName> find_name(std::uint32_t bench, std::uint64_t session);

  /// @return as find_name(), without waiting: only names that have arrived since the first call of
  ///         either function.
  [[nodiscard]] std::optional<SessionName> known_name(std::uint32_t bench, std::uint64_t session);

  /// Waits until there is a bench, every service that announced itself has described its bench, and
  /// no further bench has appeared for 150 ms, or for four times as long as the first one took if
  /// that is longer; at most `find_timeout` in total. If a service has announced itself but there
  /// is no bench yet, the limit is three times `find_timeout`. If the machine runs this thread
  /// late, the wait grows by four times that delay, by at most three times `find_timeout`.
  /// @return the benches by number; empty if none was found in that time. A bench is there while
  ///         its samples are younger than 300 ms and it has not announced its end.
  [[nodiscard]] std::vector<BenchInfo> find_benches();

  /// @return not_found, for a program that needs a bench when find_benches() found none: the
  ///         message names what the last search saw, such as a service without a description.
  [[nodiscard]] Outcome no_bench_found() const;

  /// @return the known obstacles to finding benches at present, one per line: a host name that does
  ///         not resolve, a discovery server that does not answer. Empty if none is known.
  [[nodiscard]] std::vector<std::string> network_troubles() const;

  /// The benches that are there now, by number. Does not wait.
  [[nodiscard]] std::vector<BenchInfo> present_benches() const;

  /// @param number of the bench; none = the only one there is
  /// @return not_found after `find_timeout` or, without a number, if there are several. The message
  ///         names what was looked for and what was found.
  Result<BenchInfo> find_bench(std::optional<std::uint32_t> number = std::nullopt);

  /// @param text an address such as "1.2" or "1.lift", or the name of an axis. A name is found as
  ///        soon as a bench that has it answers. If axes of several benches may have the same name,
  ///        use the address: a bench that answers later is not considered.
  /// @return not_found after `find_timeout`; immediately if the bench is there but has no such
  ///         axis, or if several axes have the name.
  Result<Axis> axis(std::string_view text);

  /// Every axis of a bench, by number.
  /// @param bench none = the only one there is
  /// @return not_found as in find_bench().
  Result<std::vector<Axis>> axes(std::optional<std::uint32_t> bench = std::nullopt);

  /// Takes control of axes of one bench without a command: of all of them, or of none if one is
  /// refused. More than kMostAxesAtOnce axes are acquired in parts of that size, in order: a
  /// refusal ends the call, and the earlier parts stay acquired.
  /// @param axes of one bench, each once
  /// @return refused if another session holds one of them.
  Outcome acquire(std::span<const AxisId> axes);

  /// Gives several axes the same command: sends it to all of them, then waits for all. An axis that
  /// refuses it or fails does not affect the others; the time-out applies to all of them together.
  /// @param axes of this session, on any benches, each once
  /// @return one outcome per axis, in their order, as the corresponding call of Axis returns it.
  std::vector<Outcome> command_each(std::span<const Axis> axes, EachCommand command,
                                    const CallOptions& options = {});

  /// Steps a lock-step bench.
  /// @return the tick reached; refused in another clock mode, and if others have joined the clock
  ///         and this session has not; timed_out, naming the stepper that time waits for.
  Result<std::uint64_t> step(std::uint32_t bench, std::uint64_t ticks);

  /// @return whether the bench is present and step() would need only one request (at most 2,000
  ///         ticks) and no other stepper. An interrupt does not end such a step.
  [[nodiscard]] bool steps_at_once(std::uint32_t bench, std::uint64_t ticks) const;

  /// Sets how fast drive time passes on a realtime bench, for everybody.
  /// @param rate drive time over wall time: 0 = pause, 0.1 to 100
  /// @return the tick in which the rate changed; refused out of range and in another clock mode.
  Result<std::uint64_t> set_rate(std::uint32_t bench, double rate);

  /// Lets drive time pass, rounded up to ticks: steps in lock-step, otherwise waits until that many
  /// ticks have run. A jump of the tick number does not shorten the wait.
  /// @return the tick reached; lost if the service was silent for SessionOptions::patience.
  Result<std::uint64_t> wait(std::uint32_t bench, std::chrono::nanoseconds duration);

  /// Waits until the bench has reached `tick`, or has jumped over it; in lock-step, steps to it.
  /// @return the tick reached.
  Result<std::uint64_t> wait_for_tick(std::uint32_t bench, std::uint64_t tick);

  /// Takes a snapshot of all axes of a bench whose time stands still: in lock-step, or paused.
  /// @return its number; refused while time passes, or if the bench already keeps 16.
  Result<std::uint64_t> take_snapshot(std::uint32_t bench);

  /// Restores all axes to the state of a snapshot. The tick number continues, owners keep their
  /// axes, and command frames that still wait for their tick are dropped.
  /// @return the tick; refused while time passes, if there is no such snapshot, or if another
  ///         session holds an axis.
  Result<std::uint64_t> restore_snapshot(std::uint32_t bench, std::uint64_t snapshot);

  /// @return the snapshots that a bench keeps, by number; works in any clock mode.
  Result<std::vector<KeptSnapshot>> snapshots(std::uint32_t bench);

  /// Returns the writes to the axes of a bench, by anyone, accepted or refused. From the first such
  /// call, the bench keeps the last 65,536.
  /// @param place of the last one already read; 0 = start with the oldest that is kept
  /// @return about 60 of them; empty if there is nothing new. Refused by a service that keeps none.
  Result<AxisWrites> writes(std::uint32_t bench, std::uint64_t place = 0);

  /// @return the windows in the black box of a bench, by number: what happened around the last
  ///         faults, losses of a master and stops by another session. Refused if it has no black
  ///         box.
  Result<std::vector<KeptWindow>> windows(std::uint32_t bench);

  /// Keeps a window around now: from 2 s before to 0.5 s after, in drive time.
  /// @return its number
  Result<std::uint64_t> freeze_window(std::uint32_t bench);

  /// Returns what axes of one bench did in a window, tick by tick. Waits while the bench is still
  /// recording it; if time stands still, the window ends now.
  /// @return refused if there is no such window
  Result<Window> window(std::uint64_t number, std::span<const AxisId> axes);

  /// Deletes a snapshot.
  /// @return refused while time passes, or if there is no such snapshot.
  Outcome drop_snapshot(std::uint32_t bench, std::uint64_t snapshot);

  /// Sends set-points, in order, to axes of one bench that the session holds, without waiting for
  /// an answer. The status shows their effect; on_event() reports a refusal, and
  /// on_set_point_refusal() each refused value. Frames for later ticks, up to 10 s ahead and up to
  /// 1,024 from all sessions, wait in the bench; one that arrives too late is refused. Does not
  /// step the clock.
  /// @return lost if the bench cannot be reached; refused without permission to command; failed,
  ///         with nothing sent, if a set-point has too many objects.
  Outcome send_set_points(std::uint32_t bench, std::span<const SetPointFrame> frames);

  /// The present state of some axes of one bench.
  /// @param axes of one bench, in any order; the result has the same order
  Result<Observation> observe(std::span<const AxisId> axes);

  /// @param axes of one bench
  /// @return refused if an axis is named twice.
  Result<Follower> follow(std::vector<AxisId> axes, Pace pace);

  /// Calls `observer`, on a thread of the session, when a service is found, falls silent, sends
  /// again, restarts or goes offline. Silence is judged by the age of samples: it is reported
  /// within 100 ms while the bench ticks, within 300 ms if time stands still (lock-step, paused).
  /// @param observer must not end the session; an empty one ends the watch. It replaces the
  ///        previous one.
  void watch_services(std::function<void(const ServiceChange&)> observer);

  /// Calls `observer`, on a thread of the session, for each event from now on of the benches that
  /// this session sees: a fault, a refusal, a loss of control, a stop by another session. Each
  /// event of a bench is reported once and in order. At least 4,096 events wait for a slow
  /// observer; beyond that, the oldest are lost.
  /// @param observer must not end the session; an empty one ends the reports. It replaces the
  ///        previous one.
  /// @param history kept = start with the oldest event that each bench still has
  void on_event(std::function<void(const Event&)> observer,
                EventHistory history = EventHistory::left_out);

  /// Calls `observer`, on a thread of the session, for each value sent by send_set_points() that a
  /// drive refuses, such as one out of the range of its object: up to 256 per frame. A set-point
  /// that is refused entirely, such as one for an axis that another session owns, is only an event.
  /// If the observer is slow, the oldest of 65,536 refusals are lost.
  /// @param observer must not end the session; an empty one ends the reports. It replaces the
  ///        previous observer, which is no longer running when this call returns (unless the
  ///        previous observer itself made this call).
  void on_set_point_refusal(std::function<void(const SetPointRefusal&)> observer);

  /// Calls `observer`, on a thread of the session, with the newest state of these axes: for each of
  /// their benches at most once per `period`, when a tick later than the last reported one has
  /// arrived. For a program with its own loop. In lock-step the present state is reported first,
  /// and nothing after it while drive time stands still. The reports continue after a restart of
  /// the service. They end for a bench that has sent nothing for SessionOptions::patience, and for
  /// a bench in this process when it ends.
  /// @param period wall time, 1 ms or more
  /// @param observer must not end the session; an empty one ends the reports. It replaces the
  ///        previous one.
  /// @param ended called with lost and the reason when the reports of a bench have ended
  /// @return not_found if one of the axes is not there; failed if `period` is too short.
  Outcome on_status(std::span<const AxisId> axes, std::chrono::milliseconds period,
                    std::function<void(const Observation&)> observer,
                    std::function<void(const Outcome&)> ended = {});

  /// As on_status(), but independent of other reports: a session can have any number of these.
  Result<StatusReports> report_status(std::span<const AxisId> axes,
                                      std::chrono::milliseconds period,
                                      std::function<void(const Observation&)> observer,
                                      std::function<void(const Outcome&)> ended = {});

  /// Immediate quick stop of every axis without a fault on a bench, whoever owns it. The owners
  /// keep their axes; nothing is acquired. Also works after interrupt().
  /// @param options done = all axes are at rest
  /// @return failed, with nothing sent, while the bench is paused.
  Outcome quick_stop(std::uint32_t bench, const CallOptions& options = {});

  /// Releases all axes. Their motion is not affected.
  /// @return failed, naming the axis, if one is running and was not seen to stop: that axis is not
  ///         released
  Outcome release();

  /// As release(), for the axes of one bench.
  Outcome release(std::uint32_t bench);

  /// Ends the session as if its program had been killed: from now on it sends nothing, releases no
  /// axis, and every call fails. A realtime bench detects the silence, and its axes react as 6007h
  /// selects. For a program that commands on behalf of a client that it has lost. May be called
  /// from any thread.
  void abandon() noexcept;

  /// Ends all calls that wait, now and later, with `failed`; motions continue. Calls that stop axes
  /// (Axis::halt, Axis::quick_stop, quick_stop, AxisGroup::halt_all, AxisGroup::quick_stop_all)
  /// still work. May be called from any thread.
  void interrupt() noexcept;

  /// Undoes interrupt(): calls from now on wait again. For a program that continues, for example to
  /// clean up. A call still waiting in another thread may continue too, so make sure that there is
  /// none.
  void end_interrupt() noexcept;

  /// @return whether interrupt() was called without an end_interrupt() since.
  [[nodiscard]] bool is_interrupted() const noexcept;

 private:
  friend class AxisGroup;
  friend class StepClock;
  std::shared_ptr<SessionCore> core_;
};

}  // namespace vdrive::client
