// SPDX-License-Identifier: Apache-2.0
#include "dds/bytes_type.hpp"

#include "dds/message_type.hpp"
#include "vdrive/wire/codec.hpp"

#include <algorithm>
#include <cstring>

namespace vdrive::wire {
namespace {

namespace rtps = eprosima::fastrtps::rtps;

BytesSample& sample_at(void* data) noexcept {
  return *static_cast<BytesSample*>(data);
}

}  // namespace

BytesType::BytesType(TopicId topic) : key_(traits_of(topic).key) {
  announce_as(traits_of(topic), support_of(topic).largest_sample(), *this);
}

bool BytesType::serialize(void* data, rtps::SerializedPayload_t* payload) {
  const std::span<const std::byte> bytes = sample_at(data).bytes;
  if (bytes.size() < kEncapsulation || bytes.size() > payload->max_size) return false;
  std::memcpy(payload->data, bytes.data(), bytes.size());
  payload->length = static_cast<std::uint32_t>(bytes.size());
  payload->encapsulation = bytes[1] == std::byte{0} ? CDR_BE : CDR_LE;
  return true;
}

bool BytesType::deserialize(rtps::SerializedPayload_t* payload, void* data) {
  BytesSample& sample = sample_at(data);
  // NOLINTNEXTLINE(*-reinterpret-cast): the library has octets
  const std::span bytes(reinterpret_cast<const std::byte*>(payload->data), payload->length);
  sample.head_size = std::min(bytes.size(), sample.head.size());
  std::copy_n(bytes.begin(), sample.head_size, sample.head.begin());
  if (sample.take != nullptr) (*sample.take)(bytes);
  return bytes.size() >= kEncapsulation;
}

std::function<std::uint32_t()> BytesType::getSerializedSizeProvider(void* data) {
  return [size = sample_at(data).bytes.size()] {
    return static_cast<std::uint32_t>(size);
  };
}

void* BytesType::createData() {
  return new BytesSample();  // NOLINT(*-owning-memory): the library gives it back to deleteData
}

void BytesType::deleteData(void* data) {
  delete static_cast<BytesSample*>(data);  // NOLINT(*-owning-memory)
}

bool BytesType::getKey(void* data, rtps::InstanceHandle_t* handle, bool force_md5) {
  if (key_ == TopicKey::none) return false;
  const BytesSample& sample = sample_at(data);
  const std::span<const std::byte> bytes =
      sample.bytes.empty() ? std::span<const std::byte>(sample.head.data(), sample.head_size)
                           : sample.bytes;
  set_key(*handle, key_of(bytes, key_), force_md5 ? size_of_key(key_) : 0);
  return true;
}

}  // namespace vdrive::wire
