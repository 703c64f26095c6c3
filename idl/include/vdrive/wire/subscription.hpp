// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/source.hpp"

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>

namespace vdrive::wire {

/// Receives messages of one type from its topic. Instantiated for the message types of topics.hpp.
template <typename Message>
class Subscription {
 public:
  /// Runs in the DDS receive thread: must be short, must not wait and must not write a message.
  /// The message is valid during the call; its sequences and strings are within the bounds of the
  /// IDL (others are dropped and counted as malformed).
  using Handler = std::function<void(const Message& message, const Source& source)>;

  /// @param malformed_handler runs for messages beyond the bounds of the IDL, in place of `handler`
  /// @throws NetworkError when DDS refuses topic, subscriber or reader.
  Subscription(Participant& participant, Handler handler, Handler malformed_handler = {});
  ~Subscription();  ///< no handler runs after this returns
  Subscription(const Subscription&) = delete;
  Subscription& operator=(const Subscription&) = delete;

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

 private:
  struct Entities;
  std::unique_ptr<Entities> entities_;
};

}  // namespace vdrive::wire
