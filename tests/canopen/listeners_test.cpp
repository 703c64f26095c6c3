// SPDX-License-Identifier: Apache-2.0
#include "bridge/listeners.hpp"

#include <gtest/gtest.h>

#include <array>

namespace vdrive::canopen {
namespace {

using Kind = Listeners::Kind;

Kind kind_of(const Listeners& listeners, std::uint32_t id) {
  return listeners.find({.id = id}).kind;
}

/// Nodes 5 and 6 at positions 0 and 1 with their default RPDO 1; node 6 also consumes the heartbeat
/// of node 127.
Listeners two_nodes() {
  constexpr std::array<std::uint16_t, 2> kOfFive{0x080, 0x205};
  constexpr std::array<std::uint16_t, 3> kOfSix{0x080, 0x206, 0x77F};
  Listeners listeners;
  listeners.add(0, {.id = 5, .identifiers = kOfFive});
  listeners.add(1, {.id = 6, .identifiers = kOfSix});
  return listeners;
}

TEST(Listeners, GiveNmtSyncAndWhatHasNoMeaningToAllNodes) {
  const Listeners listeners = two_nodes();
  for (const std::uint32_t id : {0x000U, 0x080U, 0x100U, 0x17FU, 0x7E5U, 0x7FFU}) {
    EXPECT_EQ(kind_of(listeners, id), Kind::everybody) << id;
  }
}

TEST(Listeners, GivePdosAndSdoRequestsToTheirNode) {
  const Listeners listeners = two_nodes();
  for (const std::uint32_t id : {0x206U, 0x606U, 0x77FU}) {
    const Listeners::Answer whom = listeners.find({.id = id});
    EXPECT_EQ(whom.kind, Kind::one) << id;
    EXPECT_EQ(whom.place, 1U) << id;
  }
  EXPECT_EQ(listeners.find({.id = 0x605}).place, 0U);
}

TEST(Listeners, GiveWhatNobodyNamesToNobody) {
  const Listeners listeners = two_nodes();
  for (const std::uint32_t id : {0x085U, 0x185U, 0x57FU, 0x585U, 0x607U, 0x705U}) {
    EXPECT_EQ(kind_of(listeners, id), Kind::nobody) << id;
  }
}

TEST(Listeners, GiveAPdoThatTwoNodesShareToAllNodes) {
  Listeners listeners = two_nodes();
  constexpr std::array<std::uint16_t, 1> kShared{0x206};
  listeners.add(2, {.id = 7, .identifiers = kShared});
  EXPECT_EQ(kind_of(listeners, 0x206), Kind::everybody);
}

TEST(Listeners, GiveRemoteFramesToAllAndExtendedOnesToNobody) {
  const Listeners listeners = two_nodes();
  EXPECT_EQ(listeners.find({.id = 0x185, .is_remote = true}).kind, Kind::everybody);
  EXPECT_EQ(listeners.find({.id = 0x205, .is_extended = true}).kind, Kind::nobody);
  EXPECT_EQ(listeners.find({.id = 0x10000}).kind, Kind::nobody);
}

TEST(Listeners, ForgetAllAtOnce) {
  Listeners listeners = two_nodes();
  listeners.clear();
  EXPECT_EQ(kind_of(listeners, 0x605), Kind::nobody);
  EXPECT_EQ(kind_of(listeners, 0x000), Kind::everybody);
}

}  // namespace
}  // namespace vdrive::canopen
