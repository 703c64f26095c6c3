// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/bytes_subscription.hpp"

#include "bytes_type.hpp"
#include "reader.hpp"

#include <optional>
#include <utility>

namespace vdrive::wire {

struct BytesSubscription::Entities {
  std::function<void(std::span<const std::byte>)> take;
  BytesSample sample{};
  std::optional<Reader> reader{};
};

BytesSubscription::BytesSubscription(Participant& participant, TopicId topic, Handler handler)
    : entities_(std::make_unique<Entities>()) {
  entities_->take = std::move(handler.take);
  entities_->sample.take = &entities_->take;
  entities_->reader.emplace(
      participant.entities(), topic, eprosima::fastdds::dds::TypeSupport(new BytesType(topic)),
      &entities_->sample, [deliver = std::move(handler.deliver)](const WriterId& writer) {
        deliver(writer.source);
      });
}

BytesSubscription::~BytesSubscription() = default;

std::size_t BytesSubscription::matched() const noexcept {
  return entities_->reader->matches().count();
}

std::size_t BytesSubscription::lost() const noexcept {
  return entities_->reader->lost();
}

}  // namespace vdrive::wire
