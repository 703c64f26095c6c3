// SPDX-License-Identifier: Apache-2.0
#include "bridge/command_line.hpp"

#include "bridge/arguments.hpp"
#include "bridge/canopen_bridge.hpp"
#include "bridge/settings.hpp"
#include "bridge_program.hpp"
#include "network_options.hpp"
#include "settings/configuration_error.hpp"
#include "settings/yaml_reader.hpp"
#include "vdrive/wire/bench_number.hpp"
#include "vdrive/wire/library_log.hpp"
#include "vdrive/wire/program_version.hpp"

#include <CLI/CLI.hpp>
#include <boost/asio/signal_set.hpp>

#include <csignal>
#include <cstdint>
#include <iostream>
#include <optional>
#include <string>
#include <thread>

namespace vdrive::canopen {
namespace {

struct CommandLine {
  Settings settings;
  Arguments arguments;
  std::optional<std::string> file;
  bool only_checks = false;
};

/// Keeps an empty text too, which an option bound to std::optional would lose.
CLI::Option* add_text(CLI::App& app, const std::string& name, std::optional<std::string>& text,
                      const std::string& help) {
  return app.add_option_function<std::string>(
      name,
      [&text](const std::string& value) {
        text = value;
      },
      help);
}

void declare_benches(CLI::App& app, Arguments& arguments) {
  app.add_option("--bench", arguments.benches,
                 "Bench whose axes are nodes, 1 to " + std::to_string(wire::kHighestBench) +
                     "; may be repeated; default: all")
      ->transform(bridge::whole_number(1, wire::kHighestBench))
      ->type_name("N");
  app.add_option("--node-offset", arguments.node_offsets,
                 "Node id = number of the axis + K; once for all benches, or once for each --bench")
      ->transform(bridge::whole_number(kLowestNodeOffset, kHighestNodeOffset))
      ->type_name("K");
  app.add_flag("--private", arguments.is_private,
               "Run the benches in this process, without a network");
  app.add_option("--axes", arguments.axes,
                 "Axes of a private bench, 1 to " + std::to_string(kMostNodes) + "; default: 1")
      ->transform(bridge::whole_number(1, static_cast<std::int64_t>(kMostNodes)))
      ->type_name("N");
  add_text(
      app, "--preset", arguments.preset,
      "Machine preset for the axes of a private bench, as for vdrived; default: the default axis")
      ->type_name("NAME");
  add_text(app, "--bench-config", arguments.bench_configuration,
           "Configuration file of a private bench, as for vdrived")
      ->type_name("FILE");
  add_text(app, "--clock", arguments.clock,
           "Clock of a private bench, realtime or lockstep; default: lockstep with --sync-steps, "
           "otherwise realtime")
      ->type_name("MODE");
  add_text(app, "--sync-steps", arguments.sync_steps,
           "On a lock-step bench, each SYNC advances drive time by this much, such as 1ms")
      ->type_name("PERIOD");
}

void declare_ports(CLI::App& app, Arguments& arguments) {
  app.add_option("--socketcand", arguments.socketcand,
                 "Serve the socketcand protocol at this address; port 0 = any free port; may be "
                 "repeated; default if no other connection is given: 127.0.0.1:29536")
      ->type_name("HOST:PORT");
  app.add_option("--interface", arguments.interfaces,
                 "CAN interface of the kernel (SocketCAN), such as can0; may be repeated")
      ->type_name("IFACE");
  app.add_option("--gateway", arguments.gateways,
                 "Serve the ASCII commands of CiA 309-3 at this address; may be repeated")
      ->type_name("HOST:PORT");
}

void declare(CLI::App& app, CommandLine& line) {
  app.set_version_flag("--version", wire::program_version("vdrive-canopen"));
  declare_benches(app, line.arguments);
  declare_ports(app, line.arguments);
  add_text(
      app, "--state", line.arguments.state,
      "Directory for the parameters saved by 1010h; without it, a private bench refuses 1010h, and "
      "the nodes of other benches keep their communication parameters in memory only")
      ->type_name("DIR");
  add_text(app, "--journal", line.arguments.journal,
           "Write a journal of the private bench, which 'vdrive judge' and 'vdrived --replay' read")
      ->type_name("FILE");
  add_text(app, "--log", line.arguments.log,
           "Write each frame to this file in candump's format; with --sync-steps, in drive time")
      ->type_name("FILE");
  app.add_option("--disturb", line.arguments.faults,
                 "Fault of the bus, such as '3 late 4ms 10% from 2s for 500ms': node (none = all), "
                 "lost, late TIME, doubled, duplicate or bus_off; may be repeated")
      ->type_name("FAULT");
  add_text(app, "--config", line.file, "YAML file; options of the command line override it")
      ->type_name("FILE");
  app.add_flag("--check", line.only_checks, "Check command line and configuration, then exit");
  bridge::add_domain_option(app, line.settings.session.domain);
  bridge::add_network_options(app, line.settings.session, "--dds-interface");
}

/// Reads the file, then applies the options of the command line.
void complete(CommandLine& line) {
  Settings& settings = line.settings;
  const std::string file = text_of_option("--config", line.file);
  if (!file.empty()) read_settings(vdrive::settings::read_yaml_file(file), file, settings);
  apply_arguments(line.arguments, settings);
  complete_settings(settings);
  check_private_benches(settings);
  settings.session.find_timeout = bridge::find_timeout_of(settings.session);
  // A master must not act on a stale state: the nodes of a silent bench leave the bus.
  settings.session.patience = settings.session.silence;
}

/// Ends the bridge on SIGINT and SIGTERM. In its own thread, because a SYNC that advances time
/// blocks the loop while it waits for other steppers of the clock.
class EndSignals final {
 public:
  explicit EndSignals(CanopenBridge& bridge) : signals_(context_, SIGINT, SIGTERM) {
    signals_.async_wait([&bridge](const boost::system::error_code& error, int /*signal*/) {
      if (!error) bridge.stop();
    });
    thread_ = std::jthread([this] {
      context_.run();
    });
  }

  ~EndSignals() { context_.stop(); }

  EndSignals(const EndSignals&) = delete;
  EndSignals& operator=(const EndSignals&) = delete;

 private:
  asio::io_context context_{1};
  asio::signal_set signals_;
  std::jthread thread_;  ///< last: it uses the other members
};

int serve(const Settings& settings) {
  // A client may be gone when its answer is written: only that write must fail, not the program.
  std::signal(SIGPIPE, SIG_IGN);  // NOLINT(cert-err33-c): it cannot fail for this signal
  CanopenBridge bridge(settings);
  std::optional<wire::LibraryLog> log;
  if (!settings.is_private) {
    log.emplace([&bridge](const std::string& /*part*/, const std::string& words) {
      bridge.report_library(words);
    });
  }
  const EndSignals signals(bridge);
  bridge.start();
  for (const std::string& text : bridge.first_lines()) {
    std::cout << "vdrive-canopen: " << text << std::endl;
  }
  bridge.loop().run();
  const bool is_logged = bridge.flush_logs();
  for (const std::string& text : bridge.counter_lines()) {
    std::cout << "vdrive-canopen: " << text << '\n';
  }
  const int code = bridge::conclude_output("vdrive-canopen");
  return is_logged ? code : bridge::kFailed;
}

}  // namespace

int run_command_line(int argument_count, const char* const* argument_list) {
  CLI::App app(
      "Connects virtual servo drives to CANopen masters: each axis is a node on a CAN bus.",
      "vdrive-canopen");
  CommandLine line;
  declare(app, line);
  return bridge::run_program<vdrive::settings::ConfigurationError>(
      app, argument_count, argument_list, [&] {
        complete(line);
        if (!line.only_checks) return serve(line.settings);
        std::cout << "vdrive-canopen: the configuration is valid\n";
        return bridge::conclude_output(app.get_name());
      });
}

}  // namespace vdrive::canopen
