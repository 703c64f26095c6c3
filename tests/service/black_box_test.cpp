// SPDX-License-Identifier: Apache-2.0
// The memory of a black box: what it discards, and that the rest stays correct.
#include "journal/black_box.hpp"

#include "journal/window_replay.hpp"
#include "support/effort.hpp"
#include "support/random_cases.hpp"
#include "vdrive/axis_bank.hpp"
#include "vdrive/status_digest.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

namespace vdrive::test {
namespace {

using service::BlackBox;
using service::Configuration;
using service::JournalAuthor;
using service::JournalChange;
using service::Window;
using service::WindowReplay;

constexpr ObjectAddress kTarget{0x607A, 0};
constexpr ObjectAddress kControlword{0x6040, 0};
constexpr std::uint64_t kMaster = 0xA11CE;

Configuration axes_with(std::size_t axes, std::uint32_t memory_mib) {
  Configuration configuration;
  configuration.axes = service::default_axes(axes);
  configuration.black_box_memory_mib = memory_mib;
  return configuration;
}

/// Axes with their black box, and the status that they showed in the last ticks.
class BoxedBank {
 public:
  BoxedBank(std::size_t axes, std::uint32_t memory_mib)
      : configuration_(axes_with(axes, memory_mib)),
        bank_(bank_axes(configuration_), configuration_.period),
        box_(configuration_, bank_) {
    box_.begin(bank_, 0);
  }

  BlackBox& box() { return box_; }

  void write(std::size_t axis, ObjectAddress object, std::int64_t value) {
    if (bank_.write(axis, object, value) != AbortCode::none) return;
    box_.record(
        JournalChange{.axis = static_cast<std::uint16_t>(axis), .address = object, .value = value},
        {.means = JournalAuthor::Means::request, .session = kMaster});
  }

  void step() {
    bank_.step();
    box_.record_tick(bank_, ++tick_);
    shown_[tick_] = bits();
    if (shown_.size() > 4'000) shown_.erase(shown_.begin());
  }

  /// Replays the window; each tick that differs is a test failure. @return the number of ticks
  /// compared.
  std::size_t compare(const Window& window) {
    std::vector<std::size_t> axes(bank_.size());
    for (std::size_t axis = 0; axis < axes.size(); ++axis) axes[axis] = axis;
    WindowReplay replay(configuration_);
    replay.start(box_, window, axes);
    std::size_t compared = 0;
    for (auto item = replay.next(); item != WindowReplay::Item::end; item = replay.next()) {
      const auto shown = shown_.find(replay.tick());
      if (item != WindowReplay::Item::tick || shown == shown_.end()) continue;
      EXPECT_EQ(replay.bank().status_hash(), shown->second) << "tick " << replay.tick();
      ++compared;
    }
    return compared;
  }

 private:
  [[nodiscard]] std::uint64_t bits() const { return bank_.status_hash(); }

  Configuration configuration_;
  AxisBank bank_;
  BlackBox box_;
  std::uint64_t tick_ = 0;
  std::map<std::uint64_t, std::uint64_t> shown_;
};

// 1 MiB holds some 30,000 entries. At 40 writes per tick on average it is full in less than a
// second of drive time, so blocks, slots and windows are reused again and again.
TEST(BlackBox, KeepsItsBudgetAndStaysRightWhileItForgets) {
  const int ticks = number_of<int>({.usual = 20'000, .full = 200'000, .nightly = 3'600'000});
  BoxedBank bank(4, 1);
  Random random(7);
  std::size_t windows = 0;
  std::uint64_t number = 0;
  for (int tick = 0; tick < ticks; ++tick) {
    for (std::uint64_t writes = random.below(40); writes > 0; --writes) {
      const std::size_t axis = random.below(4);
      bank.write(axis, kTarget, random.between(-100'000, 100'000));
      bank.write(axis, kControlword, random.one_in(20) ? 0x06 : (random.one_in(2) ? 0x0F : 0x3F));
    }
    bank.step();
    if (random.one_in(5'000)) static_cast<void>(bank.box().freeze({}));
    while (const Window* const window = bank.box().next_window(number)) {
      if (bank.box().is_open(*window)) break;
      number = window->number;
      ++windows;
      EXPECT_GT(bank.compare(*window), 0U) << "window " << number;
    }
  }
  EXPECT_GT(windows, 0U);
}

TEST(BlackBox, KeepsTheLastSixteenWindows) {
  BoxedBank bank(2, 8);
  for (int window = 0; window < 60; ++window) {
    ASSERT_NE(bank.box().freeze({}), 0U);
    for (int tick = 0; tick < 501; ++tick) bank.step();
  }
  std::uint64_t number = 0;
  std::size_t count = 0;
  while (const Window* const window = bank.box().next_window(number)) {
    number = window->number;
    ++count;
    EXPECT_EQ(window->last_tick - window->causes[0].tick, 500U);
  }
  EXPECT_EQ(count, 16U);
  EXPECT_EQ(number, 60U);
}

TEST(BlackBox, GivesRoomBackWhenAWindowIsLetGo) {
  BoxedBank bank(4, 1);
  ASSERT_NE(bank.box().freeze({}), 0U);
  for (int tick = 0; tick < 600; ++tick) bank.step();
  const Window window = *bank.box().next_window(0);
  bank.box().hold(window);  // as the thread that reads it does
  for (int tick = 0; tick < 3'000; ++tick) {
    for (std::int64_t write = 0; write < 40; ++write) bank.write(0, kTarget, write);
    bank.step();
  }
  EXPECT_GT(bank.compare(window), 0U) << "what is held does not change";
  bank.box().let_go(window);
  ASSERT_NE(bank.box().freeze({}), 0U) << "it records";
}

TEST(BlackBox, IsOffWhereFourSnapshotsHaveNoRoom) {
  BoxedBank none(1, 0);
  EXPECT_FALSE(none.box().is_on());
  EXPECT_EQ(none.box().freeze({}), 0U);
  BoxedBank small(200, 1);
  EXPECT_FALSE(small.box().is_on());
  small.step();
  EXPECT_EQ(small.box().next_window(0), nullptr);
}

}  // namespace
}  // namespace vdrive::test
