// SPDX-License-Identifier: Apache-2.0
// A bench in the user's process, over the local bus.
#include "vdrive/bench/bench.hpp"

#include "support/process_tree.hpp"
#include "vdrive/client.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <future>
#include <iterator>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::bench {
namespace {

using client::OutcomeKind;
using client::Session;
using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::HasSubstr;
using testing::Not;

std::size_t count_entries(const char* directory) {
  return static_cast<std::size_t>(
      std::distance(std::filesystem::directory_iterator(directory), {}));
}

TEST(Bench, IsFoundAtOnceAndHasItsAxes) {
  const Bench bench({.axes = 3});
  // A search without waiting would find nothing over DDS.
  Session session = bench.session({.find_timeout = milliseconds(0)});
  const auto benches = session.find_benches();
  ASSERT_EQ(benches.size(), 1U);
  EXPECT_EQ(benches.front().axes.size(), 3U);
  EXPECT_EQ(benches.front().clock_mode, ClockMode::lockstep);
}

/// @return the number of lines of /proc/self/maps with a file in memory, such as one of
///         memfd_create.
std::size_t count_files_in_memory() {
  const std::string maps = test::text_of("/proc/self/maps");
  std::size_t count = 0;
  for (auto at = maps.find("/memfd:"); at != std::string::npos; at = maps.find("/memfd:", at + 1)) {
    ++count;
  }
  return count;
}

TEST(Bench, IsFoundBySessionsWhoseOptionsOfANetworkAreWrong) {
  const Bench bench;
  Session session = bench.session({.domain = 100'000,
                                   .interfaces = {"nowhere"},
                                   .peers = {"nobody"},
                                   .discovery_servers = {"nobody"},
                                   .security = "no directory",
                                   .find_timeout = milliseconds(0)});
  ASSERT_TRUE(session.find_bench());
  const auto missing = session.find_bench(7);
  EXPECT_THAT(missing.outcome().message(), HasSubstr("on this bus"));
  EXPECT_THAT(missing.outcome().message(), Not(HasSubstr("nowhere")));
}

TEST(Bench, MovesAnAxisInLockStepWithoutAThreadASocketAFileOrAChild) {
  const std::size_t in_memory = count_files_in_memory();
  ASSERT_EQ(test::child_of(getpid()), 0);
  const std::size_t threads = count_entries("/proc/self/task");
  const std::size_t files = count_entries("/proc/self/fd");
  const Bench bench;
  Session session = bench.session();
  auto axis = session.axis("1.1");
  ASSERT_TRUE(axis) << axis.outcome().message();
  ASSERT_TRUE(axis->enable());
  const auto moved = axis->move_to(10'000);
  ASSERT_TRUE(moved) << moved.message();
  const auto status = axis->status();
  ASSERT_TRUE(status);
  EXPECT_EQ(status->status.load_position_actual_value, 10'000);
  EXPECT_EQ(count_entries("/proc/self/task"), threads);
  EXPECT_EQ(count_entries("/proc/self/fd"), files);
  EXPECT_EQ(count_files_in_memory(), in_memory);
  EXPECT_EQ(test::child_of(getpid()), 0);
}

TEST(Bench, HasTheAxesOfAStruct) {
  std::vector<AxisConfiguration> axes(3);
  axes[1].initial_position = 4096;
  axes[2].parameters = {{.address = {0x6081, 0}, .value = 1234}};
  const Bench bench({.axis_configurations = axes, .period = std::chrono::microseconds(250)});
  Session session = bench.session();
  const auto benches = session.find_benches();
  ASSERT_EQ(benches.size(), 1U);
  EXPECT_EQ(benches.front().axes.size(), 3U);
  EXPECT_EQ(benches.front().period, std::chrono::microseconds(250));
  EXPECT_EQ(session.axis("1.2")->status()->status.load_position_actual_value, 4096);
  EXPECT_EQ(*session.axis("1.3")->read({0x6081, 0}), 1234);
}

TEST(Bench, RefusesAStructOfAxesThatIsWrongByName) {
  const auto refusal_of = [](const BenchOptions& options) -> std::string {
    try {
      check(options);
    } catch (const BenchError& error) {
      EXPECT_THROW(const Bench bench(options), BenchError);
      return error.what();
    }
    return "none";
  };
  std::vector<AxisConfiguration> axes(2);
  EXPECT_EQ(refusal_of({.axes = 2, .axis_configurations = axes}),
            "axis_configurations and axes are both given: give only one");
  EXPECT_EQ(refusal_of({.preset = "ball-screw", .axis_configurations = axes}),
            "axis_configurations and preset are both given: give only one");
  axes[1].model.load_inertia = -1.0;
  EXPECT_THAT(refusal_of({.axis_configurations = axes}), HasSubstr("axis 2: load_inertia = -1"));
  axes[1] = {};
  axes[1].parameters = {{.address = {0x1234, 0}, .value = 1}};
  EXPECT_THAT(refusal_of({.axis_configurations = axes}), HasSubstr("1234h"));
  axes[1] = {};
  EXPECT_EQ(refusal_of({.axis_configurations = axes}), "none");
  EXPECT_THAT(refusal_of({.period = std::chrono::microseconds(0)}), HasSubstr("period = 0"));
}

TEST(Bench, WithANumberThatIsOnTheBusIsRefusedByName) {
  const Bench bench({.number = 7});
  try {
    const Bench second({.number = 7, .bus = bench.bus()});
    FAIL() << "two benches have the number 7";
  } catch (const BenchError& error) {
    EXPECT_THAT(error.what(), HasSubstr("number = 7: bench 7 is already on this bus"));
  }
}

// 4096 UU are a turn of 10 mm: deploy/axes/ball-screw.yaml.
TEST(Bench, OfAPresetHasAxesOfThatMachine) {
  const Bench bench({.axes = 2, .preset = "ball-screw"});
  Session session = bench.session();
  const auto found = session.find_bench();
  ASSERT_TRUE(found) << found.outcome().message();
  ASSERT_EQ(found->axes.size(), 2U);
  EXPECT_EQ(found->axes[1].unit, (Unit{.kind = UnitKind::linear, .name = "mm", .size = 409.6}));
}

TEST(Bench, OfAnUnknownPresetIsRefusedWithTheNamesThatThereAre) {
  EXPECT_THAT(preset_names(), testing::Contains("winder"));
  try {
    const Bench bench({.preset = "ball-skrew"});
    FAIL() << "there is such a machine";
  } catch (const BenchError& error) {
    EXPECT_THAT(error.what(), HasSubstr("ball-skrew"));
    for (const std::string& name : preset_names()) EXPECT_THAT(error.what(), HasSubstr(name));
  }
}

TEST(Bench, MeetsOthersOnItsBusAndNoneOfAnother) {
  const Bench one({.number = 1});
  const Bench two({.number = 2, .bus = one.bus()});
  const Bench apart({.number = 3});
  Session session = one.session();
  EXPECT_EQ(session.find_benches().size(), 2U);
  EXPECT_EQ(session.find_bench(3).outcome().kind(), OutcomeKind::not_found);
}

/// @return how often each thread of this process except the calling one has waited, in descending
///         order.
std::vector<unsigned long> waits_of_other_threads() {
  constexpr std::string_view kLabel = "\nvoluntary_ctxt_switches:";
  std::vector<unsigned long> waits;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    if (task.path().filename() == std::to_string(gettid())) continue;
    const std::string status = test::text_of(task.path() / "status");
    const std::size_t label = status.find(kLabel);
    if (label != std::string::npos)
      waits.push_back(std::stoul(status.substr(label + kLabel.size())));
  }
  std::sort(waits.rbegin(), waits.rend());
  return waits;
}

TEST(Bench, OfRealTimeThatNobodyWatchesWakesOneThreadInEveryTick) {
  const Bench bench({.clock = ClockMode::realtime});
  // The bench has threads for the ticks, the status and the reports. If nobody reads, the last two
  // wait for 5 ms, that is for five ticks.
  std::vector<unsigned long> before = waits_of_other_threads();
  EXPECT_TRUE(test::holds_soon([&before] {
    const std::vector<unsigned long> now = waits_of_other_threads();
    if (now.size() < 3 || now.size() != before.size()) {
      before = now;
      return false;
    }
    if (now[0] - before[0] < 200) return false;
    const bool are_rare = 2 * (now[1] - before[1]) < now[0] - before[0];
    before = now;  // a late thread may have waited less often, so the next 200 ticks decide
    return are_rare;
  }));
}

TEST(Bench, OfFreerunPassesDriveTimeByItself) {
  const Bench bench({.clock = ClockMode::freerun});
  Session session = bench.session();
  ASSERT_TRUE(session.find_bench());
  const auto reached = session.wait(1, seconds(1));
  ASSERT_TRUE(reached) << reached.outcome().message();
}

/// Enables the axis and moves it. @return an empty text, or the failure.
std::string enable_and_move(Session& session, int number) {
  auto axis = session.axis("1." + std::to_string(number));
  if (!axis) return axis.outcome().message();
  if (const auto enabled = axis->enable(); !enabled) return enabled.message();
  const auto moved = axis->move_to(1'000 * number);
  return moved ? "" : moved.message();
}

/// Runs `work(number)` for axes 1 to 4, each in a separate thread. @return the results.
template <typename Work>
std::vector<std::string> in_four_threads(const Work& work) {
  std::vector<std::future<std::string>> running;
  for (int number = 1; number <= 4; ++number) {
    running.push_back(std::async(std::launch::async, work, number));
  }
  std::vector<std::string> results;
  for (auto& result : running) results.push_back(result.get());
  return results;
}

// Drive time waits for every stepper, even for a thread that the system does not schedule.
TEST(Bench, ServesSessionsOfSeveralThreadsThatJoinItsClock) {
  const Bench bench({.axes = 4});
  const auto failures = in_four_threads([&bench](int number) -> std::string {
    Session session = bench.session();
    const std::array<std::uint32_t, 1> benches{1};
    const auto clock = client::StepClock::join(session, benches);
    return clock ? enable_and_move(session, number) : clock.outcome().message();
  });
  EXPECT_THAT(failures, testing::Each(""));
}

// Each step of the session is a sign of life for all its axes.
TEST(Bench, ServesSeveralThreadsOfOneSession) {
  const Bench bench({.axes = 4});
  Session session = bench.session();
  const auto failures = in_four_threads([&session](int number) {
    return enable_and_move(session, number);
  });
  EXPECT_THAT(failures, testing::Each(""));
}

TEST(Bench, WithoutAWatchdogServesSessionsOfSeveralThreads) {
  const Bench bench(
      {.configuration = "watchdog: {timeout_ms: off}\nclock: {mode: lockstep}\n", .axes = 4});
  const auto failures = in_four_threads([&bench](int number) {
    Session session = bench.session();
    return enable_and_move(session, number);
  });
  EXPECT_THAT(failures, testing::Each(""));
}

// The watchdog counts drive time: 500 ms.
TEST(Bench, TakesAnAxisFromASessionThatIsSilentWhileAnotherOneSteps) {
  const Bench bench;
  Session silent = bench.session();
  auto axis = silent.axis("1.1");
  ASSERT_TRUE(axis->enable());
  Session other = bench.session();
  ASSERT_TRUE(other.step(1, 490));
  EXPECT_EQ(axis->status()->status.error_code, 0U);
  ASSERT_TRUE(other.step(1, 510));
  const auto lost = axis->status();
  EXPECT_EQ(lost->status.error_code, 0x8130U);
  EXPECT_THAT(client::what_it_shows(*lost), HasSubstr("use lock-step and join its clock"));
}

// This program links vdrive::bench only.
TEST(ProgramOfABench, LoadsNoDdsLibrary) {
  const Bench bench;
  ASSERT_TRUE(bench.session().axis("1.1"));
  const std::string maps = test::text_of("/proc/self/maps");
  ASSERT_THAT(maps, HasSubstr("libstdc++"));
  for (const char* library : {"libfastrtps", "libcrypto", "libtinyxml2"}) {
    EXPECT_THAT(maps, Not(HasSubstr(library)));
  }
}

TEST(ProgramOfABench, SaysWhatASessionOverDdsNeeds) {
  try {
    const Session session;
    FAIL() << "a session over DDS was made";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("no DDS library"));
    EXPECT_THAT(error.what(), HasSubstr("link vdrive::client"));
  }
}

}  // namespace
}  // namespace vdrive::bench
