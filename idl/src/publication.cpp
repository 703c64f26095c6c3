// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/publication.hpp"

#include "backend.hpp"

namespace vdrive::wire {

AnyPublication::AnyPublication(Participant& participant, TopicId topic)
    : writer_(participant.backend().make_writer(topic, Backend::Form::messages, nullptr)) {}

AnyPublication::~AnyPublication() = default;

bool AnyPublication::write_message(const void* message) noexcept {
  return writer_->write(message);
}

std::size_t AnyPublication::matched() const noexcept {
  return writer_->matches().count();
}

bool AnyPublication::wait_for_matched(std::size_t count, std::chrono::milliseconds timeout) {
  return writer_->matches().wait_for(count, timeout);
}

bool AnyPublication::wait_for_match(const Source& source, std::chrono::milliseconds timeout) {
  return writer_->matches().wait_for(source, timeout);
}

bool AnyPublication::wait_for_acknowledged(std::chrono::milliseconds timeout) {
  return writer_->wait_for_acknowledged(timeout);
}

}  // namespace vdrive::wire
