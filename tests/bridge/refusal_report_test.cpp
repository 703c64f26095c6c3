// SPDX-License-Identifier: Apache-2.0
#include "reports.hpp"
#include "vdrive/dictionary/abort_code.hpp"

#include <gtest/gtest.h>

#include <optional>

namespace vdrive::bridge {
namespace {

constexpr std::uint64_t kOfBridge = 0x0A;

client::Event refusal(std::uint64_t session, std::uint32_t code) {
  client::Event event;
  event.kind = client::EventKind::refused;
  event.session = session;
  event.code = code;
  event.text = "frame 7 refused: too late, late by 3 ms (session 0x000000000000000a)";
  return event;
}

// Equal refusals are counted, so the text must be the same for all of them.
TEST(RefusalReport, LeavesOutWhatDiffersFromCommandToCommand) {
  EXPECT_EQ(refusal_report(refusal(kOfBridge, 11), kOfBridge),
            "a command was refused: frame 7 refused: too late");
}

TEST(RefusalReport, IsMadeOfRefusedCommandsOfTheBridgeOnly) {
  EXPECT_EQ(refusal_report(refusal(0x0B, 11), kOfBridge), std::nullopt);
  client::Event fault = refusal(kOfBridge, 11);
  fault.kind = client::EventKind::state_changed;
  EXPECT_EQ(refusal_report(fault, kOfBridge), std::nullopt);
}

TEST(RefusalReport, LeavesControlToItsKeeper) {
  EXPECT_EQ(
      refusal_report(refusal(kOfBridge, wire_code(AbortCode::refused_local_control)), kOfBridge),
      std::nullopt);
}

}  // namespace
}  // namespace vdrive::bridge
