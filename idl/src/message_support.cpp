// SPDX-License-Identifier: Apache-2.0
#include "message_support.hpp"

#include "vdrive/assert.hpp"

#include <array>
#include <tuple>

namespace vdrive::wire {
namespace {

template <typename Message>
constexpr MessageSupport support_of_row(const TopicRow<Message>& /*row*/) {
  return {.largest_sample = largest_sample<Message>,
          .encoded_size =
              [](const void* message) {
                return kEncapsulation +
                       Message::getCdrSerializedSize(*static_cast<const Message*>(message));
              },
          .encode =
              [](const void* message, std::span<std::byte> output) noexcept {
                return write_sample(*static_cast<const Message*>(message), output);
              },
          .read =
              [](std::span<const std::byte> sample, void* message) noexcept {
                return read_sample(sample, *static_cast<Message*>(message));
              },
          .within_bounds =
              [](const void* message) noexcept {
                return Topic<Message>::kRow.within_bounds(*static_cast<const Message*>(message));
              }};
}

constexpr std::array kSupport = std::apply(
    [](const auto&... rows) {
      return std::array{support_of_row(rows)...};
    },
    kTopicRows);

}  // namespace

const MessageSupport& support_of(TopicId topic) noexcept {
  ensure(static_cast<std::size_t>(topic) < kSupport.size(), "a topic has a row");
  return kSupport[static_cast<std::size_t>(topic)];
}

}  // namespace vdrive::wire
