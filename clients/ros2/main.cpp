// SPDX-License-Identifier: Apache-2.0
#include "bridge.hpp"
#include "bridge_program.hpp"
#include "network_options.hpp"
#include "settings/configuration_error.hpp"
#include "settings/yaml_reader.hpp"
#include "standard_streams.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/wire/bench_number.hpp"
#include "vdrive/wire/library_log.hpp"
#include "vdrive/wire/program_version.hpp"

#include <CLI/CLI.hpp>

#include <csignal>
#include <cstdlib>
#include <iostream>
#include <string>

namespace vdrive::ros2 {
namespace {

struct Arguments {
  Settings settings;
  std::string file;
  std::string name_space;
  std::optional<double> rate;
  std::vector<std::uint32_t> benches;
  bool enable = false;
  bool prefix = false;
  bool only_checks = false;
};

void declare(CLI::App& app, Arguments& arguments) {
  client::SessionOptions& session = arguments.settings.session;
  app.set_version_flag("--version", wire::program_version("vdrive-ros2"));
  bridge::add_domain_option(app, session.domain, "; ROS_DOMAIN_ID of the nodes");
  app.add_option("--bench", arguments.benches,
                 "Serve this bench, 1 to " + std::to_string(wire::kHighestBench) +
                     "; may be repeated; default: all")
      ->transform(bridge::whole_number(1, wire::kHighestBench))
      ->type_name("N");
  app.add_option("--namespace", arguments.name_space, "Prefix for topic names, such as /cell1")
      ->type_name("NAME");
  app.add_flag("--enable", arguments.enable,
               "Enable the axes of each bench that is found; default: command nothing until the "
               "topic enable is true");
  app.add_flag("--prefix", arguments.prefix, "Name joints bench1_x instead of x");
  app.add_option("--rate", arguments.rate,
                 "Joint states a second, " + to_text(Settings::kLowestRate) + " to " +
                     to_text(Settings::kHighestRate) + "; default: " + to_text(Settings{}.rate))
      ->check(CLI::Range(Settings::kLowestRate, Settings::kHighestRate))
      ->type_name("HZ");
  app.add_option("--config", arguments.file, "YAML file; options of the command line override it")
      ->type_name("FILE");
  app.add_flag("--check", arguments.only_checks, "Check command line and configuration, then exit");
  bridge::add_network_options(app, session);
}

/// Reads the file, then applies the options of the command line.
void complete(Arguments& arguments) {
  Settings& settings = arguments.settings;
  if (!arguments.file.empty()) {
    read_settings(vdrive::settings::read_yaml_file(arguments.file), arguments.file, settings);
  }
  if (!arguments.name_space.empty()) settings.name_space = arguments.name_space;
  if (!arguments.benches.empty()) settings.benches = arguments.benches;
  if (arguments.rate) settings.rate = *arguments.rate;
  settings.is_enabled = settings.is_enabled || arguments.enable;
  settings.is_prefixed = settings.is_prefixed || arguments.prefix;
  // After the file, because only now is it known whether the closed mode is used.
  settings.session.find_timeout = bridge::find_timeout_of(settings.session);
  // Nothing may be commanded from an old state: after a silence, a link discards the state and
  // starts to follow the bench again.
  settings.session.patience = settings.session.silence;
  resolve_topics(settings);
}

/// Blocks SIGINT and SIGTERM in every thread; sigwait() receives them.
sigset_t block_end_signals() {
  sigset_t signals{};
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

int serve(const Arguments& arguments) {
  const sigset_t signals = block_end_signals();
  Bridge bridge(arguments.settings);
  const wire::LibraryLog log([&bridge](const std::string& /*part*/, const std::string& words) {
    bridge.report_library(words);
  });
  std::cout << "vdrive-ros2: " << arguments.settings.topics.joint_states
            << (arguments.settings.is_enabled ? " (axes are enabled)" : " (axes are not enabled)")
            << ", session " << session_text(bridge.session()) << std::endl;
  int received = 0;
  sigwait(&signals, &received);
  return bridge::kDone;
}

/// Parses the command line, and serves until SIGINT or SIGTERM.
/// @return the exit code: 0 done, 1 no network, 2 bad command line or configuration
int run_command_line(int argument_count, const char* const* argument_list) {
  CLI::App app(
      "Publishes benches of virtual servo drives as joints of ROS 2, and moves them as ROS 2 "
      "commands, by plain DDS.",
      "vdrive-ros2");
  Arguments arguments;
  declare(app, arguments);
  return bridge::run_program<vdrive::settings::ConfigurationError>(
      app, argument_count, argument_list, [&] {
        complete(arguments);
        if (!arguments.only_checks) return serve(arguments);
        std::cout << "vdrive-ros2: the configuration is valid\n";
        return bridge::conclude_output(app.get_name());
      });
}

}  // namespace
}  // namespace vdrive::ros2

int main(int argument_count, char** arguments) {
  vdrive::bridge::open_standard_streams();
  // Everything has been released. A static destructor of the DDS library would sleep 100 ms.
  std::quick_exit(vdrive::ros2::run_command_line(argument_count, arguments));
}
