// SPDX-License-Identifier: Apache-2.0
#include "security_check.hpp"

#include "datagram_check.hpp"

#include <algorithm>
#include <array>
#include <string_view>

namespace vdrive::wire {
namespace {

constexpr std::size_t kSecurePrefix = 20;   ///< [bytes] transform, key, session and nonce
constexpr std::size_t kSecurePostfix = 20;  ///< [bytes] common MAC and number of receiver MACs
constexpr std::size_t kReceiverMac = 20;    ///< [bytes] each receiver MAC: key and MAC

/// The length of the encrypted part is big endian, whatever the flag says. The library compares it
/// in 32 bits with its buffer, but not with the data that has arrived.
bool is_secure_body(ByteView body) {
  ByteReader reader(body, false);
  const std::uint64_t length = reader.u32_big();
  return reader.ok() && body.size() == ((4 + length + 3) & ~std::uint64_t{3});
}

bool is_secure_postfix(ByteView body) {
  ByteReader reader(body, false);
  reader.skip(kSecurePostfix - 4);
  const std::uint64_t others = reader.u32_big();
  return reader.ok() && body.size() == kSecurePostfix + others * kReceiverMac;
}

bool has_its_length(const Submessage& submessage) {
  switch (submessage.kind) {
    case SubmessageKind::sec_body:
      return is_secure_body(submessage.body);
    case SubmessageKind::sec_postfix:
    case SubmessageKind::srtps_postfix:
      return is_secure_postfix(submessage.body);
    default:
      return submessage.body.size() == kSecurePrefix;
  }
}

/// The key exchange uses AES-256-GCM and key 0, so its prefix starts with these eight bytes. Any
/// other key belongs to an endpoint whose messages are encrypted completely.
bool is_of_key_exchange(ByteView prefix) {
  constexpr std::array<std::uint8_t, 8> kTransform{0, 0, 0, 4, 0, 0, 0, 0};
  return prefix.size() >= kTransform.size() &&
         std::equal(kTransform.begin(), kTransform.end(), prefix.begin());
}

/// Parses the types of DDS Security, 7.2: strings, properties and the tokens composed of them.
class TokenReader {
 public:
  TokenReader(ByteView bytes, bool little) noexcept : input_(bytes, little) {}

  [[nodiscard]] bool at_end() const noexcept { return input_.left() == 0; }

  [[nodiscard]] bool skip(std::size_t count) noexcept {
    input_.skip(count);
    return input_.ok();
  }

  /// A string or byte sequence: its length, then that many bytes, padded to four.
  [[nodiscard]] bool field(ByteView& out) noexcept {
    const std::uint32_t length = input_.u32();
    if (!input_.ok() || length > input_.left()) return false;
    out = input_.bytes(length);
    // The last one is not padded.
    input_.skip(std::min<std::size_t>(input_.left(), (4 - input_.position() % 4) % 4));
    return true;
  }

  /// @param take called with name and value of each element
  /// @return whether all elements were complete.
  template <typename Take>
  [[nodiscard]] bool pairs(const Take& take) noexcept {
    const std::uint32_t count = input_.u32();
    for (std::uint32_t index = 0; input_.ok() && index < count; ++index) {
      ByteView name;
      ByteView value;
      if (!field(name) || !field(value) || !take(name, value)) return false;
    }
    return input_.ok();
  }

  /// @param take as in pairs(), for the binary properties
  template <typename Take>
  [[nodiscard]] bool token(const Take& take) noexcept {
    ByteView class_id;
    return field(class_id) && pairs([](ByteView, ByteView) {
             return true;
           }) &&
           pairs(take);
  }

  template <typename Take>
  [[nodiscard]] bool tokens(const Take& take) noexcept {
    const std::uint32_t count = input_.u32();
    for (std::uint32_t index = 0; input_.ok() && index < count; ++index) {
      if (!token(take)) return false;
    }
    return input_.ok();
  }

 private:
  ByteReader input_;
};

/// @return whether the property is the participant data, which the library reads as an
///         announcement.
bool is_participant_data(ByteView name) {
  constexpr std::string_view kName = "c.pdata";
  return name.size() > kName.size() &&
         std::equal(kName.begin(), kName.end(), name.begin(), [](char letter, std::uint8_t byte) {
           return static_cast<std::uint8_t>(letter) == byte;
         });
}

/// That announcement is a big-endian list without the four-byte encapsulation.
bool is_handshake_property(ByteView name, ByteView value) {
  return !is_participant_data(name) || check_list(value, false) == Refusal::none;
}

}  // namespace

Refusal SecureOrder::begin(const Submessage& submessage) noexcept {
  if (ended_) return Refusal::security;
  switch (submessage.kind) {
    case SubmessageKind::srtps_prefix:
      of_message_ = true;
      expected_ = static_cast<std::uint8_t>(SubmessageKind::sec_body);
      return submessage.offset == kHeaderSize + kSubmessageHeaderSize ? Refusal::none
                                                                      : Refusal::security;
    case SubmessageKind::sec_prefix:
      expected_ = static_cast<std::uint8_t>(SubmessageKind::sec_body);
      return Refusal::none;
    default:
      return Refusal::security;
  }
}

Refusal SecureOrder::next_part(const Submessage& submessage) noexcept {
  if (!is_secure(submessage.kind) || !has_its_length(submessage)) return Refusal::security;
  if (expected_ == 0) return begin(submessage);
  if (static_cast<std::uint8_t>(submessage.kind) != expected_) return Refusal::security;
  if (submessage.kind == SubmessageKind::sec_body) {
    expected_ = static_cast<std::uint8_t>(of_message_ ? SubmessageKind::srtps_postfix
                                                      : SubmessageKind::sec_postfix);
  } else {
    expected_ = 0;
    ended_ = of_message_;
  }
  return Refusal::none;
}

bool may_be_in_clear(const Submessage& submessage) noexcept {
  switch (submessage.kind) {
    case SubmessageKind::info_ts:
    case SubmessageKind::info_src:
    case SubmessageKind::info_reply_ip4:
    case SubmessageKind::info_dst:
    case SubmessageKind::info_reply:
    case SubmessageKind::sec_body:
    case SubmessageKind::sec_postfix:
    case SubmessageKind::srtps_prefix:
    case SubmessageKind::srtps_postfix:
      return true;
    case SubmessageKind::sec_prefix:
      return is_of_key_exchange(submessage.body);
    case SubmessageKind::data: {
      const DataSubmessage data = parse_data(submessage, kDataFixed);
      return (data.writer == kParticipantsWriter &&
              (data.reader == kParticipantsReader || data.reader == kUnknownEntity)) ||
             (data.writer == kHandshakeWriter && data.reader == kHandshakeReader);
    }
    default:
      return false;
  }
}

bool is_token(ByteView value, bool little) noexcept {
  TokenReader reader(value, little);
  return reader.token([](ByteView, ByteView) {
    return true;
  }) && reader.at_end();
}

bool is_handshake(const Submessage& submessage, const DataSubmessage& data) noexcept {
  // [bytes] Two message identities, a participant and two endpoints.
  constexpr std::size_t kGuids = 2 * 24 + 3 * 16;
  const ByteView content = data.content;
  if (!submessage.has(kThird) || content.size() < kEncapsulationSize || content[0] != 0 ||
      content[1] > 1) {
    return false;
  }
  TokenReader reader(content, content[1] == 1);
  ByteView class_id;
  return reader.skip(kEncapsulationSize + kGuids) && reader.field(class_id) &&
         reader.tokens(is_handshake_property);
}

}  // namespace vdrive::wire
