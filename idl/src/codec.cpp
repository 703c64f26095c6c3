// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/codec.hpp"

#include "cdr.hpp"
#include "message_support.hpp"

#include <utility>

namespace vdrive::wire {
namespace {

void read_command(CdrReader& reader, msg::AxisCommand& command) {
  command.axis(reader.next<std::uint16_t>());
  command.members(reader.next<std::uint16_t>());
  command.ds402_controlword(reader.next<std::uint16_t>());
  command.op_mode_cmd(reader.next<std::int8_t>());
  command.position_user_target_value(reader.next<std::int32_t>());
  command.profile_velocity(reader.next<std::uint32_t>());
  command.profile_acc(reader.next<std::uint32_t>());
  command.profile_dec(reader.next<std::uint32_t>());
  command.positioning_option_code(reader.next<std::uint16_t>());
}

}  // namespace

std::size_t encoded_size(TopicId topic, const void* message) {
  return support_of(topic).encoded_size(message);
}

std::size_t encode(TopicId topic, const void* message, std::span<std::byte> output) noexcept {
  return support_of(topic).encode(message, output);
}

bool decode(TopicId topic, std::span<const std::byte> sample, void* message) noexcept {
  const MessageSupport& support = support_of(topic);
  return CdrReader(sample).is_good() && support.read(sample, message) &&
         support.within_bounds(message);
}

CommandDecoder::CommandDecoder(std::size_t spare) {
  spare_.reserve(spare + msg::MAX_AXES_PER_FRAME);
  for (std::size_t count = 0; count < spare; ++count) {
    spare_.emplace_back().objects().reserve(msg::MAX_OBJECTS_PER_AXIS);
  }
}

/// A vector that shrinks would throw the room of its elements' sequences away.
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

Decoding CommandDecoder::decode(std::span<const std::byte> sample, msg::CommandFrame& frame) {
  CdrReader reader(sample);
  frame.bench(reader.next<std::uint32_t>());
  frame.incarnation(reader.next<std::uint64_t>());
  frame.session(reader.next<std::uint64_t>());
  frame.epoch(reader.next<std::uint32_t>());
  frame.sequence_number(reader.next<std::uint64_t>());
  frame.apply_at_tick(reader.next<std::uint64_t>());
  frame.valid_until_tick(reader.next<std::uint64_t>());
  frame.flags(reader.next<std::uint32_t>());
  const auto count = reader.next<std::uint32_t>();
  const bool fits = count <= msg::MAX_AXES_PER_FRAME;
  resize(frame.axes(), fits ? count : 0);
  if (!fits) return Decoding::too_many_axes;
  for (auto& command : frame.axes()) {
    read_command(reader, command);
    const auto objects = reader.next<std::uint32_t>();
    if (objects > msg::MAX_OBJECTS_PER_AXIS) {
      resize(frame.axes(), 0);
      return Decoding::too_many_objects;
    }
    command.objects().resize(objects);
    for (auto& object : command.objects()) {
      object.index(reader.next<std::uint16_t>());
      object.subindex(reader.next<std::uint8_t>());
      object.value(reader.next<std::int64_t>());
    }
  }
  return reader.is_good() ? Decoding::good : Decoding::malformed;
}

// NOLINTNEXTLINE(readability-convert-member-functions-to-static): one object decodes both kinds
Decoding CommandDecoder::decode(std::span<const std::byte> sample, msg::Request& request) {
  CdrReader reader(sample);
  request.client(reader.next<std::uint64_t>());
  request.request_id(reader.next<std::uint64_t>());
  request.bench(reader.next<std::uint32_t>());
  request.incarnation(reader.next<std::uint64_t>());
  request.session(reader.next<std::uint64_t>());
  request.kind(reader.next<std::uint32_t>());
  request.ticks(reader.next<std::uint64_t>());
  request.last_sequence(reader.next<std::uint64_t>());
  request.rate(reader.next_double());
  request.snapshot(reader.next<std::uint64_t>());
  request.axes().reserve(msg::MAX_AXES_PER_FRAME);
  request.objects().reserve(msg::MAX_OBJECTS_PER_REQUEST);
  request.axes().clear();
  request.objects().clear();
  const auto axes = reader.next<std::uint32_t>();
  if (axes > msg::MAX_AXES_PER_FRAME) return Decoding::too_many_axes;
  request.axes().resize(axes);
  reader.next(std::span(request.axes()));
  const auto objects = reader.next<std::uint32_t>();
  if (objects > msg::MAX_OBJECTS_PER_REQUEST) {
    request.axes().clear();
    return Decoding::too_many_objects;
  }
  request.objects().resize(objects);
  for (auto& object : request.objects()) {
    object.axis(reader.next<std::uint16_t>());
    object.index(reader.next<std::uint16_t>());
    object.subindex(reader.next<std::uint8_t>());
    object.value(reader.next<std::int64_t>());
  }
  return reader.is_good() ? Decoding::good : Decoding::malformed;
}

}  // namespace vdrive::wire
