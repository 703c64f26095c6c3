// SPDX-License-Identifier: Apache-2.0
#include "bridge/arguments.hpp"

#include "settings/configuration_error.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace vdrive::canopen {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

std::string problem_of_arguments(const Arguments& arguments, Settings settings = {}) {
  try {
    apply_arguments(arguments, settings);
    complete_settings(settings);
  } catch (const vdrive::settings::ConfigurationError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(CanopenArguments, DescribeOneBus) {
  Settings settings;
  apply_arguments({.benches = {1, 2},
                   .node_offsets = {0, 10},
                   .socketcand = {"127.0.0.1:0"},
                   .gateways = {"localhost:60000"},
                   .interfaces = {"can0"},
                   .sync_steps = "2ms",
                   .state = "/tmp/state"},
                  settings);
  ASSERT_THAT(settings.buses, SizeIs(1));
  const BusSetting& bus = settings.buses.front();
  ASSERT_THAT(bus.benches, SizeIs(2));
  EXPECT_EQ(bus.benches[0].node_offset, 0);
  EXPECT_EQ(bus.benches[1].number, 2U);
  EXPECT_EQ(bus.benches[1].node_offset, 10);
  EXPECT_EQ(address_text(bus.socketcand.at(0)), "127.0.0.1:0");
  EXPECT_EQ(address_text(bus.gateways.at(0)), "127.0.0.1:60000");
  EXPECT_EQ(settings.sync_steps, 2ms);
  EXPECT_EQ(settings.state.string(), "/tmp/state");
}

TEST(CanopenArguments, GiveOneOffsetToAllBenches) {
  Settings named;
  apply_arguments({.benches = {1, 2}, .node_offsets = {5}}, named);
  EXPECT_EQ(named.buses.front().benches.at(1).node_offset, 5);
  Settings all;
  apply_arguments({.node_offsets = {5}}, all);
  EXPECT_THAT(all.buses.front().benches, IsEmpty());
  EXPECT_EQ(all.buses.front().node_offset, 5);
}

TEST(CanopenArguments, MakeAPrivateBench) {
  Settings settings;
  apply_arguments({.node_offsets = {4}, .is_private = true, .axes = 3, .sync_steps = "1ms"},
                  settings);
  complete_settings(settings);
  EXPECT_TRUE(settings.is_private);
  EXPECT_EQ(settings.clock, ClockMode::lockstep);
  ASSERT_THAT(settings.buses.front().benches, SizeIs(1));
  const BenchSetting& bench = settings.buses.front().benches.front();
  EXPECT_EQ(bench.number, 1U);
  EXPECT_EQ(bench.node_offset, 4);
  EXPECT_EQ(bench.axes, 3U);
}

TEST(CanopenArguments, ReplaceWhatTheFileSays) {
  Settings settings;
  read_settings("buses:\n  - {socketcand: [127.0.0.1:1], benches: [{bench: 7}]}\n", "canopen.yaml",
                settings);
  apply_arguments({.socketcand = {"127.0.0.1:2"}}, settings);
  EXPECT_EQ(address_text(settings.buses.front().socketcand.at(0)), "127.0.0.1:2");
  EXPECT_EQ(settings.buses.front().benches.at(0).number, 7U) << "the benches are not named";
}

TEST(CanopenArguments, GiveOffsetsToTheBenchesOfTheFile) {
  Settings settings;
  read_settings("buses:\n  - {benches: [{bench: 7}, {bench: 9, node_offset: 2}]}\n", "canopen.yaml",
                settings);
  Settings each = settings;
  apply_arguments({.node_offsets = {5}}, settings);
  ASSERT_THAT(settings.buses.front().benches, SizeIs(2));
  EXPECT_EQ(settings.buses.front().benches[0].number, 7U);
  EXPECT_EQ(settings.buses.front().benches[0].node_offset, 5);
  EXPECT_EQ(settings.buses.front().benches[1].node_offset, 5);
  apply_arguments({.node_offsets = {1, 3}}, each);
  EXPECT_EQ(each.buses.front().benches.at(1).node_offset, 3);
  EXPECT_THAT(problem_of_arguments({.node_offsets = {1, 2, 3}}, each),
              HasSubstr("--node-offset is given 3 times for 2 benches"));
}

TEST(CanopenArguments, NameOptionValueAndLimitOfAnError) {
  EXPECT_THAT(problem_of_arguments({.socketcand = {"29536"}}),
              HasSubstr("--socketcand '29536': must be an address and a port"));
  EXPECT_THAT(problem_of_arguments({.gateways = {"a:b"}}), HasSubstr("--gateway 'a:b'"));
  for (const char* const step : {"1", "0", "124us", "11s", "1.5us", "never", "-1ms"}) {
    const std::string problem = problem_of_arguments({.sync_steps = step});
    if (std::string(step) == "1") {
      EXPECT_EQ(problem, "accepted") << "seconds";
    } else {
      EXPECT_THAT(problem, HasSubstr("--sync-steps '" + std::string(step) +
                                     "': must be a duration from 125us to 10s"));
    }
  }
  EXPECT_THAT(problem_of_arguments({.clock = "freerun"}),
              AllOf(HasSubstr("--clock: 'freerun'"), HasSubstr("realtime, lockstep")));
  EXPECT_THAT(problem_of_arguments({.axes = 3}),
              HasSubstr("--axes applies only to a private bench"));
  EXPECT_THAT(problem_of_arguments({.preset = "winder"}),
              HasSubstr("--preset applies only to a private bench"));
  EXPECT_THAT(problem_of_arguments(
                  {.is_private = true, .preset = "winder", .bench_configuration = "a.yaml"}),
              HasSubstr("--preset and --bench-config are both given"));
  EXPECT_THAT(problem_of_arguments({.bench_configuration = "a.yaml"}),
              HasSubstr("--bench-config applies only to a private bench"));
  EXPECT_THAT(
      problem_of_arguments({.is_private = true, .axes = 1, .bench_configuration = "a.yaml"}),
      HasSubstr("--axes and --bench-config are both given"));
  EXPECT_THAT(problem_of_arguments({.benches = {1, 2, 3}, .node_offsets = {0, 1}}),
              HasSubstr("--node-offset is given 2 times for 3 benches"));
}

// With an unset variable, --sync-steps "$STEP" has an empty text: the bus would run in real time.
TEST(CanopenArguments, RefuseAnEmptyText) {
  const std::string why = ": its value is empty";
  EXPECT_EQ(problem_of_arguments({.is_private = true, .sync_steps = ""}), "--sync-steps" + why);
  EXPECT_EQ(problem_of_arguments({.is_private = true, .clock = ""}), "--clock" + why);
  EXPECT_EQ(problem_of_arguments({.state = ""}), "--state" + why);
  EXPECT_EQ(problem_of_arguments({.is_private = true, .bench_configuration = ""}),
            "--bench-config" + why);
}

TEST(CanopenArguments, NameNoBusWhereTheFileHasSeveral) {
  Settings settings;
  settings.buses.resize(2);
  EXPECT_THAT(problem_of_arguments({.benches = {1}}, settings), HasSubstr("the file has 2 buses"));
}

TEST(CanopenArguments, GiveTheBusALogAndFaults) {
  Settings settings;
  apply_arguments({.log = "bus.log", .faults = {"3 lost 5%", "doubled"}}, settings);
  complete_settings(settings);
  const BusSetting& bus = settings.buses.at(0);
  EXPECT_EQ(bus.log.string(), "bus.log");
  ASSERT_THAT(bus.faults, SizeIs(2));
  EXPECT_EQ(bus.faults[0], (BusFault{.kind = BusFaultKind::lost, .node = 3, .percent = 5}));
  EXPECT_THAT(bus.socketcand, SizeIs(1)) << "they are no port";
}

TEST(CanopenArguments, RefuseAFaultWithItsReason) {
  EXPECT_THAT(problem_of_arguments({.faults = {"3 gone"}}),
              HasSubstr("--disturb '3 gone': 'gone' is not a fault of the bus"));
  EXPECT_THAT(problem_of_arguments({.faults = std::vector<std::string>(65, "lost")}),
              HasSubstr("--disturb is given 65 times: a bus has at most 64 faults"));
  EXPECT_THAT(problem_of_arguments({.log = ""}), HasSubstr("--log: its value is empty"));
}

}  // namespace
}  // namespace vdrive::canopen
