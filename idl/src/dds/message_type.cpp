// SPDX-License-Identifier: Apache-2.0
#include "dds/message_type.hpp"

#include <fastrtps/utils/md5.h>

#include <string>
#include <tuple>

namespace vdrive::wire {
namespace {

namespace dds = eprosima::fastdds::dds;

template <typename Message>
dds::TypeSupport make_type(const TopicRow<Message>& /*row*/) {
  return dds::TypeSupport(new MessageType<Message>());
}

}  // namespace

dds::TypeSupport message_type_of(TopicId topic) {
  return std::apply(
      [topic](const auto&... rows) {
        dds::TypeSupport type;
        std::size_t number = 0;
        static_cast<void>(
            ((number++ == static_cast<std::size_t>(topic) && (type = make_type(rows), true)) ||
             ...));
        return type;
      },
      kTopicRows);
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
