// SPDX-License-Identifier: Apache-2.0
// The black box of a bench: the ticks around a fault that nobody watched.
#include "support/bench_on_wire.hpp"
#include "support/random_cases.hpp"
#include "support/temporary_directory.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/status_digest.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::client {
namespace {

using namespace std::chrono_literals;
using test::BenchOnWire;
using test::options_on_wire;
using testing::HasSubstr;
using testing::SizeIs;

constexpr std::uint32_t kBench = 1;
constexpr ObjectAddress kControlword{0x6040, 0};
constexpr ObjectAddress kMode{0x6060, 0};
constexpr ObjectAddress kTarget{0x607A, 0};
constexpr ObjectAddress kOverTemperature{0x5E03, 0};     // test-bench input
constexpr std::uint32_t kOverTemperatureFault = 0x4310;  // 603Fh

/// The status seen by a recorder alongside the bench, by tick and axis number.
using Recorded = std::map<std::pair<std::uint64_t, std::uint16_t>, AxisStatus>;

std::uint64_t bits_of(const AxisStatus& status) {
  return digest_of({&status, 1}, 1, {}).image;
}

std::vector<AxisId> ids_of(const std::vector<Axis>& axes) {
  std::vector<AxisId> ids;
  for (const Axis& axis : axes) ids.push_back(axis.id());
  return ids;
}

/// A lock-step bench, its master, and a recorder that sees each tick.
class RecordedBench {
 public:
  explicit RecordedBench(const std::string& words)
      : service_("--clock lockstep " + words),
        session_(options_on_wire()),
        axes_(session_.axes(kBench).value()),
        follower_(session_.follow(ids_of(axes_), Pace::drive).value()) {}

  Session& session() { return session_; }

  std::vector<Axis>& axes() { return axes_; }

  void step(std::uint64_t ticks) {
    for (std::uint64_t tick = 0; tick < ticks; ++tick) {
      const auto seen = follower_.next(10s);
      ASSERT_TRUE(seen) << seen.outcome().message();
      now_ = seen->tick;
      for (const AxisSnapshot& axis : seen->axes)
        recorded_[{seen->tick, axis.id.axis}] = axis.status;
    }
  }

  [[nodiscard]] std::uint64_t now() const { return now_; }

  void write(std::size_t axis, ObjectAddress object, std::int64_t value) {
    const auto code = axes_[axis].write(object, value);
    ASSERT_TRUE(code) << code.outcome().message();
  }

  /// Enables the axis and starts a motion of many seconds.
  void move(std::size_t axis, std::int32_t target) {
    write(axis, kMode, 1);
    write(axis, kTarget, target);
    for (const int word : {0x80, 0x06, 0x07, 0x0F, 0x1F}) write(axis, kControlword, word);
    step(1);
    write(axis, kControlword, 0x0F);
  }

  /// Compares the window bit for bit with the recording. @return the number of samples compared.
  std::size_t compare(const Window& window) const {
    std::size_t compared = 0;
    for (const Observation& sample : window.samples) {
      for (const AxisSnapshot& axis : sample.axes) {
        const auto seen = recorded_.find({sample.tick, axis.id.axis});
        if (seen == recorded_.end()) continue;
        ++compared;
        EXPECT_EQ(bits_of(axis.status), bits_of(seen->second))
            << "axis " << axis.id.axis << ", tick " << sample.tick;
      }
    }
    return compared;
  }

 private:
  BenchOnWire service_;
  Session session_;
  std::vector<Axis> axes_;
  Follower follower_;
  Recorded recorded_;
  std::uint64_t now_ = 0;
};

std::vector<std::string> causes_of(const std::vector<KeptWindow>& windows) {
  std::vector<std::string> causes;
  for (const KeptWindow& window : windows) {
    for (const WindowCause& cause : window.causes) {
      causes.push_back(std::string(to_string(cause.kind)) + " of axis " +
                       std::to_string(cause.axis));
    }
  }
  return causes;
}

/// @return the digest of every tick of axis 1 in a window.
std::vector<std::uint64_t> bits_of_axis_1(Session& session, std::uint64_t number) {
  std::vector<std::uint64_t> bits;
  const std::vector<AxisId> axes{{kBench, 1}};
  const auto window = session.window(number, axes);
  EXPECT_TRUE(window) << window.outcome().message();
  if (!window) return bits;
  for (const Observation& sample : window->samples) {
    bits.push_back(bits_of(sample.axes.front().status));
  }
  return bits;
}

// 2 s before the fault and 0.5 s after it, in ticks of 1 ms.
TEST(Window, ShowsEachTickAroundAFaultAsARecorderSawIt) {
  RecordedBench bench("--axes 3");
  bench.move(1, 2'000'000'000);
  bench.step(3'000);
  bench.write(1, kOverTemperature, 1);
  bench.step(1);
  const std::uint64_t fault = bench.now();
  bench.step(700);

  const auto windows = bench.session().windows(kBench);
  ASSERT_TRUE(windows) << windows.outcome().message();
  ASSERT_THAT(*windows, SizeIs(1));
  EXPECT_EQ(windows->front().causes.front().code, kOverTemperatureFault);
  EXPECT_EQ(windows->front().causes.front().axis, 2);
  EXPECT_FALSE(windows->front().is_open);

  const std::vector<AxisId> wanted{{kBench, 2}, {kBench, 3}};
  const auto window = bench.session().window(windows->front().number, wanted);
  ASSERT_TRUE(window) << window.outcome().message();
  ASSERT_FALSE(window->samples.empty());
  EXPECT_EQ(window->samples.front().tick, fault - 2'000);
  EXPECT_EQ(window->samples.back().tick, fault + 500);
  EXPECT_EQ(bench.compare(*window), 2 * 2'501U);
  EXPECT_THAT(window->breaks, SizeIs(0));

  ASSERT_THAT(window->writes, SizeIs(1)) << "what was written before the window is not of it";
  EXPECT_EQ(window->writes.front().object, kOverTemperature);
  EXPECT_EQ(window->writes.front().value, 1);
  EXPECT_EQ(window->writes.front().tick, fault - 1);
  EXPECT_EQ(window->writes.front().session, bench.session().id());
  const auto value = std::ranges::find_if(window->values, [](const WindowValue& each) {
    return each.axis == 2 && each.object == kTarget;
  });
  ASSERT_NE(value, window->values.end());
  EXPECT_EQ(value->value, 2'000'000'000);
  EXPECT_TRUE(std::ranges::any_of(window->events, [&](const WindowEvent& event) {
    return event.kind == EventKind::fault && event.tick == fault && event.axis == 2 &&
           event.code == kOverTemperatureFault;
  }));
}

TEST(Window, EndsNowWhereTimeStands) {
  RecordedBench bench("--axes 1");
  bench.step(100);
  const auto number = bench.session().freeze_window(kBench);
  ASSERT_TRUE(number) << number.outcome().message();
  bench.step(10);
  const auto window = bench.session().window(*number, ids_of(bench.axes()));
  ASSERT_TRUE(window) << window.outcome().message();
  EXPECT_EQ(window->samples.back().tick, 110U);
  EXPECT_EQ(window->kept.causes.front().kind, WindowCause::Kind::asked);
  EXPECT_EQ(window->kept.causes.front().session, bench.session().id());
  EXPECT_EQ(window->samples.front().tick, 0U) << "the window begins with what was first recorded";
}

TEST(Window, ShowsWhereASnapshotWasRestored) {
  RecordedBench bench("--axes 2");
  bench.move(0, 1'000'000);
  bench.step(100);
  const auto snapshot = bench.session().take_snapshot(kBench);
  ASSERT_TRUE(snapshot);
  bench.step(400);
  ASSERT_TRUE(bench.session().restore_snapshot(kBench, *snapshot));
  const std::uint64_t restored = bench.now();
  bench.step(400);
  const auto number = bench.session().freeze_window(kBench);
  bench.step(600);
  const auto window = bench.session().window(*number, ids_of(bench.axes()));
  ASSERT_TRUE(window) << window.outcome().message();
  ASSERT_THAT(window->breaks, SizeIs(1));
  EXPECT_EQ(window->breaks.front().kind, WindowBreak::Kind::restored);
  EXPECT_EQ(window->breaks.front().tick, restored);
  // The tick of the restored state occurs twice: as it was originally, and after the restore.
  EXPECT_EQ(std::ranges::count(window->samples, restored, &Observation::tick), 2);
  Window without = *window;
  std::erase_if(without.samples, [&](const Observation& sample) {
    return sample.tick == restored;
  });
  EXPECT_GT(bench.compare(without), 1'000U);
}

TEST(Window, HasAllFaultsThatHappenedTogether) {
  RecordedBench bench("--axes 5");
  bench.step(10);
  for (std::size_t axis = 0; axis < 4; ++axis) bench.write(axis, kOverTemperature, 1);
  bench.step(600);
  const auto windows = bench.session().windows(kBench);
  ASSERT_TRUE(windows);
  EXPECT_THAT(*windows, SizeIs(1));
  EXPECT_THAT(causes_of(*windows), testing::ElementsAre("fault of axis 1", "fault of axis 2",
                                                        "fault of axis 3", "fault of axis 4"));
}

TEST(Window, IsRefusedWithItsNumberWhenItIsGone) {
  RecordedBench bench("--axes 1");
  const auto window = bench.session().window(7, ids_of(bench.axes()));
  EXPECT_EQ(window.outcome().kind(), OutcomeKind::refused);
  EXPECT_THAT(window.outcome().message(), HasSubstr("window 7"));
}

TEST(Window, KeepsTheRarestKindsLongest) {
  RecordedBench bench("--axes 2");
  ASSERT_TRUE(bench.session().freeze_window(kBench));
  bench.step(600);
  for (int fault = 0; fault < 20; ++fault) {
    bench.write(0, kOverTemperature, 1);
    bench.step(600);
    bench.write(0, kOverTemperature, 0);
    bench.write(0, kControlword, 0);
    bench.write(0, kControlword, 0x80);
    bench.step(1);
  }
  const auto windows = bench.session().windows(kBench);
  ASSERT_TRUE(windows);
  ASSERT_THAT(*windows, SizeIs(16));
  EXPECT_EQ(windows->front().causes.front().kind, WindowCause::Kind::asked)
      << "the only one of its kind";
  EXPECT_EQ(windows->back().number, 21U);
}

/// A bench whose time passes by itself; only ticks that a follower received are compared.
class RunningBench : public testing::TestWithParam<const char*> {};

TEST_P(RunningBench, GivesAWindowWhileItTicks) {
  const BenchOnWire bench(std::string("--axes 2 --clock ") + GetParam());
  Session session(options_on_wire());
  const std::vector<AxisId> ids{{kBench, 1}, {kBench, 2}};
  auto follower = session.follow(ids, Pace::observe);
  ASSERT_TRUE(follower);
  Axis axis = session.axis("1.1").value();
  ASSERT_TRUE(axis.write(kOverTemperature, 1));
  Recorded recorded;
  std::uint64_t fault = 0;
  for (std::uint64_t tick = 0; fault == 0 || tick < fault + 500;) {
    const auto seen = follower->next(10s);
    ASSERT_TRUE(seen) << seen.outcome().message();
    tick = seen->tick;
    for (const AxisSnapshot& each : seen->axes) recorded[{tick, each.id.axis}] = each.status;
    if (fault == 0 && seen->axes.front().status.error_code != 0) fault = tick;
  }
  const auto windows = session.windows(kBench);
  ASSERT_TRUE(windows);
  ASSERT_THAT(*windows, SizeIs(1));
  for (int round = 0; round < 3; ++round) {
    const auto window = session.window(windows->front().number, ids);
    ASSERT_TRUE(window) << window.outcome().message();
    std::size_t compared = 0;
    for (const Observation& sample : window->samples) {
      for (const AxisSnapshot& each : sample.axes) {
        const auto seen = recorded.find({sample.tick, each.id.axis});
        if (seen == recorded.end()) continue;
        ++compared;
        EXPECT_EQ(bits_of(each.status), bits_of(seen->second)) << "tick " << sample.tick;
      }
    }
    // Freerun publishes by wall time, so it may have left out the complete window.
    if (GetParam() == std::string("realtime")) EXPECT_GT(compared, 0U);
    const std::uint64_t at = windows->front().causes.front().tick;
    for (const Observation& sample : window->samples) {
      EXPECT_EQ(sample.axes.front().status.error_code != 0, sample.tick >= at) << sample.tick;
    }
    const std::uint64_t span = window->samples.back().tick - window->samples.front().tick;
    EXPECT_EQ(window->samples.size(), span + 1) << "each tick, whatever was published";
  }
}

INSTANTIATE_TEST_SUITE_P(Clocks, RunningBench, testing::Values("realtime", "freerun"),
                         [](const auto& clock) {
                           return std::string(clock.param);
                         });

// The first run ends normally; the second has the same axes and the same state directory.
TEST(Window, OutlastsItsService) {
  const test::TemporaryDirectory state;
  const std::string words = "--axes 2 --state " + state.path().string();
  std::vector<std::uint64_t> before;
  {
    RecordedBench bench(words);
    bench.move(0, 1'000'000);
    bench.step(100);
    bench.write(0, kOverTemperature, 1);
    bench.step(700);
    before = bits_of_axis_1(bench.session(), 1);
  }
  RecordedBench bench(words);
  const auto windows = bench.session().windows(kBench);
  ASSERT_TRUE(windows) << windows.outcome().message();
  EXPECT_THAT(causes_of(*windows), testing::ElementsAre("fault of axis 1"));
  EXPECT_THAT(before, SizeIs(603)) << "from tick 0 to 500 ms after the fault in tick 102";
  EXPECT_EQ(bits_of_axis_1(bench.session(), 1), before);
  const auto next = bench.session().freeze_window(kBench);
  ASSERT_TRUE(next);
  EXPECT_EQ(*next, 2U) << "numbers go on";
}

TEST(Window, OfOtherAxesIsLeftOut) {
  const test::TemporaryDirectory state;
  const std::string words = " --state " + state.path().string();
  {
    RecordedBench bench("--axes 2" + words);
    ASSERT_TRUE(bench.session().freeze_window(kBench));
    bench.step(600);
  }
  RecordedBench bench("--axes 3" + words);
  const auto windows = bench.session().windows(kBench);
  ASSERT_TRUE(windows);
  EXPECT_THAT(*windows, SizeIs(0));
}

TEST(Window, OfADamagedFileIsLeftOut) {
  const test::TemporaryDirectory state;
  const std::string words = "--axes 1 --state " + state.path().string();
  {
    RecordedBench bench(words);
    ASSERT_TRUE(bench.session().freeze_window(kBench));
    bench.step(600);
  }
  const auto file = state.path() / "bench-1.window-1";
  const auto size = std::filesystem::file_size(file);
  ASSERT_GT(size, 100U);
  for (const std::uintmax_t place : {std::uintmax_t{0}, std::uintmax_t{20}, size / 2, size - 1}) {
    std::fstream damaged(file, std::ios::binary | std::ios::in | std::ios::out);
    damaged.seekg(static_cast<std::streamoff>(place));
    const auto byte = static_cast<char>(damaged.get() ^ 0x10);
    damaged.seekp(static_cast<std::streamoff>(place));
    damaged.put(byte);
  }
  RecordedBench bench(words);
  const auto windows = bench.session().windows(kBench);
  ASSERT_TRUE(windows);
  EXPECT_THAT(*windows, SizeIs(0));
  EXPECT_FALSE(std::filesystem::exists(file)) << "it is removed, with a line in the log";
}

TEST(Window, OfRandomWritesIsAsItWas) {
  const int seeds = test::number_of<int>({.usual = 3, .full = 20, .nightly = 200});
  for (int seed = 1; seed <= seeds; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    test::Random random(static_cast<std::uint64_t>(seed));
    RecordedBench bench("--axes 4");
    for (int round = 0; round < 40; ++round) {
      const auto axis = random.below(4);
      switch (random.below(5)) {
        case 0:
          bench.move(axis, static_cast<std::int32_t>(random.below(2'000'000)) - 1'000'000);
          break;
        case 1:
          bench.write(axis, kOverTemperature, static_cast<std::int64_t>(random.below(2)));
          break;
        case 2:
          static_cast<void>(bench.axes()[axis].write(
              kControlword, static_cast<std::int64_t>(random.below(0x10000))));
          break;
        case 3:
          static_cast<void>(bench.axes()[axis].power_cycle());
          break;
        default:
          break;
      }
      bench.step(1 + random.below(200));
    }
    const auto number = bench.session().freeze_window(kBench);
    ASSERT_TRUE(number);
    const auto window = bench.session().window(*number, ids_of(bench.axes()));
    ASSERT_TRUE(window) << window.outcome().message();
    EXPECT_GT(bench.compare(*window), 0U);
  }
}

}  // namespace
}  // namespace vdrive::client
