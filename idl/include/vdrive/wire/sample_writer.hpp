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

/// Writes samples that are already encoded (vdrive/wire/codec.hpp) to a topic, with the QoS of the
/// topic. Created by a participant, which outlives it; `Publication` wraps it for messages.
class SampleWriter {
 public:
  /// Called with the participants of the readers that match now, whenever they change: in a DDS
  /// thread, or on a local bus in the thread of the reader that joins or leaves. Must not wait.
  using Observer = std::function<void(const std::vector<Source>& matched)>;

  SampleWriter() = default;
  virtual ~SampleWriter() = default;
  SampleWriter(const SampleWriter&) = delete;
  SampleWriter& operator=(const SampleWriter&) = delete;

  /// Best-effort topics and those whose writer keeps the newest samples never block; others block
  /// for up to their max_blocking_time (100 ms).
  /// @return false when the sample was not accepted: history full, or too many instances.
  [[nodiscard]] virtual bool write(std::span<const std::byte> sample) noexcept = 0;

  /// Waits until every matched reliable reader has received everything. @return false on time-out.
  [[nodiscard]] virtual bool wait_for_acknowledged(std::chrono::milliseconds timeout) = 0;

  /// @return the readers that match.
  [[nodiscard]] Matches& matches() noexcept { return matches_; }

 protected:
  Matches matches_;
};

}  // namespace vdrive::wire
