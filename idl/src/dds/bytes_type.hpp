// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "dds/library/library.hpp"
#include "message_support.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

namespace vdrive::wire {

/// What the library has of a sample.
struct BytesSample {
  std::span<const std::byte> bytes;                                       ///< to be written
  const std::function<void(std::span<const std::byte>)>* take = nullptr;  ///< of a reader
  std::array<std::byte, 20> head{};  ///< of what was received: encapsulation and key
  std::size_t head_size = 0;
};

/// The type of a topic as the network sees it, fit for a network of strangers: no type objects on
/// the wire, and no exception out of a payload. Samples are encoded and decoded elsewhere.
class BytesType final : public LibraryType {
 public:
  using Key = MessageKey (*)(std::span<const std::byte> sample) noexcept;

  /// @param name as it is announced
  /// @param largest sample that a reader takes [bytes]; it drops what is larger without a report
  /// @param key of a sample; nullptr for a topic without keys
  BytesType(const std::string& name, std::size_t largest, Key key);

  /// That of a topic. A sample that exceeds a bound of the type by less than its size still
  /// arrives, and gets an answer with the reason.
  explicit BytesType(TopicId topic);

 private:
  [[nodiscard]] std::span<const std::byte> bytes_of(const void* data) const noexcept override;
  bool encode(const void* data, rtps::SerializedPayload_t& payload) override;
  bool decode(const rtps::SerializedPayload_t& payload, void* data) override;
  bool put_key(std::span<const std::byte> sample, rtps::InstanceHandle_t& handle,
               bool force_md5) override;
  void* make() override;
  void drop(void* data) override;

  Key key_;
};

}  // namespace vdrive::wire
