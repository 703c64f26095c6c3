// SPDX-License-Identifier: Apache-2.0
// Tests of the checker itself: each rule is shown to fail on a synthetic file that breaks it.
#include "architecture/include_rules.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

namespace vdrive::architecture {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

struct Case {
  std::string name;
  std::string path;
  std::string line;
};

std::string name_of(const testing::TestParamInfo<Case>& info) {
  return info.param.name;
}

class Refuses : public testing::TestWithParam<Case> {};

TEST_P(Refuses, NamesFileLineAndReason) {
  const std::string text = "// SPDX-License-Identifier: Apache-2.0\n" + GetParam().line + "\n";

  EXPECT_THAT(check_source(GetParam().path, text),
              ElementsAre(HasSubstr(GetParam().path + ":2: ")));
}

INSTANTIATE_TEST_SUITE_P(
    IncludeRules, Refuses,
    testing::Values(
        Case{"dds_in_core", "core/src/axis.cpp", "#include <fastdds/dds/topic/Topic.hpp>"},
        Case{"quoted_dds_in_core", "core/src/axis.cpp", "#include \"fastrtps/types.h\""},
        Case{"wire_in_core", "core/src/axis.cpp", "#include \"vdrive/wire/topics.hpp\""},
        Case{"service_in_core", "core/src/axis.cpp", "#include \"vdrive/service/host.hpp\""},
        Case{"logging_library_in_core", "core/src/axis.cpp", "#include <spdlog/spdlog.h>"},
        Case{"thread_in_core", "core/include/vdrive/axis.hpp", "#include <thread>"},
        Case{"lock_in_core", "core/src/axis.cpp", "#  include <mutex>"},
        Case{"file_in_core", "core/src/axis.cpp", "#include <fstream>"},
        Case{"c_library_in_core", "core/src/axis.cpp", "#include <math.h>"},
        Case{"clock_in_core", "core/src/axis.cpp",
             "const auto now = std::chrono::steady_clock::now();"},
        Case{"environment_in_core", "core/src/axis.cpp",
             "const char* home = std::getenv(\"HOME\");"},
        Case{"libm_in_core", "core/src/axis.cpp", "const double y = std::exp(x);"},
        Case{"exchange_in_presence", "clients/src/presence/discovery.cpp",
             "#include \"exchange/bench_links.hpp\""},
        Case{"presence_in_base", "clients/src/base/wakeup.hpp",
             "#include \"presence/directory.hpp\""},
        Case{"stream_in_exchange", "clients/src/exchange/exchange.hpp",
             "#include \"streams/status_stream.hpp\""},
        Case{"clock_in_streams", "clients/src/streams/status_stream.cpp",
             "#include \"clocks/bench_clocks.hpp\""},
        Case{"session_in_clocks", "clients/src/clocks/observer.cpp",
             "#include \"session/session_core.hpp\""},
        Case{"call_in_session", "clients/src/session/session.cpp",
             "#include \"calls/axes_command.hpp\""},
        Case{"group_in_call", "clients/src/calls/axis.cpp", "#include \"groups/group_state.hpp\""},
        Case{"connection_in_group", "clients/src/groups/axis_group.cpp",
             "#include \"exchange/bench_links.hpp\""},
        Case{"header_of_the_client_without_its_room", "clients/src/streams/status_feed.cpp",
             "#include \"status_feed.hpp\""},
        Case{"file_of_the_client_without_a_room", "clients/src/axis.cpp",
             "#include \"base/wakeup.hpp\""},
        Case{"third_level_of_namespaces", "idl/src/guard/rtps.hpp",
             "namespace vdrive::wire::rtps {"},
        Case{"third_level_of_namespaces_in_tests", "tests/churn/roles.hpp",
             "namespace vdrive::test::churn {"},
        Case{"dds_in_codec", "idl/src/codec.cpp", "#include <fastdds/dds/topic/Topic.hpp>"},
        Case{"dds_in_local_bus", "idl/src/local/local_participant.cpp",
             "#include <fastrtps/utils/md5.h>"},
        Case{"dds_in_public_header_of_the_wire", "idl/include/vdrive/wire/participant.hpp",
             "#include <fastdds/dds/domain/DomainParticipant.hpp>"},
        Case{"participant_over_dds_in_wire", "idl/src/participant.cpp",
             "#include \"dds/dds_participant.hpp\""},
        Case{"python_in_client", "clients/src/calls/axis.cpp", "#include <pybind11/pybind11.h>"},
        Case{"wire_in_python", "clients/python/src/axis.cpp",
             "#include \"vdrive/wire/topics.hpp\""},
        Case{"engine_in_wire", "service/src/wire/wire_program.cpp",
             "#include \"engine/bench_engine.hpp\""},
        Case{"store_in_wire", "service/src/wire/wire_process.cpp",
             "#include \"store/parameter_store.hpp\""},
        Case{"wire_in_seam", "service/src/seam/wire_link.hpp",
             "#include \"wire/wire_program.hpp\""},
        Case{"wire_in_supervision", "service/src/supervision/wire_supervisor.cpp",
             "#include \"wire/wire_program.hpp\""},
        Case{"store_in_base", "service/src/base/event_record.hpp",
             "#include \"store/parameter_file.hpp\""},
        Case{"configuration_in_settings", "service/src/settings/yaml_reader.cpp",
             "#include \"configuration/configuration.hpp\""},
        Case{"clock_in_engine", "service/src/engine/bench_clock.cpp",
             "#include \"clock/tick_clock.hpp\""},
        Case{"engine_in_publish", "service/src/publish/status_publisher.cpp",
             "#include \"engine/bench_axes.hpp\""},
        Case{"store_in_clock", "service/src/clock/lockstep_driver.cpp",
             "#include \"store/parameter_store.hpp\""},
        Case{"wire_in_run", "service/src/run/bench_run.hpp", "#include \"wire/wire_program.hpp\""},
        Case{"program_in_run", "service/src/run/bench_run.cpp", "#include \"program/metrics.hpp\""},
        Case{"whole_engine_in_the_program", "service/src/program/service.cpp",
             "#include \"engine/bench_engine.hpp\""},
        Case{"dds_in_bench", "clients/bench/src/bench.cpp",
             "#include <fastdds/dds/topic/Topic.hpp>"},
        Case{"bench_in_client", "clients/src/session/session.cpp",
             "#include \"vdrive/bench/bench.hpp\""},
        Case{"bench_in_gateway", "clients/gateway/src/hub.cpp",
             "#include \"vdrive/bench/bench.hpp\""},
        Case{"bench_in_judge", "clients/judge/src/judge/judge.cpp",
             "#include \"vdrive/bench/bench.hpp\""},
        Case{"client_in_judge", "clients/judge/src/judge/judge.cpp",
             "#include \"vdrive/client/session.hpp\""},
        Case{"log_in_judge", "clients/judge/src/judge/judge.cpp",
             "#include \"log/bus_decoder.hpp\""},
        Case{"bus_in_log_of_judge", "clients/judge/src/log/bus_decoder.cpp",
             "#include \"bus/bus.hpp\""},
        Case{"yaml_in_judge", "clients/judge/src/judge/judge.cpp",
             "#include \"settings/yaml_reader.hpp\""},
        Case{"file_in_judge", "clients/judge/src/judge/judge.cpp", "#include <fstream>"},
        Case{"clock_in_judge", "clients/judge/src/log/bus_decoder.cpp",
             "const auto now = std::chrono::steady_clock::now();"},
        Case{"bus_in_node", "clients/canopen/src/node/node.hpp", "#include \"bus/bus.hpp\""},
        Case{"network_in_node", "clients/canopen/src/node/node.cpp",
             "#include <boost/asio/io_context.hpp>"},
        Case{"client_in_node", "clients/canopen/src/node/node.cpp",
             "#include \"vdrive/client/session.hpp\""},
        Case{"bridge_in_bus", "clients/canopen/src/bus/bus.cpp",
             "#include \"bridge/bench_nodes.hpp\""},
        Case{"kit_in_bus", "clients/canopen/src/bus/bus.cpp", "#include \"reports.hpp\""},
        Case{"engine_in_bridge_to_canopen", "clients/canopen/src/bridge/stepped_bench.cpp",
             "#include \"engine/masters.hpp\""},
        Case{"program_in_clock", "service/src/clock/shutdown.cpp",
             "#include \"program/service.hpp\""},
        Case{"whole_engine_in_a_part_of_it", "service/src/engine/masters.cpp",
             "#include \"engine/bench_engine.hpp\""},
        Case{"whole_engine_in_metrics", "service/src/program/metrics.cpp",
             "#include \"engine/bench_engine.hpp\""},
        Case{"header_of_the_service_without_its_room", "service/src/engine/masters.cpp",
             "#include \"control_table.hpp\""},
        Case{"file_of_the_service_without_a_room", "service/src/masters.cpp",
             "#include \"engine/control_table.hpp\""},
        Case{"command_in_command", "clients/tool/commands/jog.cpp",
             "#include \"commands/velocity.hpp\""},
        Case{"command_in_scenarios", "clients/tool/scenarios/shell.cpp",
             "#include \"commands/run.hpp\""},
        Case{"command_in_table", "clients/tool/command_table.cpp",
             "#include \"commands/move.hpp\""},
        Case{"table_in_command", "clients/tool/commands/run.cpp", "#include \"command_table.hpp\""},
        Case{"execution_in_language", "clients/tool/language/command_line.cpp",
             "#include \"execution/command_context.hpp\""},
        Case{"language_in_output", "clients/tool/output/report.cpp",
             "#include \"language/command.hpp\""},
        Case{"diagnosis_in_execution", "clients/tool/execution/connection.cpp",
             "#include \"diagnosis/doctor.hpp\""},
        Case{"scenarios_in_execution", "clients/tool/execution/recorder.cpp",
             "#include \"scenarios/shell.hpp\""},
        Case{"output_in_program", "clients/tool/tool.cpp", "#include \"output/report.hpp\""},
        Case{"file_of_the_tool_without_a_room", "clients/tool/helpers/text.cpp",
             "#include \"base/blanks.hpp\""},
        Case{"mode_in_demand_generator", "core/src/drive/demand.cpp",
             "#include \"drive/modes/homing.hpp\""},
        Case{"mode_in_mode", "core/src/drive/modes/homing.cpp",
             "#include \"drive/modes/profile_torque.hpp\""},
        Case{"mode_in_state", "core/src/drive/state.hpp", "#include \"drive/modes/homing.hpp\""},
        Case{"drive_in_state_of_mode", "core/src/drive/modes/homing_state.hpp",
             "#include \"drive/state.hpp\""},
        Case{"table_in_mode", "core/src/drive/modes/homing.cpp",
             "#include \"drive/mode_table.hpp\""},
        Case{"neighbour_in_limits", "core/src/drive/limits.cpp", "#include \"drive/stops.hpp\""},
        Case{"tick_in_power", "core/src/drive/power.hpp", "#include \"drive/tick.hpp\""},
        Case{"drive_file_without_layer", "core/src/drive/helper.cpp",
             "#include \"drive/state.hpp\""},
        Case{"drive_in_plant", "core/src/plant/servo_design.cpp", "#include \"drive/state.hpp\""},
        Case{"service_in_idl", "idl/src/participant.cpp", "#include \"vdrive/service/host.hpp\""},
        Case{"logging_library_in_idl", "idl/src/participant.cpp", "#include <spdlog/spdlog.h>"},
        Case{"dds_in_service", "service/src/program/host.cpp",
             "#include <fastdds/dds/topic/Topic.hpp>"},
        Case{"dds_name_in_service", "service/src/program/host.cpp",
             "eprosima::fastdds::dds::DataWriter* w;"},
        Case{"one_dds_version_outside_its_room", "idl/src/dds/reader.cpp",
             "namespace rtps = eprosima::fastrtps::rtps;"},
        Case{"public_header_of_service", "service/src/program/host.cpp",
             "#include \"vdrive/service/clock.hpp\""},
        Case{"client_in_service", "service/src/program/host.cpp",
             "#include \"vdrive/client/session.hpp\""},
        Case{"wire_in_client_header", "clients/include/vdrive/client/session.hpp",
             "#include \"vdrive/wire/topics.hpp\""},
        Case{"messages_in_client_header", "clients/include/vdrive/client/session.hpp",
             "#include \"vdrive_messages.h\""},
        Case{"service_in_client", "clients/src/session/session.cpp",
             "#include \"vdrive/service/host.hpp\""},
        Case{"settings_in_client_library", "clients/src/session/session.cpp",
             "#include \"settings/yaml_reader.hpp\""},
        Case{"settings_in_seam", "service/src/seam/queues.cpp",
             "#include \"settings/yaml_reader.hpp\""},
        Case{"settings_in_core", "core/src/axis.cpp", "#include \"settings/yaml_reader.hpp\""},
        Case{"encoding_in_client", "clients/src/session/session.cpp", "#include <fastcdr/Cdr.h>"},
        Case{"encoding_of_dds_in_idl", "idl/src/codec.cpp", "#include <fastcdr/Cdr.h>"},
        Case{"wire_in_raw_example", "clients/examples/06_raw_dds/raw_dds.c",
             "#include \"vdrive/wire/topics.hpp\""},
        Case{"client_in_raw_example", "clients/examples/06_raw_dds/raw_dds.c",
             "#include <vdrive/client/session.hpp>"},
        Case{"dds_in_other_example", "clients/examples/01_move.cpp", "#include <dds/dds.h>"},
        Case{"wire_in_recording", "clients/recording/src/recording.hpp",
             "#include \"vdrive/wire/topics.hpp\""},
        Case{"messages_in_recording", "clients/recording/src/mcap_recording.cpp",
             "#include \"vdrive_messages.h\""},
        Case{"tests_in_service", "service/src/program/host.cpp",
             "#include \"tests/support/fake.hpp\""},
        Case{"path_that_climbs", "clients/tool/main.cpp",
             "#include \"../../service/src/program/host.hpp\""},
        Case{"code_in_deploy", "deploy/helper.cpp", "#include <vector>"}),
    name_of);

class Allows : public testing::TestWithParam<Case> {};

TEST_P(Allows, ReportsNothing) {
  EXPECT_THAT(check_source(GetParam().path, GetParam().line), IsEmpty());
}

INSTANTIATE_TEST_SUITE_P(
    IncludeRules, Allows,
    testing::Values(
        Case{"eigen_in_core", "core/src/plant/model.cpp", "#include <Eigen/Core>"},
        Case{"durations_in_core", "core/src/axis.cpp", "#include <chrono>"},
        Case{"square_root_in_core", "core/src/axis.cpp", "const double t = std::sqrt(x);"},
        Case{"forbidden_words_in_comments", "core/src/axis.cpp", "// not std::exp(x), see fastdds"},
        Case{"private_header_beside", "core/src/axis.cpp", "#include \"block.hpp\""},
        Case{"own_header_in_mode", "core/src/drive/modes/homing.cpp",
             "#include \"drive/modes/homing.hpp\""},
        Case{"state_of_mode_in_state", "core/src/drive/state.hpp",
             "#include \"drive/modes/homing_state.hpp\""},
        Case{"ground_in_mode", "core/src/drive/modes/homing.cpp", "#include \"drive/frame.hpp\""},
        Case{"tick_in_bank", "core/src/bank/bank_step.cpp", "#include \"drive/tick.hpp\""},
        Case{"dds_in_idl", "idl/src/dds/entities.cpp", "#include <fastdds/dds/topic/Topic.hpp>"},
        Case{"wire_in_client_source", "clients/src/session/session.cpp",
             "#include \"vdrive/wire/topics.hpp\""},
        Case{"encoding_in_recording", "clients/recording/src/status_layout.cpp",
             "#include \"vdrive/wire/cdr.hpp\""},
        Case{"alias_of_a_namespace", "idl/src/dds/library/fast_dds_2.hpp",
             "namespace rtps = eprosima::fastrtps::rtps;"},
        Case{"lower_room_in_client", "clients/src/groups/axis_group.cpp",
             "#include \"calls/axes_command.hpp\""},
        Case{"own_room_in_client", "clients/src/streams/status_feed.cpp",
             "#include \"streams/status_feed.hpp\""},
        Case{"dds_in_raw_example", "clients/examples/06_raw_dds/raw_dds.c", "#include <dds/dds.h>"},
        Case{"messages_in_raw_example", "clients/examples/06_raw_dds/raw_dds.c",
             "#include \"vdrive_messages.h\""},
        Case{"settings_in_bridge", "clients/ros2/src/settings.cpp",
             "#include \"settings/yaml_reader.hpp\""},
        Case{"bench_in_bridge_to_canopen", "clients/canopen/src/bridge/private_benches.hpp",
             "#include \"vdrive/bench/bench.hpp\""},
        Case{"kit_in_bridge_to_canopen", "clients/canopen/src/bridge/bench_drives.hpp",
             "#include \"bench_follower.hpp\""},
        Case{"node_in_log_of_judge", "clients/judge/src/log/bus_decoder.cpp",
             "#include \"node/cob_id.hpp\""},
        Case{"node_in_bus", "clients/canopen/src/bus/bus.hpp", "#include \"node/frame.hpp\""},
        Case{"kit_without_bench_in_bus", "clients/canopen/src/bus/tcp_acceptor.cpp",
             "#include \"tcp_listen.hpp\""},
        Case{"settings_in_configuration", "service/src/configuration/configuration.cpp",
             "#include \"settings/yaml_reader.hpp\""},
        Case{"json_in_tool", "clients/tool/main.cpp", "#include <nlohmann/json.hpp>"},
        Case{"own_header_in_command", "clients/tool/commands/jog.cpp",
             "#include \"commands/jog.hpp\""},
        Case{"table_in_program", "clients/tool/tool.cpp", "#include \"command_table.hpp\""},
        Case{"recording_in_command", "clients/tool/commands/convert.cpp",
             "#include \"convert.hpp\""},
        Case{"everything_in_tests", "tests/system/all.cpp",
             "#include <fastdds/dds/topic/Topic.hpp>"}),
    name_of);

TEST(PrivateHeaders, AreReachedInTheirOwnRoomAndInSettingsOnly) {
  const std::vector<std::string> headers{"service/src/settings/yaml_reader.hpp",
                                         "service/src/engine/masters.hpp",
                                         "clients/bridge/src/messages.hpp"};
  const auto reaches = [&](std::string_view path, std::string_view included) {
    return reaches_private_header(path, included, headers);
  };
  EXPECT_TRUE(reaches("clients/ros2/src/settings.cpp", "settings/yaml_reader.hpp"));
  EXPECT_TRUE(reaches("clients/ros2/src/joints.cpp", "messages.hpp"));
  EXPECT_TRUE(reaches("service/src/engine/masters.cpp", "engine/masters.hpp"));
  EXPECT_FALSE(reaches("clients/ros2/src/settings.cpp", "engine/masters.hpp"));
  EXPECT_FALSE(reaches("service/src/engine/masters.cpp", "messages.hpp"));
  EXPECT_FALSE(reaches("clients/ros2/src/settings.cpp", "yaml_reader2.hpp"));
}

TEST(TopLevel, HasTheRoomsAndNothingElse) {
  EXPECT_THAT(check_top_level({".git", "build", "core", "tests", "README.md"}), IsEmpty());
  EXPECT_THAT(check_top_level({"core", "scripts"}), ElementsAre(HasSubstr("scripts")));
}

}  // namespace
}  // namespace vdrive::architecture
