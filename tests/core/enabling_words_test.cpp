// SPDX-License-Identifier: Apache-2.0
#include "vdrive/cia402/enabling_words.hpp"

#include "vdrive/cia402/power_state_machine.hpp"

#include <gtest/gtest.h>

#include <array>

namespace vdrive {
namespace {

/// Writes controlwords one after the other, as a client does.
class WrittenWords {
 public:
  explicit WrittenWords(std::int8_t quick_stop_option) {
    options_.quick_stop_option_code = quick_stop_option;
    machine_.initialised();
  }

  void write(std::uint16_t word) {
    machine_.command(decode_command(word, last_), options_, true, false);
    last_ = word;
  }

  [[nodiscard]] PowerState state() const { return machine_.state(); }

 private:
  PowerOptions options_{};
  PowerStateMachine machine_;
  std::uint16_t last_ = 0;
};

TEST(EnablingWords, LeadFromEachStateWithoutAFaultToOperationEnabled) {
  using namespace controlwords;
  constexpr std::array kWay{kShutdown, kSwitchOn, kEnableOperation, kQuickStop};
  for (std::size_t begin = 0; begin <= kWay.size(); ++begin) {
    for (const std::int8_t option : {std::int8_t{2}, std::int8_t{6}}) {
      WrittenWords drive(option);
      for (std::size_t i = 0; i < begin; ++i) drive.write(kWay.at(i));
      const PowerState from = drive.state();
      for (const std::uint16_t word : enabling_words(from)) drive.write(word);
      EXPECT_EQ(drive.state(), PowerState::operation_enabled) << to_string(from);
    }
  }
}

TEST(EnablingWords, AreNoneInOperationEnabledAndNoLongerThanNeeded) {
  EXPECT_TRUE(enabling_words(PowerState::operation_enabled).empty());
  EXPECT_EQ(enabling_words(PowerState::switched_on).size(), 1U);
  EXPECT_EQ(enabling_words(PowerState::ready_to_switch_on).size(), 2U);
  EXPECT_EQ(enabling_words(PowerState::switch_on_disabled).size(), 3U);
  EXPECT_EQ(enabling_words(PowerState::quick_stop_active).size(), 4U);
}

}  // namespace
}  // namespace vdrive
