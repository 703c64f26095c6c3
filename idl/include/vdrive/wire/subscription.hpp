// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/source.hpp"
#include "vdrive/wire/topics.hpp"

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <utility>

namespace vdrive::wire {

/// What subscriptions of all message types have in common.
class AnySubscription {
 public:
  AnySubscription(const AnySubscription&) = delete;
  AnySubscription& operator=(const AnySubscription&) = delete;

  /// @return how many publications match now.
  [[nodiscard]] std::size_t matched() const noexcept;

  /// Waits until at least `count` publications match. @return false on time-out.
  [[nodiscard]] bool wait_for_matched(std::size_t count, std::chrono::milliseconds timeout);

  /// Waits until a publication of the participant that sent from `source` matches.
  [[nodiscard]] bool wait_for_match(const Source& source, std::chrono::milliseconds timeout);

  /// @return messages dropped because a sequence or string was longer than the IDL allows.
  [[nodiscard]] std::size_t malformed() const noexcept;

  /// @return samples that the library reported as lost or rejected.
  [[nodiscard]] std::size_t lost() const noexcept;

 protected:
  /// Runs for a message that was read into the memory of `Received`.
  using Deliver = std::function<void(const Source& source)>;

  struct Received {
    std::shared_ptr<void> message;  ///< of the topic's type; keeps its capacity between samples
    Deliver deliver;
    Deliver deliver_malformed;  ///< or nothing
  };

  AnySubscription(Participant& participant, TopicId topic, Received received);
  ~AnySubscription();  ///< nothing is delivered after this returns

 private:
  struct Entities;
  std::unique_ptr<Entities> entities_;
};

/// Receives messages of one type of topics.hpp from its topic.
template <typename Message>
class Subscription final : public AnySubscription {
 public:
  /// Runs in the DDS receive thread, on a local bus in the thread that writes: must be short, must
  /// not wait and must not write a message.
  /// The message is valid during the call; its sequences and strings are within the bounds of the
  /// IDL (others are dropped and counted as malformed). No handler runs after the destructor
  /// returned.
  using Handler = std::function<void(const Message& message, const Source& source)>;

  /// @param malformed_handler runs for messages beyond the bounds of the IDL, in place of `handler`
  /// @throws NetworkError when DDS refuses topic, subscriber or reader.
  Subscription(Participant& participant, Handler handler, Handler malformed_handler = {})
      : AnySubscription(participant, Topic<Message>::kId,
                        receive(std::move(handler), std::move(malformed_handler))) {}

 private:
  static Received receive(Handler handler, Handler malformed_handler) {
    const auto message = std::make_shared<Message>();
    return {.message = message,
            .deliver = deliver_to(std::move(handler), *message),
            .deliver_malformed =
                malformed_handler ? deliver_to(std::move(malformed_handler), *message) : Deliver{}};
  }

  static Deliver deliver_to(Handler handler, const Message& message) {
    return [handler = std::move(handler), &message](const Source& source) {
      handler(message, source);
    };
  }
};

}  // namespace vdrive::wire
