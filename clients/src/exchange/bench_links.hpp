// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/observer_failure.hpp"
#include "base/wakeup.hpp"
#include "exchange/command_history.hpp"
#include "exchange/held_axes.hpp"
#include "presence/discovery.hpp"
#include "presence/target.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/publication.hpp"
#include "vdrive/wire/sample_reader.hpp"
#include "vdrive/wire/status_frame.hpp"
#include "vdrive/wire/subscription.hpp"
#include "vdrive_messages.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

namespace vdrive::client {

/// Time allowed for a bench and this session to match each other's readers and writers: matching
/// takes milliseconds, or seconds on a machine without a free processor.
inline constexpr std::chrono::milliseconds kMatch{10'000};

/// Sent messages, by number, kept until their sender takes the answer. Only the sender of a message
/// removes it. Thread-safe; no other lock is taken under its own.
template <typename Number, typename Message, typename Answer>
class Unanswered {
 public:
  using Clock = Directory::Clock;

  /// Keeps a message that is about to be sent.
  /// @return the kept message; valid until take().
  const Message& add(const Number& number, const BenchKey& key, Message message) {
    const std::scoped_lock lock(mutex_);
    const auto added = sent_.emplace(number, Sent{.key = key,
                                                  .message = std::move(message),
                                                  .time = Clock::now(),
                                                  .answer = std::nullopt});
    return added.first->second.message;
  }

  /// Keeps the answer to a message; a repeated answer replaces the previous one.
  /// @return whether the message is still kept.
  bool answer(const Number& number, Answer answer) {
    const std::scoped_lock lock(mutex_);
    const auto sent = sent_.find(number);
    if (sent == sent_.end()) return false;
    sent->second.answer = std::move(answer);
    return true;
  }

  [[nodiscard]] bool is_answered(const Number& number) const {
    return is_answered(number, [](const Answer& /*answer*/) {
      return true;
    });
  }

  /// @return whether there is an answer for which `condition` holds.
  template <typename Condition>
  [[nodiscard]] bool is_answered(const Number& number, const Condition& condition) const {
    const std::scoped_lock lock(mutex_);
    const std::optional<Answer>& answer = sent_.at(number).answer;
    return answer && condition(*answer);
  }

  /// @return the message with this number; valid until take().
  [[nodiscard]] const Message& message(const Number& number) const {
    const std::scoped_lock lock(mutex_);
    return sent_.at(number).message;
  }

  /// Removes the message.
  /// @return its answer, if there is one.
  std::optional<Answer> take(const Number& number) {
    const std::scoped_lock lock(mutex_);
    const auto sent = sent_.find(number);
    std::optional<Answer> answer = std::move(sent->second.answer);
    sent_.erase(sent);
    return answer;
  }

  /// @return the unanswered messages that were last sent to this run before `time`, in order. They
  ///         count as sent now.
  std::vector<Message> to_repeat(const BenchKey& key, Clock::time_point time) {
    const std::scoped_lock lock(mutex_);
    std::vector<Message> messages;
    for (auto& [number, sent] : sent_) {
      if (!is_due(sent, key, time)) continue;
      messages.push_back(sent.message);
      sent.time = Clock::now();
    }
    return messages;
  }

  /// @return whether a message last sent to this run before `time` is unanswered.
  [[nodiscard]] bool has_due(const BenchKey& key, Clock::time_point time) const {
    const std::scoped_lock lock(mutex_);
    return std::ranges::any_of(sent_, [&](const auto& item) {
      return is_due(item.second, key, time);
    });
  }

 private:
  struct Sent {
    BenchKey key;
    Message message;
    Clock::time_point time;
    std::optional<Answer> answer;
  };

  static bool is_due(const Sent& sent, const BenchKey& key, Clock::time_point time) {
    return sent.key == key && !sent.answer && sent.time < time;
  }

  mutable std::mutex mutex_;  ///< guards the map; the messages in it do not change
  std::map<Number, Sent> sent_;
};

/// The answer to a request: the reply without its statuses, and the decoded statuses of its axes.
struct RequestAnswer : msg::Reply {
  std::vector<wire::ReceivedStatus> axes;
};

/// Keyed by the number of the request alone: another run of the service may answer too, to report
/// that it is not the run that was asked.
using UnansweredRequests = Unanswered<std::uint64_t, msg::Request, RequestAnswer>;

/// A frame needs its run as well, because sequence numbers are counted per run.
using FrameNumber = std::pair<BenchKey, std::uint64_t>;
using UnansweredFrames = Unanswered<FrameNumber, msg::CommandFrame, msg::CommandReply>;

/// The requests and command frames that were sent and not answered.
struct UnansweredMessages {
  UnansweredRequests requests;
  UnansweredFrames frames;
};

/// How long a wait may take, not counting times in which this program does not run. An interrupt
/// does not end the wait for the answer to a request, because the interrupted call must still clean
/// up.
struct Patience {
  std::chrono::milliseconds timeout;
  bool may_interrupt;
  bool needs_drive_time = false;  ///< the awaited event never occurs while the bench is paused
  Silence silence = Silence::ends_call;
};

/// A service whose samples arrive answers within this time or not at all.
inline constexpr Patience kAnswer{std::chrono::milliseconds(10'000), false};

/// The right to send to one run of a service: no other thread sends to it while this object lives.
struct OpenLink {
  BenchKey key;
  std::unique_lock<std::mutex> sending;  ///< no lock: another thread is sending
  bool is_matched = false;               ///< false: the bench cannot be reached yet

  explicit operator bool() const noexcept { return sending.owns_lock() && is_matched; }
};

/// The links to benches. The wire process of a service may restart: then a new participant sends
/// for the same run, and messages in transit are lost. A service carries out each message once,
/// however often it arrives, so after a reconnection every unanswered message is sent again.
/// Thread-safe.
class BenchLinks {
 public:
  BenchLinks(wire::Participant& participant, std::uint64_t session, Discovery& discovery,
             HeldAxes& held_axes, CommandHistory& history, Wakeup& wakeup,
             ObserverFailure& failure);

  /// Whether the permissions of this session allow requests and commands to benches.
  [[nodiscard]] bool may_command() const noexcept {
    return request_publication_ != nullptr && command_publication_ != nullptr;
  }

  /// Finds the bench and waits until it can receive our requests (if we may send any) and we can
  /// receive its answers.
  Result<Target> connect(std::uint32_t number);

  /// Waits until no other thread sends to this run, then until its link is connected.
  /// @param what will be sent, for messages: "requests" or "commands"
  /// @param patience wall time to wait for the match with a bench that has reconnected
  Result<OpenLink> open(const Target& target, std::string_view what,
                        std::chrono::milliseconds patience = kMatch);

  /// Closes the links when the session ends: connect() and open() fail from now on.
  void close() noexcept { is_closed_ = true; }

  /// Sends through an open link.
  /// @return false if the queue stays full, or no sample of the bench arrives while waiting for
  ///         room.
  bool send(const OpenLink& link, const msg::Request& request);
  bool send(const OpenLink& link, const msg::CommandFrame& frame);

  /// Sends a frame that needs no answer, without waiting for anything.
  /// @return false if the bench has reconnected and cannot be reached yet.
  bool send_keep_alive(const BenchKey& key);

  /// Waits until `condition` holds. The condition must depend on messages from the bench; it is
  /// evaluated after each change, without a lock. While waiting, repairs the link to the bench, and
  /// gives up if the bench is lost. The caller must not hold the lock of a state.
  template <typename Condition>
  Outcome wait(const Target& target, const Patience& patience, const Condition& condition) {
    const auto begin = discovery_.running_time();
    while (true) {
      // Read before the condition is checked, so that a later change ends the wait immediately.
      const std::uint64_t changes = wakeup_.changes();
      if (condition()) return {};
      // On the local bus this is enough for most waits: the work produces the answer.
      if (wakeup_.work(changes, target.key.number) && condition()) return {};
      const auto now = Wakeup::Clock::now();
      const bool is_broken = repair(target.key);
      // Once more, before any reason to give up: the answer may have arrived during the repair.
      if (condition()) return {};
      if (auto end = end_of_wait(target, patience, begin)) return std::move(*end);
      // Computed each time, because a pause of this program moves the deadline.
      const auto deadline = begin + patience.timeout + discovery_.own_pauses();
      if (Wakeup::Clock::now() >= deadline) {
        return Outcome::timed_out(name_of(target) + " did not answer");
      }
      wakeup_.work_until(changes, target.key.number,
                         std::min(deadline, now + (is_broken ? kReconnectPeriod : kPeriod)));
    }
  }

  /// Messages sent to benches and not answered; they are repeated when necessary.
  [[nodiscard]] UnansweredMessages& unanswered() noexcept { return unanswered_; }

  /// Calls `observer`, on the thread that delivers the answer of a bench, for each refused value of
  /// a frame that no call waits for. It must only store the refusal, see RefusalWatcher.
  /// @param observer an empty one ends the reports; it replaces the previous one
  void watch_refusals(std::function<void(const SetPointRefusal&)> observer);

  /// Takes back the axes of an answer that has been read: a later answer reuses their memory,
  /// without allocating or clearing it.
  void reuse(std::vector<wire::ReceivedStatus> axes);

 private:
  /// The link to one run of a service.
  struct Link {
    std::mutex mutex;     ///< puts messages in order; taken after HeldAxes::lock_sending
    wire::Source source;  ///< participant that has our messages; guarded by the mutex of the links
  };

  // Longest time between two checks of a wait; shorter while the link is broken.
  static constexpr std::chrono::milliseconds kPeriod{50};
  static constexpr std::chrono::milliseconds kReconnectPeriod{5};

  /// @return why a wait that began at the running time `begin` must end without success; nothing if
  ///         it continues.
  [[nodiscard]] std::optional<Outcome> end_of_wait(const Target& target, const Patience& patience,
                                                   Wakeup::Clock::time_point begin) const {
    if (patience.may_interrupt && wakeup_.is_interrupted()) return Outcome::failed("interrupted");
    if (Outcome present = discovery_.check_samples(target, patience.silence); !present) {
      return present;
    }
    if (patience.needs_drive_time && discovery_.is_paused(target.key, begin)) {
      return Outcome::failed(paused_text(target));
    }
    return std::nullopt;
  }

  /// For a call that waits for an answer: reconnects a broken link, and repeats overdue messages.
  /// Does not wait: if another thread is sending now, that thread reconnects.
  /// @return whether the link was broken.
  bool repair(const BenchKey& key);

  void take_reply(std::span<const std::byte> sample);
  void on_reply(const wire::Source& source);
  void on_command_reply(const msg::CommandReply& message, const wire::Source& source);
  void report_refusals(const msg::CommandReply& message);

  Link& link_of(const BenchKey& key);
  [[nodiscard]] wire::Source reached_source_of(const BenchKey& key) const;
  bool is_matched(const wire::Source& source, std::chrono::milliseconds patience);
  OpenLink try_open(const BenchKey& key);
  bool reconnect(const BenchKey& key, std::chrono::milliseconds patience);
  bool repeat(const BenchKey& key, Discovery::Clock::time_point sent_before);
  [[nodiscard]] bool is_broken(const BenchKey& key) const;
  template <typename Message>
  bool send_patiently(wire::Publication<Message>& publication, const OpenLink& link,
                      const Message& message);

  const std::uint64_t session_;
  std::atomic<bool> is_closed_ = false;
  wire::Participant& participant_;
  Discovery& discovery_;
  HeldAxes& held_axes_;
  CommandHistory& history_;
  UnansweredMessages unanswered_;
  Wakeup& wakeup_;
  ObserverFailure& failure_;
  mutable std::mutex mutex_;        ///< guards the map of links, their sources and `spare_`
  std::map<BenchKey, Link> links_;  ///< a map: elements must not move on insertion
  std::vector<wire::ReceivedStatus> spare_;
  std::unique_ptr<wire::Publication<msg::Request>> request_publication_;  ///< none for a viewer
  std::unique_ptr<wire::Publication<msg::CommandFrame>> command_publication_;  ///< as above
  RequestAnswer received_;    ///< the newest reply; used by the receiving thread only
  bool is_received_ = false;  ///< it could be decoded
  std::mutex refusal_mutex_;  ///< guards the observer, also while it is being called
  std::function<void(const SetPointRefusal&)> refusal_observer_;
  std::unique_ptr<wire::SampleReader> reply_reader_;
  wire::Subscription<msg::CommandReply> command_reply_subscription_;
};

}  // namespace vdrive::client
