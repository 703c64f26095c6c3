// SPDX-License-Identifier: Apache-2.0
//
// The decoder of every message, as the wire room uses it, takes any bytes: it refuses them, or
// gives a message that can be written again; what the receivers look at is read.
#include "message_types.hpp"
#include "vdrive/wire/conversion.hpp"

#include <fastdds/rtps/common/SerializedPayload.h>

#include <algorithm>
#include <cstdint>
#include <cstring>

namespace {

using eprosima::fastrtps::rtps::SerializedPayload_t;

void look_at(const vdrive::msg::AxisStatus& status) {
  static_cast<void>(vdrive::wire::from_message(status));
  for (std::size_t row = 0; row < vdrive::kObjectCount; ++row) {
    static_cast<void>(vdrive::wire::value_of(status, static_cast<vdrive::ObjectRow>(row)));
  }
}

template <typename Message>
void look_at(const Message& /*message*/) {}

template <typename Message>
void decode(const std::uint8_t* data, std::size_t size) {
  vdrive::wire::MessageType<Message> type;
  SerializedPayload_t payload(static_cast<std::uint32_t>(std::max<std::size_t>(size, 1)));
  std::memcpy(payload.data, data, size);
  payload.length = static_cast<std::uint32_t>(size);
  Message message;
  if (!type.deserialize(&payload, &message)) {
    return;
  }
  look_at(message);
  SerializedPayload_t again(type.getSerializedSizeProvider(&message)());
  static_cast<void>(type.serialize(&message, &again));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace vdrive;
  if (size == 0) {
    return 0;
  }
  const std::uint8_t which = data[0] % 10;
  ++data;
  --size;
  switch (which) {
    case 0:
      decode<msg::CommandFrame>(data, size);
      break;
    case 1:
      decode<msg::CommandReply>(data, size);
      break;
    case 2:
      decode<msg::Request>(data, size);
      break;
    case 3:
      decode<msg::Reply>(data, size);
      break;
    case 4:
      decode<msg::StatusFrame>(data, size);
      break;
    case 5:
      decode<msg::AxisStatus>(data, size);
      break;
    case 6:
      decode<msg::AxisParameters>(data, size);
      break;
    case 7:
      decode<msg::Event>(data, size);
      break;
    case 8:
      decode<msg::BenchDescription>(data, size);
      break;
    default:
      decode<msg::BenchState>(data, size);
      break;
  }
  return 0;
}
