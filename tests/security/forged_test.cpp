// SPDX-License-Identifier: Apache-2.0
// Datagrams that a program without credentials sends to a closed bench and its clients, with
// lengths, counts and contents that the library trusts before it has authenticated anything.
#include "security/material.hpp"
#include "service/probe.hpp"
#include "support/test_domain.hpp"
#include "tool/process.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/subscription.hpp"
#include "vdrive_messages.hpp"
#include "wire/attacker.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace vdrive::test {
namespace {

using namespace std::chrono_literals;

namespace fs = std::filesystem;

constexpr std::uint8_t kLittle = 1;
constexpr std::uint8_t kWithData = 5;
constexpr std::uint32_t kHandshakeWriter = 0x000201C3;
constexpr std::uint32_t kHandshakeReader = 0x000201C4;
/// Higher than any number that a participant has sent, because a reader accepts nothing older.
constexpr std::int64_t kNewest = 1'000'000;

/// @return a message that claims to be encrypted by `sender`. The library looks up the keys by the
///         sender's prefix alone, and decrypts before it checks the tag.
Datagram encrypted(const GuidPrefix& sender, const Datagram& body, const Datagram& postfix) {
  return DatagramWriter(sender)
      .add(0x33, kLittle, Datagram(20))
      .add(0x30, kLittle, body)
      .add(0x34, kLittle, postfix)
      .bytes();
}

Datagram encrypted_of_length(const GuidPrefix& sender, std::uint32_t claimed) {
  return encrypted(sender, Body().entity(claimed).raw(Datagram(64)).bytes(), Datagram(20));
}

/// @return a handshake message with these bytes after its GUIDs.
Datagram handshake(const GuidPrefix& sender, const Datagram& behind_the_guids) {
  Body body = data_to(kHandshakeReader, kHandshakeWriter, kNewest);
  body.raw({0, 1, 0, 0}).raw(Datagram(96)).raw(behind_the_guids);
  return DatagramWriter(sender).add(0x15, kWithData, body.bytes()).bytes();
}

/// @return an announcement of `sender` with a token of this content.
Datagram announcement_with_token(const GuidPrefix& sender, const Datagram& content) {
  Body body = data_to(kParticipantsReader, kParticipantsWriter, kNewest);
  body.raw({0, 3, 0, 0}).parameter(0x50, guid_of(sender));
  body.parameter(0x02, Body().u32(20).u32(0).bytes()).parameter(0x1001, content).u32(1);
  return DatagramWriter(sender).add(0x15, kWithData, body.bytes()).bytes();
}

struct Forgery {
  const char* name;
  std::function<Datagram(const GuidPrefix& sender)> make;
};

std::vector<Forgery> forgeries() {
  return {
      {"AnEncryptedBodyOf4GiB",
       [](const GuidPrefix& sender) {
         return encrypted_of_length(sender, 0xFFFFFFFF);
       }},
      {"AnEncryptedBodyLongerThanItsDatagram",
       [](const GuidPrefix& sender) {
         return encrypted_of_length(sender, 60'000);
       }},
      {"AnEncryptedBodyWithoutLengthToTheEnd",
       [](const GuidPrefix& sender) {
         return DatagramWriter(sender)
             .add(0x33, kLittle, Datagram(20))
             .add(0x30, kLittle, Body().entity(0xFFFFFFFF).bytes(), 0)
             .bytes();
       }},
      {"AnEncryptedSubmessageOf4GiB",
       [](const GuidPrefix& sender) {
         return DatagramWriter(sender)
             .add(0x31, kLittle, Body().entity(4).raw(Datagram(16)).bytes())
             .add(0x30, kLittle, Body().entity(0xFFFFFFFF).raw(Datagram(64)).bytes())
             .add(0x32, kLittle, Datagram(20))
             .bytes();
       }},
      {"AHandshakeOf4GiBOfText",
       [](const GuidPrefix& sender) {
         return handshake(sender, Body().u32(0xFFFFFFFF).u32(0).bytes());
       }},
      {"AHandshakeOf4GigaParts",
       [](const GuidPrefix& sender) {
         return handshake(sender, Body().u32(1).u32(0).u32(0xFFFFFFFF).bytes());
       }},
      {"ATokenOf4GigaProperties",
       [](const GuidPrefix& sender) {
         return announcement_with_token(sender, Body().u32(1).u32(0).u32(0xFFFFFFFF).bytes());
       }},
      {"ATokenOf4GiBOfText",
       [](const GuidPrefix& sender) {
         return announcement_with_token(sender, Body().u32(0xFFFFFFFF).u32(0).bytes());
       }},
      {"DataInClear",
       [](const GuidPrefix& sender) {
         Body body = data_to(0x00000104, 0x00000203, kNewest);
         return DatagramWriter(sender)
             .add(0x15, kWithData, body.raw({0, 1, 0, 0}).raw(Datagram(64, 0xFF)).bytes())
             .bytes();
       }},
  };
}

/// A closed lock-step bench and a member that it has authenticated.
class AttackedBench {
 public:
  explicit AttackedBench(const std::string& wire)
      : service_(VDRIVE_SERVICE,
                 tool_arguments("--clock lockstep --log-level error --wire " + wire +
                                " --security " + authority_.member("service bench").string())),
        is_ready_(tool("list --timeout 20 --security " + controller_.string()).code == 0),
        probe_({.domain = test_domain(), .security = controller_.string()}, 1),
        watcher_(wire::make_participant({.domain = test_domain(), .security = controller_.string()},
                                        "watcher")),
        states_(*watcher_, [this](const msg::BenchState& state, const wire::Source& source) {
          // The wire's own probe sends the state of bench 0 from another participant.
          if (state.bench != 1) return;
          const std::scoped_lock lock(mutex_);
          bench_ = source.participant;
        }) {}

  [[nodiscard]] bool is_found() {
    return is_ready_ && probe_.find_bench() && probe_.wait_until([this] {
      return bench() != GuidPrefix{};
    });
  }

  /// @return the prefix of the bench, which changes when another wire is started.
  [[nodiscard]] GuidPrefix bench() {
    const std::scoped_lock lock(mutex_);
    return bench_;
  }

  [[nodiscard]] GuidPrefix member() const { return probe_.source().participant; }

  [[nodiscard]] bool answers() { return probe_.read(1, 0x6041).has_value(); }

  [[nodiscard]] const fs::path& credentials() const { return controller_; }

  Finished stop() {
    service_.send(SIGTERM);
    return service_.wait();
  }

 private:
  Authority authority_;
  fs::path controller_ = authority_.member("controller desk");
  Process service_;
  bool is_ready_;  ///< before the members below, so that the service has the domain's first ports
  std::mutex mutex_;
  GuidPrefix bench_{};
  Probe probe_;
  std::unique_ptr<wire::Participant> watcher_;
  wire::Subscription<msg::BenchState> states_;
};

/// @param participants the number of participants, from the first of the domain on, that are
///        attacked
void attack(const GuidPrefix& sender, std::uint32_t participants) {
  const Attacker attacker;
  for (const Forgery& forgery : forgeries()) {
    const Datagram datagram = forgery.make(sender);
    for (std::uint32_t port = 0; port < 2 * participants; ++port)
      attacker.send(datagram, 10 + port);
  }
}

class AClosedBench : public testing::TestWithParam<const char*> {};

TEST_P(AClosedBench, KeepsItsWireWhenLengthsAreForged) {
  AttackedBench bench(GetParam());
  ASSERT_TRUE(bench.is_found());
  const GuidPrefix wire = bench.bench();
  attack(bench.member(), 1);
  EXPECT_TRUE(bench.answers());
  EXPECT_EQ(bench.bench(), wire) << "another wire was started";
  EXPECT_EQ(bench.stop().code, 0);
}

INSTANTIATE_TEST_SUITE_P(Forms, AClosedBench, testing::Values("thread", "process"),
                         [](const auto& form) {
                           return std::string("Wire_") + form.param;
                         });

TEST(AClosedClient, GoesOnWhenLengthsAreForgedInTheNameOfItsBench) {
  AttackedBench bench("process");
  ASSERT_TRUE(bench.is_found());
  Process watch(VDRIVE_TOOL, tool_arguments("watch 1.1 --timeout 20 --security " +
                                            bench.credentials().string()));
  ASSERT_THAT(watch.read_line(), testing::Not(testing::IsEmpty()));
  attack(bench.bench(), 16);
  EXPECT_TRUE(bench.answers()) << "the client of this process";
  watch.send(SIGINT);
  const Finished watched = watch.wait();
  EXPECT_GE(watched.code, 0) << watched.errors;
}

}  // namespace
}  // namespace vdrive::test
