// SPDX-License-Identifier: Apache-2.0
// REQUEST_READ_WRITES: the writes to a bench and their authors.
#include "service/engine_under_test.hpp"
#include "vdrive/wire/written.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace vdrive::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using wire::WrittenMark;

/// An entry as short text: "tick 3", "request by a11ce", "1 6040h = 15", refused "1 6040h = 15 !
/// 8000021".
std::string text_of(const msg::ObjectResult& entry) {
  const auto hex = [](std::uint64_t number) {
    std::array<char, 20> text{};
    std::snprintf(text.data(), text.size(), "%llx", static_cast<unsigned long long>(number));
    return std::string(text.data());
  };
  const auto value = static_cast<std::uint64_t>(entry.value);
  if (entry.index == 0) {
    switch (static_cast<WrittenMark>(entry.subindex)) {
      case WrittenMark::tick:
        return "tick " + std::to_string(entry.value);
      case WrittenMark::by_request:
        return "request by " + hex(value);
      case WrittenMark::by_frame:
        return "frame by " + hex(value);
      case WrittenMark::by_bench:
        return "by the bench";
      case WrittenMark::lost:
        return std::to_string(entry.value) + " lost";
      case WrittenMark::restored:
        return "restored";
      case WrittenMark::power_cycle:
        return "power cycle of " + std::to_string(entry.axis);
      default:  // marks of windows
        return "unknown";
    }
  }
  std::string text =
      std::to_string(entry.axis) + " " + hex(entry.index) + "h = " + std::to_string(entry.value);
  const std::uint32_t reason = wire::number(entry.abort_code);
  return reason == 0 ? text : text + " ! " + hex(reason);
}

class WritesOfABench : public testing::Test {
 protected:
  WritesOfABench() {
    auto configuration = bench_configuration(2);
    configuration.watchdog.reset();
    bench.emplace(configuration);
    static_cast<void>(read(0));  // a bench keeps writes only after somebody has asked for them once
  }

  msg::Reply read(std::uint64_t place) {
    auto request = bench->make_request(msg::RequestKind::read_writes, 0);
    request.snapshot = place;
    return bench->reply_to(request);
  }

  std::vector<std::string> entries(std::uint64_t place) {
    std::vector<std::string> texts;
    for (const auto& entry : read(place).objects) texts.push_back(text_of(entry));
    return texts;
  }

  std::optional<EngineUnderTest> bench;
};

TEST_F(WritesOfABench, AreToldWithTheirTickSessionAndRefusal) {
  EXPECT_THAT(entries(0), IsEmpty());
  bench->write(kAlice, 1, 0x607A, 100);
  bench->write(kAlice, 1, 0x6040, 6);  // the axis was free and is now Alice's
  bench->steps(2);
  bench->write(kBob, 1, 0x607A, 5);
  bench->write(kAlice, 2, 0x6041, 1);  // read-only
  EXPECT_THAT(entries(0), ElementsAre("tick 0", "request by a11ce", "1 607ah = 100", "1 6040h = 6",
                                      "tick 2", "request by b0b", "1 607ah = 5 ! 8000021",
                                      "request by a11ce", "2 6041h = 1 ! 6010002"));
  EXPECT_EQ(read(0).snapshot, 4U);
  EXPECT_EQ(read(0).tick, 2U);
  EXPECT_THAT(entries(4), IsEmpty());
  EXPECT_THAT(entries(1'000), IsEmpty()) << "a place of another run";
}

TEST_F(WritesOfABench, HaveThoseOfFramesAlsoOfOnesThatCameTooLate) {
  bench->acquire(kAlice, {1, 2});
  bench->steps(5);
  const auto send = [this](std::uint64_t tick) {
    auto frame = bench->make_frame(kAlice);
    frame.apply_at_tick = tick;
    auto& command = add_command(frame, 2);
    command.members = msg::HAS_POSITION_USER_TARGET_VALUE;
    command.position_user_target_value = static_cast<std::int32_t>(tick);
    set_controlword(command, 0x0F);
    bench->receive(frame);
  };
  send(0);
  send(3);
  EXPECT_THAT(entries(0), ElementsAre("tick 5", "frame by a11ce", "2 607ah = 0", "2 6040h = 15",
                                      "2 607ah = 3 ! b", "2 6040h = 15 ! b"))
      << "0Bh is REASON_TOO_LATE";
}

TEST_F(WritesOfABench, HaveTheWholeOfAFrameThatIsRefusedAsAWhole) {
  bench->acquire(kAlice, {1, 2});
  auto frame = bench->make_frame(kAlice);
  frame.flags = msg::FRAME_ALL_OR_NOTHING;
  for (const std::uint16_t axis : kFirstTwo) {
    auto& command = add_command(frame, axis);
    command.members = msg::HAS_OP_MODE_CMD;
    command.op_mode_cmd = axis == 1 ? 1 : 99;  // the axis has no mode 99
    set_controlword(command, 0x0F);
  }
  bench->receive(frame);
  EXPECT_THAT(entries(0), ElementsAre("tick 0", "frame by a11ce", "1 6060h = 1 ! 6090030",
                                      "1 6040h = 15 ! 6090030", "2 6060h = 99 ! 6090030",
                                      "2 6040h = 15 ! 6090030"))
      << "06090030h: the value is invalid";
}

TEST_F(WritesOfABench, NameWhatTheBenchDoesAndAPowerCycle) {
  bench->write(kAlice, 1, 0x6040, 0x0F);
  bench->steps(3);
  bench->reply_to(bench->make_request(msg::RequestKind::power_cycle, kAlice, {1}));
  bench->steps(2);
  bench->write(kAlice, 1, 0x6040, 0x0F);
  bench->steps(3);
  bench->engine.shut_down(service::Braking::none);
  EXPECT_THAT(entries(1), ElementsAre("tick 3", "request by a11ce", "power cycle of 1", "tick 5",
                                      "1 6040h = 15", "tick 8", "by the bench", "1 6040h = 0"));
}

// In the list of writes, index 0 denotes a mark (WrittenMark), such as the author of the entries
// after it. An entry for a write to index 0, which does not exist, would look like a mark and could
// conceal who wrote.
TEST_F(WritesOfABench, HaveNoneOfAnObjectThatWouldBeReadAsAMark) {
  bench->write(kBob, 1, 0, 1'000, 1);
  EXPECT_THAT(entries(0), IsEmpty());
}

TEST_F(WritesOfABench, NameARestore) {
  bench->reply_to(bench->make_request(msg::RequestKind::take_snapshot, kAlice));
  auto restore = bench->make_request(msg::RequestKind::restore_snapshot, kAlice);
  restore.snapshot = 1;
  bench->reply_to(restore);
  EXPECT_THAT(entries(0), ElementsAre("tick 0", "by the bench", "restored"));
}

TEST_F(WritesOfABench, ComeInPagesUntilThereIsNothingNew) {
  constexpr int kWrites = 500;
  for (int i = 0; i < kWrites; ++i) {
    bench->write(kAlice, 1, 0x607A, i);
    if (i % 3 == 0) bench->steps(1);
  }
  std::vector<std::int64_t> values;
  std::uint64_t place = 0;
  for (msg::Reply page = read(0); page.snapshot != place; page = read(place)) {
    for (const auto& entry : page.objects) {
      if (entry.index == 0x607A) values.push_back(entry.value);
    }
    place = page.snapshot;
  }
  ASSERT_EQ(values.size(), static_cast<std::size_t>(kWrites));
  for (int i = 0; i < kWrites; ++i) EXPECT_EQ(values[static_cast<std::size_t>(i)], i);
}

TEST_F(WritesOfABench, SayHowManyAreNoLongerKept) {
  constexpr std::uint64_t kMost = 65'536;
  for (std::uint64_t i = 0; i < kMost + 10; ++i) {
    bench->write(kAlice, 1, 0x607A, static_cast<std::int64_t>(i));
  }
  const msg::Reply page = read(3);
  ASSERT_GT(page.objects.size(), 4U);
  EXPECT_EQ(text_of(page.objects[0]), "tick 0");
  EXPECT_EQ(text_of(page.objects[1]), "7 lost") << "those at the places 4 to 10";
  EXPECT_EQ(text_of(page.objects[4]), "1 607ah = 10");
}

}  // namespace
}  // namespace vdrive::test
