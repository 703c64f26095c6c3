// SPDX-License-Identifier: Apache-2.0
// The findings of the doctor for constructed readings of a machine.
#include "diagnosis/checks.hpp"
#include "vdrive_messages_description.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

namespace vdrive::tool {
namespace {

using testing::HasSubstr;

/// A machine without findings.
HostReadings healthy() {
  return {.library = "Fast DDS 3.6.2",
          .interfaces = {{"lo", "127.0.0.1", true}, {"eth0", "10.0.0.1", true}},
          .multicast = {{"127.0.0.1", true}},
          .segments = {{"fastrtps_port7411", true}},
          .is_clock_synchronised = true,
          .clock_source = "tsc",
          .largest_receive_buffer = 16'777'216,
          .first_ephemeral_port = 32'768,
          .open_files = 1'024,
          .cores = 8,
          .load = 15.9,
          .may_run_realtime = true};
}

/// @return the findings that are not good, each of which must give advice.
std::vector<Finding> complaints(const HostReadings& readings, const GlobalOptions& options = {}) {
  std::vector<Finding> findings = check_host(readings, options);
  std::erase_if(findings, [](const Finding& finding) {
    return finding.severity == Severity::good;
  });
  for (const Finding& finding : findings) EXPECT_FALSE(finding.advice.empty()) << finding.text;
  return findings;
}

TEST(Doctor, ReportsNothingOnAHealthyMachine) {
  EXPECT_TRUE(complaints(healthy()).empty());
}

TEST(Doctor, NamesTheLoadOfTheMachine) {
  HostReadings readings = healthy();
  readings.cores = 2;
  readings.load = 20.34;
  readings.longest_delay = std::chrono::milliseconds{37};
  const auto found = complaints(readings);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].subject, "load");
  EXPECT_EQ(found[0].text,
            "20.3 in the last minute on 2 cores, a thread that waited ran up to 37 ms late");
  EXPECT_THAT(found[0].advice, HasSubstr("--timeout"));
  readings.load = 4.0;
  EXPECT_TRUE(complaints(readings).empty());
  readings.load.reset();
  EXPECT_TRUE(complaints(readings).empty());
}

TEST(DoctorsReadings, HaveTheLoadOfThisMachine) {
  const HostReadings readings = read_host({});
  ASSERT_TRUE(readings.load);
  EXPECT_GE(*readings.load, 0.0);
  EXPECT_GE(readings.cores, 1U);
}

TEST(Doctor, NamesTheProgramOnThePortOfTheGateway) {
  HostReadings readings = healthy();
  const auto text = [&] {
    return check_host(readings, {}).back().text;
  };
  EXPECT_THAT(text(), HasSubstr("no vdrive-gateway on 127.0.0.1:8765"));
  readings.gateway = GatewayReading::gateway;
  EXPECT_THAT(text(), HasSubstr("answers on http://127.0.0.1:8765/"));
  EXPECT_TRUE(complaints(readings).empty());
  readings.gateway = GatewayReading::another;
  const auto found = complaints(readings);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_THAT(found[0].advice, HasSubstr("--listen"));
}

TEST(Doctor, NamesADomainWithinTheEphemeralPorts) {
  GlobalOptions options;
  options.domain = 101;  // ports 32650 to 32899; the kernel's range begins at 32768
  const auto found = complaints(healthy(), options);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].severity, Severity::hint);
  EXPECT_THAT(found[0].advice, HasSubstr("use a domain below 101"));
  options.domain = 100;  // ports up to 32649
  EXPECT_TRUE(complaints(healthy(), options).empty());
}

/// The doctor's finding about the library.
Finding library_finding(const std::string& library, std::vector<std::string> interfaces) {
  HostReadings readings = healthy();
  readings.library = library;
  GlobalOptions options;
  options.interfaces = std::move(interfaces);
  const auto found = check_host(readings, options);
  const auto finding = std::ranges::find(found, "library", &Finding::subject);
  return finding == found.end() ? Finding{} : *finding;
}

TEST(Doctor, NamesTheLibraryOfDds) {
  const Finding found = library_finding("Fast DDS 3.6.2", {"10.0.0.1"});
  EXPECT_EQ(found.severity, Severity::good);
  EXPECT_EQ(found.text, "Fast DDS 3.6.2");
}

TEST(Doctor, WarnsOfALibraryWithRemoteFaultsOnAnOpenInterface) {
  for (const char* const library : {"Fast DDS 2.9.1", "Fast DDS 3.1.2"}) {
    const Finding found = library_finding(library, {"127.0.0.1", "10.0.0.1"});
    EXPECT_EQ(found.severity, Severity::hint) << library;
    EXPECT_THAT(found.text, HasSubstr(library));
    EXPECT_THAT(found.advice, HasSubstr("10.0.0.1"));
    EXPECT_THAT(found.advice, HasSubstr("docs/SECURITY.md"));
  }
}

TEST(Doctor, DoesNotWarnOfRemoteFaultsOnLoopback) {
  for (const auto& interfaces : {std::vector<std::string>{}, {"127.0.0.1"}}) {
    const Finding found = library_finding("Fast DDS 2.9.1", interfaces);
    EXPECT_EQ(found.severity, Severity::good);
    EXPECT_THAT(found.text, HasSubstr("only this machine can send"));
  }
}

TEST(Doctor, NamesAMissingOrInactiveInterface) {
  HostReadings readings = healthy();
  readings.interfaces.push_back({"eth1", "10.0.1.1", false});
  GlobalOptions options;
  options.interfaces = {"10.0.0.1", "10.0.0.2", "10.0.1.1"};
  const auto found = complaints(readings, options);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].severity, Severity::problem);
  EXPECT_THAT(found[0].text, HasSubstr("10.0.0.2 is not an address"));
  EXPECT_THAT(found[1].text, HasSubstr("eth1, which is down"));
}

TEST(Doctor, NeedsMulticastOnlyWherePeersAreNotNamed) {
  HostReadings readings = healthy();
  readings.multicast[0].is_received = false;
  auto found = complaints(readings);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].severity, Severity::problem);
  GlobalOptions options;
  options.peers = {"10.0.0.7"};
  found = complaints(readings, options);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].severity, Severity::hint);
}

TEST(Doctor, HintsAtCausesOfLateTicksAndLostSamples) {
  HostReadings readings = healthy();
  readings.is_clock_synchronised = false;
  readings.clock_source = "hpet";
  readings.largest_receive_buffer = 212'992;
  readings.may_run_realtime = false;
  readings.open_files = 64;
  readings.segments.push_back({"fastrtps_0123", false});
  const auto found = complaints(readings);
  ASSERT_EQ(found.size(), 5U);
  for (const Finding& finding : found) EXPECT_EQ(finding.severity, Severity::hint);
  EXPECT_THAT(found[0].advice, HasSubstr("chrony"));
  EXPECT_THAT(found[0].advice, HasSubstr("use tsc"));
  EXPECT_THAT(found[2].advice, HasSubstr("net.core.rmem_max=16777216"));
  EXPECT_THAT(found[3].advice, HasSubstr("CAP_SYS_NICE"));
  EXPECT_THAT(found[4].text, HasSubstr("2 segments of Fast DDS, 1 that no program uses"));
}

TEST(Doctor, ReportsABenchOfAnotherVersion) {
  client::BenchInfo bench;
  bench.number = 3;
  bench.name = "cell";
  bench.service_version = "0.0.1";
  const auto found = check_benches({&bench, 1}, {});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].severity, Severity::hint);
  EXPECT_THAT(found[0].text, HasSubstr("bench 3 'cell', 0 axes, realtime, version 0.0.1"));
}

client::BenchInfo bench_with_wire_starts(std::uint64_t starts) {
  client::BenchInfo bench;
  bench.number = 3;
  bench.wire_starts = starts;
  return bench;
}

TEST(Doctor, ReportsTheRestartsOfTheNetworkProcessOfABench) {
  // The first start does not count as a restart.
  const client::BenchInfo once = bench_with_wire_starts(2);
  const client::BenchInfo often = bench_with_wire_starts(5);
  for (const auto& [bench, words] :
       {std::pair(once, "bench 3 was started again once since the service started"),
        std::pair(often, "bench 3 was started again 4 times since the service started")}) {
    const auto found = check_benches({&bench, 1}, {});
    ASSERT_EQ(found.size(), 3U);
    EXPECT_EQ(found[1].severity, Severity::hint);
    EXPECT_THAT(found[1].text, HasSubstr(words));
    EXPECT_THAT(found[1].advice, HasSubstr("log of the service"));
  }
}

TEST(Doctor, AcceptsANetworkProcessThatNeverEnded) {
  const client::BenchInfo bench = bench_with_wire_starts(1);
  const auto found = check_benches({&bench, 1}, {});
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(found[1].severity, Severity::good);
  EXPECT_THAT(found[1].text, HasSubstr("bench 3 has not ended since the service started"));
}

TEST(Doctor, ReportsTheSilenceOfAnOwner) {
  client::BenchInfo bench = bench_with_wire_starts(1);
  bench.longest_silence = std::chrono::milliseconds{26};  // keep-alives are sent every 25 ms
  EXPECT_EQ(check_benches({&bench, 1}, {}).at(2).severity, Severity::good);
  bench.longest_silence = std::chrono::milliseconds{312};
  const Finding late = check_benches({&bench, 1}, {}).at(2);
  EXPECT_EQ(late.severity, Severity::hint);
  EXPECT_THAT(late.text, HasSubstr("bench 3 received nothing from an owner of axes is 312 ms"));
  EXPECT_THAT(late.advice, HasSubstr("watchdog.timeout_ms"));
}

TEST(Doctor, OmitsANetworkProcessWithoutKnownStarts) {
  const client::BenchInfo bench = bench_with_wire_starts(0);
  EXPECT_EQ(check_benches({&bench, 1}, {}).size(), 1U);
}

TEST(Doctor, ShowsEachFigureOfABenchToPrograms) {
  client::BenchInfo bench = bench_with_wire_starts(1);
  for (client::Figure& figure : bench.figures) figure.value = figure.name.size();
  const auto found = check_benches({&bench, 1}, {});
  const Json json = record_json(finding_record(found.at(0)));
  std::size_t count = 0;
  wire::for_each_figure<msg::BenchState>([&](const wire::MemberTraits& figure) {
    EXPECT_EQ(json.at("figures").at(std::string(figure.name)), figure.name.size()) << figure.name;
    ++count;
  });
  EXPECT_EQ(json.at("figures").size(), count);
  EXPECT_FALSE(record_json(finding_record(found.at(1))).contains("figures"))
      << "once for each bench";
}

TEST(Doctor, ExplainsHowToStartAMissingBench) {
  const auto found = check_benches({}, {});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_THAT(found[0].advice, HasSubstr("vdrived"));
}

TEST(HostReadings, OfThisMachineHavePlausibleValues) {
  const HostReadings readings = read_host({});
  EXPECT_THAT(readings.library, testing::ContainsRegex("[0-9]+\\.[0-9]+\\.[0-9]+"));
  EXPECT_GT(readings.cores, 0U);
  EXPECT_GT(readings.open_files, 0U);
  EXPECT_TRUE(std::ranges::any_of(readings.interfaces, [](const wire::OwnInterface& one) {
    return one.address == "127.0.0.1" && one.is_up;
  }));
  ASSERT_EQ(readings.multicast.size(), 1U);
  EXPECT_EQ(readings.multicast[0].address, "127.0.0.1");
}

// ---- ROS 2 -----------------------------------------------------------------------------------

RosBench served() {
  return {.session = "0x00000000000000ab",
          .bench = "bench 1",
          .message = "running",
          .control = "this bridge",
          .enable = "true",
          .network = "loopback only"};
}

TEST(DoctorOfRos, NamesTheBridgesOfTheDomainAndTheirControl) {
  GlobalOptions options;
  options.domain = 3;
  const auto nobody = check_ros({}, options);
  ASSERT_EQ(nobody.size(), 1U);
  EXPECT_EQ(nobody[0].severity, Severity::good);
  EXPECT_THAT(nobody[0].text, HasSubstr("no vdrive-ros2 publishes /diagnostics on domain 3"));
  const auto one = check_ros({.benches = {served()}}, {});
  ASSERT_EQ(one.size(), 1U);
  EXPECT_EQ(one[0].severity, Severity::good);
  EXPECT_EQ(one[0].text,
            "vdrive-ros2, session 0x00000000000000ab, loopback only: bench 1 running, controlled "
            "by this bridge");
}

TEST(DoctorOfRos, HintsAtASecondBridgeAndAtJointsThatClash) {
  RosBench second = served();
  second.session = "0x00000000000000cd";
  second.control = "session 0x00000000000000ab";
  RosBench clash = served();
  clash.bench = "bench 2";
  clash.level = 2;
  clash.message = "bench 2 is left out: its joint \"x\" is also on bench 1";
  clash.control = "";
  const auto found = check_ros({.benches = {served(), second, clash}}, {});
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(found[1].severity, Severity::hint);
  EXPECT_THAT(found[1].advice, HasSubstr("another vdrive-ros2 with --enable"));
  EXPECT_EQ(found[2].severity, Severity::hint);
  EXPECT_THAT(found[2].text, HasSubstr("loopback only: bench 2 is left out"));
  EXPECT_THAT(found[2].advice, HasSubstr("--prefix"));
}

TEST(DoctorOfRos, HintsAtAnEnvironmentThatHidesTheBridgeFromNodes) {
  GlobalOptions options;
  options.domain = 5;
  EXPECT_EQ(check_ros({.domain_id = "5", .middleware = "rmw_fastrtps_cpp"}, options).size(), 1U);
  const auto found = check_ros(
      {.domain_id = "7", .middleware = "rmw_zenoh_cpp", .discovery_range = "OFF"}, options);
  ASSERT_EQ(found.size(), 4U);
  EXPECT_THAT(found[1].advice, HasSubstr("--domain 7"));
  EXPECT_THAT(found[2].text, HasSubstr("is not DDS"));
  EXPECT_THAT(found[3].text, HasSubstr("find no other program"));
  for (std::size_t i = 1; i < found.size(); ++i) EXPECT_EQ(found[i].severity, Severity::hint);
}

}  // namespace
}  // namespace vdrive::tool
