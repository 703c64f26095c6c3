// SPDX-License-Identifier: Apache-2.0
#include "dds/bytes_type.hpp"

#include "vdrive/wire/cdr.hpp"

#include <algorithm>
#include <cstring>

namespace vdrive::wire {
namespace {

/// Twice the largest sample, rounded up to the alignment of a submessage.
std::size_t room_for(TopicId topic) {
  constexpr std::size_t kSubmessageAlignment = 4;
  const std::size_t largest = support_of(topic).largest_sample;
  return 2 * (largest + cdr_gap(largest, kSubmessageAlignment));
}

}  // namespace

BytesType::BytesType(const std::string& name, std::size_t largest, Key key)
    : LibraryType(name, largest, key != nullptr), key_(key) {}

BytesType::BytesType(TopicId topic)
    : BytesType(std::string(traits_of(topic).type_name), room_for(topic),
                traits_of(topic).has_key ? support_of(topic).key : nullptr) {}

/// The bytes from which the key is made; for a received sample its head.
std::span<const std::byte> BytesType::bytes_of(const void* data) const noexcept {
  const BytesSample& sample = *static_cast<const BytesSample*>(data);
  return sample.bytes.empty() ? std::span<const std::byte>(sample.head.data(), sample.head_size)
                              : sample.bytes;
}

bool BytesType::encode(const void* data, rtps::SerializedPayload_t& payload) {
  const std::span<const std::byte> bytes = bytes_of(data);
  if (bytes.size() < kEncapsulation || bytes.size() > payload.max_size) return false;
  std::memcpy(payload.data, bytes.data(), bytes.size());
  payload.length = static_cast<std::uint32_t>(bytes.size());
  payload.encapsulation = bytes[1] == std::byte{0} ? CDR_BE : CDR_LE;
  return true;
}

bool BytesType::decode(const rtps::SerializedPayload_t& payload, void* data) {
  BytesSample& sample = *static_cast<BytesSample*>(data);
  // NOLINTNEXTLINE(*-reinterpret-cast): the library has octets
  const std::span bytes(reinterpret_cast<const std::byte*>(payload.data), payload.length);
  sample.head_size = std::min(bytes.size(), sample.head.size());
  std::copy_n(bytes.begin(), sample.head_size, sample.head.begin());
  try {
    if (sample.take != nullptr) (*sample.take)(bytes);
  } catch (...) {  // out of memory: the sample is dropped
    return false;
  }
  return bytes.size() >= kEncapsulation;
}

void* BytesType::make() {
  return new BytesSample();  // NOLINT(*-owning-memory): the library gives it back to drop()
}

void BytesType::drop(void* data) {
  delete static_cast<BytesSample*>(data);  // NOLINT(*-owning-memory)
}

/// The key hash of DDS: the key, or its MD5 sum.
bool BytesType::put_key(std::span<const std::byte> sample, rtps::InstanceHandle_t& handle,
                        bool force_md5) {
  if (key_ == nullptr) return false;
  const MessageKey key = key_(sample);
  for (std::size_t i = 0; i < key.bytes.size(); ++i) {
    handle.value[i] = std::to_integer<rtps::octet>(key.bytes[i]);
  }
  if (!force_md5) return true;
  LibraryMd5 md5;
  md5.init();
  // NOLINTNEXTLINE(*-reinterpret-cast): the library has characters
  md5.update(reinterpret_cast<const unsigned char*>(key.bytes.data()),
             static_cast<unsigned int>(key.size));
  md5.finalize();
  for (std::size_t i = 0; i < key.bytes.size(); ++i) handle.value[i] = md5.digest[i];
  return true;
}

}  // namespace vdrive::wire
