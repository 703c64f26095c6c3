// SPDX-License-Identifier: Apache-2.0
// The guard's check of the parts of DDS Security that are sent in clear, without a network: one row
// for each field in docs/explanation/guard.md.
#include "guard/datagram_check.hpp"
#include "wire/datagrams.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

namespace vdrive::wire {
namespace {

using test::Body;
using test::data_to;
using test::Datagram;
using test::DatagramWriter;

constexpr test::GuidPrefix kMember{1, 15, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11};
constexpr std::uint8_t kLittleData = 5;
constexpr std::uint8_t kLittleDataInlineQos = 7;
constexpr std::uint32_t kHandshakeWriter = 0x000201C3;
constexpr std::uint32_t kHandshakeReader = 0x000201C4;
constexpr std::uint32_t kReaderOfUser = 0x00000104;
constexpr std::uint32_t kWriterOfUser = 0x00000203;

struct SecureCase {
  const char* name;
  Refusal expected;
  std::function<Datagram()> make;
  Mode mode = Mode::open;
};

/// The parts of an encrypted message, as the library sends them unless a test changes one.
struct Encrypted {
  Datagram prefix = Datagram(20, 0xAA);
  Datagram body = Body().entity(5).raw(Datagram(8, 0xBB)).bytes();  // 5 bytes and 3 of padding
  Datagram postfix = Datagram(20);
  std::uint8_t endianness = 1;

  /// A complete message.
  [[nodiscard]] DatagramWriter message() const {
    DatagramWriter writer(kMember);
    add(writer, {0x33, 0x30, 0x34});
    return writer;
  }

  /// A submessage after INFO_DST, as in the exchange of keys.
  [[nodiscard]] DatagramWriter submessage() const {
    DatagramWriter writer(kMember);
    writer.add(0x0E, 1, Datagram(12));
    add(writer, {0x31, 0x30, 0x32});
    return writer;
  }

  void add(DatagramWriter& writer, std::initializer_list<std::uint8_t> kinds) const {
    for (const std::uint8_t kind : kinds) {
      const bool is_body = kind == 0x30;
      const bool is_prefix = kind == 0x31 || kind == 0x33;
      writer.add(kind, endianness, is_body ? body : is_prefix ? prefix : postfix);
    }
  }
};

/// @return submessages of these kinds, with the parts of Encrypted.
Datagram in_order(std::initializer_list<std::uint8_t> kinds) {
  DatagramWriter writer(kMember);
  Encrypted().add(writer, kinds);
  return writer.bytes();
}

Datagram body_of(std::uint32_t claimed, std::size_t bytes) {
  return Encrypted{.body = Body().entity(claimed).raw(Datagram(bytes)).bytes()}.message().bytes();
}

Datagram postfix_of(std::uint32_t claimed, std::size_t macs) {
  return Encrypted{.postfix =
                       Body().raw(Datagram(16)).entity(claimed).raw(Datagram(20 * macs)).bytes()}
      .message()
      .bytes();
}

Body& text(Body& body, const std::string& letters) {
  body.u32(static_cast<std::uint32_t>(letters.size() + 1)).raw({letters.begin(), letters.end()});
  return body.raw(Datagram(4 - letters.size() % 4));
}

/// @return a DataHolder with one text property and one binary property.
Body token(const std::string& name, const Datagram& bytes) {
  Body body;
  text(body, "DDS:Auth:PKI-DH:1.0+Req").u32(1);
  text(text(body, "dds.cert.algo"), "EC-prime256v1").u32(1);
  Datagram filled = bytes;
  filled.resize((bytes.size() + 3) / 4 * 4);
  return text(body, name).u32(static_cast<std::uint32_t>(bytes.size())).raw(filled);
}

Datagram announcement_of(const Datagram& identity_token) {
  Body body = data_to(test::kParticipantsReader, test::kParticipantsWriter, 1);
  body.raw({0, 3, 0, 0}).parameter(0x50, test::guid_of(kMember));
  body.parameter(0x02, Body().u32(20).u32(0).bytes()).parameter(0x1001, identity_token).u32(1);
  return DatagramWriter(kMember).add(0x15, kLittleData, body.bytes()).bytes();
}

/// @param tokens the number of tokens, then the tokens of the message
Datagram handshake_of(const Datagram& tokens, std::uint32_t reader = kHandshakeReader,
                      std::uint32_t writer = kHandshakeWriter) {
  Body body = data_to(reader, writer, 1);
  text(body.raw({0, 1, 0, 0}).raw(Datagram(96)), "dds.sec.auth").raw(tokens);
  return DatagramWriter(kMember).add(0x15, kLittleData, body.bytes()).bytes();
}

Datagram handshake_with(const Body& its_token) {
  return handshake_of(Body().u32(1).raw(its_token.bytes()).bytes());
}

/// Replaces the first number that equals `from` with `to`.
Datagram with_number(Datagram datagram, std::uint32_t from, std::uint32_t to) {
  const Datagram old_bytes = Body().u32(from).bytes();
  const Datagram new_bytes = Body().u32(to).bytes();
  const auto place =
      std::search(datagram.begin() + 20, datagram.end(), old_bytes.begin(), old_bytes.end());
  EXPECT_NE(place, datagram.end()) << "no " << from;
  if (place != datagram.end()) std::copy(new_bytes.begin(), new_bytes.end(), place);
  return datagram;
}

std::vector<SecureCase> encrypted_cases() {
  return {
      {"EncryptedMessage", Refusal::none,
       [] {
         return Encrypted().message().bytes();
       }},
      {"EncryptedSubmessage", Refusal::none,
       [] {
         return Encrypted().submessage().bytes();
       }},
      {"EncryptedMessageOfABigEndianSender", Refusal::none,
       [] {
         Datagram datagram = Encrypted().message().bytes();
         for (const std::size_t part : {20U, 44U, 60U}) {
           datagram[part + 1] = 0;
           std::swap(datagram[part + 2], datagram[part + 3]);
         }
         return datagram;
       }},
      {"PrefixTooShort", Refusal::security,
       [] {
         return Encrypted{.prefix = Datagram(16)}.message().bytes();
       }},
      {"PrefixTooLong", Refusal::security,
       [] {
         return Encrypted{.prefix = Datagram(24)}.submessage().bytes();
       }},
      {"BodyOfNothing", Refusal::none,
       [] {
         return body_of(0, 0);
       }},
      {"BodyThatNeedsNoFilling", Refusal::none,
       [] {
         return body_of(8, 8);
       }},
      {"BodyOf4GiB", Refusal::security,
       [] {
         return body_of(0xFFFFFFFF, 64);
       }},
      {"BodyWhoseLengthWrapsToItsOwn", Refusal::security,
       [] {
         return body_of(0xFFFFFFFD, 0);
       }},
      {"BodyOneByteLongerThanWhatArrived", Refusal::security,
       [] {
         return body_of(65, 64);
       }},
      {"BodyWithFourBytesToFillUp", Refusal::security,
       [] {
         return body_of(60, 64);
       }},
      {"BodyLittleEndian", Refusal::security,
       [] {
         return body_of(0x40000000, 64);
       }},
      {"BodyWithoutItsLength", Refusal::length,
       [] {
         return Encrypted{.body = Datagram(2)}.message().bytes();
       }},
      {"PostfixForTwoReceivers", Refusal::none,
       [] {
         return postfix_of(2, 2);
       }},
      {"PostfixOfMoreThanItHas", Refusal::security,
       [] {
         return postfix_of(3, 2);
       }},
      {"PostfixOfLessThanItHas", Refusal::security,
       [] {
         return postfix_of(1, 2);
       }},
      {"PostfixWhoseLengthWraps", Refusal::security,
       [] {
         return postfix_of(0x0CCCCCCD, 0);
       }},
      {"PostfixTooShort", Refusal::security,
       [] {
         return Encrypted{.postfix = Datagram(16)}.message().bytes();
       }},
  };
}

std::vector<SecureCase> order_cases() {
  const auto no_length = [](std::initializer_list<std::uint8_t> kinds, std::size_t part) {
    Datagram datagram = in_order(kinds);
    datagram[part + 2] = datagram[part + 3] = 0;
    return datagram;
  };
  return {
      {"PrefixAlone", Refusal::security,
       [] {
         return in_order({0x33});
       }},
      {"MessageWithoutPostfix", Refusal::security,
       [] {
         return in_order({0x33, 0x30});
       }},
      {"MessageWithoutBody", Refusal::security,
       [] {
         return in_order({0x33, 0x34});
       }},
      {"BodyAlone", Refusal::security,
       [] {
         return in_order({0x30});
       }},
      {"PostfixAlone", Refusal::security,
       [] {
         return in_order({0x32});
       }},
      {"SubmessageWithThePostfixOfAMessage", Refusal::security,
       [] {
         return in_order({0x31, 0x30, 0x34});
       }},
      {"MessageWithThePostfixOfASubmessage", Refusal::security,
       [] {
         return in_order({0x33, 0x30, 0x32});
       }},
      {"TwoBodies", Refusal::security,
       [] {
         return in_order({0x31, 0x30, 0x30, 0x32});
       }},
      {"TwoSubmessages", Refusal::none,
       [] {
         return in_order({0x31, 0x30, 0x32, 0x31, 0x30, 0x32});
       }},
      {"SignedSubmessage", Refusal::security,
       [] {
         return DatagramWriter(kMember)
             .add(0x31, 1, Datagram(20))
             .add(0x0E, 1, Datagram(12))
             .add(0x32, 1, Datagram(20))
             .bytes();
       }},
      {"MessageBehindInfo", Refusal::security,
       [] {
         DatagramWriter writer(kMember);
         writer.add(0x0E, 1, Datagram(12));
         Encrypted().add(writer, {0x33, 0x30, 0x34});
         return writer.bytes();
       }},
      {"MessageWithMoreBehind", Refusal::security,
       [] {
         return Encrypted().message().add(0x0E, 1, Datagram(12)).bytes();
       }},
      {"MessageWithStatisticsBehind", Refusal::none,
       [] {
         return Encrypted().message().add(0x80, 1, Datagram(56)).bytes();
       }},
      {"PrefixWithStatisticsBehind", Refusal::security,
       [] {
         DatagramWriter writer(kMember);
         Encrypted().add(writer, {0x33});
         return writer.add(0x80, 1, Datagram(56)).bytes();
       }},
      {"PrefixToTheEnd", Refusal::length,
       [=] {
         return no_length({0x33, 0x30, 0x34}, 20);
       }},
      {"BodyToTheEnd", Refusal::length,
       [=] {
         return no_length({0x33, 0x30, 0x34}, 44);
       }},
      {"PostfixToTheEnd", Refusal::length,
       [=] {
         return no_length({0x33, 0x30, 0x34}, 60);
       }},
      {"PostfixOfASubmessageToTheEnd", Refusal::length,
       [=] {
         return no_length({0x31, 0x30, 0x32}, 60);
       }},
  };
}

std::vector<SecureCase> token_cases() {
  const Datagram some(40, 0xCC);
  const auto identity = [=] {
    return announcement_of(token("dds.ca.sn", some).bytes());
  };
  const auto request = [=] {
    return handshake_with(token("c.id", some));
  };
  const auto with_participant = [](const Datagram& list) {
    return handshake_with(token("c.pdata", list));
  };
  const Datagram last = {0x00, 0x01, 0x00, 0x00};  // a sentinel, big-endian
  return {
      {"Token", Refusal::none, identity},
      {"TokenOfATextTooLong", Refusal::parameters,
       [=] {
         return with_number(identity(), 24, 0xFFFFFFFF);
       }},
      {"TokenOf4GigaProperties", Refusal::parameters,
       [=] {
         return with_number(identity(), 14, 0xFFFFFFFF);
       }},
      {"TokenWithBytesTooLong", Refusal::parameters,
       [=] {
         return with_number(identity(), 40, 44);
       }},
      {"TokenWithBytesThatWrap", Refusal::parameters,
       [=] {
         return with_number(identity(), 40, 0xFFFFFFF0);
       }},
      {"TokenWithMoreBehind", Refusal::parameters,
       [=] {
         return announcement_of(token("dds.ca.sn", some).u32(0).bytes());
       }},
      {"TokenOfManyProperties", Refusal::parameters,
       [] {
         return announcement_of(Body().u32(1).u32(0).u32(0x01000000).u32(0).bytes());
       }},
      {"TokenOfManyBytes", Refusal::parameters,
       [] {
         return announcement_of(Body().u32(1).u32(0).u32(0).u32(0x01000000).bytes());
       }},
      {"EmptyToken", Refusal::none,
       [] {
         return announcement_of(Body().u32(1).u32(0).u32(0).u32(0).bytes());
       }},
      {"Handshake", Refusal::none, request},
      {"HandshakeWithoutTokens", Refusal::none,
       [] {
         return handshake_of(Body().u32(0).bytes());
       }},
      {"HandshakeWhoseLastBytesAreNotFilledUp", Refusal::none,
       [] {
         Datagram last_token = Body().u32(1).u32(1).u32(0).u32(0).u32(1).u32(1).u32(0).bytes();
         const Datagram value = Body().u32(2).raw({1, 2}).bytes();
         last_token.insert(last_token.end(), value.begin(), value.end());
         return handshake_of(last_token);
       }},
      {"HandshakeOf4GigaTokens", Refusal::handshake,
       [] {
         return handshake_of(Body().u32(0xFFFFFFFF).bytes());
       }},
      {"HandshakeOfOneTokenTooMany", Refusal::handshake,
       [=] {
         return handshake_of(Body().u32(2).raw(token("c.id", some).bytes()).bytes());
       }},
      {"HandshakeOfATextTooLong", Refusal::handshake,
       [=] {
         return with_number(request(), 13, 0xFFFFFFFF);
       }},
      {"HandshakeOfAPropertyTooLong", Refusal::handshake,
       [=] {
         return with_number(request(), 14, 0xFFFFFF00);
       }},
      {"HandshakeWithBytesTooLong", Refusal::handshake,
       [=] {
         return with_number(request(), 40, 44);
       }},
      {"HandshakeWithBytesThatWrap", Refusal::handshake,
       [=] {
         return with_number(request(), 40, 0xFFFFFF80);
       }},
      {"HandshakeWithoutItsGuids", Refusal::handshake,
       [] {
         Body body = data_to(kHandshakeReader, kHandshakeWriter, 1);
         body.raw({0, 1, 0, 0}).raw(Datagram(92));
         return DatagramWriter(kMember).add(0x15, kLittleData, body.bytes()).bytes();
       }},
      {"HandshakeThatIsAList", Refusal::handshake,
       [] {
         Body body = data_to(kHandshakeReader, kHandshakeWriter, 1);
         body.raw({0, 3, 0, 0}).raw(Datagram(200));
         return DatagramWriter(kMember).add(0x15, kLittleData, body.bytes()).bytes();
       }},
      {"HandshakeWithAParticipant", Refusal::none,
       [=] {
         return with_participant(last);
       }},
      {"HandshakeWithAParticipantThatDoesNotEnd", Refusal::handshake,
       [=] {
         return with_participant({0x00, 0x50, 0x01, 0x00});
       }},
      {"HandshakeWithAParticipantWhoseTokenIsTooLong", Refusal::handshake,
       [=] {
         Datagram list{0x10, 0x01, 0x00, 0x08, 0xFF, 0xFF, 0xFF, 0xFF, 0, 0, 0, 0};
         list.insert(list.end(), last.begin(), last.end());
         return with_participant(list);
       }},
      {"HandshakeInPieces", Refusal::handshake,
       [] {
         Body body = data_to(kHandshakeReader, kHandshakeWriter, 1, 28);
         body.u32(1).u16(1).u16(1024).u32(3000).raw(Datagram(1024));
         return DatagramWriter(kMember).add(0x16, 1, body.bytes()).bytes();
       }},
  };
}

std::vector<SecureCase> clear_cases() {
  const auto info = [](std::uint8_t kind, std::size_t size) {
    return DatagramWriter(kMember).add(kind, 1, Datagram(size)).bytes();
  };
  const auto of_key = [](const Datagram& transform) {
    Datagram prefix = transform;
    prefix.resize(20);
    return Encrypted{.prefix = prefix}.submessage().bytes();
  };
  const auto to = [](std::uint32_t reader, std::uint32_t writer) {
    Body body = data_to(reader, writer, 1);
    return DatagramWriter(kMember)
        .add(0x15, kLittleData, body.raw({0, 3, 0, 0}).u32(1).bytes())
        .bytes();
  };
  const auto of_a_set = [](std::uint8_t kind, const Body& body) {
    return DatagramWriter(kMember).add(kind, 1, body.bytes()).bytes();
  };
  const auto closed = Mode::closed;
  return {
      {"InfoTime", Refusal::none,
       [=] {
         return info(0x09, 8);
       },
       closed},
      {"InfoSource", Refusal::none,
       [=] {
         return info(0x0C, 20);
       },
       closed},
      {"InfoDestination", Refusal::none,
       [=] {
         return info(0x0E, 12);
       },
       closed},
      {"InfoReply", Refusal::none,
       [=] {
         return info(0x0F, 4);
       },
       closed},
      {"EncryptedMessage", Refusal::none,
       [] {
         return Encrypted().message().bytes();
       },
       closed},
      {"ExchangeOfKeys", Refusal::none,
       [=] {
         return of_key({0, 0, 0, 4});
       },
       closed},
      {"EncryptedWithTheKeyOfAnEndpoint", Refusal::unprotected,
       [=] {
         return of_key({0, 0, 0, 4, 0, 0, 0, 1});
       },
       closed},
      {"SignedInPlaceOfEncrypted", Refusal::unprotected,
       [=] {
         return of_key({0, 0, 0, 3});
       },
       closed},
      {"Announcement", Refusal::none,
       [] {
         return DatagramWriter(kMember)
             .add(0x15, kLittleData, test::announcement(kMember, "some name", 20).bytes())
             .bytes();
       },
       closed},
      {"AnnouncementForAnyReader", Refusal::none,
       [=] {
         return to(0, test::kParticipantsWriter);
       },
       closed},
      {"AnnouncementForAnotherReader", Refusal::unprotected,
       [=] {
         return to(kReaderOfUser, test::kParticipantsWriter);
       },
       closed},
      {"AnnouncementOfAnotherWriter", Refusal::unprotected,
       [=] {
         return to(test::kParticipantsReader, kWriterOfUser);
       },
       closed},
      {"AnnouncementOfAnEndpoint", Refusal::unprotected,
       [=] {
         return to(test::kPublicationsReader, test::kPublicationsWriter);
       },
       closed},
      {"Handshake", Refusal::none,
       [] {
         return handshake_of(Body().u32(0).bytes());
       },
       closed},
      {"HandshakeForAnotherReader", Refusal::unprotected,
       [] {
         return handshake_of(Body().u32(0).bytes(), kReaderOfUser);
       },
       closed},
      {"HandshakeOfAnotherWriter", Refusal::unprotected,
       [] {
         return handshake_of(Body().u32(0).bytes(), kHandshakeReader, kWriterOfUser);
       },
       closed},
      {"Data", Refusal::unprotected,
       [=] {
         return to(kReaderOfUser, kWriterOfUser);
       },
       closed},
      {"DataForAnyReader", Refusal::unprotected,
       [=] {
         return to(0, kWriterOfUser);
       },
       closed},
      {"DataWithInlineQos", Refusal::unprotected,
       [] {
         Body body = data_to(kReaderOfUser, kWriterOfUser, 1);
         body.parameter(0x71, {0, 0, 0, 3}).u32(1).raw({0, 1, 0, 0}).u32(0);
         return DatagramWriter(kMember).add(0x15, kLittleDataInlineQos, body.bytes()).bytes();
       },
       closed},
      {"Fragment", Refusal::unprotected,
       [] {
         Body body = data_to(kReaderOfUser, kWriterOfUser, 1, 28);
         body.u32(1).u16(1).u16(1024).u32(3000).raw(Datagram(1024));
         return DatagramWriter(kMember).add(0x16, 1, body.bytes()).bytes();
       },
       closed},
      {"Heartbeat", Refusal::unprotected,
       [=] {
         return of_a_set(0x07, Body().entity(1).entity(2).sequence(1).sequence(1).u32(1));
       },
       closed},
      {"Acknack", Refusal::unprotected,
       [=] {
         return of_a_set(0x06, Body().entity(1).entity(2).sequence(1).u32(0).u32(1));
       },
       closed},
      {"Gap", Refusal::unprotected,
       [=] {
         return of_a_set(0x08, test::gap(1, 2, 1, 2));
       },
       closed},
      {"HeartbeatOfTheExchangeOfKeys", Refusal::unprotected,
       [=] {
         return of_a_set(
             0x07, Body().entity(0xFF0202C4).entity(0xFF0202C3).sequence(1).sequence(1).u32(1));
       },
       closed},
      {"Pad", Refusal::unprotected,
       [=] {
         return info(0x01, 4);
       },
       closed},
      {"OfAnotherVendor", Refusal::unprotected,
       [=] {
         return info(0x81, 4);
       },
       closed},
  };
}

class SecureDatagram : public testing::TestWithParam<SecureCase> {};

TEST_P(SecureDatagram, IsAcceptedOrRefusedByItsBytes) {
  const Datagram datagram = GetParam().make();
  EXPECT_EQ(describe(check_datagram(datagram, GetParam().mode).refusal),
            describe(GetParam().expected));
}

constexpr auto kNameOfCase = [](const auto& row) {
  return std::string(row.param.name);
};
INSTANTIATE_TEST_SUITE_P(Encrypted, SecureDatagram, testing::ValuesIn(encrypted_cases()),
                         kNameOfCase);
INSTANTIATE_TEST_SUITE_P(Order, SecureDatagram, testing::ValuesIn(order_cases()), kNameOfCase);
INSTANTIATE_TEST_SUITE_P(Token, SecureDatagram, testing::ValuesIn(token_cases()), kNameOfCase);
INSTANTIATE_TEST_SUITE_P(ClosedMode, SecureDatagram, testing::ValuesIn(clear_cases()), kNameOfCase);

TEST(SecureDatagramCheck, SurvivesEveryTruncation) {
  for (const auto& rows : {encrypted_cases(), order_cases(), token_cases(), clear_cases()}) {
    for (const auto& row : rows) {
      const Datagram whole = row.make();
      for (std::size_t size = 0; size < whole.size(); ++size) {
        // On the heap and exactly this long, so that a sanitizer detects any access beyond it.
        const Datagram part(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
        static_cast<void>(check_datagram(part, row.mode));
      }
    }
  }
}

}  // namespace
}  // namespace vdrive::wire
