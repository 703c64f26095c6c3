// SPDX-License-Identifier: Apache-2.0
// The bytes of RTPS 2.5 (OMG formal/22-04-01, chapter 9.4) as the guard reads them.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace vdrive::wire {

using ByteView = std::span<const std::uint8_t>;
using GuidPrefix = std::array<std::uint8_t, 12>;  ///< of a participant's GUID

constexpr std::size_t kHeaderSize = 20;
constexpr std::size_t kSubmessageHeaderSize = 4;
constexpr std::size_t kEncapsulationSize = 4;  ///< before the content of a sample or a list
constexpr std::size_t kPrefixOffset = 8;       ///< of the prefix of the sender in the header

/// Kinds of submessages.
enum class SubmessageKind : std::uint8_t {
  pad = 0x01,
  acknack = 0x06,
  heartbeat = 0x07,
  gap = 0x08,
  info_ts = 0x09,
  info_src = 0x0C,
  info_reply_ip4 = 0x0D,
  info_dst = 0x0E,
  info_reply = 0x0F,
  nack_frag = 0x12,
  heartbeat_frag = 0x13,
  data = 0x15,
  data_frag = 0x16,
  sec_body = 0x30,
  sec_prefix = 0x31,
  sec_postfix = 0x32,
  srtps_prefix = 0x33,
  srtps_postfix = 0x34,
  statistics = 0x80,  ///< of Fast DDS; for other vendors another kind
};

/// @return whether the kind is one of DDS Security 1.1, section 7.3.6: encrypted or signed parts.
constexpr bool is_secure(SubmessageKind kind) noexcept {
  return kind >= SubmessageKind::sec_body && kind <= SubmessageKind::srtps_postfix;
}

/// Flags of a submessage.
using Flag = std::uint8_t;
inline constexpr Flag kLittle = 0x01;
inline constexpr Flag kSecond = 0x02;
inline constexpr Flag kThird = 0x04;
inline constexpr Flag kFourth = 0x08;

/// Entities of discovery.
using EntityId = std::uint32_t;
inline constexpr EntityId kUnknownEntity = 0;
inline constexpr EntityId kPublicationsWriter = 0x000003C2;
inline constexpr EntityId kPublicationsReader = 0x000003C7;
inline constexpr EntityId kSubscriptionsWriter = 0x000004C2;
inline constexpr EntityId kSubscriptionsReader = 0x000004C7;
inline constexpr EntityId kParticipantsWriter = 0x000100C2;
inline constexpr EntityId kParticipantsReader = 0x000100C7;
/// Entities of the handshake: BuiltinParticipantStatelessMessage (DDS Security 1.1, section 7.4.3).
inline constexpr EntityId kHandshakeWriter = 0x000201C3;
inline constexpr EntityId kHandshakeReader = 0x000201C4;

/// Size of the statistics that end a datagram of Fast DDS, without the submessage header [bytes].
inline constexpr std::size_t kStatisticsSize = 56;

/// Parameters of lists.
using ParameterId = std::uint16_t;
inline constexpr ParameterId kPad = 0x0000;
inline constexpr ParameterId kSentinel = 0x0001;
inline constexpr ParameterId kLease = 0x0002;
inline constexpr ParameterId kTopicName = 0x0005;
inline constexpr ParameterId kTypeName = 0x0007;
inline constexpr ParameterId kPartition = 0x0029;
inline constexpr ParameterId kContentFilter = 0x0035;
inline constexpr ParameterId kParticipantGuid = 0x0050;
inline constexpr ParameterId kEntityName = 0x0062;
inline constexpr ParameterId kTypeId = 0x0069;
inline constexpr ParameterId kKeyHash = 0x0070;
inline constexpr ParameterId kStatusInfo = 0x0071;
inline constexpr ParameterId kTypeObject = 0x0072;
inline constexpr ParameterId kDataRepresentation = 0x0073;
inline constexpr ParameterId kTypeInformation = 0x0075;
inline constexpr ParameterId kIdentityToken = 0x1001;
inline constexpr ParameterId kParticipantSecurity = 0x1005;
inline constexpr ParameterId kPermissionsToken = 0x1002;
inline constexpr ParameterId kDataSharing = 0x8006;  ///< of Fast DDS; for other vendors another one

/// Reads consecutive numbers. A number past the end is 0 and makes `ok` false.
class ByteReader {
 public:
  ByteReader(ByteView bytes, bool little) noexcept : bytes_(bytes), little_(little) {}

  [[nodiscard]] bool ok() const noexcept { return ok_; }

  [[nodiscard]] std::size_t position() const noexcept { return position_; }

  [[nodiscard]] std::size_t left() const noexcept { return bytes_.size() - position_; }

  void skip(std::size_t count) noexcept {
    if (count > left()) {
      ok_ = false;
      position_ = bytes_.size();
    } else {
      position_ += count;
    }
  }

  std::uint16_t u16() noexcept { return static_cast<std::uint16_t>(number(2, little_)); }

  std::uint32_t u32() noexcept { return number(4, little_); }

  /// A number in network order, whatever the flag says.
  std::uint32_t u32_big() noexcept { return number(4, false); }

  /// Entity ids are in network order, whatever the flag says.
  std::uint32_t entity() noexcept { return u32_big(); }

  /// @return the next `count` bytes; none if there are fewer.
  ByteView bytes(std::size_t count) noexcept {
    const std::size_t from = position_;
    skip(count);
    return ok_ ? bytes_.subspan(from, count) : ByteView{};
  }

  /// @return a sequence number; its high half comes first and may be negative.
  std::int64_t sequence() noexcept {
    const std::uint64_t high = u32();
    return static_cast<std::int64_t>((high << 32U) | u32());
  }

 private:
  std::uint32_t number(std::size_t size, bool little) noexcept {
    if (size > left()) {
      skip(size);
      return 0;
    }
    std::uint32_t value = 0;
    for (std::size_t index = 0; index < size; ++index) {
      const std::size_t place = little ? size - 1 - index : index;
      value = (value << 8U) | bytes_[position_ + place];
    }
    position_ += size;
    return value;
  }

  ByteView bytes_;
  std::size_t position_ = 0;
  bool little_;
  bool ok_ = true;
};

/// Writes the first four bytes of `place`.
inline void put_u32(std::span<std::uint8_t> place, std::uint32_t value, bool little) {
  for (std::size_t index = 0; index < 4; ++index) {
    const std::size_t shift = 8 * (little ? index : 3 - index);
    place[index] = static_cast<std::uint8_t>(value >> shift);
  }
}

/// @param datagram with its complete header
[[nodiscard]] inline GuidPrefix sender_of(ByteView datagram) {
  GuidPrefix prefix{};
  std::copy_n(datagram.begin() + kPrefixOffset, prefix.size(), prefix.begin());
  return prefix;
}

struct Submessage {
  SubmessageKind kind{};
  std::uint8_t flags = 0;
  std::size_t offset = 0;  ///< of the body in the datagram
  ByteView body;
  bool last = false;  ///< nothing follows it

  [[nodiscard]] bool has(Flag flag) const noexcept { return (flags & flag) != 0; }

  [[nodiscard]] ByteReader reader() const noexcept { return {body, has(kLittle)}; }
};

/// Iterates over the submessages of a datagram.
class Submessages {
 public:
  explicit Submessages(ByteView datagram) noexcept : datagram_(datagram) {}

  [[nodiscard]] bool at_end() const noexcept { return position_ >= datagram_.size(); }

  /// @return whether the next submessage is inside the datagram and leaves the following one
  ///         aligned.
  [[nodiscard]] bool next(Submessage& out) noexcept {
    ByteReader header(datagram_.subspan(position_), true);
    if (header.left() < kSubmessageHeaderSize) return false;
    out.kind = static_cast<SubmessageKind>(datagram_[position_]);
    out.flags = datagram_[position_ + 1];
    header = ByteReader(datagram_.subspan(position_ + 2), out.has(kLittle));
    std::size_t length = header.u16();
    out.offset = position_ + kSubmessageHeaderSize;
    const std::size_t left = datagram_.size() - out.offset;
    if (length == 0 && out.kind != SubmessageKind::pad && out.kind != SubmessageKind::info_ts) {
      // Where the library decrypts, it takes a length of 0 literally.
      if (is_secure(out.kind)) return false;
      length = left;  // RTPS 2.5, 9.4.5.1.3: it extends to the end
    }
    out.last = length == left;
    if (length > left || (length % 4 != 0 && !out.last)) return false;
    out.body = datagram_.subspan(out.offset, length);
    position_ = out.offset + length;
    return true;
  }

 private:
  ByteView datagram_;
  std::size_t position_ = kHeaderSize;
};

/// @return whether the entity is a built-in one, such as those of discovery (RTPS 2.5, 9.3.1.2).
constexpr bool is_built_in(EntityId entity) noexcept {
  constexpr EntityId kBuiltIn = 0xC0;
  return (entity & kBuiltIn) == kBuiltIn;
}

/// A HEARTBEAT submessage (RTPS 2.5, 9.4.5).
struct Heartbeat {
  EntityId reader = kUnknownEntity;
  EntityId writer = kUnknownEntity;
  std::int64_t first = 0;
  std::int64_t last = 0;  ///< first - 1 if there is none
  std::uint32_t count = 0;
};

/// @return nothing for any other submessage, or one that is too short.
[[nodiscard]] inline std::optional<Heartbeat> parse_heartbeat(
    const Submessage& submessage) noexcept {
  if (submessage.kind != SubmessageKind::heartbeat) return std::nullopt;
  ByteReader bytes = submessage.reader();
  Heartbeat heartbeat;
  heartbeat.reader = bytes.entity();
  heartbeat.writer = bytes.entity();
  heartbeat.first = bytes.sequence();
  heartbeat.last = bytes.sequence();
  heartbeat.count = bytes.u32();
  return bytes.ok() ? std::optional(heartbeat) : std::nullopt;
}

/// An ACKNACK submessage (RTPS 2.5, 9.4.5) without the set of missing numbers.
struct Acknack {
  EntityId reader = kUnknownEntity;
  EntityId writer = kUnknownEntity;
  std::int64_t base = 0;  ///< all numbers before it are acknowledged; 0 requests a first heartbeat
  std::uint32_t count = 0;
};

/// @return nothing for any other submessage, or one that is too short.
[[nodiscard]] inline std::optional<Acknack> parse_acknack(const Submessage& submessage) noexcept {
  if (submessage.kind != SubmessageKind::acknack) return std::nullopt;
  constexpr std::size_t kBitsOfWord = 32;
  ByteReader bytes = submessage.reader();
  Acknack acknack;
  acknack.reader = bytes.entity();
  acknack.writer = bytes.entity();
  acknack.base = bytes.sequence();
  const std::size_t bits = bytes.u32();
  bytes.skip((bits + kBitsOfWord - 1) / kBitsOfWord * sizeof(std::uint32_t));
  acknack.count = bytes.u32();
  return bytes.ok() ? std::optional(acknack) : std::nullopt;
}

/// A parameter of a list.
struct ListEntry {
  std::uint16_t id = 0;
  std::size_t offset = 0;  ///< of the id in the list
  ByteView value;
};

/// Iterates over a parameter list up to its sentinel.
class ParameterList {
 public:
  ParameterList(ByteView bytes, bool little) noexcept : bytes_(bytes), little_(little) {}

  /// @return whether there is another parameter; false at the sentinel or if the list is malformed
  [[nodiscard]] bool next(ListEntry& out) noexcept {
    ByteReader reader(bytes_.subspan(position_), little_);
    out.id = reader.u16();
    const std::size_t length = reader.u16();
    if (!reader.ok()) return false;
    if (out.id == kSentinel) {
      ended_ = true;
      position_ += 4;
      return false;
    }
    const std::size_t aligned = (length + 3) & ~std::size_t{3};
    if (aligned > reader.left()) return false;
    out.offset = position_;
    out.value = bytes_.subspan(position_ + 4, length);
    position_ += 4 + aligned;
    return true;
  }

  /// @return whether the sentinel was reached.
  [[nodiscard]] bool ended() const noexcept { return ended_; }

  /// @return number of bytes read, including the sentinel once it was reached.
  [[nodiscard]] std::size_t size() const noexcept { return position_; }

 private:
  ByteView bytes_;
  std::size_t position_ = 0;
  bool little_;
  bool ended_ = false;
};

/// A DATA submessage.
struct DataSubmessage {
  std::uint32_t reader = 0;
  std::uint32_t writer = 0;
  std::int64_t sequence = 0;
  ByteView inline_qos;      ///< with its sentinel; empty if there is none
  std::size_t payload = 0;  ///< offset in the body
  ByteView content;         ///< the payload
  bool whole = false;       ///< every part is inside the body

  /// @return whether the payload is a list of parameters (PL_CDR), in either byte order.
  [[nodiscard]] bool is_list() const noexcept {
    return content.size() >= 4 && content[0] == 0 && (content[1] == 2 || content[1] == 3);
  }

  [[nodiscard]] bool list_is_little() const noexcept { return content[1] == 3; }

  [[nodiscard]] ByteView list() const noexcept { return content.subspan(4); }
};

/// Size of a DATA before its lists [bytes] (RTPS 9.4.5.3)
inline constexpr std::size_t kDataFixed = 16;

/// @param fixed number of bytes after octetsToInlineQos up to the inline QoS: 16 for DATA, 28 for
///        DATA_FRAG
[[nodiscard]] DataSubmessage parse_data(const Submessage& submessage, std::size_t fixed) noexcept;

/// @return whether the library may treat the DATA as the announcement of a participant.
[[nodiscard]] bool may_announce(const Submessage& submessage, const DataSubmessage& data) noexcept;

/// @return whether the library may treat the DATA as discovery; its content has then passed the
///         check. Other content belongs to a program and must not be changed.
[[nodiscard]] bool is_discovery(const Submessage& submessage, const DataSubmessage& data) noexcept;

/// @param datagram the one that contains `submessage`, or a copy of it
/// @return the bytes of data.list() in `datagram`; requires data.is_list().
[[nodiscard]] std::span<std::uint8_t> list_in(std::span<std::uint8_t> datagram,
                                              const Submessage& submessage,
                                              const DataSubmessage& data) noexcept;

}  // namespace vdrive::wire
