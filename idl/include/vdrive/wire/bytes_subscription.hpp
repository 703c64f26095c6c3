// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/topics.hpp"

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <span>

namespace vdrive::wire {

class ReaderEnd;  ///< known inside the wire room only

/// Receives the samples of a topic as bytes: like `Subscription`, for a program that does not
/// decode messages. Nothing about the bytes is checked but their length, which is at most twice the
/// largest of the type.
class BytesSubscription {
 public:
  /// Both run in the DDS receive thread, one sample at a time: they must be short, must not wait
  /// and must not write a sample. `take` is given the sample with its encapsulation, valid during
  /// the call; `deliver` follows with who sent it.
  struct Handler {
    std::function<void(std::span<const std::byte> sample)> take;
    std::function<void(const Source& source)> deliver;
  };

  /// @throws NetworkError when DDS refuses topic, subscriber or reader.
  BytesSubscription(Participant& participant, TopicId topic, Handler handler);
  ~BytesSubscription();  ///< no handler runs after this returns
  BytesSubscription(const BytesSubscription&) = delete;
  BytesSubscription& operator=(const BytesSubscription&) = delete;

  /// @return how many publications match now.
  [[nodiscard]] std::size_t matched() const noexcept;

  /// Waits until a publication of the participant that sent from `source` matches.
  [[nodiscard]] bool wait_for_match(const Source& source, std::chrono::milliseconds timeout);

  /// @return samples that the library reported as lost or rejected.
  [[nodiscard]] std::size_t lost() const noexcept;

 private:
  std::unique_ptr<ReaderEnd> reader_;
};

}  // namespace vdrive::wire
