// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/bytes_publication.hpp"

#include "backend.hpp"

#include <utility>

namespace vdrive::wire {

BytesPublication::BytesPublication(Participant& participant, TopicId topic, Observer observer)
    : writer_(participant.backend().make_writer(topic, Backend::Form::bytes, std::move(observer))) {
}

BytesPublication::~BytesPublication() = default;

bool BytesPublication::write(std::span<const std::byte> sample) noexcept {
  return writer_->write(&sample);
}

std::size_t BytesPublication::matched() const noexcept {
  return writer_->matches().count();
}

bool BytesPublication::is_matched(const Source& source) const {
  return writer_->matches().contains(source);
}

bool BytesPublication::wait_for_acknowledged(std::chrono::milliseconds timeout) {
  return writer_->wait_for_acknowledged(timeout);
}

}  // namespace vdrive::wire
