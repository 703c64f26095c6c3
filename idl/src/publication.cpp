// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/publication.hpp"

#include "message_types.hpp"
#include "writer.hpp"

namespace vdrive::wire {

struct AnyPublication::Entities {
  Writer writer;
};

AnyPublication::AnyPublication(Participant& participant, TopicId topic)
    : entities_(
          new Entities{.writer = {participant.entities(), topic, support_of(topic).make_type()}}) {}

AnyPublication::~AnyPublication() = default;

bool AnyPublication::write_message(const void* message) noexcept {
  return entities_->writer.write(message);
}

std::size_t AnyPublication::matched() const noexcept {
  return entities_->writer.matches().count();
}

bool AnyPublication::wait_for_matched(std::size_t count, std::chrono::milliseconds timeout) {
  return entities_->writer.matches().wait_for(count, timeout);
}

bool AnyPublication::wait_for_match(const Source& source, std::chrono::milliseconds timeout) {
  return entities_->writer.matches().wait_for(source, timeout);
}

bool AnyPublication::wait_for_acknowledged(std::chrono::milliseconds timeout) {
  return entities_->writer.wait_for_acknowledged(timeout);
}

}  // namespace vdrive::wire
