// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/topics.hpp"

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace vdrive::wire {

class WriterEnd;  ///< known inside the wire room only

/// Writes samples that were encoded elsewhere (vdrive/wire/codec.hpp) on a topic, with the topic's
/// QoS: like `Publication`, for a program that does not decode messages.
class BytesPublication {
 public:
  /// Runs with the participants of the subscriptions that match now, in a DDS thread, on a local
  /// bus in the thread of what comes or goes; must not wait.
  using Observer = std::function<void(const std::vector<Source>& matched)>;

  /// @throws NotPermitted when the permissions of a closed participant do not name the topic;
  ///         NetworkError when DDS refuses topic, publisher or writer.
  BytesPublication(Participant& participant, TopicId topic, Observer observer = nullptr);
  ~BytesPublication();
  BytesPublication(const BytesPublication&) = delete;
  BytesPublication& operator=(const BytesPublication&) = delete;

  /// Best-effort topics and those whose writer keeps the newest never block; others up to their
  /// max_blocking_time (100 ms).
  /// @return false when the sample was not taken: history full, or too many instances.
  [[nodiscard]] bool write(std::span<const std::byte> sample) noexcept;

  /// @return how many subscriptions match now.
  [[nodiscard]] std::size_t matched() const noexcept;

  /// @return whether a subscription of the participant that sends from `source` matches now.
  [[nodiscard]] bool is_matched(const Source& source) const;

  /// Waits until every matched reliable subscription has what was written. @return false on
  /// time-out.
  [[nodiscard]] bool wait_for_acknowledged(std::chrono::milliseconds timeout);

 private:
  std::unique_ptr<WriterEnd> writer_;
};

}  // namespace vdrive::wire
