// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/source.hpp"

#include <chrono>
#include <cstddef>
#include <memory>

namespace vdrive::wire {

/// Writes messages of one type on its topic (DESIGN: topics `vdrive/v1/...`), with the topic's QoS.
/// Instantiated for the message types of topics.hpp.
template <typename Message>
class Publication {
 public:
  /// @throws NotPermitted when the permissions of a closed participant do not name the topic;
  ///         NetworkError when DDS refuses topic, publisher or writer.
  explicit Publication(Participant& participant);
  ~Publication();
  Publication(const Publication&) = delete;
  Publication& operator=(const Publication&) = delete;

  /// Best-effort topics never block; reliable ones up to their max_blocking_time (100 ms).
  /// @return false when the message was not taken: history full, or too many instances.
  [[nodiscard]] bool write(const Message& message) noexcept;

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

 private:
  struct Entities;
  std::unique_ptr<Entities> entities_;
};

}  // namespace vdrive::wire
