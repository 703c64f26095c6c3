// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/source.hpp"
#include "vdrive/wire/topics.hpp"

#include <chrono>
#include <cstddef>
#include <memory>

namespace vdrive::wire {

class WriterEnd;  ///< known inside the wire room only

/// What publications of all message types have in common.
class AnyPublication {
 public:
  AnyPublication(const AnyPublication&) = delete;
  AnyPublication& operator=(const AnyPublication&) = delete;

  /// @return how many subscriptions match now.
  [[nodiscard]] std::size_t matched() const noexcept;

  /// Waits until at least `count` subscriptions match. @return false on time-out.
  [[nodiscard]] bool wait_for_matched(std::size_t count, std::chrono::milliseconds timeout);

  /// Waits until a subscription of the participant that sent from `source` matches.
  /// @return false on time-out.
  [[nodiscard]] bool wait_for_match(const Source& source, std::chrono::milliseconds timeout);

  /// Waits until every matched reliable subscription has what was written. @return false on
  /// time-out.
  [[nodiscard]] bool wait_for_acknowledged(std::chrono::milliseconds timeout);

 protected:
  AnyPublication(Participant& participant, TopicId topic);
  ~AnyPublication();

  /// @param message of the topic's type
  [[nodiscard]] bool write_message(const void* message) noexcept;

 private:
  std::unique_ptr<WriterEnd> writer_;
};

/// Writes messages of one type of topics.hpp on its topic, with the topic's QoS.
template <typename Message>
class Publication final : public AnyPublication {
 public:
  /// @throws NotPermitted when the permissions of a closed participant do not name the topic;
  ///         NetworkError when DDS refuses topic, publisher or writer.
  explicit Publication(Participant& participant)
      : AnyPublication(participant, Topic<Message>::kId) {}

  /// Best-effort topics never block; reliable ones up to their max_blocking_time (100 ms).
  /// @return false when the message was not taken: history full, or too many instances.
  [[nodiscard]] bool write(const Message& message) noexcept { return write_message(&message); }
};

}  // namespace vdrive::wire
