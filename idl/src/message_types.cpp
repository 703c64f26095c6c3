// SPDX-License-Identifier: Apache-2.0
#include "message_types.hpp"

#include "vdrive/assert.hpp"

#include <fastrtps/utils/md5.h>

#include <string>
#include <tuple>

namespace vdrive::wire {
namespace {

template <typename Message>
constexpr MessageSupport support_of_row(const TopicRow<Message>& /*row*/) {
  return {.make_type =
              [] {
                return eprosima::fastdds::dds::TypeSupport(new MessageType<Message>());
              },
          .largest_sample = largest_sample<Message>,
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

void announce_as(const TopicTraits& topic, std::uint32_t largest_sample,
                 eprosima::fastdds::dds::TopicDataType& type) {
  type.setName(std::string(topic.type_name).c_str());
  type.m_typeSize = largest_sample;
  type.m_isGetKeyDefined = topic.key != TopicKey::none;
  type.auto_fill_type_object(false);
  type.auto_fill_type_information(false);
}

void set_key(eprosima::fastrtps::rtps::InstanceHandle_t& handle,
             const std::array<std::byte, kKeyHashSize>& key, std::size_t summed) {
  for (std::size_t byte = 0; byte < key.size(); ++byte) {
    handle.value[byte] = std::to_integer<std::uint8_t>(key[byte]);
  }
  if (summed == 0) return;
  MD5 md5;
  md5.init();
  // NOLINTNEXTLINE(*-reinterpret-cast): the library has characters
  md5.update(reinterpret_cast<const unsigned char*>(key.data()), static_cast<unsigned int>(summed));
  md5.finalize();
  for (std::size_t byte = 0; byte < key.size(); ++byte) handle.value[byte] = md5.digest[byte];
}

}  // namespace vdrive::wire
