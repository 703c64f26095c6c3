// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/bytes_subscription.hpp"

#include "backend.hpp"

#include <utility>

namespace vdrive::wire {

BytesSubscription::BytesSubscription(Participant& participant, TopicId topic, Handler handler)
    : reader_(participant.backend().make_reader(
          topic, {.take = std::move(handler.take), .deliver = std::move(handler.deliver)})) {}

BytesSubscription::~BytesSubscription() = default;

std::size_t BytesSubscription::matched() const noexcept {
  return reader_->matches().count();
}

bool BytesSubscription::wait_for_match(const Source& source, std::chrono::milliseconds timeout) {
  return reader_->matches().wait_for(source, timeout);
}

std::size_t BytesSubscription::lost() const noexcept {
  return reader_->lost();
}

}  // namespace vdrive::wire
