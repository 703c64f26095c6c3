// SPDX-License-Identifier: Apache-2.0
// The log of the guide "find the bug in this master" is the one that this master makes with the
// drive of the core, and the judge finds its mistakes.
#include "judge/judged_log.hpp"
#include "judge/logged_node.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

namespace vdrive::judge {
namespace {

using testing::ElementsAre;

/// A master with three mistakes. It sends its first word before it starts the node, it does not
/// wait for Ready to switch on, and it never clears bit 4, so that only its first move is made.
std::string log_of_the_guide() {
  LoggedNode node;
  node.step(20);
  node.word(0x0006);
  node.step(10);
  node.nmt(0x01);
  node.step(10);
  node.pdo(2, {{0x0006, 2}, {1, 1}});
  node.word(0x0007);
  node.step(10);
  node.word(0x000F);
  node.step(10);
  for (const int target : {4'096, 8'192, 12'288}) {
    node.write({0x607A, 0}, target, 4);
    node.write({0x6040, 0}, 0x001F, 2);
    node.step(400);
  }
  node.write({0x6040, 0}, 0x0006, 2);
  node.step(20);
  return node.log();
}

TEST(LogOfTheGuide, IsTheOneOfItsMaster) {
  std::ifstream file(VDRIVE_SOURCE_DIR "/docs/guides/one_move.candump", std::ios::binary);
  const std::string kept{std::istreambuf_iterator<char>(file), {}};
  const std::string made = log_of_the_guide();
  if (kept == made) return;
  const std::string other = testing::TempDir() + "one_move.candump";
  std::ofstream(other, std::ios::binary) << made;
  FAIL() << "docs/guides/one_move.candump is not what the master does; it is in " << other;
}

TEST(LogOfTheGuide, HasTheMistakesThatTheGuideNames) {
  EXPECT_THAT(rules_in(log_of_the_guide()), ElementsAre("handshake-2", "state-2", "pdo-1"));
}

}  // namespace
}  // namespace vdrive::judge
