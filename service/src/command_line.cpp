// SPDX-License-Identifier: Apache-2.0
#include "vdrive/service/command_line.hpp"

#include "vdrive/axis_bank.hpp"
#include "vdrive/service/configuration.hpp"
#include "vdrive/service/journal.hpp"
#include "vdrive/service/parameter_store.hpp"
#include "vdrive/service/replay.hpp"
#include "vdrive/service/service.hpp"

#include <CLI/CLI.hpp>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <csignal>
#include <cstdio>
#include <ctime>
#include <iostream>
#include <optional>
#include <string>
#include <utility>

namespace vdrive::service {
namespace {

constexpr int kDone = 0;
constexpr int kFailed = 1;
constexpr int kUsage = 2;
constexpr int kNumberTaken = 5;
constexpr long kPollInterval = 50'000'000;  // [ns]

/// What the command line says; it overrides the file.
struct Arguments {
  std::optional<std::string> config;
  std::optional<std::string> check;
  std::optional<std::string> clock;
  std::optional<std::int64_t> period;
  std::optional<std::uint32_t> bench;
  std::optional<std::size_t> axes;
  std::optional<std::uint32_t> domain;
  std::optional<double> rate;
  std::optional<std::uint32_t> threads;
  std::optional<std::string> journal;
  std::optional<std::string> state;
  std::optional<std::string> replay;
  std::string log_level = "info";
  bool print_config = false;
};

void declare(CLI::App& app, Arguments& arguments) {
  app.set_version_flag("--version", std::string("vdrived ") + VDRIVE_VERSION);
  app.add_option("--config", arguments.config, "Configuration in YAML; without it the demo bench")
      ->type_name("FILE");
  app.add_option("--check", arguments.check, "Check a configuration and leave")->type_name("FILE");
  app.add_flag("--print-config", arguments.print_config,
               "Print the configuration in effect as YAML and leave");
  app.add_option("--clock", arguments.clock, "realtime, lockstep or freerun")->type_name("MODE");
  app.add_option("--period", arguments.period, "Length of a tick [us], 125 to 10000")
      ->type_name("US");
  app.add_option("--rate", arguments.rate, "realtime: 0 = paused, 0.1 to 100")->type_name("R");
  app.add_option("--bench", arguments.bench, "Number of the bench, 1 to 65535")->type_name("N");
  app.add_option("--axes", arguments.axes, "N default axes numbered from 1, up to 16384")
      ->type_name("N");
  app.add_option("--domain", arguments.domain, "DDS domain, 0 to 232")
      ->envname("VDRIVE_DOMAIN")
      ->type_name("N");
  app.add_option("--threads", arguments.threads, "Threads that step the axes, 1 to 64")
      ->type_name("N");
  app.add_option("--state", arguments.state,
                 "Keep stored parameters in this directory; else in $STATE_DIRECTORY; without "
                 "either nothing can be stored")
      ->type_name("DIR");
  app.add_option("--journal", arguments.journal,
                 "Record what the axes do into a new file, for --replay")
      ->type_name("FILE");
  app.add_option("--replay", arguments.replay,
                 "Run the axes of a journal again and compare every tick: 0 = agrees, 1 = differs "
                 "or ticks are missing, 2 = no usable journal")
      ->type_name("FILE");
  app.add_option("--log-level", arguments.log_level, "What to log on standard error")
      ->check(CLI::IsMember({"debug", "info", "warn", "error", "off"}))
      ->capture_default_str();
}

ClockMode clock_named(const std::string& name) {
  if (name == "realtime") {
    return ClockMode::realtime;
  }
  if (name == "lockstep") {
    return ClockMode::lockstep;
  }
  if (name == "freerun") {
    return ClockMode::freerun;
  }
  throw ConfigurationError("--clock " + name + ": must be one of realtime, lockstep, freerun");
}

Configuration effective_configuration(const Arguments& arguments) {
  Configuration configuration =
      arguments.config ? load_configuration(*arguments.config) : demo_configuration();
  if (arguments.clock) {
    configuration.clock = clock_named(*arguments.clock);
  }
  if (arguments.period) {
    configuration.period = std::chrono::microseconds{*arguments.period};
  }
  if (arguments.axes) {
    configuration.axes = default_axes(*arguments.axes);
  }
  configuration.bench = arguments.bench.value_or(configuration.bench);
  configuration.network.domain = arguments.domain.value_or(configuration.network.domain);
  if (arguments.rate && configuration.clock == ClockMode::freerun) {
    throw ConfigurationError("--rate has no meaning with the clock freerun");
  }
  configuration.rate = arguments.rate.value_or(configuration.rate);
  configuration.threads = arguments.threads.value_or(configuration.threads);
  check(configuration);
  return configuration;
}

sigset_t stop_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  return signals;
}

int serve(const Configuration& configuration, const Arguments& arguments) {
  // Blocked before the first thread starts, so that every thread leaves them to this one.
  const sigset_t signals = stop_signals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  auto store = open_parameter_store(arguments.state, configuration.bench);
  Service service(configuration, arguments.journal ? open_journal(*arguments.journal) : nullptr,
                  std::move(store));
  service.start();
  const timespec interval{.tv_sec = 0, .tv_nsec = kPollInterval};
  while (sigtimedwait(&signals, nullptr, &interval) < 0) {
    if (const auto older = service.conflict()) {
      service.stop();
      throw BenchNumberTaken("bench " + std::to_string(configuration.bench) +
                             " belongs to a service that started earlier (incarnation " +
                             std::to_string(*older) + ")");
    }
  }
  service.stop();
  return kDone;
}

int replay_journal(const Arguments& arguments) {
  const ReplayResult result = replay(*arguments.replay, arguments.threads);
  (result.agrees ? std::cout : std::cerr) << result.text << '\n';
  return result.agrees && result.is_complete ? kDone : kFailed;
}

int carry_out(const Arguments& arguments) {
  if (arguments.replay) {
    return replay_journal(arguments);
  }
  if (arguments.check) {
    static_cast<void>(load_configuration(*arguments.check));
    std::cout << *arguments.check << ": good\n";
    return kDone;
  }
  const Configuration configuration = effective_configuration(arguments);
  if (arguments.print_config) {
    std::cout << to_yaml(configuration);
    return kDone;
  }
  return serve(configuration, arguments);
}

}  // namespace

int run_command_line(int argument_count, const char* const* arguments) {
  CLI::App app{"vdrived: a bench of virtual CiA 402 servo drives on DDS", "vdrived"};
  Arguments given;
  declare(app, given);
  try {
    app.parse(argument_count, arguments);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kUsage;
  }
  spdlog::set_default_logger(spdlog::stderr_color_mt("vdrived"));
  spdlog::set_level(spdlog::level::from_str(given.log_level));
  try {
    return carry_out(given);
  } catch (const BenchNumberTaken& taken) {
    std::cerr << "vdrived: " << taken.what() << '\n';
    return kNumberTaken;
  } catch (const JournalError& error) {
    std::cerr << "vdrived: " << error.what() << '\n';
    return kUsage;
  } catch (const std::exception& error) {
    std::cerr << "vdrived: " << error.what() << '\n';
    return kFailed;
  }
}

}  // namespace vdrive::service
