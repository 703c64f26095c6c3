// SPDX-License-Identifier: Apache-2.0
#include "bridge/settings.hpp"

#include "settings/configuration_error.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace vdrive::canopen {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

Settings read_file(const std::string& text) {
  Settings settings;
  read_settings(text, "canopen.yaml", settings);
  complete_settings(settings);
  return settings;
}

std::string problem_of_file(const std::string& text) {
  try {
    (void)read_file(text);
  } catch (const vdrive::settings::ConfigurationError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(CanopenSettings, AreOneBusForAllBenchesOnTheUsualPortByDefault) {
  const Settings settings = read_file("");
  ASSERT_THAT(settings.buses, SizeIs(1));
  const BusSetting& bus = settings.buses.front();
  EXPECT_EQ(bus.name, "can0");
  EXPECT_THAT(bus.benches, IsEmpty());
  ASSERT_THAT(bus.socketcand, SizeIs(1));
  EXPECT_EQ(address_text(bus.socketcand.front()), "127.0.0.1:29536");
  EXPECT_THAT(bus.gateways, IsEmpty());
  EXPECT_FALSE(settings.is_private);
  EXPECT_FALSE(settings.sync_steps);
}

TEST(CanopenSettings, AreReadFromTheFile) {
  const Settings settings = read_file(
      "sync_steps_us: 2000\nstate: /var/lib/vdrive\nbuses:\n"
      "  - socketcand: [127.0.0.1:0, \"[::1]:29537\"]\n"
      "    gateways: [127.0.0.1:60000]\n"
      "    benches: [{bench: 1}, {bench: 2, node_offset: 10}]\n"
      "  - name: machine\n    interfaces: [vcan0]\n    benches: [{bench: 3, node_offset: -100}]\n");
  EXPECT_EQ(settings.sync_steps, 2ms);
  EXPECT_EQ(settings.state.string(), "/var/lib/vdrive");
  ASSERT_THAT(settings.buses, SizeIs(2));
  const BusSetting& first = settings.buses[0];
  EXPECT_EQ(first.name, "can0");
  ASSERT_THAT(first.socketcand, SizeIs(2));
  EXPECT_EQ(address_text(first.socketcand[1]), "[::1]:29537");
  ASSERT_THAT(first.gateways, SizeIs(1));
  ASSERT_THAT(first.benches, SizeIs(2));
  EXPECT_EQ(first.benches[1].number, 2U);
  EXPECT_EQ(first.benches[1].node_offset, 10);
  EXPECT_EQ(settings.buses[1].name, "machine");
  EXPECT_THAT(settings.buses[1].interfaces, testing::ElementsAre("vcan0"));
  EXPECT_THAT(settings.buses[1].socketcand, IsEmpty()) << "it has another connection";
  EXPECT_EQ(settings.buses[1].benches[0].node_offset, -100);
}

TEST(CanopenSettings, OfAPrivateBenchHaveOneAxisAndTheClockThatFits) {
  const Settings real = read_file("private: true\n");
  EXPECT_EQ(real.clock, ClockMode::realtime);
  ASSERT_THAT(real.buses.front().benches, SizeIs(1));
  EXPECT_EQ(real.buses.front().benches.front().axes, 1U);
  const Settings stepped =
      read_file("private: true\nsync_steps_us: 1000\nbuses:\n  - benches: [{bench: 1, axes: 3}]\n");
  EXPECT_EQ(stepped.clock, ClockMode::lockstep);
  EXPECT_EQ(stepped.buses.front().benches.front().axes, 3U);
}

TEST(CanopenSettings, NameFileLineKeyValueAndLimitOfAnError) {
  EXPECT_THAT(problem_of_file("sync_steps_us: 100\n"),
              HasSubstr("canopen.yaml:1: sync_steps_us = 100: must be a whole number from 125 to "
                        "10000000 us"));
  EXPECT_THAT(problem_of_file("bus: []\n"),
              AllOf(HasSubstr("canopen.yaml:1: bus"), HasSubstr("buses")));
  EXPECT_THAT(problem_of_file("clock: freerun\n"), HasSubstr("must be one of realtime, lockstep"));
  EXPECT_THAT(problem_of_file("state: \"\"\n"), HasSubstr("must be the name of a directory"));
  EXPECT_THAT(problem_of_file("buses:\n  - socketcand: [here]\n"),
              HasSubstr("canopen.yaml:2: buses[0].socketcand[0] = here: must be an address and a "
                        "port, such as 127.0.0.1:29536"));
  EXPECT_THAT(problem_of_file("buses:\n  - socketcand: 127.0.0.1:1\n"),
              HasSubstr("must be a list"));
  EXPECT_THAT(problem_of_file("buses:\n  - name: a/b\n"),
              HasSubstr("buses[0].name = a/b: must be 1 to 16 letters"));
  EXPECT_THAT(problem_of_file("buses:\n  - interfaces: [\"\"]\n"), HasSubstr("such as can0"));
  EXPECT_THAT(problem_of_file("buses:\n  - benches: [{bench: 0}]\n"), HasSubstr("from 1 to 65535"));
  EXPECT_THAT(problem_of_file("buses:\n  - benches: [{node_offset: 1}]\n"),
              HasSubstr("needs the key bench"));
  EXPECT_THAT(problem_of_file("buses:\n  - benches: [{bench: 1, node_offset: 127}]\n"),
              HasSubstr("node_offset = 127: must be a whole number from -65534 to 126"));
  EXPECT_THAT(problem_of_file("private: true\nbuses:\n  - benches: [{bench: 1, axes: 128}]\n"),
              HasSubstr("axes = 128: must be a whole number from 1 to 127"));
  EXPECT_THAT(
      problem_of_file("private: true\nbuses:\n  - benches: [{bench: 1, axes: 1, config: a}]\n"),
      HasSubstr("give only one"));
}

TEST(CanopenSettings, RefuseWhatContradictsItself) {
  EXPECT_THAT(problem_of_file("buses:\n  - {name: a, benches: [{bench: 1}], socketcand: "
                              "[127.0.0.1:1]}\n  - {name: a, benches: [{bench: 2}]}\n"),
              HasSubstr("another bus has the name 'a'"));
  EXPECT_THAT(problem_of_file("buses:\n  - {benches: [{bench: 1}], interfaces: [can0]}\n"
                              "  - {benches: [{bench: 2}]}\n"),
              HasSubstr("bus can1: no client can reach it"));
  EXPECT_THAT(problem_of_file("buses:\n  - {benches: [{bench: 1}], interfaces: [can0]}\n"
                              "  - {interfaces: [can1]}\n"),
              HasSubstr("bus can1: with several buses"));
  EXPECT_THAT(problem_of_file("buses:\n  - {benches: [{bench: 1}], interfaces: [can0]}\n"
                              "  - {benches: [{bench: 1}], interfaces: [can1]}\n"),
              HasSubstr("bench 1 is given twice"));
  EXPECT_THAT(problem_of_file("buses:\n  - {socketcand: [127.0.0.1:5], gateways: [127.0.0.1:5]}\n"),
              HasSubstr("two servers listen on 127.0.0.1:5"));
  EXPECT_THAT(problem_of_file("buses:\n  - {interfaces: [can0, can0]}\n"),
              HasSubstr("the interface 'can0' is given twice"));
  EXPECT_THAT(problem_of_file("buses:\n  - {benches: [{bench: 1, axes: 3}]}\n"),
              HasSubstr("add --private"));
  EXPECT_THAT(problem_of_file("clock: lockstep\n"), HasSubstr("--clock applies only to a private"));
  EXPECT_THAT(problem_of_file("private: true\nclock: lockstep\n"), HasSubstr("needs --sync-steps"));
  EXPECT_THAT(problem_of_file("private: true\nclock: realtime\nsync_steps_us: 1000\n"),
              HasSubstr("--sync-steps needs --clock lockstep"));
}

TEST(CanopenSettings, OfAPrivateBenchTakeNoNetwork) {
  Settings settings;
  settings.is_private = true;
  settings.session.domain = 5;
  EXPECT_THROW(complete_settings(settings), vdrive::settings::ConfigurationError);
}

TEST(CanopenSettings, GiveABusALogAndFaults) {
  const Settings settings =
      read_file("buses:\n  - log: bus.log\n    disturb: [3 lost 5%, late 4ms from 2s for 500ms]\n");
  const BusSetting& bus = settings.buses.at(0);
  EXPECT_EQ(bus.log.string(), "bus.log");
  ASSERT_THAT(bus.faults, SizeIs(2));
  EXPECT_EQ(bus.faults[0].node, 3);
  EXPECT_EQ(bus.faults[1].until, std::chrono::microseconds(2'500ms));
}

TEST(CanopenSettings, RefuseAFaultAndALogOfTwoBusesWithTheirPlace) {
  EXPECT_THAT(problem_of_file("buses:\n  - disturb: [3 gone]\n"),
              AllOf(HasSubstr("canopen.yaml"), HasSubstr("disturb"),
                    HasSubstr("'gone' is not a fault of the bus")));
  EXPECT_THAT(
      problem_of_file("buses:\n  - {gateways: ['127.0.0.1:0'], log: a, benches: [{bench: 1}]}\n"
                      "  - {gateways: ['127.0.0.1:0'], log: a, benches: [{bench: 2}]}\n"),
      HasSubstr("the log 'a' is given twice"));
}

}  // namespace
}  // namespace vdrive::canopen
