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
class LocalBus;  ///< opaque: a bench in this process makes it
}  // namespace vdrive::wire

namespace vdrive::client {

class AxisGroup;
class SessionCore;
class StepClock;

/// Who sends keep-alives to the benches while this program holds axes.
enum class KeepAlive : std::uint8_t {
  own_thread,   ///< the session itself, every 25 ms while the bench runs in realtime
  user_frames,  ///< only the user's own commands: a program that hangs loses its axes
};

/// @return the DDS domain that the environment variable VDRIVE_DOMAIN names, 0 when it is not set.
/// @throws std::runtime_error when it is set, but no number from 0 to 232
[[nodiscard]] std::uint32_t default_domain();

/// What to reach, and how. The defaults see every bench of this machine on the default domain.
struct SessionOptions {
  /// A session that misses the first message of an authentication gets the next one a second later.
  static constexpr std::chrono::milliseconds kFindTimeoutOfClosedMode{5'000};

  std::optional<std::uint32_t> domain{};  ///< DDS domain, 0 to 232; none = default_domain()
  std::vector<std::string> interfaces{};  ///< in the networks to use: own addresses, or names such
                                          ///< as eth0; empty = loopback only
  std::vector<std::string> peers{};       ///< hosts searched for benches in addition to multicast
  std::vector<std::string>
      discovery_servers{};  ///< such as "10.0.0.9:11811", instead of multicast and peers
  std::string security{};   ///< directory of the closed mode's material; empty = open
  std::optional<std::uint32_t> bench{};  ///< see this bench only
  KeepAlive keep_alive = KeepAlive::own_thread;
  /// Wall time that finding a service may take; in the closed mode better kFindTimeoutOfClosedMode.
  /// A service that has announced itself, and a busy machine, get more: see find_benches().
  std::chrono::milliseconds find_timeout{2000};
  /// A call that waits reports a service as lost when its newest sample is older than this [wall
  /// time], 50 ms or more: a busy machine may stop a process for some hundred milliseconds, and a
  /// service sends nothing while its network process restarts. Session::watch_services reports the
  /// silence earlier.
  std::chrono::milliseconds silence{1500};
  /// What follows a bench (Follower, Session::wait, wait_for_tick, on_status) continues after a
  /// silence up to this [wall time], so that it survives the replacement of the network process; a
  /// follower counts what it missed. One shorter than `silence` acts as `silence`. In neither of
  /// them counts a time in which this program did not run itself: stopped, or without a processor.
  std::chrono::milliseconds patience{10'000};
  /// The benches of this process that the session sees (vdrive::bench::Bench::bus); nothing = those
  /// of the network. With a bus no option of the network counts, and a bench is there or not: no
  /// silence and no patience count either. A `silence` out of its range is refused all the same.
  std::shared_ptr<wire::LocalBus> bus{};
  /// What others read of who controls an axis, at most 64 bytes of UTF-8, beside the number of this
  /// process and the name of its host; empty = the name of the file that this process runs.
  std::string program{};
};

/// What happened to a service.
enum class ServiceNews : std::uint8_t {
  found,         ///< it is there
  fell_silent,   ///< no sample arrived: it ended, hangs, or the network is down
  sends_again,   ///< the same run of the service as before
  restarted,     ///< another run: no session holds an axis of it, every axis is disabled
  went_offline,  ///< it announced its end
};

/// @return the news as one word, such as "fell_silent".
[[nodiscard]] std::string_view to_string(ServiceNews news) noexcept;

/// One change that Session::watch_services reports.
struct ServiceChange {
  std::uint32_t bench = 0;
  ServiceNews news = ServiceNews::found;
  std::chrono::milliseconds silence{};  ///< age of its newest sample
  std::string text;                     ///< such as "bench 1 stopped sending 83 ms ago"
};

/// Objects that one set-point can have beside position, mode and controlword.
inline constexpr std::size_t kMostObjectsOfSetPoint = 8;

/// A value for an object of an axis.
struct ObjectValue {
  ObjectAddress object;
  std::int64_t value = 0;  ///< in the unit of the object
};

/// What a frame of set-points brings to one axis. What is not given stays.
struct SetPoint {
  std::uint16_t axis = 0;                      ///< number on the bench
  std::optional<OperatingMode> mode{};         ///< 6060h
  std::optional<std::int32_t> position{};      ///< 607Ah [UU]
  std::optional<std::int32_t> velocity{};      ///< 60FFh [UU/s]
  std::optional<std::int16_t> torque{};        ///< 6071h [‰ of rated torque]
  std::optional<std::uint16_t> controlword{};  ///< 6040h, acts last
  /// Further objects, written in this order after the members above and before the controlword;
  /// with velocity and torque at most kMostObjectsOfSetPoint. The bench refuses an object that it
  /// does not have, that may not be written, or that acts on power or memory, such as 1010h.
  std::vector<ObjectValue> objects{};
};

/// Objects to write before a stream that has a set-point for each tick and nothing beside it, each
/// 0: 60C2h:01 and the offsets 60B0h, 60B1h and 60B2h, which another master may have left.
[[nodiscard]] std::vector<ObjectValue> objects_before_stream();

/// Set-points that are in force in one tick.
struct SetPointFrame {
  std::uint64_t tick = 0;        ///< 0 = the next
  bool drops_waiting = false;    ///< first drops the frames of the session that wait for their tick
  std::vector<SetPoint> axes{};  ///< each once; more than kMostAxesAtOnce are sent in parts
};

/// A value of a set-point that its drive has refused: the object keeps the one that it has.
struct SetPointRefusal {
  AxisId axis;
  ObjectAddress object;
  AbortCode code = AbortCode::none;

  friend auto operator<=>(const SetPointRefusal&, const SetPointRefusal&) = default;
};

/// A saved state of all axes of a bench, which the bench keeps.
struct KeptSnapshot {
  std::uint64_t number = 0;
  std::uint64_t tick = 0;  ///< in which it was taken
};

/// Whether a follower advances the clock of a lock-step bench.
enum class Pace : std::uint8_t {
  drive,    ///< in lock-step each sample is a step of one tick; else follows the status stream
  observe,  ///< follows the status stream, whoever advances the clock, also while it is paused
};

/// How far the samples of a follower were behind the time of their bench when the program got them.
/// That time is the newest tick that the session has received from the bench, in a status or in a
/// state; so a program that takes samples slower than they come shows, and a network whose delay is
/// the same for all messages does not. Differences of the tick number count as drive time, also
/// those that the number jumped over. A sample that is a step of its own (lock-step with
/// Pace::drive) is never late.
struct Lateness {
  std::uint64_t samples = 0;           ///< that the follower gave
  std::uint64_t late = 0;              ///< of these, those after which a later one was due already
  std::chrono::nanoseconds last{};     ///< [drive time] of the newest sample
  std::chrono::nanoseconds longest{};  ///< [drive time]
};

/// Sees axes of one bench tick by tick. Made by Session::follow; must not outlive the session.
class Follower {
 public:
  ~Follower();
  Follower(const Follower&) = delete;
  Follower& operator=(const Follower&) = delete;
  Follower(Follower&&) noexcept;
  Follower& operator=(Follower&&) noexcept;

  /// Waits for the next tick that shows all axes; in lock-step with Pace::drive steps to it.
  /// @param patience wall time to wait for a sample
  /// @return timed_out after `patience`, lost when the service was silent for
  ///         SessionOptions::patience, has ended or was restarted, failed when interrupted or, with
  ///         Pace::drive, when the bench is paused. After a silence the same follower continues.
  Result<Observation> next(std::chrono::milliseconds patience);

  /// The same, with the memory of an earlier sample: a program that gives each one back follows
  /// thousands of axes without an allocation a tick.
  /// @param sample the next one on success, else as it was
  Outcome next(std::chrono::milliseconds patience, Observation& sample);

  /// @return whether next() would wait neither for a time nor for other steppers: a sample waits,
  /// or
  ///         this session alone steps the bench. Then no interrupt that comes meanwhile ends it.
  [[nodiscard]] bool has_next() const;

  /// @return since the follower was made.
  [[nodiscard]] Lateness lateness() const noexcept;

 private:
  friend class SessionCore;
  struct State;
  explicit Follower(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// Reports the states of axes to a function of the program until it is destroyed. Made by
/// Session::report_status; must not outlive the session.
class StatusReports {
 public:
  /// Waits for a report that is under way. Its own observer may destroy it, too: then the report
  /// that is under way is the last one.
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

/// A program's presence on a domain: finds benches, reads, writes, commands their axes.
///
/// A session is a random 64-bit number. It acquires an axis with the first command to it, keeps
/// every axis that it has and releases all of them when it ends; a release leaves an axis as it is.
/// It does not release an axis that one of its calls has set into a motion without an end (a
/// velocity, a torque, a stream, set-points) and that it has not seen stop since: free and running,
/// nothing would stop it. That axis stays with the session, and the watchdog of the bench stops it
/// when the session is silent. A call that has reached the velocity or the torque that it was to
/// leave has done so on purpose: its axis is released.
/// Deadlines of motion are drive time, the ticks that are run: a jump of the tick number uses up
/// none of it. In freerun they count from the tick in which the last command of the call came into
/// force: until it arrives, such a bench may run minutes of drive time. Finding a service and
/// noticing its silence are wall time. A call that waits for drive time fails once its bench is
/// paused. In lock-step, calls that wait step the clock themselves; while the session has joined
/// the clock (StepClock) they grant their ticks and wait for the other steppers, up to 10 s of wall
/// time for the next tick.
///
/// In the closed mode the identity may be a viewer's: then what is published can be seen, and every
/// call that would have to send something to a bench is refused with kNotPermitted.
///
/// When the network part of a service starts anew, or the link comes back, calls that wait continue
/// by themselves: what was not answered is sent again, and acts once. Axes that the bench took away
/// meanwhile are not taken again.
///
/// Calls may come from several threads. Steps of a lock-step bench that several threads ask for at
/// once follow each other; each is answered with the tick that it reached.
///
/// Observers (watch_services, on_event, on_status, report_status) run in threads of the session,
/// never in a call of the program. They may call the session, wait, and end or replace their own
/// reports. An exception that leaves an observer ends its reports. The next call that needs a bench
/// throws it, once; of several observers each call throws the exception of one: a call of the
/// session, of its axes and groups, of its followers, StepClock::join, StepClock::step or
/// StepClock::step_for. Not a call that stops axes (see interrupt()) or gives them back (release),
/// nor present_benches, no_bench_found, on_event, watch_services, abandon and
/// AxisGroup::queue_move, nor a call of an observer of the same session.
///
/// A process that was forked cannot use the session of its parent: calls return lost there, those
/// without an outcome throw OutcomeError or do nothing, and nothing ends.
class Session {
 public:
  /// @throws std::runtime_error when the domain or `silence` is out of range, VDRIVE_DOMAIN is
  ///         needed and is no domain, the security material is not in order, or DDS cannot be set
  ///         up.
  explicit Session(const SessionOptions& options = {});

  /// Gives all axes back. Axes and groups of the session, and their copies, command nothing any
  /// more.
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// The session's number; the owner that an axis shows while this session holds it.
  [[nodiscard]] std::uint64_t id() const noexcept;

  /// @return who a session is, such as the owner that an axis of this bench shows: what its program
  ///         said when it acquired an axis of the bench first; nothing for one that says nothing,
  ///         such as a client of another vendor. Waits up to a second where the name has to be
  ///         received first, up to 100 ms for a session that was not asked for before.
  [[nodiscard]] std::optional<SessionName> find_name(std::uint32_t bench, std::uint64_t session);

  /// @return the same without waiting: what has arrived since the first call of either.
  [[nodiscard]] std::optional<SessionName> known_name(std::uint32_t bench, std::uint64_t session);

  /// Waits until some bench is there, every service that announced itself has described its bench,
  /// and no further one turns up for 150 ms, or for four times as long as the first one took; in
  /// all at most for `find_timeout`. While there is no bench, but a service has announced itself,
  /// for three times as long. Where the machine lets this thread run late, it waits longer by four
  /// times that delay, at most by three times `find_timeout`.
  /// @return the benches by number; none after that time. A bench is there while its samples are
  ///         younger than 300 ms and it has not announced its end.
  [[nodiscard]] std::vector<BenchInfo> find_benches();

  /// @return not_found for a program that needs a bench where find_benches() found none: the
  ///         message names what the newest search saw, such as a service without a description.
  [[nodiscard]] Outcome no_bench_found() const;

  /// @return what is in the way of finding benches now, a line each: a name of a host that does not
  ///         resolve, a discovery server that does not answer. Empty: nothing that is known.
  [[nodiscard]] std::vector<std::string> network_troubles() const;

  /// The benches that are there now, by number. Waits for none.
  [[nodiscard]] std::vector<BenchInfo> present_benches() const;

  /// @param number of the bench; none = the only one there is
  /// @return not_found after `find_timeout` or, without a number, when several are there. The
  ///         message names what was looked for and what was found.
  Result<BenchInfo> find_bench(std::optional<std::uint32_t> number = std::nullopt);

  /// @param text an address such as "1.2" or "1.lift", or the name of an axis
  /// A name is found as soon as a bench that has it answers. Where benches may share a name, give
  /// the address: one that answers late is not compared.
  /// @return not_found after `find_timeout`, at once when the bench is there without such an axis
  ///         or several axes have the name.
  Result<Axis> axis(std::string_view text);

  /// Every axis of a bench, by number.
  /// @param bench none = the only one there is
  /// @return not_found as find_bench() is.
  Result<std::vector<Axis>> axes(std::optional<std::uint32_t> bench = std::nullopt);

  /// Takes control of axes of one bench without a command: of all of them, or of none when one is
  /// refused. Of more than kMostAxesAtOnce axes the first of them decide.
  /// @param axes of one bench, each once
  /// @return refused when another session holds one of them.
  Outcome acquire(std::span<const AxisId> axes);

  /// Gives several axes the same command: first to all of them, then waits for all. One that
  /// refuses it or fails does not keep it from the others; the time-out is that of all together.
  /// @param axes of this session, of any benches, each once
  /// @return one outcome an axis, in their order, as the call of Axis has it.
  std::vector<Outcome> command_each(std::span<const Axis> axes, EachCommand command,
                                    const CallOptions& options = {});

  /// Steps a lock-step bench.
  /// @return the tick reached; refused under another clock mode, and while others have joined the
  ///         clock and this session has not; timed_out, naming the stepper that time waits for.
  Result<std::uint64_t> step(std::uint32_t bench, std::uint64_t ticks);

  /// @return whether step() would take one request, at most 2,000 ticks, of this session alone, of
  /// a
  ///         bench that is present. Then no interrupt that comes meanwhile ends it.
  [[nodiscard]] bool steps_at_once(std::uint32_t bench, std::uint64_t ticks) const;

  /// Sets how fast drive time passes on a realtime bench, for everybody.
  /// @param rate drive time over wall time: 0 = pause, 0.1 to 100
  /// @return the tick in which the rate changed; refused outside of the range and under another
  ///         clock mode.
  Result<std::uint64_t> set_rate(std::uint32_t bench, double rate);

  /// Lets drive time pass, rounded up to ticks: steps in lock-step, else waits until as many ticks
  /// were run. A jump of the tick number makes it no shorter.
  /// @return the tick reached; lost when the service was silent for SessionOptions::patience.
  Result<std::uint64_t> wait(std::uint32_t bench, std::chrono::nanoseconds duration);

  /// Waits until the bench has reached `tick`, also by a jump of the number over it; in lock-step
  /// steps to it.
  /// @return the tick reached.
  Result<std::uint64_t> wait_for_tick(std::uint32_t bench, std::uint64_t tick);

  /// Takes a snapshot of all axes of a bench whose time stands still: in lock-step, or paused.
  /// @return its number; refused while time passes, or when the bench keeps 16 already.
  Result<std::uint64_t> take_snapshot(std::uint32_t bench);

  /// Puts all axes back into the state of a snapshot. The tick number continues, owners stay,
  /// frames that wait are dropped.
  /// @return the tick; refused while time passes, when there is no such snapshot, or when another
  ///         session holds an axis.
  Result<std::uint64_t> restore_snapshot(std::uint32_t bench, std::uint64_t snapshot);

  /// @return the snapshots that a bench keeps, by number; in any clock mode.
  Result<std::vector<KeptSnapshot>> snapshots(std::uint32_t bench);

  /// Returns what was written to the axes of a bench, by whomever, accepted or refused. From
  /// the first such call on a bench keeps the last 65,536.
  /// @param place of the last one that is known; 0 = from the oldest that is kept
  /// @return some 60 of them; none when there is nothing new. Refused by a service without them.
  Result<AxisWrites> writes(std::uint32_t bench, std::uint64_t place = 0);

  /// @return the windows of the black box of a bench, by number: what happened around the last
  ///         faults, losses of a master and stops by somebody. Refused where it has no black box.
  Result<std::vector<KeptWindow>> windows(std::uint32_t bench);

  /// Keeps a window around now: from 2 s before to 0.5 s after, in drive time.
  /// @return its number
  Result<std::uint64_t> freeze_window(std::uint32_t bench);

  /// Returns what axes of one bench did in a window, tick by tick. Waits while the bench still
  /// records it; where time stands, it ends now.
  /// @return refused when there is no such window
  Result<Window> window(std::uint64_t number, std::span<const AxisId> axes);

  /// Forgets a snapshot.
  /// @return refused while time passes, or when there is no such snapshot.
  Outcome drop_snapshot(std::uint32_t bench, std::uint64_t snapshot);

  /// Sends set-points to axes of one bench, which the session holds, in order, and waits for no
  /// answer: the status shows what became of them; on_event() reports that one was refused, and
  /// on_set_point_refusal() each value. Frames for later ticks, up to 10 s ahead and up to 1,024 of
  /// all sessions, wait in the bench; one that comes too late is refused. Steps no clock.
  /// @return lost when the bench cannot be reached, refused without permission to command; failed,
  ///         with nothing sent, when a set-point has too many objects.
  Outcome send_set_points(std::uint32_t bench, std::span<const SetPointFrame> frames);

  /// The present state of some axes of one bench.
  /// @param axes of one bench, in any order; the result has the same order
  Result<Observation> observe(std::span<const AxisId> axes);

  /// @param axes of one bench
  /// @return refused when one of them is named twice.
  Result<Follower> follow(std::vector<AxisId> axes, Pace pace);

  /// Calls `observer`, in a thread of the session, when a service is found, falls silent, sends
  /// again, restarts or goes offline. A silence is judged by the age of samples: it is reported
  /// within 100 ms while the bench ticks, within 300 ms where time stands still (lock-step,
  /// paused).
  /// @param observer must not end the session; an empty one ends the watch. It replaces the last.
  void watch_services(std::function<void(const ServiceChange&)> observer);

  /// Calls `observer`, in a thread of the session, for each event of the benches that this session
  /// sees, from now on: a fault, a refusal, a loss of control, a stop by another session. Each
  /// event of a bench comes once and in order. A program that is slow loses the oldest of 4,096.
  /// @param observer must not end the session; an empty one ends the reports. It replaces the last.
  /// @param history kept = from the oldest event on that each bench still has
  void on_event(std::function<void(const Event&)> observer,
                EventHistory history = EventHistory::left_out);

  /// Calls `observer`, in a thread of the session, for each value of send_set_points() that a drive
  /// refuses, such as one out of the range of its object: up to 256 of a frame. What is refused as
  /// a whole, such as a set-point for an axis that another session owns, is an event only. A
  /// program that is slow loses the oldest of 65,536.
  /// @param observer must not end the session; an empty one ends the reports, and none is under way
  ///        when this call returns, but the one that makes it. It replaces the last.
  void on_set_point_refusal(std::function<void(const SetPointRefusal&)> observer);

  /// Calls `observer`, in a thread of the session, with the newest state of these axes: for each of
  /// their benches at most once in `period`, when a tick later than the one before has come. For a
  /// program with a loop of its own. In lock-step the present state comes first; while drive time
  /// stands still nothing comes after it.
  /// A service that restarts is followed. The reports of a bench that has sent nothing for
  /// SessionOptions::patience have ended; those of a bench in this process end with it.
  /// @param period wall time, 1 ms or more
  /// @param observer must not end the session; an empty one ends the reports. It replaces the last.
  /// @param ended called with lost, and its reason, when the reports of a bench have ended
  /// @return not_found when one of the axes is not there; failed for a shorter period.
  Outcome on_status(std::span<const AxisId> axes, std::chrono::milliseconds period,
                    std::function<void(const Observation&)> observer,
                    std::function<void(const Outcome&)> ended = {});

  /// The same beside others: a session has any number of these reports.
  Result<StatusReports> report_status(std::span<const AxisId> axes,
                                      std::chrono::milliseconds period,
                                      std::function<void(const Observation&)> observer,
                                      std::function<void(const Outcome&)> ended = {});

  /// Quick stop of every axis of a bench that has no fault, whoever owns it, at once. The owners
  /// keep their axes; nothing is acquired. Also after interrupt().
  /// @param options done = all axes are at rest
  /// @return failed, with nothing sent, while the bench is paused.
  Outcome quick_stop(std::uint32_t bench, const CallOptions& options = {});

  /// Gives all axes back. They stay as they are.
  /// @return failed, naming it, when an axis runs that was not seen to stop: it is not given back
  Outcome release();

  /// The same for the axes of one bench.
  Outcome release(std::uint32_t bench);

  /// Ends the session as a kill of its program would: from now on it sends nothing, releases no
  /// axis, and every call fails. A bench in realtime detects the silence, and its axes react as
  /// 6007h says. For a program that commands on behalf of a client that it has lost. May be called
  /// from any thread.
  void abandon() noexcept;

  /// Ends all calls that wait, now and later, with `failed`; what moves continues. A call that
  /// stops axes (Axis::halt, Axis::quick_stop, quick_stop, AxisGroup::halt_all,
  /// AxisGroup::quick_stop_all) works after it. May be called from any thread.
  void interrupt() noexcept;

  /// Ends what interrupt() has begun: calls from now on wait again. For a program that continues,
  /// such as one that cleans up. A call that is still waiting in another thread may continue, too:
  /// make sure that there is none.
  void end_interrupt() noexcept;

  /// @return whether interrupt() was called, and end_interrupt() not since.
  [[nodiscard]] bool is_interrupted() const noexcept;

 private:
  friend class AxisGroup;
  friend class StepClock;
  std::shared_ptr<SessionCore> core_;
};

}  // namespace vdrive::client
