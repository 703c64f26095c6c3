// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/observer_failure.hpp"
#include "base/wakeup.hpp"
#include "exchange/command_history.hpp"
#include "exchange/holdings.hpp"
#include "exchange/unanswered.hpp"
#include "presence/discovery.hpp"
#include "presence/target.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/publication.hpp"
#include "vdrive/wire/sample_reader.hpp"
#include "vdrive/wire/status_frame.hpp"
#include "vdrive/wire/subscription.hpp"
#include "vdrive_messages.hpp"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string_view>
#include <vector>

namespace vdrive::client {

/// How long a bench that sends and this session may take to match each other's readers and writers:
/// milliseconds, and on a machine without a free processor seconds.
inline constexpr std::chrono::milliseconds kMatch{10'000};

/// What was sent and not answered: requests and command frames.
struct UnansweredMessages {
  UnansweredRequests requests;
  UnansweredFrames frames;
};

/// What answers of benches are noted in.
struct AnsweredParts {
  Holdings& holdings;
  CommandHistory& history;
  UnansweredMessages& unanswered;
};

/// The right to send to one run of a service: no other thread sends to it while this object lives.
struct OpenLink {
  BenchKey key;
  std::unique_lock<std::mutex> sending;  ///< no lock: another thread sends
  bool is_matched = false;               ///< false: the bench is not reached yet

  explicit operator bool() const noexcept { return sending.owns_lock() && is_matched; }
};

/// The links to benches. The network process of a service may restart: then a new participant sends
/// for the same run, and messages in transit are lost. A service carries out each message once,
/// however often it arrives, so after a reconnection every unanswered message is sent again.
/// Thread-safe.
class BenchLinks {
 public:
  BenchLinks(wire::Participant& participant, std::uint64_t session, Discovery& discovery,
             AnsweredParts answered, Wakeup& wakeup, ObserverFailure& failure);

  /// Whether this session's permissions let it send requests and commands to benches.
  [[nodiscard]] bool may_command() const noexcept {
    return request_publication_ != nullptr && command_publication_ != nullptr;
  }

  /// Finds the bench and waits until it receives requests, if we may send any, and we its answers.
  Result<Target> connect(std::uint32_t number);

  /// Waits until no other thread sends to this run, then until its link is connected.
  /// @param what is to be sent, for the message: "requests" or "commands"
  /// @param patience wall time to wait for the match of a bench that is connected anew
  Result<OpenLink> open(const Target& target, std::string_view what,
                        std::chrono::milliseconds patience = kMatch);

  /// The session has ended: connect() and open() fail from now on.
  void close() noexcept { is_closed_ = true; }

  /// Sends through an open link. @return false when the queue stays full, or no sample of the bench
  /// arrives meanwhile.
  bool send(const OpenLink& link, const msg::Request& request);
  bool send(const OpenLink& link, const msg::CommandFrame& frame);

  /// Sends a frame that needs no answer, without waiting for anything.
  /// @return false when the bench is connected anew and not reached yet.
  bool send_keep_alive(const BenchKey& key);

  /// For a call that waits for an answer: reconnects a broken link, and sends again what is
  /// overdue. Does not wait: when another thread sends at this moment, that thread reconnects.
  /// @return whether it was broken.
  bool repair(const BenchKey& key);

  /// Calls `observer`, in the thread that delivers the answer of a bench, for each value of a frame
  /// that no call waits for and that is refused. It only keeps what it gets, see RefusalWatcher.
  /// @param observer an empty one ends the reports; it replaces the last
  void watch_refusals(std::function<void(const SetPointRefusal&)> observer);

  /// Gives the axes of an answer back that was read: a next one takes their memory, which is
  /// neither allocated nor cleared again.
  void reuse(std::vector<wire::ReceivedStatus> axes);

 private:
  /// The link to one run of a service.
  struct Link {
    std::mutex mutex;     ///< orders what is sent; taken after Holdings::lock_sending
    wire::Source source;  ///< participant that has what was sent; guarded by the mutex of the links
  };

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
  Holdings& holdings_;
  CommandHistory& history_;
  UnansweredMessages& unanswered_;
  Wakeup& wakeup_;
  ObserverFailure& failure_;
  mutable std::mutex mutex_;        ///< guards the map of links, their sources and `spare_`
  std::map<BenchKey, Link> links_;  ///< stay where they are when one is added
  std::vector<wire::ReceivedStatus> spare_;
  std::unique_ptr<wire::Publication<msg::Request>> request_publication_;  ///< none for a viewer
  std::unique_ptr<wire::Publication<msg::CommandFrame>> command_publication_;  ///< the same
  RequestAnswer received_;    ///< the newest reply, of the thread that receives
  bool is_received_ = false;  ///< it can be read
  std::mutex refusal_mutex_;  ///< guards the observer, also while it is called
  std::function<void(const SetPointRefusal&)> refusal_observer_;
  std::unique_ptr<wire::SampleReader> reply_reader_;
  wire::Subscription<msg::CommandReply> command_reply_subscription_;
};

}  // namespace vdrive::client
