// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/matches.hpp"
#include "vdrive/wire/source.hpp"

#include <chrono>
#include <cstddef>
#include <functional>
#include <span>
#include <vector>

namespace vdrive::wire {

/// Writes samples that were encoded elsewhere (vdrive/wire/codec.hpp) on a topic, with the topic's
/// QoS. Made by a participant, which outlives it; `Publication` is one for messages.
class SampleWriter {
 public:
  /// Runs with the participants of the readers that match now, whenever they have changed: in a DDS
  /// thread, on a local bus in the thread of what comes or goes; must not wait.
  using Observer = std::function<void(const std::vector<Source>& matched)>;

  SampleWriter() = default;
  virtual ~SampleWriter() = default;
  SampleWriter(const SampleWriter&) = delete;
  SampleWriter& operator=(const SampleWriter&) = delete;

  /// Best-effort topics and those whose writer keeps the newest never block; others up to their
  /// max_blocking_time (100 ms).
  /// @return false when the sample was not taken: history full, or too many instances.
  [[nodiscard]] virtual bool write(std::span<const std::byte> sample) noexcept = 0;

  /// Waits until every matched reliable reader has what was written. @return false on time-out.
  [[nodiscard]] virtual bool wait_for_acknowledged(std::chrono::milliseconds timeout) = 0;

  /// @return the readers that match.
  [[nodiscard]] Matches& matches() noexcept { return matches_; }

 protected:
  Matches matches_;
};

}  // namespace vdrive::wire
