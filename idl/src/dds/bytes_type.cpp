// SPDX-License-Identifier: Apache-2.0
#include "dds/bytes_type.hpp"

#include "vdrive/wire/cdr.hpp"

#include <fastrtps/utils/md5.h>

#include <algorithm>
#include <cstring>

namespace vdrive::wire {
namespace {

namespace rtps = eprosima::fastrtps::rtps;

BytesSample& sample_at(void* data) noexcept {
  return *static_cast<BytesSample*>(data);
}

/// Twice the largest sample, which ends at a multiple of the alignment of a submessage.
std::size_t room_for(TopicId topic) {
  constexpr std::size_t kSubmessageAlignment = 4;
  const std::size_t largest = support_of(topic).largest_sample;
  return 2 * (largest + cdr_gap(largest, kSubmessageAlignment));
}

}  // namespace

BytesType::BytesType(const std::string& name, std::size_t largest, Key key) : key_(key) {
  setName(name.c_str());
  m_typeSize = static_cast<std::uint32_t>(largest);
  m_isGetKeyDefined = key != nullptr;
  auto_fill_type_object(false);
  auto_fill_type_information(false);
}

BytesType::BytesType(TopicId topic)
    : BytesType(std::string(traits_of(topic).type_name), room_for(topic),
                traits_of(topic).has_key ? support_of(topic).key : nullptr) {}

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
  try {
    if (sample.take != nullptr) (*sample.take)(bytes);
  } catch (...) {  // no memory: the sample is dropped
    return false;
  }
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

/// The key hash of DDS: the key, or its MD5 sum.
bool BytesType::getKey(void* data, rtps::InstanceHandle_t* handle, bool force_md5) {
  if (key_ == nullptr) return false;
  const BytesSample& sample = sample_at(data);
  const MessageKey key =
      key_(sample.bytes.empty() ? std::span<const std::byte>(sample.head.data(), sample.head_size)
                                : sample.bytes);
  std::memcpy(handle->value, key.bytes.data(), key.bytes.size());
  if (!force_md5) return true;
  MD5 md5;
  md5.init();
  // NOLINTNEXTLINE(*-reinterpret-cast): the library has characters
  md5.update(reinterpret_cast<const unsigned char*>(key.bytes.data()),
             static_cast<unsigned int>(key.size));
  md5.finalize();
  std::memcpy(handle->value, md5.digest, key.bytes.size());
  return true;
}

}  // namespace vdrive::wire
