// SPDX-License-Identifier: Apache-2.0
#include "message_support.hpp"

#include "vdrive/assert.hpp"
#include "vdrive/wire/cdr.hpp"
#include "vdrive_messages_description.hpp"

#include <algorithm>
#include <tuple>

namespace vdrive::wire {
namespace {

/// The key members of a message are its first ones.
template <typename Message>
MessageKey key_of(std::span<const std::byte> sample) noexcept {
  CdrReader reader(sample);
  std::array<std::byte, kEncapsulation + kKeyHashSize> image{};
  CdrWriter writer(image, CdrWriter::Order::big_endian);
  for_each_member<Message>([&]<typename Value>(const Member<Message, Value>& member) {
    if constexpr (CdrNumber<Value>) {
      if (member.is_key) writer.put(reader.next<Value>());
    }
  });
  ensure(writer.is_good(), "a key has at most 16 bytes");
  MessageKey key{.bytes = {}, .size = writer.size() - kEncapsulation};
  if (reader.is_good()) std::copy_n(image.begin() + kEncapsulation, key.size, key.bytes.begin());
  return key;
}

template <typename Message>
MessageSupport support_of_row(const TopicRow<Message>& /*row*/) {
  return {.largest_sample = largest_sample<Message>(),
          .encode =
              [](const void* message, std::span<std::byte> output) noexcept {
                CdrWriter writer(output);
                writer.put(*static_cast<const Message*>(message));
                return writer.size();
              },
          .decode =
              [](std::span<const std::byte> sample, void* message) {
                CdrReader reader(sample);
                reader.get(*static_cast<Message*>(message));
                return decoding_of(reader);
              },
          .key = key_of<Message>};
}

}  // namespace

const MessageSupport& support_of(TopicId topic) noexcept {
  static const std::array rows_of_support = std::apply(
      [](const auto&... rows) {
        return std::array{support_of_row(rows)...};
      },
      kTopicRows);
  ensure(static_cast<std::size_t>(topic) < rows_of_support.size(), "a topic has a row");
  return rows_of_support[static_cast<std::size_t>(topic)];
}

Decoding decoding_of(const CdrReader& reader) noexcept {
  if (!reader.beyond_bound().empty()) return Decoding::beyond_bounds;
  return reader.is_good() ? Decoding::good : Decoding::malformed;
}

}  // namespace vdrive::wire
