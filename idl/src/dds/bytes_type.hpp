// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/topics.hpp"

#include <fastdds/dds/topic/TopicDataType.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

namespace vdrive::wire {

/// What stands for a message where only its bytes matter.
struct BytesSample {
  std::span<const std::byte> bytes;                                       ///< to be written
  const std::function<void(std::span<const std::byte>)>* take = nullptr;  ///< of a reader
  std::array<std::byte, 20> head{};  ///< of what was received: encapsulation and key
  std::size_t head_size = 0;
};

/// The type support of a topic whose samples are encoded and decoded elsewhere: it copies them. It
/// is announced like the generated one, so that both match.
class BytesType final : public eprosima::fastdds::dds::TopicDataType {
 public:
  explicit BytesType(TopicId topic);

  bool serialize(void* data, eprosima::fastrtps::rtps::SerializedPayload_t* payload) override;
  bool deserialize(eprosima::fastrtps::rtps::SerializedPayload_t* payload, void* data) override;
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override;
  void* createData() override;
  void deleteData(void* data) override;
  bool getKey(void* data, eprosima::fastrtps::rtps::InstanceHandle_t* handle,
              bool force_md5) override;

 private:
  TopicKey key_;
};

}  // namespace vdrive::wire
