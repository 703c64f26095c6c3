// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/codec.hpp"

#include "message_support.hpp"
#include "vdrive_messages_description.hpp"

#include <utility>

namespace vdrive::wire {

std::size_t encoded_size(TopicId topic, const void* message) noexcept {
  return support_of(topic).encode(message, {});
}

std::size_t encode(TopicId topic, const void* message, std::span<std::byte> output) noexcept {
  const std::size_t size = support_of(topic).encode(message, output);
  return size <= output.size() ? size : 0;
}

Decoding decode(TopicId topic, std::span<const std::byte> sample, void* message) {
  return support_of(topic).decode(sample, message);
}

CommandDecoder::CommandDecoder(std::size_t spare) {
  spare_.reserve(spare + msg::MAX_AXES_PER_FRAME);
  for (std::size_t count = 0; count < spare; ++count) {
    spare_.emplace_back().objects.reserve(msg::MAX_OBJECTS_PER_AXIS);
  }
}

/// Keeps removed elements: shrinking the vector would free the capacity of their sequences.
void CommandDecoder::resize(std::vector<msg::AxisCommand>& axes, std::size_t count) {
  axes.reserve(msg::MAX_AXES_PER_FRAME);
  while (axes.size() > count) {
    if (spare_.size() < spare_.capacity()) spare_.push_back(std::move(axes.back()));
    axes.pop_back();
  }
  while (axes.size() < count) {
    if (spare_.empty()) {
      axes.emplace_back();
    } else {
      axes.push_back(std::move(spare_.back()));
      spare_.pop_back();
    }
  }
}

Decoding CommandDecoder::result_of(const CdrReader& reader) noexcept {
  too_long_ = reader.beyond_bound().empty()     ? msg::Reason::none
              : reader.beyond_bound() == "axes" ? msg::Reason::too_many_axes
                                                : msg::Reason::too_many_objects;
  return decoding_of(reader);
}

Decoding CommandDecoder::decode(std::span<const std::byte> sample, msg::CommandFrame& frame) {
  CdrReader reader(sample);
  reader.get(frame, [this]<typename Element>(std::vector<Element>& elements, std::size_t count) {
    if constexpr (std::is_same_v<Element, msg::AxisCommand>) {
      resize(elements, count);
    } else {
      elements.resize(count);
    }
  });
  return result_of(reader);
}

Decoding CommandDecoder::decode(std::span<const std::byte> sample, msg::Request& request) {
  request.axes.reserve(msg::MAX_AXES_PER_FRAME);
  request.objects.reserve(msg::MAX_OBJECTS_PER_REQUEST);
  CdrReader reader(sample);
  reader.get(request);
  // A message beyond a bound is not carried out, so nothing needs its axes.
  if (!reader.beyond_bound().empty()) request.axes.clear();
  return result_of(reader);
}

}  // namespace vdrive::wire
