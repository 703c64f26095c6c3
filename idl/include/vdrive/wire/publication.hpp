// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/codec.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/sample_writer.hpp"
#include "vdrive/wire/source.hpp"
#include "vdrive/wire/topics.hpp"

#include <chrono>
#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

namespace vdrive::wire {

/// Writes messages of one type of topics.hpp on its topic, with the topic's QoS.
template <typename Message>
class Publication final {
 public:
  /// @throws as Participant::make_writer
  explicit Publication(Participant& participant)
      : writer_(participant.make_writer(Topic<Message>::kId)) {}

  /// Like SampleWriter::write. Does not allocate once it has written a message of that size.
  [[nodiscard]] bool write(const Message& message) noexcept {
    try {
      const std::scoped_lock lock(encoding_);
      sample_.resize(encoded_size(message));
      encode(message, sample_);
      return writer_->write(sample_);
    } catch (...) {  // out of memory
      return false;
    }
  }

  /// @return how many subscriptions match now.
  [[nodiscard]] std::size_t matched() const noexcept { return writer_->matches().count(); }

  /// Waits until at least `count` subscriptions match. @return false on time-out.
  [[nodiscard]] bool wait_for_matched(std::size_t count, std::chrono::milliseconds timeout) {
    return writer_->matches().wait_for(count, timeout);
  }

  /// Waits until a subscription of the participant that sent from `source` matches.
  /// @return false on time-out.
  [[nodiscard]] bool wait_for_match(const Source& source, std::chrono::milliseconds timeout) {
    return writer_->matches().wait_for(source, timeout);
  }

  /// Like SampleWriter::wait_for_acknowledged.
  [[nodiscard]] bool wait_for_acknowledged(std::chrono::milliseconds timeout) {
    return writer_->wait_for_acknowledged(timeout);
  }

 private:
  std::mutex encoding_;
  /// Bytes of the last message. Not thread_local: the thread-local objects of a thread may be
  /// destroyed before a session that the thread created and that must still release its axes.
  std::vector<std::byte> sample_;
  std::unique_ptr<SampleWriter> writer_;
};

}  // namespace vdrive::wire
