// SPDX-License-Identifier: Apache-2.0
// Builds RTPS datagrams for tests, byte by byte.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <vector>

namespace vdrive::test {

using Datagram = std::vector<std::uint8_t>;
using GuidPrefix = std::array<std::uint8_t, 12>;

constexpr std::uint32_t kParticipantsWriter = 0x000100C2;
constexpr std::uint32_t kParticipantsReader = 0x000100C7;
constexpr std::uint32_t kPublicationsWriter = 0x000003C2;
constexpr std::uint32_t kPublicationsReader = 0x000003C7;

/// Writes little-endian submessages one after the other; the vendor is Fast DDS unless another is
/// given.
class DatagramWriter {
 public:
  explicit DatagramWriter(const GuidPrefix& sender, std::uint8_t vendor = 15) {
    bytes_ = {'R', 'T', 'P', 'S', 2, 3, 1, vendor};
    bytes_.insert(bytes_.end(), sender.begin(), sender.end());
  }

  /// @param length as encoded; by default the length of `body`
  DatagramWriter& add(std::uint8_t kind, std::uint8_t flags, const Datagram& body,
                      int length = -1) {
    const std::size_t written = length < 0 ? body.size() : static_cast<std::size_t>(length);
    bytes_.insert(bytes_.end(), {kind, flags, static_cast<std::uint8_t>(written),
                                 static_cast<std::uint8_t>(written >> 8U)});
    bytes_.insert(bytes_.end(), body.begin(), body.end());
    return *this;
  }

  [[nodiscard]] const Datagram& bytes() const { return bytes_; }

 private:
  Datagram bytes_;
};

/// Writes numbers to a body.
class Body {
 public:
  Body& u16(std::uint32_t value) { return little(value, 2); }

  Body& u32(std::uint32_t value) { return little(value, 4); }

  Body& entity(std::uint32_t value) {
    for (int shift = 24; shift >= 0; shift -= 8) {
      bytes_.push_back(static_cast<std::uint8_t>(value >> shift));
    }
    return *this;
  }

  Body& sequence(std::int64_t value) {
    const auto bits = static_cast<std::uint64_t>(value);
    return u32(static_cast<std::uint32_t>(bits >> 32U)).u32(static_cast<std::uint32_t>(bits));
  }

  Body& raw(const Datagram& bytes) {
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    return *this;
  }

  /// Adds a parameter, with its value padded to a multiple of four bytes.
  Body& parameter(std::uint16_t id, Datagram value) {
    value.resize((value.size() + 3) / 4 * 4);
    return u16(id).u16(static_cast<std::uint32_t>(value.size())).raw(value);
  }

  [[nodiscard]] const Datagram& bytes() const { return bytes_; }

 private:
  Body& little(std::uint32_t value, int size) {
    for (int shift = 0; shift < size * 8; shift += 8) {
      bytes_.push_back(static_cast<std::uint8_t>(value >> shift));
    }
    return *this;
  }

  Datagram bytes_;
};

/// @return the start of DATA or DATA_FRAG.
inline Body data_to(std::uint32_t reader, std::uint32_t writer, std::int64_t sequence,
                    std::uint32_t to_inline_qos = 16) {
  Body body;
  body.u16(0).u16(to_inline_qos).entity(reader).entity(writer).sequence(sequence);
  return body;
}

inline Body gap(std::uint32_t reader, std::uint32_t writer, std::int64_t start, std::int64_t base) {
  return Body().entity(reader).entity(writer).sequence(start).sequence(base).u32(0);
}

/// A participant that sends, one of its writers, and a reader on this side.
constexpr GuidPrefix kSender{1, 15, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11};
constexpr std::uint32_t kUserReader = 0x00000104;
constexpr std::uint32_t kUserWriter = 0x00000203;

inline Body heartbeat(std::uint32_t reader, std::uint32_t writer, std::int64_t first,
                      std::int64_t last, std::uint32_t count = 1) {
  return Body().entity(reader).entity(writer).sequence(first).sequence(last).u32(count);
}

/// @param words of the bit set, all bits of which are 0
inline Body acknack(std::uint32_t reader, std::uint32_t writer, std::int64_t base,
                    std::uint32_t bits = 0, std::size_t words = 0) {
  Body body;
  body.entity(reader).entity(writer).sequence(base).u32(bits);
  for (std::size_t word = 0; word < words; ++word) body.u32(0);
  return body.u32(1);
}

/// @return a GUID as the value of a parameter.
inline Datagram guid_of(const GuidPrefix& participant) {
  Datagram value(participant.begin(), participant.end());
  value.insert(value.end(), {0, 0, 1, 0xC1});
  return value;
}

/// @return the announcement of a participant.
inline Body announcement(const GuidPrefix& participant, const std::string& name,
                         std::uint32_t lease_seconds) {
  Body text;
  text.u32(static_cast<std::uint32_t>(name.size() + 1)).raw({name.begin(), name.end()}).raw({0});
  Body body = data_to(kParticipantsReader, kParticipantsWriter, 1);
  body.raw({0, 3, 0, 0}).parameter(0x50, guid_of(participant));
  body.parameter(0x62, text.bytes()).parameter(0x02, Body().u32(lease_seconds).u32(0).bytes());
  return body.u32(1);  // sentinel
}

}  // namespace vdrive::test
