// SPDX-License-Identifier: Apache-2.0
// The memory of benches in a process, and a thousand benches.
#include "vdrive/bench/bench.hpp"
#include "vdrive/client.hpp"

#include <gtest/gtest.h>

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

namespace vdrive::bench {
namespace {

using client::Session;

constexpr std::size_t kKibi = 1'024;
constexpr std::size_t kMostOfABench = 1'024 * kKibi;  ///< two axes and a session [bytes]
/// Each kept answer takes another page: 128 answers to the frames of a session (4 KiB each) and 128
/// to its requests (1.7 KiB), 0.7 MiB in total.
constexpr std::size_t kMostOfAMovedBench = kMostOfABench + 750 * kKibi;

#ifdef VDRIVE_SANITIZED
constexpr bool kIsMeasured = false;  // a sanitizer needs extra memory for each byte
#else
constexpr bool kIsMeasured = true;
#endif

// A sanitizer takes many times as long, and finds the same with fewer benches.
constexpr std::uint32_t kThousand = kIsMeasured ? 1'000 : 100;

/// @return the resident memory of this process [bytes].
std::size_t resident() {
  std::ifstream file("/proc/self/statm");
  std::size_t size = 0;
  std::size_t pages = 0;
  file >> size >> pages;
  return pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

struct Place {
  explicit Place(const BenchOptions& options) : bench(options), session(bench.session()) {}

  Bench bench;
  Session session;
};

/// Creates a bench and reads its first axis.
std::unique_ptr<Place> make_place(const BenchOptions& options) {
  auto place = std::make_unique<Place>(options);
  EXPECT_TRUE(place->session.axis("1.1"));
  return place;
}

/// A bench reserves room for the largest messages, however many axes it has (see
/// docs/explanation/performance.md), but only the used part counts. For a bench of two axes the
/// largest part is 256 answers with room for 64 objects (0.4 MiB); the rest is a few pages per
/// queue.
TEST(BenchOfTwoAxes, TakesAtMostOneMebibyte) {
  constexpr std::size_t kBenches = 100;  // enough to make the one-time costs negligible
  make_place({.axes = 2});
  const std::size_t before = resident();
  std::vector<std::unique_ptr<Place>> places;
  for (std::size_t count = 0; count < kBenches; ++count) places.push_back(make_place({.axes = 2}));
  const std::size_t each = (resident() - before) / kBenches;
  RecordProperty("kib_each", std::to_string(each / kKibi));
  if (kIsMeasured) {
    EXPECT_LE(each, kMostOfABench);
  }
}

TEST(BenchesOfTwoAxes, GiveTheirMemoryBackWhenTheyEnd) {
  constexpr std::size_t kBenches = 50;
  constexpr int kRounds = 10;
  const auto make_and_end = [] {
    std::vector<std::unique_ptr<Place>> places;
    for (std::size_t count = 0; count < kBenches; ++count) {
      places.push_back(make_place({.axes = 2}));
      auto axis = places.back()->session.axis("1.2");
      ASSERT_TRUE(axis && axis->enable() && axis->move_to(100));
    }
  };
  make_and_end();
  const std::size_t after_one = resident();
  for (int round = 1; round < kRounds; ++round) make_and_end();
  const std::size_t after_all = resident();
  RecordProperty("kib_each", std::to_string((after_all - after_one) / kBenches / kKibi));
  if (kIsMeasured) {
    // A tenth of the memory of that many benches.
    EXPECT_LE(after_all, after_one + kBenches * kMostOfAMovedBench / 10);
  }
}

/// @return benches of two axes on one bus, with the numbers 1 to `count`.
std::vector<Bench> benches_on_one_bus(std::uint32_t count) {
  std::vector<Bench> benches;
  benches.reserve(count);
  std::shared_ptr<wire::LocalBus> bus;
  for (std::uint32_t number = 1; number <= count; ++number) {
    benches.emplace_back(BenchOptions{.axes = 2, .number = number, .bus = bus});
    bus = benches.front().bus();
  }
  return benches;
}

struct Bus {
  explicit Bus(std::uint32_t count)
      : benches(benches_on_one_bus(count)), session(benches.front().session()) {}

  std::vector<Bench> benches;
  Session session;
};

void expect_to_move_and_step(Session& session, std::uint32_t number) {
  auto axis = session.axis(std::to_string(number) + ".2");
  ASSERT_TRUE(axis) << axis.outcome().message();
  ASSERT_TRUE(axis->enable());
  const auto target = static_cast<std::int32_t>(number);
  const auto moved = axis->move_to(target);
  ASSERT_TRUE(moved) << moved.message();
  const auto status = axis->status();
  ASSERT_TRUE(status);
  EXPECT_EQ(status->status.position_demand_value, target);
  const auto first = session.step(number, 1);
  ASSERT_TRUE(first) << first.outcome().message();
  const auto second = session.step(number, 3);
  ASSERT_TRUE(second);
  EXPECT_EQ(*second - *first, 3U);
}

TEST(AThousandBenches, OfTenBusesAreAllMovedAndStepped) {
  constexpr std::uint32_t kBuses = 10;
  constexpr std::uint32_t kOnEach = kThousand / kBuses;
  const std::size_t before = resident();
  std::deque<Bus> buses;
  for (std::size_t bus = 0; bus < kBuses; ++bus) {
    buses.emplace_back(kOnEach);
    ASSERT_EQ(buses.back().session.find_benches().size(), kOnEach);
  }
  for (Bus& bus : buses) {
    for (std::uint32_t number = 1; number <= kOnEach; ++number) {
      expect_to_move_and_step(bus.session, number);
    }
  }
  if (kIsMeasured) {
    EXPECT_LE(resident() - before, kBuses * kOnEach * kMostOfAMovedBench);
  }
}

/// A call checks every bench of its bus, so only some of them move.
TEST(AThousandBenches, MeetOnOneBus) {
  constexpr std::uint32_t kBenches = kThousand;
  const std::vector<Bench> benches = benches_on_one_bus(kBenches);
  Session session = benches.front().session();
  ASSERT_EQ(session.find_benches().size(), kBenches);
  for (std::uint32_t number = 1; number <= kBenches; number += 99) {
    expect_to_move_and_step(session, number);
  }
}

}  // namespace
}  // namespace vdrive::bench
