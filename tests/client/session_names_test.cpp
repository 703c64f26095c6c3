// SPDX-License-Identifier: Apache-2.0
// A message about a blocked call names the program, not its session number.
#include "support/bench_on_wire.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/axis_group.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/publication.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <optional>
#include <string>

namespace vdrive::client {
namespace {

using test::BenchOnWire;
using test::options_on_wire;
using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

constexpr const char* kBenchOfTwo =
    "--clock lockstep --axes 2 --config " VDRIVE_SOURCE_DIR "/tests/data/patient.yaml";

SessionOptions called(const std::string& program) {
  SessionOptions options = options_on_wire();
  options.program = program;
  return options;
}

/// @return this process as a session names it, with `program` as its program.
SessionName name_here(const std::string& program) {
  std::array<char, 256> host{};
  EXPECT_EQ(gethostname(host.data(), host.size() - 1), 0);
  return {.program = program, .process = static_cast<std::uint32_t>(getpid()), .host = host.data()};
}

/// @return the end of a message about an axis that `session` controls.
std::string controlled_by(const std::string& program, const Session& session) {
  const SessionName name = name_here(program);
  return "axis 1.1 is controlled by " + program + " (process " + std::to_string(name.process) +
         " on " + name.host + "), session " + session_text(session.id());
}

class NamedSessions : public testing::Test {
 protected:
  const BenchOnWire bench_{kBenchOfTwo};
  Session alpha_{called("alpha")};
  Session beta_{called("beta")};
  Axis of_alpha_ = alpha_.axis("1.1").value();
  Axis of_beta_ = beta_.axis("1.1").value();
};

TEST_F(NamedSessions, ARefusedProgramReadsWhoIsInControl) {
  ASSERT_TRUE(of_alpha_.acquire());
  const Outcome refused = of_beta_.enable();
  EXPECT_EQ(refused.code(), 0x08000021U);
  EXPECT_EQ(refused.message(), "control of axis 1.1 refused: " + controlled_by("alpha", alpha_));
  ASSERT_NE(refused.owner(), nullptr);
  EXPECT_EQ(*refused.owner(),
            (AxisOwner{.axis = {1, 1}, .session = alpha_.id(), .name = name_here("alpha")}));
}

TEST_F(NamedSessions, EveryKindOfRefusalHasTheName) {
  ASSERT_TRUE(of_alpha_.acquire());
  const std::string owner = controlled_by("alpha", alpha_);
  EXPECT_THAT(of_beta_.acquire().message(), EndsWith(": " + owner));
  EXPECT_THAT(of_beta_.move_to(5).message(), EndsWith(": " + owner));
  EXPECT_THAT(of_beta_.power_cycle().message(), EndsWith(": " + owner));
  EXPECT_THAT(of_beta_.write({0x607A, 0}, 5).outcome().message(),
              StartsWith("write of 5 UU (0.44 deg) to position_user_target_value"));
  EXPECT_THAT(of_beta_.write({0x607A, 0}, 5).outcome().message(), EndsWith(": " + owner));
  const std::array ids{AxisId{1, 1}, AxisId{1, 2}};
  EXPECT_THAT(beta_.acquire(ids).message(), EndsWith(": " + owner));
  const std::array names{std::string("1.1"), std::string("1.2")};
  auto group = AxisGroup::create(beta_, names).value();
  EXPECT_THAT(group.enable_all().message(), EndsWith(": " + owner));
}

// During a call the axis is taken over by another session, so the next frame has an old epoch.
TEST_F(NamedSessions, ARobbedProgramReadsWhoHasTakenItsAxis) {
  ASSERT_TRUE(of_alpha_.enable());
  const Outcome jogged = of_alpha_.jog(10'000, [this](const AxisSnapshot& axis) {
    if (axis.status.velocity_demand_value == 10'000) {
      EXPECT_TRUE(of_beta_.take_over());
    }
    return true;
  });
  EXPECT_EQ(jogged.kind(), OutcomeKind::refused);
  EXPECT_THAT(jogged.message(), StartsWith("a quick stop ended the jog: "));
  EXPECT_THAT(jogged.message(), EndsWith(": " + controlled_by("beta", beta_)));
}

TEST_F(NamedSessions, ASessionThatSaysNothingIsAnUnknownProgram) {
  constexpr std::uint64_t kOther = 0xAB;
  const auto other = wire::make_participant({.bus = test::local_bus()}, "other");
  wire::Publication<msg::Request> requests(*other);
  msg::Request request;
  request.client = kOther;
  request.request_id = 1;
  request.bench = 1;
  request.session = kOther;
  request.kind = msg::RequestKind::acquire;
  request.axes = {1};
  ASSERT_TRUE(requests.write(request));
  ASSERT_EQ(of_beta_.status().value().owner_session, kOther);
  const Outcome refused = of_beta_.enable();
  EXPECT_EQ(refused.message(),
            "control of axis 1.1 refused: axis 1.1 is controlled by an unknown program, session "
            "0x00000000000000ab");
  ASSERT_NE(refused.owner(), nullptr);
  EXPECT_EQ(refused.owner()->session, kOther);
  EXPECT_EQ(refused.owner()->name, std::nullopt);
  EXPECT_EQ(beta_.find_name(1, kOther), std::nullopt);
}

TEST_F(NamedSessions, ANameIsShownWithoutControlCharactersAndInvalidUtf8) {
  Session odd(called("a\n\x1b[2J\xff"));
  Axis axis = odd.axis("1.2").value();
  ASSERT_TRUE(axis.acquire());
  const Outcome refused = beta_.axis("1.2").value().acquire();
  EXPECT_THAT(refused.message(), HasSubstr("controlled by a\\n\\x1B[2J\\xFF (process "));
  ASSERT_NE(refused.owner(), nullptr);
  ASSERT_TRUE(refused.owner()->name);
  EXPECT_EQ(refused.owner()->name->program, "a\\n\\x1B[2J\\xFF");
}

// The IDL allows 64 bytes; a longer name is truncated.
TEST_F(NamedSessions, AnEndlessNameIsCut) {
  Session endless(called(std::string(1'000, 'n')));
  ASSERT_TRUE(endless.axis("1.2").value().acquire());
  const auto name = beta_.find_name(1, endless.id());
  ASSERT_TRUE(name);
  EXPECT_EQ(name->program, std::string(64, 'n'));
}

TEST_F(NamedSessions, AreKnownFromTheFirstAxisOn) {
  EXPECT_EQ(beta_.known_name(1, alpha_.id()), std::nullopt);
  ASSERT_TRUE(of_alpha_.acquire());
  EXPECT_EQ(beta_.find_name(1, alpha_.id()), name_here("alpha"));
  EXPECT_EQ(beta_.known_name(1, alpha_.id()), name_here("alpha"));
  EXPECT_EQ(beta_.find_name(7, alpha_.id()), std::nullopt) << "it has no axis of that bench";
}

// A program may acquire an axis and end immediately, as commands of the tool do.
TEST_F(NamedSessions, OfAProgramThatEndedAtOnceStayKnown) {
  constexpr int kPrograms = 20;
  for (int i = 0; i < kPrograms; ++i) {
    const std::string program = "brief " + std::to_string(i);
    std::uint64_t session = 0;
    {
      Session brief(called(program));
      session = brief.id();
      ASSERT_TRUE(brief.axis("1.2").value().acquire());
    }
    EXPECT_EQ(beta_.find_name(1, session), name_here(program));
  }
}

TEST_F(NamedSessions, WithoutAChoiceAProgramIsCalledAsItsFile) {
  Session usual(options_on_wire());
  ASSERT_TRUE(usual.axis("1.2").value().acquire());
  EXPECT_EQ(beta_.find_name(1, usual.id()), name_here(program_invocation_short_name));
}

TEST(SessionNameText, NamesWhatIsKnown) {
  EXPECT_EQ(to_string(SessionName{.program = "vdrive", .process = 4711, .host = "bench-host"}),
            "vdrive (process 4711 on bench-host)");
  EXPECT_EQ(to_string(SessionName{.program = "vdrive", .process = 4711, .host = {}}),
            "vdrive (process 4711)");
  EXPECT_EQ(to_string(SessionName{.program = {}, .process = 0, .host = "bench-host"}),
            "an unknown program (on bench-host)");
  EXPECT_EQ(owner_text(0x0B, std::nullopt), "an unknown program, session 0x000000000000000b");
}

TEST(Refusal, EndsWithTheMeaningOfItsCodeUntilAnOwnerIsKnown) {
  constexpr std::uint32_t kStaleEpoch = 2;  // REASON_STALE_EPOCH
  const Outcome refused =
      Outcome::refused(kStaleEpoch, "bench 1 refused the command frame").with_prefix("first: ");
  EXPECT_EQ(refused.message(),
            "first: bench 1 refused the command frame: the epoch is not current: control was lost, "
            "released or renewed");
  EXPECT_EQ(refused.owner(), nullptr);
  const Outcome owned = refused.with_owner({.axis = {1, 2}, .session = 0x0B});
  EXPECT_EQ(owned.message(),
            "first: bench 1 refused the command frame: axis 1.2 is controlled by an unknown "
            "program, session 0x000000000000000b");
  const Outcome named =
      owned.with_owner({.axis = {1, 2}, .session = 0x0B, .name = SessionName{.program = "vdrive"}});
  EXPECT_EQ(named.message(),
            "first: bench 1 refused the command frame: axis 1.2 is controlled by vdrive, session "
            "0x000000000000000b");
  EXPECT_EQ(named.code(), kStaleEpoch);
}

}  // namespace
}  // namespace vdrive::client
