// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/reply.hpp"

#include "axis_layout.hpp"
#include "vdrive/wire/cdr.hpp"
#include "vdrive_messages_description.hpp"

#include <tuple>
#include <utility>

namespace vdrive::wire {
namespace {

/// Calls `visit(member)` with each member before the axes, which are the last member.
template <typename Visit>
void for_each_of_head(const Visit& visit) {
  constexpr std::size_t kAxes = member_index<msg::Reply>("statuses");
  static_assert(kAxes + 1 == std::tuple_size_v<decltype(Description<msg::Reply>::kMembers)>);
  [&]<std::size_t... kMember>(std::index_sequence<kMember...>) {
    (visit(std::get<kMember>(Description<msg::Reply>::kMembers)), ...);
  }
  (std::make_index_sequence<kAxes>{});
}

void put_head(const msg::Reply& reply, std::size_t axes, CdrWriter& writer) noexcept {
  for_each_of_head([&](const auto& member) {
    writer.put(reply.*member.pointer);
  });
  writer.put(static_cast<std::uint32_t>(axes));
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
    sequence.put(position, axis.status, {reply.bench, axis.number}, axis.tick, axis.owner, first);
  }
  return size;
}

bool decode_reply(std::span<const std::byte> sample, msg::Reply& reply,
                  std::vector<ReceivedStatus>& axes) {
  CdrReader reader(sample);
  if (!reader.is_native()) return false;
  for_each_of_head([&](const auto& member) {
    reader.get(member, reply.*member.pointer);
  });
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
