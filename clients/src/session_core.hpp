// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "directory.hpp"
#include "status_feed.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/publication.hpp"
#include "vdrive/wire/subscription.hpp"
#include "vdrive_messages.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

namespace vdrive::client {

/// Wall time that a step waits for the other steppers of its clock to grant the next tick.
inline constexpr std::chrono::milliseconds kStepPatience{10'000};

/// The run of a service that a call commands.
struct Target {
  BenchKey key;
  ClockMode clock_mode = ClockMode::realtime;
  std::chrono::microseconds period{1000};
  std::uint32_t status_every_ticks = 1;
  double rate = 1.0;       ///< realtime: drive time over wall time
  bool is_paused = false;  ///< drive time stands still, and with it the status stream

  [[nodiscard]] bool steps() const { return clock_mode == ClockMode::lockstep; }
};

/// @return how messages call a bench and an axis: "bench 1", "axis 1.2".
[[nodiscard]] std::string name_of(const Target& target);
[[nodiscard]] std::string name_of(const Target& target, std::uint16_t axis);

/// @return why nothing moves there: "bench 1 is paused: rate 0".
[[nodiscard]] std::string paused_text(const Target& target);

/// @return the message that the run of the service has ended and that another run has begun.
[[nodiscard]] std::string restarted_text(const Target& target);

/// @return why a session without permission to command sent nothing.
[[nodiscard]] Outcome not_permitted(const Target& target);

/// What one command frame carries.
struct FrameContent {
  std::vector<msg::AxisCommand> commands;
  std::uint64_t apply_at_tick = 0;  ///< 0 = the next; a frame that misses its tick is refused
  std::uint32_t flags = 0;          ///< FRAME_..., beside the wish for a reply
};

/// Frames on their way to one bench.
struct SentFrames {
  Target target;
  std::vector<std::uint64_t> sequences;
};

/// What became of command frames.
struct Applied {
  Outcome outcome;         ///< the first refusal, if any
  std::uint64_t tick = 0;  ///< in which the last accepted one is in force; 0 = none was
  std::vector<std::uint16_t> ignored_set_points;  ///< axes that did not take theirs
};

/// Everything behind Session: the DDS entities, who is there, what is held, what is awaited.
/// Handlers run in DDS threads and only fill; calls wait on one condition variable.
class SessionCore : public std::enable_shared_from_this<SessionCore> {
 public:
  /// How long a wait may take. An interrupt does not end the wait for the answer to a request: the
  /// interrupted call still has to clean up.
  struct Patience {
    std::chrono::milliseconds timeout;
    bool may_interrupt;
    bool needs_drive_time = false;  ///< what is awaited never comes while the bench is paused
  };

  /// What this session granted as a stepper of one run of a service.
  struct Grant {
    std::uint64_t granted = 0;  ///< last tick that it lets pass
    std::uint64_t reached = 0;  ///< tick of the last answer
  };

  /// A step that was asked for and not answered yet.
  struct Stepping {
    std::uint64_t request = 0;  ///< its number
    std::uint64_t ticks = 0;    ///< that it grants
  };

  explicit SessionCore(const SessionOptions& options);
  ~SessionCore();
  SessionCore(const SessionCore&) = delete;
  SessionCore& operator=(const SessionCore&) = delete;

  [[nodiscard]] std::uint64_t id() const noexcept { return id_; }

  std::vector<PresentBench> find_benches();
  Result<PresentBench> find_bench(std::optional<std::uint32_t> number);

  /// An axis by address or name.
  Result<AxisInfo> find_axis(std::string_view text);

  /// An axis by name among `benches`.
  Result<AxisInfo> find_name(std::string_view name, std::span<const PresentBench> benches) const;

  /// Whether this session's permissions let it ask benches for anything.
  [[nodiscard]] bool may_command() const noexcept {
    return request_publication_ != nullptr && command_publication_ != nullptr;
  }

  /// Finds the bench and waits until it can hear requests, if we may ask any, and we its answers.
  Result<Target> connect(std::uint32_t number);

  /// Asks and waits for the answer. Fills in who asks whom.
  /// @param what names the request in messages, such as "read of axis 1.1"
  Result<msg::Reply> request(const Target& target, msg::Request request, std::string_view what);

  /// A request that may change the session's epoch: acquire, write, power cycle.
  Result<msg::Reply> request_control(const Target& target, msg::Request request,
                                     std::string_view what);

  /// A request about snapshots of a bench.
  Result<msg::Reply> request_snapshot(std::uint32_t bench, std::uint32_t kind,
                                      std::uint64_t snapshot);

  /// Takes an axis unless it is held already.
  /// @param shows_us whether the axis shows this session as its owner: control may have been lost
  Outcome acquire(const Target& target, std::uint16_t axis, bool shows_us);

  /// @return whether this session took all of these and has not heard of a loss.
  bool holds(const Target& target, std::span<const std::uint16_t> axes);

  /// Takes these axes, all or none.
  Outcome acquire(const Target& target, std::span<const std::uint16_t> axes);

  /// Writes objects of one axis, which takes the axis when one of them is a command object.
  Result<msg::Reply> write(const Target& target, msg::Request request, std::string_view what);

  /// Asks several things at once. @return the answers in the same order, or the first refusal.
  Result<std::vector<msg::Reply>> requests(const Target& target, std::vector<msg::Request> requests,
                                           std::string_view what);

  /// Sends frames in order. @return the sequence numbers to collect the answers by, also of what
  ///         was sent before a failure.
  Outcome send(const Target& target, std::span<const FrameContent> frames,
               std::vector<std::uint64_t>& sequences);

  /// Waits for the answers to these frames. A frame that waits for its tick is answered then.
  /// @param outcome of the sending; when it failed nothing is waited for
  Applied collect(const Target& target, std::span<const std::uint64_t> sequences, Outcome outcome);

  /// Waits until all of these are answered, or one of them is refused.
  /// @return whether none was refused.
  Result<bool> await_answers(std::span<const SentFrames> sent);

  /// Sends one frame for each command, in order, and waits until they are in force: in lock-step
  /// steps one tick.
  Result<Applied> command(const Target& target, std::span<const msg::AxisCommand> commands);

  /// Steps, and shows `axes` afterwards. 0 ticks only show.
  /// @param patience wall time for other steppers to grant the next tick
  Result<Observation> step(const Target& target, std::uint64_t ticks,
                           std::span<const std::uint16_t> axes,
                           std::chrono::milliseconds patience = kStepPatience);

  /// Makes this session a stepper of the bench. @return the present tick.
  Result<std::uint64_t> join_clock(const Target& target);

  /// Ends that, if the service still answers.
  void leave_clock(const Target& target);

  /// What this session granted; nothing when it has not joined the clock.
  std::optional<Grant> grant_of(const BenchKey& key);

  /// Of a bench whose clock this session has joined: asks to let time pass until `tick`, and does
  /// not wait.
  /// @param request carries what else the step is to show
  Result<Stepping> begin_step_to(const Target& target, std::uint64_t tick, msg::Request request);

  /// Waits until that tick is reached, asking again while other steppers have not granted it.
  /// @return the tick reached, timed_out at the deadline, naming the stepper that is missing.
  Result<std::uint64_t> end_step(const Target& target, Stepping stepping,
                                 std::chrono::steady_clock::time_point deadline);

  /// @return lost when the run of the service that `target` speaks of is gone.
  Outcome check_presence(const Target& target);

  Result<std::uint64_t> set_rate(const Target& target, double rate);

  /// @return whether drive time stands still now.
  bool is_paused(const Target& target);

  /// The present state of `axes`.
  Result<Observation> observe(const Target& target, std::span<const std::uint16_t> axes);

  Result<std::uint64_t> wait_for_tick(const Target& target, std::uint64_t tick);

  /// The newest tick of the bench.
  Result<std::uint64_t> present_tick(const Target& target);

  /// Starts to collect the status stream for `axes`; ends with the last pointer to it.
  std::shared_ptr<StatusFeed> open_feed(const Target& target, std::vector<std::uint16_t> axes);

  /// Sees `axes` tick by tick.
  Follower follow(const Target& target, std::vector<std::uint16_t> axes, Pace pace);

  /// Waits for the next sample of a feed.
  Result<Observation> next(const Target& target, StatusFeed& feed, Patience patience);

  /// Session::watch_services.
  void watch_services(std::function<void(const ServiceChange&)> observer);

  Outcome release();
  void interrupt() noexcept;

  /// Wall time without a sample after which a service counts as lost.
  [[nodiscard]] std::chrono::milliseconds silence() const noexcept { return options_.silence; }

 private:
  /// What this session has from one run of a service.
  struct Holding {
    BenchKey key;
    bool lives_by_wall_clock = false;
    std::uint32_t epoch = 0;
    std::uint64_t epoch_since = 0;  ///< first sequence number sent with this epoch
    std::uint64_t sequence = 0;     ///< last one sent
    std::set<std::uint16_t> axes;
  };

  using Lock = std::unique_lock<std::mutex>;
  using PendingCommand = std::pair<BenchKey, std::uint64_t>;

  /// A frame that was sent, and its answer once it is there.
  struct AwaitedCommand {
    msg::CommandFrame frame;
    Directory::Clock::time_point sent;
    std::optional<msg::CommandReply> reply;
  };

  /// A request that was sent, and its answer once it is there.
  struct AwaitedRequest {
    BenchKey key;
    msg::Request request;
    Directory::Clock::time_point sent;
    std::optional<msg::Reply> reply;
  };

  /// The way to one run of a service. Its mutex orders what is written to it, and is taken after a
  /// send mutex.
  struct Link {
    std::mutex mutex;
    wire::Source source;  ///< participant that has what was written; guarded by the session's mutex
  };

  void on_description(const msg::BenchDescription& message, const wire::Source& source);
  void on_state(const msg::BenchState& message, const wire::Source& source);
  void on_reply(const msg::Reply& message, const wire::Source& source);
  void on_command_reply(const msg::CommandReply& message, const wire::Source& source);
  void on_status(const msg::StatusFrame& message, const wire::Source& source);

  /// Repairs the link to a bench that is broken or owes an answer; releases the lock meanwhile.
  /// @return whether it was broken.
  bool repair_if_needed(Lock& lock, const BenchKey& key, Directory::Clock::time_point now);

  /// @return why a wait that began at `begin` ends without what it waits for; nothing = it goes on.
  [[nodiscard]] std::optional<Outcome> end_of_wait(const Target& target, const Patience& patience,
                                                   Directory::Clock::time_point begin,
                                                   Directory::Clock::time_point now);

  template <typename Condition>
  Outcome wait(Lock& lock, const Target& target, Patience patience, const Condition& condition);
  template <typename Condition>
  bool wait_to_find(Lock& lock, const Condition& condition);
  bool is_interrupted();
  Outcome gone(const Target& target);
  /// @param patience wall time to wait for the way to a bench that is connected anew
  Result<std::uint64_t> send_request(const Target& target, msg::Request request,
                                     std::chrono::milliseconds patience = kMatch);
  Result<msg::Reply> await_reply(const Target& target, std::uint64_t number, Patience patience);
  Result<msg::Reply> step_once(const Target& target, msg::Request request,
                               std::chrono::milliseconds patience);
  Result<msg::Reply> step_as_stepper(const Target& target, const Grant& grant,
                                     const msg::Request& request,
                                     std::chrono::milliseconds patience);
  Result<msg::Reply> conclude_step(const Target& target, const Stepping& stepping,
                                   std::chrono::steady_clock::time_point deadline);
  Outcome missing_stepper(const Target& target, std::uint64_t session) const;

  // the way to a bench: session_link.cpp
  /// How long a bench and this session may take to find each other's queues.
  static constexpr std::chrono::milliseconds kMatch{2'000};

  Link& link_of(const BenchKey& key);
  bool is_matched(const wire::Source& source, std::chrono::milliseconds patience);
  Outcome await_match(const Target& target);
  bool mend(Link& link, const BenchKey& key, std::chrono::milliseconds patience);
  bool match_until(Link& link, const BenchKey& key, Directory::Clock::time_point deadline);
  bool repeat(const BenchKey& key, Directory::Clock::time_point sent_before);
  bool is_broken(const BenchKey& key) const;
  bool is_overdue(const BenchKey& key, Directory::Clock::time_point now) const;
  void repair(const BenchKey& key);
  template <typename Message>
  bool write_patiently(wire::Publication<Message>& publication, const BenchKey& key,
                       const Message& message);

  std::mutex& send_mutex_of(std::uint32_t bench);
  Holding& holding(const BenchKey& key);
  bool is_answered(const SentFrames& sent) const;
  bool is_refused(const SentFrames& sent) const;
  void note_acquired(const Target& target, std::span<const std::uint16_t> axes,
                     const msg::Reply& reply);
  Outcome send(const Target& target, const FrameContent& content,
               std::vector<std::uint64_t>& sequences);
  msg::CommandFrame next_frame(Holding& held) const;
  std::uint64_t last_sequence(const BenchKey& key);
  Result<Observation> observe_published(const Target& target, std::span<const std::uint16_t> axes);
  Result<Observation> read_status(const Target& target, std::span<const std::uint16_t> axes);
  void subscribe_status();

  void keep_alive(const std::stop_token& stop);
  void start_keep_alive();
  bool send_keep_alive(const BenchKey& key);

  const SessionOptions options_;
  const std::uint64_t id_;

  std::mutex mutex_;  ///< guards what follows; taken after a send mutex
  /// By bench: orders its frames, and keeps them away from a change of the epoch. A bench that does
  /// not answer holds up no other's keep-alives.
  std::map<std::uint32_t, std::mutex> send_mutexes_;
  std::condition_variable changed_;
  Directory directory_;
  std::map<std::uint32_t, Holding> holdings_;
  std::map<BenchKey, Grant> grants_;  ///< of the clocks that this session has joined
  std::uint64_t last_request_ = 0;
  std::map<std::uint64_t, AwaitedRequest> requests_;
  std::map<PendingCommand, AwaitedCommand> commands_;
  std::map<BenchKey, Link> links_;  ///< stay where they are when others are added
  std::vector<std::weak_ptr<StatusFeed>> feeds_;
  bool interrupted_ = false;

  wire::Participant participant_;
  std::unique_ptr<wire::Publication<msg::Request>> request_publication_;  ///< none for a viewer
  std::unique_ptr<wire::Publication<msg::CommandFrame>> command_publication_;  ///< the same
  wire::Subscription<msg::Reply> reply_subscription_;
  wire::Subscription<msg::CommandReply> command_reply_subscription_;
  wire::Subscription<msg::BenchState> state_subscription_;
  wire::Subscription<msg::BenchDescription> description_subscription_;
  std::once_flag status_subscribed_;
  std::unique_ptr<wire::Subscription<msg::StatusFrame>> status_subscription_;
  std::once_flag keep_alive_started_;
  std::jthread keep_alive_thread_;
  std::jthread watch_thread_;
};

template <typename Condition>
Outcome SessionCore::wait(Lock& lock, const Target& target, Patience patience,
                          const Condition& condition) {
  constexpr std::chrono::milliseconds kLook{50};
  constexpr std::chrono::milliseconds kLookAtABrokenLink{5};
  const auto begin = Directory::Clock::now();
  while (!condition()) {
    const auto now = Directory::Clock::now();
    const bool is_broken = repair_if_needed(lock, target.key, now);
    if (condition()) break;
    if (auto end = end_of_wait(target, patience, begin, now)) return std::move(*end);
    changed_.wait_until(
        lock, std::min(begin + patience.timeout, now + (is_broken ? kLookAtABrokenLink : kLook)));
  }
  return {};
}

template <typename Condition>
bool SessionCore::wait_to_find(Lock& lock, const Condition& condition) {
  constexpr std::chrono::seconds kUnheard{1};
  const auto begin = Directory::Clock::now();
  const auto deadline = begin + options_.find_timeout;
  auto announce_at = begin + kUnheard;
  while (!condition()) {
    const auto now = Directory::Clock::now();
    if (interrupted_ || now >= deadline) return false;
    if (now >= announce_at) {
      announce_at = now + kUnheard;
      lock.unlock();
      participant_.announce_again();
      lock.lock();
      continue;
    }
    changed_.wait_until(lock, std::min(deadline, now + std::chrono::milliseconds(50)));
  }
  return true;
}

/// Why a whole request was refused.
/// @param what names the request
[[nodiscard]] Outcome refusal_of(const Target& target, const msg::Reply& reply,
                                 std::string_view what);

}  // namespace vdrive::client
