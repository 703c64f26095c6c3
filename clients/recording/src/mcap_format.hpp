// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <string>
#include <string_view>

/// The MCAP records (https://mcap.dev/spec): opcode (u8), length of the body (u64), body; all
/// numbers are little-endian.
namespace vdrive::recording {

/// The first and the last bytes of a file.
inline constexpr std::string_view kMcapMagic{"\x89MCAP0\r\n", 8};

/// Size of the opcode and length that precede a body [bytes].
inline constexpr std::size_t kMcapHead = 9;

enum class Opcode : std::uint8_t {
  header = 0x01,
  footer = 0x02,
  schema = 0x03,
  channel = 0x04,
  message = 0x05,
  chunk = 0x06,
  message_index = 0x07,
  chunk_index = 0x08,
  attachment = 0x09,
  attachment_index = 0x0A,
  statistics = 0x0B,
  metadata = 0x0C,
  metadata_index = 0x0D,
  summary_offset = 0x0E,
  data_end = 0x0F,
};

using TextMap = std::map<std::string, std::string>;

/// Appends one record to `out`; its length is filled in by the destructor.
class RecordBuilder {
 public:
  RecordBuilder(std::string& out, Opcode opcode);
  ~RecordBuilder();
  RecordBuilder(const RecordBuilder&) = delete;
  RecordBuilder& operator=(const RecordBuilder&) = delete;

  template <std::unsigned_integral Number>
  RecordBuilder& put(Number number) {
    static_assert(std::endian::native == std::endian::little, "numbers are copied as they are");
    const std::size_t place = out_.size();
    out_.resize(place + sizeof(Number));
    std::memcpy(out_.data() + place, &number, sizeof(Number));
    return *this;
  }

  /// Text or bytes, preceded by their length (u32).
  RecordBuilder& put(std::string_view text);

  /// A map, preceded by its length in bytes (u32).
  RecordBuilder& put(const TextMap& map);

  /// Bytes without a length.
  RecordBuilder& put_raw(std::string_view bytes);

 private:
  std::string& out_;
  std::size_t start_;  ///< of the body
};

/// Reads the body of one record.
class BodyReader {
 public:
  /// @param where the record, for error messages: such as "the channel record at byte 120"
  BodyReader(std::string_view body, std::string where);

  /// @throws RecordingError, like the members below, if the rest of the body is too short
  template <std::unsigned_integral Number>
  [[nodiscard]] Number get() {
    Number number{};
    const std::string_view bytes = take(sizeof(Number));
    std::memcpy(&number, bytes.data(), sizeof(Number));
    return number;
  }

  [[nodiscard]] std::string_view get_text();
  [[nodiscard]] TextMap get_map();

  /// @return the next bytes.
  [[nodiscard]] std::string_view take(std::uint64_t size);

  /// @return the remaining bytes.
  [[nodiscard]] std::string_view rest() const noexcept { return body_; }

 private:
  std::string_view body_;
  std::string where_;
};

/// @return the CRC-32 of `bytes`, continuing from `crc`, as defined by MCAP.
[[nodiscard]] std::uint32_t crc_of(std::string_view bytes, std::uint32_t crc = 0) noexcept;

}  // namespace vdrive::recording
