// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/codec.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/sample_reader.hpp"
#include "vdrive/wire/source.hpp"
#include "vdrive/wire/topics.hpp"

#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <utility>

namespace vdrive::wire {

/// Receives messages of one type of topics.hpp from its topic.
template <typename Message>
class Subscription final {
 public:
  /// Runs in the DDS receive thread, or on a local bus in the writing thread: must be short, must
  /// not wait and must not write a message.
  /// The message is valid during the call. Its sequences are within the bounds of the IDL (other
  /// messages are dropped and counted as malformed); longer texts are truncated. No handler runs
  /// after the destructor has returned.
  using Handler = std::function<void(const Message& message, const Source& source)>;

  /// @param beyond_bounds called instead of `handler` for messages beyond the bounds of the IDL,
  ///        with the part of the message before the sequence that is too long
  /// @throws as Participant::make_reader
  explicit Subscription(Participant& participant, Handler handler, Handler beyond_bounds = {})
      : handler_(std::move(handler)),
        beyond_bounds_(std::move(beyond_bounds)),
        reader_(participant.make_reader(Topic<Message>::kId,
                                        {.take =
                                             [this](std::span<const std::byte> sample) {
                                               decoding_ = decode_checked(sample, message_);
                                             },
                                         .deliver =
                                             [this](const Source& source) {
                                               deliver(source);
                                             }})) {}

  Subscription(const Subscription&) = delete;
  Subscription& operator=(const Subscription&) = delete;
  ~Subscription() = default;

  /// @return how many publications match now.
  [[nodiscard]] std::size_t matched() const noexcept { return reader_->matches().count(); }

  /// Waits until at least `count` publications match. @return false on time-out.
  [[nodiscard]] bool wait_for_matched(std::size_t count, std::chrono::milliseconds timeout) {
    return reader_->matches().wait_for(count, timeout);
  }

  /// Waits until a publication of the participant that sent from `source` matches.
  [[nodiscard]] bool wait_for_match(const Source& source, std::chrono::milliseconds timeout) {
    return reader_->matches().wait_for(source, timeout);
  }

  /// @return messages dropped because a sequence was longer than the IDL allows.
  [[nodiscard]] std::size_t malformed() const noexcept { return malformed_; }

  /// Like SampleReader::lost.
  [[nodiscard]] std::size_t lost() const noexcept { return reader_->lost(); }

 private:
  void deliver(const Source& source) {
    if (decoding_ == Decoding::good) {
      handler_(message_, source);
    } else if (decoding_ == Decoding::beyond_bounds) {
      ++malformed_;
      if (beyond_bounds_) beyond_bounds_(message_, source);
    }
  }

  Handler handler_;
  Handler beyond_bounds_;
  Message message_{};  ///< keeps its capacity from sample to sample
  Decoding decoding_ = Decoding::malformed;
  std::atomic<std::size_t> malformed_{0};
  std::unique_ptr<SampleReader> reader_;  ///< last, so destroyed first: delivery stops
};

}  // namespace vdrive::wire
