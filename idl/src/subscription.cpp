// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/subscription.hpp"

#include "backend.hpp"
#include "message_support.hpp"

#include <atomic>
#include <memory>
#include <utility>

namespace vdrive::wire {

struct AnySubscription::Entities {
  void deliver(const Source& source) {
    if (within_bounds(received.message.get())) {
      received.deliver(source);
      return;
    }
    ++malformed;
    if (received.deliver_malformed) received.deliver_malformed(source);
  }

  Received received;
  bool (*within_bounds)(const void* message) noexcept;
  std::atomic<std::size_t> malformed{0};
  std::unique_ptr<ReaderEnd> reader{};
};

AnySubscription::AnySubscription(Participant& participant, TopicId topic, Received received)
    : entities_(new Entities{.received = std::move(received),
                             .within_bounds = support_of(topic).within_bounds}) {
  entities_->reader = participant.backend().make_reader(
      topic, {.message = entities_->received.message.get(),
              .take = {},
              .deliver = [entities = entities_.get()](const Source& source) {
                entities->deliver(source);
              }});
}

AnySubscription::~AnySubscription() = default;

std::size_t AnySubscription::matched() const noexcept {
  return entities_->reader->matches().count();
}

bool AnySubscription::wait_for_matched(std::size_t count, std::chrono::milliseconds timeout) {
  return entities_->reader->matches().wait_for(count, timeout);
}

bool AnySubscription::wait_for_match(const Source& source, std::chrono::milliseconds timeout) {
  return entities_->reader->matches().wait_for(source, timeout);
}

std::size_t AnySubscription::malformed() const noexcept {
  return entities_->malformed;
}

std::size_t AnySubscription::lost() const noexcept {
  return entities_->reader->lost();
}

}  // namespace vdrive::wire
