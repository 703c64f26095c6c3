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

/// A sample as the library handles it.
struct BytesSample {
  std::span<const std::byte> bytes;                                       ///< to be written
  const std::function<void(std::span<const std::byte>)>* take = nullptr;  ///< of a reader
  std::array<std::byte, 20> head{};  ///< start of a received sample: encapsulation and key
  std::size_t head_size = 0;
};

/// The type of a topic as the library sees it, safe against untrusted senders: it announces no type
/// objects, and no payload causes an exception. Samples are encoded and decoded elsewhere.
class BytesType final : public LibraryType {
 public:
  using Key = MessageKey (*)(std::span<const std::byte> sample) noexcept;

  /// @param name as announced
  /// @param largest maximum size of a sample that a reader accepts [bytes]; larger ones are dropped
  ///        without a report
  /// @param key returns the key of a sample; nullptr for a topic without keys
  BytesType(const std::string& name, std::size_t largest, Key key);

  /// The type of a topic of the wire contract. Accepts twice the largest valid size, so that a
  /// sample that exceeds a bound still arrives and is answered with the reason.
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
