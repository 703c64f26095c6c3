// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/reply.hpp"

#include "axis_layout.hpp"
#include "cdr.hpp"

namespace vdrive::wire {
namespace {

/// Everything in front of the axes, in the order of the IDL.
void put_head(const msg::Reply& reply, std::size_t axes, CdrWriter& writer) noexcept {
  writer.put(reply.client());
  writer.put(reply.request_id());
  writer.put(reply.bench());
  writer.put(reply.incarnation());
  writer.put(reply.reason());
  writer.put(reply.refused_axis());
  writer.put(reply.owner_session());
  writer.put(reply.tick());
  writer.put(reply.epoch());
  writer.put(reply.last_sequence());
  writer.put(reply.missing_stepper());
  writer.put(reply.snapshot());
  writer.put(static_cast<std::uint32_t>(reply.objects().size()));
  for (const msg::ObjectResult& object : reply.objects()) {
    writer.put(object.axis());
    writer.put(object.index());
    writer.put(object.subindex());
    writer.put(object.abort_code());
    writer.put(object.value());
  }
  writer.put(static_cast<std::uint32_t>(axes));
}

void read_members(CdrReader& reader, msg::Reply& reply) noexcept {
  reply.client(reader.next<std::uint64_t>());
  reply.request_id(reader.next<std::uint64_t>());
  reply.bench(reader.next<std::uint32_t>());
  reply.incarnation(reader.next<std::uint64_t>());
  reply.reason(reader.next<std::uint32_t>());
  reply.refused_axis(reader.next<std::uint16_t>());
  reply.owner_session(reader.next<std::uint64_t>());
  reply.tick(reader.next<std::uint64_t>());
  reply.epoch(reader.next<std::uint32_t>());
  reply.last_sequence(reader.next<std::uint64_t>());
  reply.missing_stepper(reader.next<std::uint64_t>());
  reply.snapshot(reader.next<std::uint64_t>());
}

/// @return false when there are too many.
bool read_objects(CdrReader& reader, std::vector<msg::ObjectResult>& objects) {
  const auto count = reader.next<std::uint32_t>();
  if (count > msg::MAX_OBJECTS_PER_REQUEST) return false;
  objects.resize(count);
  for (msg::ObjectResult& object : objects) {
    object.axis(reader.next<std::uint16_t>());
    object.index(reader.next<std::uint16_t>());
    object.subindex(reader.next<std::uint8_t>());
    object.abort_code(reader.next<std::uint32_t>());
    object.value(reader.next<std::int64_t>());
  }
  return true;
}

}  // namespace

std::size_t encoded_reply_size(const msg::Reply& reply, std::size_t axes) noexcept {
  CdrWriter head{{}};
  put_head(reply, axes, head);
  return head.size() + AxisSequence(head.size() - kEncapsulation).place_of(axes);
}

std::size_t encode_reply(const msg::Reply& reply, std::span<const ShownAxis> axes,
                         std::span<std::byte> output) noexcept {
  CdrWriter head(output);
  put_head(reply, axes.size(), head);
  const AxisSequence sequence(head.size() - kEncapsulation);
  const std::size_t size = head.size() + sequence.place_of(axes.size());
  if (size > output.size()) return 0;
  std::byte* const first = output.data() + head.size();
  for (std::size_t position = 0; position < axes.size(); ++position) {
    const ShownAxis& axis = axes[position];
    sequence.put(position, axis.status, {reply.bench(), axis.number}, axis.tick, axis.owner, first);
  }
  return size;
}

bool decode_reply(std::span<const std::byte> sample, msg::Reply& reply,
                  std::vector<ReceivedStatus>& axes) {
  CdrReader reader(sample);
  if (!reader.is_native()) return false;
  read_members(reader, reply);
  if (!read_objects(reader, reply.objects())) return false;
  const auto count = reader.next<std::uint32_t>();
  const std::size_t begin = reader.position();
  const AxisSequence sequence(begin - kEncapsulation);
  if (!reader.is_good() || count > msg::MAX_AXES_PER_FRAME ||
      sample.size() < begin + sequence.place_of(count)) {
    return false;
  }
  axes.resize(count);
  for (std::uint32_t position = 0; position < count; ++position) {
    sequence.get(position, sample.data() + begin, axes[position]);
  }
  return true;
}

}  // namespace vdrive::wire
