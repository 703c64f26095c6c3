// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/bytes_publication.hpp"

#include "bytes_type.hpp"
#include "writer.hpp"

#include <utility>

namespace vdrive::wire {

struct BytesPublication::Entities {
  Writer writer;
};

BytesPublication::BytesPublication(Participant& participant, TopicId topic, Observer observer)
    : entities_(new Entities{.writer = {participant.entities(), topic,
                                        eprosima::fastdds::dds::TypeSupport(new BytesType(topic)),
                                        std::move(observer)}}) {}

BytesPublication::~BytesPublication() = default;

bool BytesPublication::write(std::span<const std::byte> sample) noexcept {
  const BytesSample data{.bytes = sample};
  return entities_->writer.write(&data);
}

std::size_t BytesPublication::matched() const noexcept {
  return entities_->writer.matches().count();
}

bool BytesPublication::is_matched(const Source& source) const {
  return entities_->writer.matches().wait_for(source, std::chrono::milliseconds::zero());
}

bool BytesPublication::wait_for_acknowledged(std::chrono::milliseconds timeout) {
  return entities_->writer.wait_for_acknowledged(timeout);
}

}  // namespace vdrive::wire
