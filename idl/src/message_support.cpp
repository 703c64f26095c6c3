// SPDX-License-Identifier: Apache-2.0
#include "message_support.hpp"

#include "vdrive/assert.hpp"

#include <algorithm>
#include <array>
#include <cstring>
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

std::array<std::byte, kKeyHashSize> key_of(std::span<const std::byte> sample,
                                           TopicKey key) noexcept {
  std::array<std::byte, kKeyHashSize> hash{};
  if (sample.size() < kEncapsulation + size_of_key(key)) return hash;
  std::memcpy(hash.data(), &sample[kEncapsulation], size_of_key(key));
  constexpr auto kSession = 8;  // behind the padding, which a sender may fill with anything
  if (key == TopicKey::bench_and_session) {
    std::fill(hash.begin() + 4, hash.begin() + kSession, std::byte{0});
  }
  const bool is_little = sample[1] != std::byte{0};
  if (is_little) {
    std::reverse(hash.begin(), hash.begin() + 4);
    if (key == TopicKey::bench_and_number) std::swap(hash[4], hash[5]);
    if (key == TopicKey::bench_and_session) std::reverse(hash.begin() + kSession, hash.end());
  }
  return hash;
}

}  // namespace vdrive::wire
