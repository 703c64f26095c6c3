// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "presence/directory.hpp"
#include "vdrive/wire/status_frame.hpp"
#include "vdrive_messages.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

namespace vdrive::client {

/// Messages that were sent and are kept, by number, until their sender takes the answer. Only the
/// sender of a message removes it. Thread-safe; its lock is never held while another one is taken.
template <typename Number, typename Message, typename Answer>
class Unanswered {
 public:
  using Clock = Directory::Clock;

  /// Keeps a message that is about to be sent. @return it; valid until it is taken.
  const Message& add(const Number& number, const BenchKey& key, Message message) {
    const std::scoped_lock lock(mutex_);
    const auto added = sent_.emplace(number, Sent{.key = key,
                                                  .message = std::move(message),
                                                  .time = Clock::now(),
                                                  .answer = std::nullopt});
    return added.first->second.message;
  }

  /// @return whether the answer is awaited. A repeated answer replaces the one before.
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

  /// @return whether there is an answer, of which `condition` holds.
  template <typename Condition>
  [[nodiscard]] bool is_answered(const Number& number, const Condition& condition) const {
    const std::scoped_lock lock(mutex_);
    const std::optional<Answer>& answer = sent_.at(number).answer;
    return answer && condition(*answer);
  }

  /// @return the message that has this number; valid until it is taken.
  [[nodiscard]] const Message& message(const Number& number) const {
    const std::scoped_lock lock(mutex_);
    return sent_.at(number).message;
  }

  /// Removes the message. @return its answer, if there is one.
  std::optional<Answer> take(const Number& number) {
    const std::scoped_lock lock(mutex_);
    const auto sent = sent_.find(number);
    std::optional<Answer> answer = std::move(sent->second.answer);
    sent_.erase(sent);
    return answer;
  }

  /// @return what was last sent to this run before `time` and has no answer, in order. It counts as
  ///         sent now.
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

  /// @return whether something was last sent to this run before `time` and has no answer.
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

  mutable std::mutex mutex_;  ///< guards what was sent, but for the messages: those do not change
  std::map<Number, Sent> sent_;
};

/// The answer to a request: the message, without statuses, and the axes that it shows.
struct RequestAnswer : msg::Reply {
  std::vector<wire::ReceivedStatus> axes;
};

/// By number of the request: another run of the service may answer that it is another one.
using UnansweredRequests = Unanswered<std::uint64_t, msg::Request, RequestAnswer>;

/// A sequence number counts for one run.
using FrameNumber = std::pair<BenchKey, std::uint64_t>;
using UnansweredFrames = Unanswered<FrameNumber, msg::CommandFrame, msg::CommandReply>;

}  // namespace vdrive::client
