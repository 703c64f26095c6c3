// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/matches.hpp"
#include "vdrive/wire/source.hpp"

#include <cstddef>
#include <functional>
#include <span>

namespace vdrive::wire {

/// Handlers for the samples of a reader. Both run in the DDS receive thread, or on a local bus in
/// the writing thread, one sample at a time. They must be short, must not wait and must not write a
/// sample.
struct SampleHandler {
  /// Receives the sample with its encapsulation, valid during the call. The bytes are unchecked
  /// except for their length, which is at most twice that of the largest sample of the topic.
  std::function<void(std::span<const std::byte> sample)> take;
  /// Runs after `take` with the sender; over DDS, not for a sample without an encapsulation.
  std::function<void(const Source& source)> deliver;
};

/// Receives the samples of a topic as bytes. Created by a participant, which outlives it;
/// `Subscription` wraps it for messages. No handler runs after its destructor has returned.
class SampleReader {
 public:
  SampleReader() = default;
  virtual ~SampleReader() = default;
  SampleReader(const SampleReader&) = delete;
  SampleReader& operator=(const SampleReader&) = delete;

  /// @return number of samples that the library reported as lost or rejected.
  [[nodiscard]] virtual std::size_t lost() const noexcept = 0;

  /// @return the writers that match.
  [[nodiscard]] Matches& matches() noexcept { return matches_; }

 protected:
  Matches matches_;
};

}  // namespace vdrive::wire
