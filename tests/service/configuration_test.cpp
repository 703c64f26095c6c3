// SPDX-License-Identifier: Apache-2.0
#include "configuration/configuration_file.hpp"
#include "configuration/configuration_help.hpp"
#include "configuration/configuration_warnings.hpp"
#include "support/temporary_directory.hpp"
#include "vdrive/axis_bank.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/plant/model_parameters.hpp"
#include "vdrive/text.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace vdrive::service {
namespace {

using namespace std::chrono_literals;

Configuration parse(const std::string& text) {
  return parse_configuration(text, "bench.yaml");
}

std::string refusal_of(const std::string& text) {
  try {
    static_cast<void>(parse(text));
  } catch (const ConfigurationError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Configuration, WithoutAFileIsTheDemoBench) {
  const Configuration demo = demo_configuration();
  EXPECT_EQ(demo.bench, 1U);
  ASSERT_EQ(demo.axes.size(), 2U);
  EXPECT_EQ(demo.axes[0].number, 1U);
  EXPECT_EQ(demo.axes[0].name, "x");
  EXPECT_EQ(demo.axes[1].name, "y");
  EXPECT_EQ(demo.clock, ClockMode::realtime);
  EXPECT_EQ(demo.period, 1ms);
  EXPECT_EQ(demo.watchdog, 500ms);
}

TEST(Configuration, ReadsEveryKey) {
  const Configuration read = parse(R"(
bench: {number: 7, name: "左 bench"}
clock: {mode: lockstep, period_us: 250, steppers: 5, clock_step: jump, threads: 3, realtime_priority: 40}
status: {every_ticks: 5}
watchdog: {timeout_ms: 250}
metrics: {address: 10.0.0.1, port: 9464}
network: {domain: 9, interfaces: [10.0.0.1], discovery_server: ["10.0.0.9:11811", 10.0.0.8:1], shared_memory: true}
axes:
  - number: 4
    name: lift
    unit: {kind: linear, name: mm, per_unit: 1000.5}
    initial_position: -12
    settings: {acknowledge_while_halted: false, enable_from_switch_on_disabled: false, following_error_is_fault: false, limits_need_homing: true, quick_stop_dwell_ms: 8}
    model: {coupling: two_inertia, feedback: single_encoder, load_inertia: 0.002, backlash: 1e-3}
    parameters: {profile_velocity: 1000, "607Dh:1": -500, profile_deceleration: 0x11}
  - number: 2
)");
  EXPECT_EQ(read.bench, 7U);
  EXPECT_EQ(read.name, "左 bench");
  EXPECT_EQ(read.clock, ClockMode::lockstep);
  EXPECT_EQ(read.period, 250us);
  EXPECT_EQ(read.steppers, 5U);
  EXPECT_EQ(parse("clock: {rate: 2.5}").rate, 2.5);
  EXPECT_EQ(read.clock_step, WallStepPolicy::jump);
  EXPECT_EQ(parse(to_yaml(read)).clock_step, WallStepPolicy::jump);
  EXPECT_EQ(read.threads, 3U);
  EXPECT_EQ(read.realtime_priority, 40);
  EXPECT_EQ(read.status_every, 5U);
  EXPECT_EQ(read.watchdog, 250ms);
  EXPECT_EQ(read.metrics_address, "10.0.0.1");
  EXPECT_EQ(read.metrics_port, 9464);
  EXPECT_EQ(read.network.domain, 9U);
  EXPECT_EQ(read.network.interfaces, std::vector<std::string>{"10.0.0.1"});
  EXPECT_EQ(read.network.discovery_servers,
            (std::vector<std::string>{"10.0.0.9:11811", "10.0.0.8:1"}));
  EXPECT_TRUE(read.network.shared_memory);
  ASSERT_EQ(read.axes.size(), 2U);
  EXPECT_EQ(read.axes[0].number, 2U);  // in ascending order
  EXPECT_EQ(read.axes[0].name, "axis2");
  const auto& lift = read.axes[1].configuration;
  EXPECT_EQ(read.axes[1].name, "lift");
  EXPECT_EQ(read.axes[1].unit, (Unit{.kind = UnitKind::linear, .name = "mm", .size = 1'000.5}));
  EXPECT_EQ(parse(to_yaml(read)).axes[1].unit, read.axes[1].unit);
  EXPECT_EQ(read.axes[0].unit, Unit()) << "a revolution of 4096 user units, shown in degrees";
  EXPECT_EQ(lift.initial_position, -12);
  EXPECT_FALSE(lift.settings.enable_from_switch_on_disabled);
  EXPECT_FALSE(lift.settings.following_error_is_fault);
  EXPECT_FALSE(lift.settings.acknowledge_while_halted);
  EXPECT_TRUE(lift.settings.limits_need_homing);
  EXPECT_EQ(lift.settings.quick_stop_dwell_ms, 8U);
  EXPECT_EQ(lift.model.coupling, Coupling::two_inertia);
  EXPECT_EQ(lift.model.feedback, Feedback::single_encoder);
  EXPECT_EQ(lift.model.load_inertia, 0.002);
  EXPECT_EQ(lift.model.backlash, 1e-3);
  ASSERT_EQ(lift.parameters.size(), 3U);
  EXPECT_EQ(lift.parameters[0].address, (ObjectAddress{0x6081, 0}));
  EXPECT_EQ(lift.parameters[1].address, (ObjectAddress{0x607D, 1}));
  EXPECT_EQ(lift.parameters[1].value, -500);
  EXPECT_EQ(lift.parameters[2].address, (ObjectAddress{0x6084, 0}));
  EXPECT_EQ(lift.parameters[2].value, 17) << "by its name in CiA 402";
}

TEST(Configuration, ReadsNumbersByTheGrammarOfTheTool) {
  const Configuration read = parse("bench: {number: 0x10}\nclock: {period_us: 1e3}\n");
  EXPECT_EQ(read.bench, 16U);
  EXPECT_EQ(read.period, std::chrono::milliseconds(1));
}

TEST(Configuration, OfAnEmptyFileIsTheDefault) {
  EXPECT_EQ(to_yaml(parse("")), to_yaml(demo_configuration()));
  EXPECT_EQ(to_yaml(parse("# only a comment\n")), to_yaml(demo_configuration()));
}

// Messages from strangers can end the wire. In open mode on the loopback interface, only programs
// of this host can send any.
TEST(Configuration, HasAWireOfThreadsOnlyWhereNoStrangerReachesIt) {
  const auto form_of = [](const std::string& text) {
    return effective_wire_form(parse(text));
  };
  EXPECT_EQ(form_of("clock: {mode: realtime}"), WireForm::process);
  for (const std::string clock : {"clock: {mode: lockstep}\n", "clock: {mode: freerun}\n"}) {
    EXPECT_EQ(form_of(clock), WireForm::thread);
    EXPECT_EQ(form_of(clock + "network: {interfaces: [127.0.0.1, 127.0.1.1]}"), WireForm::thread);
    EXPECT_EQ(form_of(clock + "network: {peers: [10.0.0.2]}"), WireForm::thread)
        << "a host to send to, which cannot send here";
    EXPECT_EQ(form_of(clock + "network: {interfaces: [127.0.0.1, 10.0.0.1]}"), WireForm::process);
    EXPECT_EQ(form_of(clock + "network: {security: members/cell}"), WireForm::process);
    EXPECT_EQ(form_of(clock + "network: {security: members/cell}\nwire: {form: thread}"),
              WireForm::thread)
        << "a choice";
    EXPECT_EQ(form_of(clock + "network: {interfaces: [10.0.0.1], shared_memory: true}"),
              WireForm::thread);
  }
}

TEST(Configuration, CanTurnTheWatchdogOff) {
  EXPECT_EQ(parse("watchdog: {timeout_ms: off}").watchdog, std::nullopt);
}

TEST(Configuration, IsTheSameAfterPrintingAndReading) {
  Configuration original = parse(R"(
bench: {number: 3, name: "a: b #1"}
clock: {mode: lockstep, steppers: 3}
watchdog: {timeout_ms: off}
network: {peers: [10.0.0.2, 10.0.0.3]}
axes:
  - {number: 9, name: tilt, model: {motor_inertia: 0.00012345678901234567},
     parameters: {app_speed_limit: 5}}
)");
  const std::string text = to_yaml(original);
  const Configuration again = parse(text);
  EXPECT_EQ(to_yaml(again), text);
  EXPECT_EQ(again.axes[0].configuration.model.motor_inertia,
            original.axes[0].configuration.model.motor_inertia);
  EXPECT_EQ(again.watchdog, std::nullopt);
  EXPECT_EQ(again.steppers, 3U);
  EXPECT_EQ(again.network.peers, (std::vector<std::string>{"10.0.0.2", "10.0.0.3"}));
  EXPECT_EQ(again.name, "a: b #1");
}

// The YAML printer replaces bytes that are not UTF-8 by longer text, and such a configuration would
// not be read back.
TEST(Configuration, NamesAreUtf8WithoutControlCharacters) {
  for (const char* const name : {"左", "\xC3\xA9", "\xF0\x9F\x94\xA7"}) {
    const std::string text = std::string("bench: {name: ") + name + "}";
    EXPECT_EQ(parse(text).name, name);
    EXPECT_EQ(parse(to_yaml(parse(text))).name, name);
  }
  // Not a first byte, a lone first byte, truncated, overlong, a surrogate, above U+10FFFF, no
  // continuation byte (RFC 3629); a control character in YAML's notation, and DEL.
  for (const char* const name :
       {"\xFF", "\xC3", "\xE5\xB7", "\xC0\xAF", "\xE0\x80\xAF", "\xED\xA0\x80", "\xF4\x90\x80\x80",
        "\xC3\xC3", R"(a\x07)", R"(a\x7F)"}) {
    EXPECT_THROW(parse(std::string("bench: {name: \"") + name + "\"}"), ConfigurationError) << name;
    EXPECT_THROW(parse(std::string("axes: [{number: 1, name: \"") + name + "\"}]"),
                 ConfigurationError)
        << name;
  }
}

TEST(Configuration, OfAFreeRunningClockHasNoWatchdogUnlessTheFileNamesOne) {
  EXPECT_EQ(effective_watchdog(parse("clock: {mode: freerun}")), std::nullopt);
  const auto chosen = parse("clock: {mode: freerun}\nwatchdog: {timeout_ms: 50}");
  EXPECT_EQ(effective_watchdog(chosen), std::chrono::milliseconds{50});
  EXPECT_EQ(effective_watchdog(parse("clock: {mode: realtime}")), std::chrono::milliseconds{500});
  const std::string text = to_yaml(parse("clock: {mode: freerun, period_us: 250}"));
  EXPECT_EQ(to_yaml(parse(text)), text);
  EXPECT_EQ(effective_watchdog(parse(text)), std::nullopt);
}

TEST(Configuration, PrintsDiscoveryServersAsItReadsThem) {
  const Configuration original = parse("network: {discovery_server: [10.0.0.9:11811]}");
  EXPECT_EQ(parse(to_yaml(original)).network.discovery_servers,
            std::vector<std::string>{"10.0.0.9:11811"});
}

struct Refused {
  const char* name;
  const char* text;
  const char* message;  ///< the expected beginning
};

class RefusedConfiguration : public testing::TestWithParam<Refused> {};

TEST_P(RefusedConfiguration, NamesFileLineKeyValueAndLimit) {
  const std::string message = refusal_of(GetParam().text);
  EXPECT_TRUE(message.starts_with(GetParam().message)) << message;
}

INSTANTIATE_TEST_SUITE_P(
    Rows, RefusedConfiguration,
    testing::Values(
        Refused{"control_characters", "clock: {mode: \"a\\nb\\e[31m\"}",
                R"(bench.yaml:1: clock.mode = a\nb\x1B[31m: must be one of)"},
        Refused{"control_characters_in_a_key", "{\"a\\nb\": 1}",
                R"(bench.yaml:1: a\nb: unknown key)"},
        Refused{"not_utf8", "bench:\n  name: \"\xFF\"",
                R"(bench.yaml:2: '  name: "\xFF"' is not valid UTF-8)"},
        Refused{"two_documents", "bench: {number: 1}\n---\nbench: {number: 2}",
                "bench.yaml:2: a second YAML document"},
        // The parser consumes nothing of these and reports documents without end.
        Refused{"begins_with_a_comma", ", name: left}",
                "bench.yaml:1: a YAML document cannot begin"},
        Refused{"goes_on_with_a_comma", "bench: {number: 1}\n...\n, {n% ",
                "bench.yaml:3: a second YAML document"},
        Refused{"security_names_nothing", "network: {security: \"\"}",
                "bench.yaml:1: network.security: must name a directory"},
        Refused{"security_without_a_value", "network: {security: }",
                "bench.yaml:1: network.security: must be a single value"},
        Refused{"not_yaml", "bench: [1\nclock: 3", "bench.yaml:2: "},
        Refused{"not_a_map", "hello", "bench.yaml:1: "},
        Refused{
            "unknown_section", "\nbunch: {number: 1}",
            "bench.yaml:2: bunch: unknown key (did you mean 'bench'?); known here: bench, clock, "
            "status"},
        Refused{"unknown_key", "clock:\n  speed: 3",
                "bench.yaml:2: clock.speed: unknown key; known here: mode, period_us"},
        Refused{
            "interface", "network:\n  interfaces: [10.0]",
            "bench.yaml:2: network.interfaces[0] = 10.0: must be an IPv4 address or an interface"},
        Refused{"peer", "network:\n  peers: [10.0.0.1, 10.0.0]",
                "bench.yaml:2: network.peers[1] = 10.0.0: must be an IPv4 address"},
        Refused{"peers_and_server",
                "network:\n  peers: [10.0.0.1]\n  discovery_server: [10.0.0.9:11811]",
                "bench.yaml:2: network"},
        Refused{"discovery_server", "network: {discovery_server: [10.0.0.9]}",
                "bench.yaml:1: network.discovery_server[0] = 10.0.0.9: must be a host and a port"},
        Refused{"key_twice", "clock:\n  rate: 1\n  rate: 2",
                "bench.yaml:3: clock.rate: the key appears twice"},
        Refused{"section_is_no_map", "clock: 7", "bench.yaml:1: clock = 7: must be a map"},
        Refused{"bench_zero", "bench: {number: 0}",
                "bench.yaml:1: bench.number = 0: must be a whole number from 1 to 65535"},
        Refused{"period_short", "clock:\n  period_us: 124",
                "bench.yaml:2: clock.period_us = 124: must be a whole number from 125 to 10000 us"},
        Refused{"period_is_text", "clock: {period_us: fast}",
                "bench.yaml:1: clock.period_us = fast: must be a whole number"},
        Refused{"period_is_broken", "clock: {period_us: 1000.5}",
                "bench.yaml:1: clock.period_us = 1000.5: must be a whole number"},
        Refused{"mode", "clock: {mode: warp}",
                "bench.yaml:1: clock.mode = warp: must be one of realtime, lockstep, freerun"},
        Refused{"clock_step", "clock: {clock_step: leap}",
                "bench.yaml:1: clock.clock_step = leap: must be one of steer, jump"},
        Refused{"rate_in_freerun", "clock:\n  rate: 2\n  mode: freerun",
                "bench.yaml:2: clock.rate = 2: cannot be used with clock.mode freerun"},
        Refused{"rate_in_lockstep", "clock: {mode: lockstep, rate: 2}",
                "bench.yaml:1: clock.rate = 2: cannot be used with clock.mode lockstep, which "
                "advances only when programs step it"},
        Refused{"steppers_in_realtime", "clock: {steppers: 2}",
                "bench.yaml:1: clock.steppers = 2: cannot be used with clock.mode realtime, which "
                "runs by the wall clock"},
        Refused{"steppers", "clock: {mode: lockstep, steppers: 65}",
                "bench.yaml:1: clock.steppers = 65: must be a whole number from 0 to 64"},
        Refused{"rate_low", "clock: {rate: 0.05}",
                "bench.yaml:1: clock.rate = 0.05: must be 0 (paused) or from 0.1 to 100"},
        Refused{"rate_nan", "clock: {rate: nan}",
                "bench.yaml:1: clock.rate = nan: must be a finite number"},
        Refused{"metrics", "metrics: {address: localhost}",
                "bench.yaml:1: metrics.address = localhost: must be an IPv4 address, such as "
                "10.0.0.1"},
        Refused{"watchdog", "watchdog: {timeout_ms: 4}",
                "bench.yaml:1: watchdog.timeout_ms = 4: must be a whole number from 5 to 10000 ms"},
        Refused{"domain", "network: {domain: 233}",
                "bench.yaml:1: network.domain = 233: must be a whole number from 0 to 232"},
        Refused{"boolean", "network: {shared_memory: maybe}",
                "bench.yaml:1: network.shared_memory = maybe: must be one of false, true"},
        Refused{"no_axes", "axes: []", "bench.yaml:1: axes: a bench needs at least one axis"},
        Refused{"axis_without_number", "axes:\n  - {name: a}",
                "bench.yaml:2: axes[0]: the axis has no number; add number: 1 to 65535"},
        Refused{"axis_twice", "axes:\n  - {number: 1}\n  - {number: 1}",
                "bench.yaml:3: axes[1]: axis number 1 appears twice"},
        Refused{"name_twice", "axes:\n  - {number: 1, name: a}\n  - {number: 2, name: a}",
                "bench.yaml:3: axes[1]: axis name a appears twice"},
        Refused{"name_like_a_number", "axes:\n  - {number: 1, name: 1.2}",
                "bench.yaml:2: axes[0].name = 1.2: a name must not contain spaces"},
        Refused{
            "model_key", "axes:\n  - number: 1\n    model: {inertia: 1}",
            "bench.yaml:3: axes[0].model.inertia: unknown key; known here: coupling, feedback, "},
        Refused{"model_value", "axes:\n  - number: 1\n    model: {motor_inertia: 0}",
                "bench.yaml:3: axes[0].model.motor_inertia = 0: must be from 1e-08 to 10000 kg.m2"},
        Refused{"model_below_its_limit", "axes:\n  - number: 1\n    model: {motor_inertia: 1e-9}",
                "bench.yaml:3: axes[0].model.motor_inertia = 1e-9: must be from 1e-08 to 10000 "
                "kg.m2"},
        Refused{"model_above_its_limit", "axes:\n  - number: 1\n    model:\n      backlash: 99",
                "bench.yaml:4: axes[0].model.backlash = 99: must be from 0 to 6.3 rad"},
        Refused{"model_end_stops",
                "axes:\n  - number: 1\n    model: {lower_end_stop: 5, upper_end_stop: 3}",
                "bench.yaml:3: axes[0].model.lower_end_stop = 5: must be below upper_end_stop = 3 "
                "UU"},
        Refused{"model_negative", "axes:\n  - number: 1\n    model: {backlash: -1}",
                "bench.yaml:3: axes[0].model.backlash = -1: must be from 0 to 6.3 rad"},
        Refused{
            "two_inertia_needs_a_load",
            "axes:\n  - number: 1\n    model:\n      load_inertia: 0\n      coupling: two_inertia",
            "bench.yaml:4: axes[0].model.load_inertia = 0: must be from 1e-08 to 10000 kg.m2"},
        Refused{"unknown_object", "axes:\n  - number: 1\n    parameters: {speed: 1}",
                "bench.yaml:3: axes[0].parameters.speed = 1: no such object"},
        Refused{"index_without_the_mark_of_hex", "axes:\n  - number: 1\n    parameters: {6081: 1}",
                "bench.yaml:3: axes[0].parameters.6081 = 1: no such object (did you mean 0x6081 or "
                "6081h?)"},
        Refused{"fraction_of_an_object",
                "axes:\n  - number: 1\n    parameters: {profile_velocity: 12.5}",
                "bench.yaml:3: axes[0].parameters.profile_velocity = 12.5: must be a whole number "
                "from 0 UU/s (0.00 deg/s) to 4294967295 UU/s (377487359.91 deg/s), or"},
        Refused{"unknown_index", "axes:\n  - number: 1\n    parameters: {\"0x6FFF\": 1}",
                "bench.yaml:3: axes[0].parameters.0x6FFF = 1: no such object"},
        Refused{"parameter_range", "axes:\n  - number: 1\n    parameters: {motor_max_speed_rpm: 0}",
                "bench.yaml:3: axes[0].parameters.motor_max_speed_rpm = 0: must be a whole number "
                "from 1 to 4294967295 RPM"},
        Refused{"parameter_in_user_units",
                "axes:\n  - number: 1\n    parameters: {profile_velocity: -1}",
                "bench.yaml:3: axes[0].parameters.profile_velocity = -1: must be a whole number "
                "from 0 UU/s (0.00 deg/s) to 4294967295 UU/s (377487359.91 deg/s)"},
        Refused{"parameter_without_a_meaning",
                "axes:\n  - number: 7\n    parameters:\n      homing_method: 36",
                "bench.yaml:4: axes[0].parameters.homing_method = 36: must be -4 to 14, 17 to 30, "
                "33 to 35 or 37"},
        Refused{"option_code_without_a_meaning",
                "axes:\n  - number: 7\n    parameters:\n      0x60F2: 3",
                "bench.yaml:4: axes[0].parameters.0x60F2 = 3: must be 0, 1 or 2"},
        Refused{
            "direction_without_a_range", "axes:\n  - number: 7\n    parameters:\n      0x60F2: 64",
            "bench.yaml:4: axes[0].parameters.0x60F2 = 64: must be 0, 1 or 2, because bits 6 and "
            "7 need a modulo axis: set min_position_range_limit (607Bh:1) below "
            "max_position_range_limit (607Bh:2)"},
        Refused{"parameter_with_few_values",
                "axes:\n  - number: 1\n    parameters: {halt_option_code: 5}",
                "bench.yaml:3: axes[0].parameters.halt_option_code = 5: must be 1 to 4"},
        Refused{"mistyped_object", "axes:\n  - number: 1\n    parameters: {profil_velocity: 1}",
                "bench.yaml:3: axes[0].parameters.profil_velocity = 1: no such object (did you "
                "mean 'profile_velocity'?); write its variable_name"},
        Refused{"wrong_subindex", "axes:\n  - number: 1\n    parameters: {\"0x607D:3\": 1}",
                "bench.yaml:3: axes[0].parameters.0x607D:3 = 1: no such object: 607Dh has "
                "sub-indices 1 and 2"},
        Refused{"mistyped_mode", "clock: {mode: realtme}",
                "bench.yaml:1: clock.mode = realtme: must be one of realtime, lockstep, freerun "
                "(did you mean 'realtime'?)"},
        Refused{"mistyped_key_of_the_model", "axes:\n  - number: 1\n    model: {motor_inertai: 1}",
                "bench.yaml:3: axes[0].model.motor_inertai: unknown key (did you mean "
                "'motor_inertia'?); known here: coupling, "},
        Refused{"parameter_twice",
                "axes:\n  - number: 1\n    parameters:\n      profile_velocity: 1\n"
                "      \"0x6081\": 2",
                "bench.yaml:5: axes[0].parameters.0x6081 = 2: the same object, 0x6081, has the "
                "value 1 UU/s (0.09 deg/s) in line 4"},
        Refused{"parameter_is_a_command", "axes:\n  - number: 1\n    parameters: {6040h: 15}",
                "bench.yaml:3: axes[0].parameters.6040h = 15: ds402_controlword (0x6040) is not a "
                "parameter, because writing it commands the axis; parameters are objects that keep "
                "a value, such as profile_velocity, and test inputs, such as test_load_torque"},
        Refused{"parameter_stores", "axes:\n  - number: 1\n    parameters: {\"1010h:1\": 1}",
                "bench.yaml:3: axes[0].parameters.1010h:1 = 1: store_all_parameters (0x1010:1) is "
                "not a parameter, because writing it stores or restores parameters; "},
        Refused{"parameter_clears", "axes:\n  - number: 1\n    parameters: {\"1003h:0\": 0}",
                "bench.yaml:3: axes[0].parameters.1003h:0 = 0: error_history_count (0x1003) is not "
                "a parameter, because writing it clears the error history; "},
        Refused{"parameter_read_only",
                "axes:\n  - number: 1\n    parameters: {ds402_statusword: 1}",
                "bench.yaml:3: axes[0].parameters.ds402_statusword = 1: "}),
    [](const auto& row) {
      return row.param.name;
    });

TEST(Configuration, GivesAnAxisTheIdentityThatAMasterExpects) {
  const Configuration configuration =
      parse("axes:\n  - number: 1\n    parameters: {vendor_id: 0x1234, \"1018h:4\": 4294967295}");
  const auto parameters = bank_axes(configuration)[0].parameters;
  ASSERT_EQ(parameters.size(), 2U);
  EXPECT_EQ(parameters[0].address, (ObjectAddress{0x1018, 1}));
  EXPECT_EQ(parameters[0].value, 0x1234);
  EXPECT_EQ(parameters[1].address, (ObjectAddress{0x1018, 4}));
  EXPECT_EQ(parameters[1].value, 4'294'967'295);
}

// A mistake does not hide those after it. What can be judged only in a correct file, such as the
// missing number of axis 2, is not judged.
TEST(Configuration, IsRefusedWithEachMistakeInItsLine) {
  EXPECT_EQ(refusal_of("bench: {number: 0}\n"
                       "clock:\n"
                       "  mode: warp\n"
                       "  speed: 3\n"
                       "  period_us: 7\n"
                       "axes:\n"
                       "  - number: 1\n"
                       "    parameters:\n"
                       "      profile_velocity: -1\n"
                       "      homing_method: 36\n"
                       "  - number: 70000\n"
                       "  - number: 3\n"
                       "    model:\n"
                       "      backlash: 99\n"
                       "      motor_inertia: 0\n"
                       "    parameters: {profile_velocity: -1}\n"),
            "bench.yaml:1: bench.number = 0: must be a whole number from 1 to 65535\n"
            "bench.yaml:3: clock.mode = warp: must be one of realtime, lockstep, freerun\n"
            "bench.yaml:4: clock.speed: unknown key; known here: mode, period_us, rate, steppers, "
            "clock_step, threads, realtime_priority\n"
            "bench.yaml:5: clock.period_us = 7: must be a whole number from 125 to 10000 us\n"
            "bench.yaml:9: axes[0].parameters.profile_velocity = -1: must be a whole number from 0 "
            "UU/s (0.00 deg/s) to 4294967295 UU/s (377487359.91 deg/s)\n"
            "bench.yaml:10: axes[0].parameters.homing_method = 36: must be -4 to 14, 17 to 30, "
            "33 to 35 or 37\n"
            "bench.yaml:11: axes[1].number = 70000: must be a whole number from 1 to 65535\n"
            "bench.yaml:14: axes[2].model.backlash = 99: must be from 0 to 6.3 rad\n"
            "bench.yaml:15: axes[2].model.motor_inertia = 0: must be from 1e-08 to 10000 kg.m2\n"
            "bench.yaml:16: axes[2].parameters.profile_velocity = -1: must be a whole number from "
            "0 UU/s (0.00 deg/s) to 4294967295 UU/s (377487359.91 deg/s)");
}

// A file of 4 MiB has room for a million mistakes.
TEST(Configuration, IsRefusedWithAHundredMistakesAtMost) {
  std::string text = "axes:\n";
  for (int axis = 0; axis < 150; ++axis) text += "  - {number: 0, name: 1}\n";
  const std::string refusal = refusal_of(text);
  EXPECT_EQ(std::ranges::count(refusal, '\n'), 100);
  EXPECT_TRUE(refusal.ends_with("\nstopped after 100 mistakes")) << refusal;
}

// Of the 64 characters shown, 48 are from the beginning and 16 from the end.
TEST(Configuration, IsRefusedWithALongValueShortened) {
  EXPECT_EQ(refusal_of("clock: {mode: " + std::string(10'000, 'a') + "}"),
            "bench.yaml:1: clock.mode = " + std::string(48, 'a') + "..." + std::string(16, 'a') +
                ": must be one of realtime, lockstep, freerun");
}

TEST(Configuration, MayHaveATestInputFromPowerUpOn) {
  EXPECT_EQ(parse("axes: [{number: 1, parameters: {test_load_torque: 500}}]")
                .axes[0]
                .configuration.parameters.at(0)
                .value,
            500);
}

TEST(Configuration, MayUseAnAliasForWhatSeveralAxesHave) {
  const Configuration configuration = parse(
      "axes:\n  - {number: 1, parameters: &all {profile_velocity: 7}}\n"
      "  - {number: 2, parameters: *all}\n");
  EXPECT_EQ(configuration.axes[1].configuration.parameters.at(0).value, 7);
}

// Each line refers ten times to the previous line: 10^20 values.
TEST(Configuration, WhoseAliasesMultiplyIsRefusedWithTheLimit) {
  std::string text = "l0: &l0 [" + std::string(10, '1') + "]\n";
  for (int level = 1; level <= 20; ++level) {
    const std::string before = "*l" + std::to_string(level - 1);
    text += "l" + std::to_string(level) + ": &l" + std::to_string(level) + " [" + before;
    for (int count = 1; count < 10; ++count) text += ", " + before;
    text += "]\n";
  }
  EXPECT_EQ(refusal_of(text),
            "bench.yaml:7: more than 2097152 values, with each alias replaced by what it names");
  EXPECT_EQ(refusal_of("axes: &all [*all]"),
            "bench.yaml:1: an alias refers to a node that contains it");
}

TEST(Configuration, NestedWithoutEndIsRefusedWithTheLimit) {
  for (const char* const part : {"[", "{a: ", "- "}) {
    std::string text;
    for (int depth = 0; depth < 100'000; ++depth) text += part;
    EXPECT_EQ(refusal_of(text), "bench.yaml:1: nested more than 32 levels deep") << part;
  }
}

TEST(Configuration, HasExactlyOneYamlDocument) {
  EXPECT_EQ(parse("---\nbench: {number: 7}\n").bench, 7U) << "a mark at the begin is none too many";
  EXPECT_EQ(parse("bench: {number: 7}\n...\n").bench, 7U);
  EXPECT_EQ(parse("\xEF\xBB\xBF"
                  "bench: {number: 7}\n")
                .bench,
            7U)
      << "the mark of UTF-8";
  EXPECT_NE(refusal_of("bench: {number: 7}\n---\n").find("a second YAML document"),
            std::string::npos)
      << "an empty one counts too";
}

// "a: 1" in UTF-16 and UTF-32, with and without a byte order mark.
TEST(Configuration, InUtf16OrUtf32IsRefusedAsSuch) {
  using namespace std::string_literals;
  for (const std::string& text :
       {"\xFF\xFE"s + "a\0:\0 \0001\0"s, "\xFE\xFF"s + "\0a\0:\0 \0001"s, "a\0:\0 \0001\0"s,
        "\0a\0:\0 \0001"s, "\0\0\0a\0\0\0:\0\0\0 \0\0\0001"s}) {
    EXPECT_EQ(refusal_of(text), "bench.yaml: is encoded in UTF-16 or UTF-32; it must be UTF-8");
  }
  EXPECT_EQ(refusal_of("bench: {number: 7}\n# a\0b"s),
            R"(bench.yaml:2: '# a\x00b' is not valid UTF-8)")
      << "what follows a zero was not read";
}

TEST(Configuration, OfAnOpenBenchIsPrintedWithoutACredentialDirectory) {
  EXPECT_EQ(to_yaml(demo_configuration()).find("security"), std::string::npos);
  const Configuration closed = parse("network: {security: members/cell}");
  EXPECT_EQ(parse(to_yaml(closed)).network.security, "members/cell");
}

std::string refusal_of_file(const std::filesystem::path& file) {
  try {
    static_cast<void>(load_configuration(file));
  } catch (const ConfigurationError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Configuration, OfAFileThatIsTooLargeIsRefusedWithItsSizeAndTheLimit) {
  const test::TemporaryDirectory directory;
  const auto file = directory.path() / "bench.yaml";
  std::ofstream(file) << "bench: {number: 7}\n#" << std::string(kLargestSettingsFile - 20, '.');
  EXPECT_EQ(load_configuration(file).bench, 7U) << "exactly as large as permitted";
  std::ofstream(file, std::ios::app) << '.';
  EXPECT_EQ(refusal_of_file(file), file.string() + ": has 4194305 bytes; the limit is 4194304");
  EXPECT_EQ(refusal_of_file("/dev/zero"), "/dev/zero: has more bytes than the limit, 4194304");
}

TEST(Configuration, ReportsWhyAFileCannotBeRead) {
  EXPECT_EQ(refusal_of_file("/nowhere/bench.yaml"),
            "/nowhere/bench.yaml: cannot be read: No such file or directory");
  const test::TemporaryDirectory directory;
  EXPECT_EQ(refusal_of_file(directory.path()),
            directory.path().string() + ": is a directory, not a file");
  const std::filesystem::path empty = directory.path() / "empty.yaml";
  std::ofstream(empty).close();
  EXPECT_EQ(refusal_of_file(empty),
            empty.string() + ": is empty; without --config the service has the demo bench");
}

TEST(Configuration, ReportsTheLineThatATabIndents) {
  EXPECT_EQ(refusal_of("bench:\n  number: 1\nclock:\n\tmode: lockstep\n"),
            "bench.yaml:4: this line is indented with a tab; YAML allows only spaces");
  EXPECT_EQ(refusal_of("bench:\n  number: 1\n  \tname: x\n"),
            "bench.yaml:3: this line is indented with a tab; YAML allows only spaces");
  EXPECT_EQ(refusal_of("bench: {number: 1}\t# behind the value\n"), "accepted");
}

std::string refusal_of_unit(const std::string& unit) {
  return refusal_of("axes:\n  - number: 1\n    unit: " + unit + "\n");
}

TEST(Configuration, CanSelectTheUnitOfARotaryAxis) {
  const Configuration read =
      parse("axes: [{number: 1, unit: {kind: rotary, name: rev, per_revolution: 8192}}]");
  EXPECT_EQ(read.axes[0].unit, (Unit{.kind = UnitKind::rotary, .name = "rev", .size = 8'192.0}));
  EXPECT_EQ(parse(to_yaml(read)).axes[0].unit, read.axes[0].unit);
}

TEST(Configuration, RefusesAUnitThatIsIncompleteMixedOrOutOfRange) {
  const std::string place = "bench.yaml:3: axes[0].unit";
  EXPECT_EQ(refusal_of_unit("{name: mm}"), place + ": a unit needs a kind: rotary or linear");
  EXPECT_EQ(refusal_of_unit("{kind: curved}"),
            place + ".kind = curved: must be one of rotary, linear");
  EXPECT_EQ(refusal_of_unit("{kind: linear, name: mm}"),
            place +
                ": a linear unit needs name and per_unit, such as {kind: linear, name: mm, "
                "per_unit: 819.2}");
  EXPECT_EQ(refusal_of_unit("{kind: rotary, per_unit: 5}"),
            place + ".per_unit = 5: cannot be used with kind: rotary; use per_revolution");
  EXPECT_EQ(refusal_of_unit("{kind: linear, name: m2, per_unit: 5}"),
            place + ".name = m2: the name of a unit may contain only letters and %, such as mm");
  for (const char* const size : {"0", "-1", "9e-07", "1.1e+09"}) {
    EXPECT_EQ(refusal_of_unit(std::string("{kind: rotary, per_revolution: ") + size + "}"),
              place + ".per_revolution = " + size + ": must be from 1e-06 to 1e+09 user units");
  }
  EXPECT_EQ(refusal_of_unit("{kind: rotary, per_revolution: nan}"),
            place + ".per_revolution = nan: must be a finite number [user units]");
}

constexpr const char* kAxisWith = "axes:\n  - number: 1\n    parameters:\n";

TEST(Configuration, RefusesALowerLimitThatIsNotBelowTheUpperOne) {
  for (const char* const lower : {"201", "200"}) {
    EXPECT_EQ(refusal_of(std::string(kAxisWith) + "      user_position_upper_limit: 200\n" +
                         "      user_position_lower_limit: " + lower + "\n"),
              std::string("bench.yaml:5: axes[0].parameters.user_position_lower_limit = ") + lower +
                  ": must be below user_position_upper_limit (607Dh:2) = 200 UU (17.58 deg)");
  }
  EXPECT_EQ(refusal_of(std::string(kAxisWith) + "      \"0x607D:1\": 199\n" +
                       "      \"0x607D:2\": 200\n"),
            "accepted");
}

TEST(Configuration, WarnsOfLimitsThatAreOff) {
  const std::string limit = std::string(kAxisWith) + "      \"0x607D:2\": 200\n";
  const std::vector<std::string> warnings = start_warnings(parse(limit));
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_EQ(warnings[0],
            "bench.yaml:4: axes[0].parameters.0x607D:2 = 200: axis 1 axis1: "
            "user_position_upper_limit = 200 UU (17.58 deg) has no effect because "
            "app_position_limit_switch (3535h) is 0; set it to 1");
  EXPECT_EQ(start_warnings(parse(limit + "      app_position_limit_switch: 0\n")).size(), 1U);
  EXPECT_TRUE(start_warnings(parse(limit + "      app_position_limit_switch: 1\n")).empty());
  EXPECT_TRUE(start_warnings(demo_configuration()).empty());
}

/// @return the example of docs/guides/configuration.md: its first block of YAML.
std::string documented_example() {
  std::ifstream page(VDRIVE_SOURCE_DIR "/docs/guides/configuration.md");
  std::string text;
  bool is_inside = false;
  for (std::string line; std::getline(page, line);) {
    if (is_inside && line == "```") break;
    if (is_inside) text += line + "\n";
    is_inside = is_inside || line == "```yaml";
  }
  return text;
}

TEST(Configuration, OfTheGuideHasNoWarningAndItsLimitsAreInForce) {
  const Configuration example = parse(documented_example());
  EXPECT_TRUE(start_warnings(example).empty());
  const std::vector<AxisConfiguration> axes = bank_axes(example);
  AxisBank bank(axes, example.period);
  EXPECT_EQ(bank.read(0, {0x3535, 0}).value, 1);
  EXPECT_EQ(bank.read(0, {0x607D, 1}).value, -100'000);
}

// The guide has only the names; `vdrived --help-config` has the units, limits and defaults.
TEST(Configuration, OfTheGuideNamesEachModelParameter) {
  std::ifstream file(VDRIVE_SOURCE_DIR "/docs/guides/configuration.md");
  std::ostringstream page;
  page << file.rdbuf();
  for (const ModelParameter& parameter : kModelParameters) {
    EXPECT_NE(page.str().find("`" + std::string(parameter.name) + "`"), std::string::npos)
        << parameter.name;
  }
}

TEST(Configuration, AcceptsEachModelParameterUpToItsLimits) {
  for (const ModelParameter& parameter : kModelParameters) {
    SCOPED_TRACE(parameter.name);
    const auto with = [&](double value) {
      return "axes: [{number: 1, model: {coupling: two_inertia, " + std::string(parameter.name) +
             ": " + to_text(value) + "}}]";
    };
    EXPECT_EQ(refusal_of(with(parameter.lowest)), "accepted");
    EXPECT_EQ(refusal_of(with(parameter.highest)), "accepted");
    EXPECT_NE(refusal_of(with(parameter.highest * 1.001)), "accepted");
    EXPECT_NE(refusal_of(with(parameter.lowest - std::abs(parameter.lowest) * 0.001 - 1e-12)),
              "accepted");
  }
}

// ---- help ------------------------------------------------------------------------------------

/// @return the keys that the error about an unknown key of a section names.
std::vector<std::string> known_keys(const std::string& text) {
  const std::string message = refusal_of(text);
  const std::string_view title = "known here: ";
  const auto begin = message.find(title);
  std::vector<std::string> keys;
  if (begin == std::string::npos) return keys;
  std::istringstream list(message.substr(begin + title.size()));
  for (std::string key; std::getline(list >> std::ws, key, ',');) keys.push_back(key);
  return keys;
}

TEST(ConfigurationHelp, DescribesEachKeyThatIsRead) {
  const std::string help = configuration_help();
  const auto expect_described = [&help](const std::string& prefix, const std::string& text) {
    const auto keys = known_keys(text);
    EXPECT_FALSE(keys.empty()) << text;
    for (const std::string& key : keys) {
      const std::string path = "\n" + prefix + key;
      EXPECT_NE(("\n" + help).find(path), std::string::npos)
          << prefix << key << " has no text in its row";
    }
  };
  for (const std::string& section : known_keys("zz: 1")) {
    if (section == "axes") continue;
    expect_described(section + ".", section + ": {zz: 1}");
  }
  expect_described("axes[].", "axes: [{zz: 1}]");
  expect_described("axes[].settings.", "axes: [{number: 1, settings: {zz: 1}}]");
  expect_described("axes[].model.", "axes: [{number: 1, model: {zz: 1}}]");
}

// The help texts contain the limits in words; a refusal shows the limits in force.
TEST(ConfigurationHelp, NamesTheLimitsThatAreInForce) {
  std::size_t compared = 0;
  for (const ConfigurationKey& key : configuration_keys()) {
    std::string path(key.path);
    std::string text;
    if (path.starts_with("axes[].settings.")) {
      text = "axes: [{number: 1, settings: {" + path.substr(16) + ": zz}}]";
    } else if (path == "axes[].number") {
      text = "axes: [{number: zz}]";
    } else if (!path.starts_with("axes")) {
      const auto dot = path.find('.');
      text = path.substr(0, dot) + ": {" + path.substr(dot + 1) + ": zz}";
    }
    const std::string refusal = refusal_of(text);
    const std::string_view title = "must be a whole number from ";
    const auto begin = refusal.find(title);
    if (begin == std::string::npos) continue;
    const std::string limits = refusal.substr(begin + title.size());  // "1 to 64 ms"
    const auto end = limits.find_first_not_of("0123456789", limits.find(" to ") + 4);
    EXPECT_NE(key.what.find(limits.substr(0, end)), std::string_view::npos)
        << path << ": " << key.what << " " << limits;
    ++compared;
  }
  EXPECT_GE(compared, 9U);
}

TEST(ConfigurationHelp, HasTheDefaultsOfAPrintedConfiguration) {
  const std::string help = configuration_help();
  EXPECT_NE(help.find("\nclock.period_us\n    Length of a tick, 125 to 10000 us. Default: 1000.\n"),
            std::string::npos);
  EXPECT_NE(help.find("\naxes[].model.backlash\n    of the shaft, at the load, both directions "
                      "together, 0 to 6.3 rad. Default: 0.\n"),
            std::string::npos);
}

// ---- warnings --------------------------------------------------------------------------------

std::vector<std::string> warnings_of(const std::string& text) {
  const test::TemporaryDirectory directory;
  const auto file = directory.path() / "bench.yaml";
  std::ofstream(file) << text;
  std::vector<std::string> warnings = loop_warnings(file);
  for (std::string& warning : warnings) warning.erase(0, directory.path().string().size() + 1);
  return warnings;
}

TEST(ConfigurationWarnings, AreAbsentForStableLoads) {
  EXPECT_TRUE(warnings_of("bench: {number: 2}").empty());
  EXPECT_TRUE(
      warnings_of("axes: [{number: 1}, {number: 2, model: {coupling: two_inertia}}]").empty());
  EXPECT_TRUE(warnings_of("axes:\n  - number: 1\n    model: {load_inertia: 0.03}\n"
                          "    parameters: {gear_ratio_numerator: 1, gear_ratio_denominator: 10}\n")
                  .empty());
}

// 0.1 kg.m2 times 10² and the motor's 3e-4 kg.m2 are 33334 times the inertia of the motor; 409600
// UU/s² at the load are 20π rad/s² at the motor, which takes 628 N.m on 10.0003 kg.m2.
TEST(ConfigurationWarnings, NameLineAndAxisOfAnInvertedGear) {
  const auto warnings = warnings_of(
      "axes:\n  - {number: 2, name: table}\n  - number: 1\n    name: lift\n"
      "    model: {load_inertia: 0.1}\n    parameters: {gear_ratio_numerator: 10}\n");
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_EQ(warnings.front(),
            "bench.yaml:3: axes[1]: axis 1 (lift): profile_acc and profile_dec need 628 N.m at the "
            "motor, whose limit is 9 N.m; the total inertia is 33334 times the motor inertia, the "
            "load turns 10 times as fast as the motor (a reduction gear has gear_ratio_numerator "
            "below gear_ratio_denominator)");
}

// An elastic load of a hundred times the motor's inertia leaves 1000 Hz / 101 for the velocity
// loop.
TEST(ConfigurationWarnings, NameTheReducedBandwidthOfALoad) {
  const auto warnings =
      warnings_of("axes: [{number: 1, model: {coupling: two_inertia, load_inertia: 0.03}}]");
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings.front().find("the velocity loop reaches only 9.9 of 100 Hz"),
            std::string::npos)
      << warnings.front();
}

TEST(DefaultAxes, AreNumberedFromOneUpToTheLimit) {
  const auto axes = default_axes(kMaxAxes);
  EXPECT_EQ(axes.front().number, 1U);
  EXPECT_EQ(axes.back().number, kMaxAxes);
  EXPECT_EQ(axes.back().name, "axis16384");
  EXPECT_THROW(static_cast<void>(default_axes(kMaxAxes + 1)), ConfigurationError);
  EXPECT_THROW(static_cast<void>(default_axes(0)), ConfigurationError);
}

TEST(BankAxes, HaveSerialNumbersOfBenchAndAxis) {
  Configuration configuration = demo_configuration();
  configuration.bench = 3;
  EXPECT_EQ(bank_axes(configuration)[1].serial_number, 3U * 65'536U + 2U);
}

}  // namespace
}  // namespace vdrive::service
