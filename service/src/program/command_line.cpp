// SPDX-License-Identifier: Apache-2.0
#include "program/command_line.hpp"

#include "base/log.hpp"
#include "configuration/configuration_file.hpp"
#include "configuration/configuration_help.hpp"
#include "configuration/configuration_warnings.hpp"
#include "configuration/mechanics.hpp"
#include "configuration/presets.hpp"
#include "journal/journal.hpp"
#include "journal/replay.hpp"
#include "program/service.hpp"
#include "program/service_manager.hpp"
#include "run/bench_wire.hpp"
#include "store/parameter_store.hpp"
#include "supervision/wire_host.hpp"
#include "vdrive/axis_bank.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wire/bench_number.hpp"
#include "vdrive/wire/library_log.hpp"
#include "vdrive/wire/ports.hpp"
#include "vdrive/wire/program_version.hpp"
#include "vdrive/wire/security.hpp"
#include "vdrive/wording.hpp"
#include "wire/confinement.hpp"
#include "wire/library_log_sink.hpp"
#include "wire/wire_process.hpp"

#include <CLI/CLI.hpp>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace vdrive::service {
namespace {

constexpr int kDone = 0;
constexpr int kFailed = 1;
constexpr int kUsage = 2;
constexpr int kNumberTaken = 5;
constexpr std::uint16_t kHighestPort = 65'535;
constexpr std::chrono::milliseconds kPollInterval{50};
constexpr std::chrono::milliseconds kBusyPollInterval{5};  ///< while the service starts or ends

/// The command line requests something that is impossible.
class BadArguments : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The settings from the command line, which override the file.
struct Arguments {
  std::optional<std::string> config;
  std::optional<std::string> check;
  std::optional<std::string> clock;
  std::optional<std::int64_t> period;
  std::optional<std::uint32_t> bench;
  std::optional<std::size_t> axes;
  std::optional<std::string> preset;
  std::optional<std::uint32_t> domain;
  std::optional<std::string> security;
  std::optional<double> rate;
  std::optional<std::uint32_t> steppers;
  std::optional<std::uint32_t> threads;
  std::optional<std::uint32_t> metrics;
  std::optional<std::string> journal;
  std::optional<std::string> state;
  std::optional<std::string> replay;
  std::optional<std::string> wire;
  std::optional<int> wire_process;
  bool without_guard = false;
  std::string log_level = "info";
  bool print_config = false;
  bool help_config = false;
};

/// @return for example "1 to 64".
std::string range(double lowest, double highest) {
  return to_text(lowest) + " to " + to_text(highest);
}

CLI::Validator one_of(std::vector<std::string> words) {
  std::string choice = choice_of(words);
  return {[words = std::move(words)](const std::string& text) {
            return refusal_of_choice(text, words);
          },
          std::move(choice)};
}

CLI::Validator whole_number(std::int64_t lowest, std::int64_t highest) {
  return {[lowest, highest](std::string& text) {
            return take_integer(text, lowest, highest);
          },
          ""};
}

/// Accepts a rate in the number format of all options.
std::string take_rate(std::string& text) {
  const auto rate = parse_number(text);
  const bool is_good = rate && (*rate == 0.0 || (*rate >= kLowestRate && *rate <= kHighestRate));
  if (!is_good) {
    return "'" + text + "' must be 0 (paused) or from " + range(kLowestRate, kHighestRate);
  }
  text = to_text(*rate);
  return {};
}

void declare_configuration(CLI::App& app, Arguments& arguments) {
  app.add_option("--config", arguments.config, "Configuration in YAML; default: the demo bench")
      ->type_name("FILE");
  app.add_option("--check", arguments.check, "Check a configuration and exit")->type_name("FILE");
  app.add_flag("--print-config", arguments.print_config,
               "Print the configuration in effect as YAML and exit");
  app.add_flag("--help-config", arguments.help_config,
               "Print every key of a configuration, with its values and default, and exit");
}

void declare_bench(CLI::App& app, Arguments& arguments) {
  app.add_option("--clock", arguments.clock, "realtime, lockstep or freerun")->type_name("MODE");
  app.add_option("--period", arguments.period,
                 "Length of a tick [us], " + range(static_cast<double>(kShortestPeriod.count()),
                                                   static_cast<double>(kLongestPeriod.count())))
      ->transform(whole_number(kShortestPeriod.count(), kLongestPeriod.count()))
      ->type_name("US");
  app.add_option(
         "--rate", arguments.rate,
         "realtime: drive time over wall time, 0 (paused) or " + range(kLowestRate, kHighestRate))
      ->transform(CLI::Validator(take_rate, ""))
      ->type_name("R");
  app.add_option("--steppers", arguments.steppers,
                 "lockstep: time stands still until N programs have joined the clock, " +
                     range(0, kMaxSteppers) + "; 0 = no wait")
      ->transform(whole_number(0, kMaxSteppers))
      ->type_name("N");
  app.add_option("--bench", arguments.bench,
                 "Number of the bench, " + range(1, wire::kHighestBench))
      ->transform(whole_number(1, wire::kHighestBench))
      ->envname("VDRIVE_BENCH")
      ->type_name("N");
  app.add_option("--axes", arguments.axes,
                 "N default axes numbered from 1, up to " + std::to_string(kMaxAxes))
      ->transform(whole_number(1, static_cast<std::int64_t>(kMaxAxes)))
      ->type_name("N");
  app.add_option("--preset", arguments.preset,
                 "Preset machine for the axes (1 axis unless --axes is given): " +
                     choice_of(preset_names()))
      ->type_name("NAME");
}

void declare_program(CLI::App& app, Arguments& arguments) {
  app.add_option("--domain", arguments.domain, "DDS domain, " + range(0, wire::kHighestDomain))
      ->transform(whole_number(0, wire::kHighestDomain))
      ->envname("VDRIVE_DOMAIN")
      ->type_name("N");
  app.add_option("--security", arguments.security,
                 "Closed mode: directory with certificate, key and permissions")
      ->envname("VDRIVE_SECURITY")
      ->type_name("DIR");
  app.add_option("--threads", arguments.threads,
                 "Threads that step the axes, " + range(1, kMaxThreads))
      ->transform(whole_number(1, kMaxThreads))
      ->type_name("N");
  app.add_option("--metrics", arguments.metrics,
                 "Serve Prometheus metrics on this port of metrics.address, " +
                     range(0, kHighestPort) + "; 0 = any free one")
      ->transform(whole_number(0, kHighestPort))
      ->type_name("PORT");
  app.add_option("--state", arguments.state,
                 "Directory for stored parameters; default: $STATE_DIRECTORY; without a directory "
                 "nothing can be stored")
      ->type_name("DIR");
  app.add_option("--journal", arguments.journal, "Record a journal to a new file, for --replay")
      ->type_name("FILE");
  app.add_option("--replay", arguments.replay,
                 "Replay a journal and compare every tick. Exit code 0: all ticks agree; 1: a tick "
                 "differs or is missing; 2: the journal cannot be used")
      ->type_name("FILE");
  app.add_option("--wire", arguments.wire,
                 "Where DDS runs: in a separate process, which the service restarts when it ends, "
                 "or in threads of the service; default: process in realtime, in the closed mode "
                 "and with an interface other than loopback, thread otherwise")
      ->check(one_of({"process", "thread"}))
      ->type_name("FORM");
  app.add_option("--wire-process", arguments.wire_process)->group("");  // used by the spawner
  app.add_flag("--without-guard", arguments.without_guard)->group("");  // only for tests
  app.add_option("--log-level", arguments.log_level,
                 "Level of the log, which goes to standard error")
      ->check(one_of({"debug", "info", "warn", "error", "off"}))
      ->capture_default_str();
}

void declare(CLI::App& app, Arguments& arguments) {
  app.set_version_flag("--version", wire::program_version("vdrived"));
  declare_configuration(app, arguments);
  declare_bench(app, arguments);
  declare_program(app, arguments);
}

ClockMode clock_named(const std::string& name) {
  if (const auto mode = clock_mode_named(name)) return *mode;
  std::vector<std::string> names;
  names.reserve(kClockModes.size());
  for (const ClockMode mode : kClockModes) names.emplace_back(to_string(mode));
  throw ConfigurationError("--clock " + in_quotes(name) +
                           ": must be one of realtime, lockstep, freerun" +
                           suggestion(name, names));
}

void override(Configuration& configuration, const Arguments& arguments) {
  if (arguments.clock) {
    const ClockMode clock = clock_named(*arguments.clock);
    if (clock != configuration.clock) {  // the file's values are meant for its own clock mode
      configuration.rate = Configuration{}.rate;
      configuration.steppers = Configuration{}.steppers;
    }
    configuration.clock = clock;
  }
  if (arguments.period) configuration.period = std::chrono::microseconds{*arguments.period};
  if (arguments.preset) {
    configuration.axes = preset_axes(*arguments.preset, arguments.axes.value_or(1));
  } else if (arguments.axes) {
    configuration.axes = default_axes(*arguments.axes);
  }
  configuration.bench = arguments.bench.value_or(configuration.bench);
  configuration.network.domain = arguments.domain.value_or(configuration.network.domain);
  configuration.network.security = arguments.security.value_or(configuration.network.security);
  configuration.rate = arguments.rate.value_or(configuration.rate);
  configuration.steppers = arguments.steppers.value_or(configuration.steppers);
  const auto refuse_unfit = [&](bool is_given, const std::string& key) {
    const auto problem = is_given ? problem_of_clock(key, configuration) : std::nullopt;
    if (problem)
      throw ConfigurationError("--" + key + " cannot be used with the clock " + *problem);
  };
  refuse_unfit(arguments.rate.has_value(), "rate");
  refuse_unfit(arguments.steppers.has_value(), "steppers");
  configuration.threads = arguments.threads.value_or(configuration.threads);
  configuration.network.guard = !arguments.without_guard;
  if (arguments.wire) configuration.wire_form = wire_form_named(*arguments.wire);
  if (arguments.metrics) {
    configuration.metrics_port = static_cast<std::uint16_t>(*arguments.metrics);
  }
  check(configuration);
}

/// CLI11 treats an empty value like an option without a value, and an empty variable as unset.
void refuse_empty_values(const CLI::App& app) {
  for (const CLI::Option* const option : app.get_options()) {
    const auto& values = option->results();
    if (std::ranges::find(values, "") != values.end()) {
      throw BadArguments(option->get_name() + ": the value is empty");
    }
    const std::string variable = option->get_envname();
    const char* const text = variable.empty()
                                 ? nullptr
                                 : std::getenv(variable.c_str());  // NOLINT(concurrency-mt-unsafe)
    if (option->count() == 0 && text != nullptr && *text == '\0') {
      throw BadArguments(variable +
                         " in the environment is set, but empty: unset it or give a value");
    }
  }
}

/// @throws ConfigurationError for the file, BadArguments for the command line
Configuration effective_configuration(const Arguments& arguments) {
  Configuration configuration =
      arguments.config ? load_configuration(*arguments.config) : demo_configuration();
  try {
    override(configuration, arguments);
  } catch (const ConfigurationError& error) {
    throw BadArguments(error.what());
  }
  return configuration;
}

sigset_t stop_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  return signals;
}

/// Waits for a signal. @return false on timeout
bool takes_signal(const sigset_t& signals, std::chrono::nanoseconds timeout) {
  const timespec time{.tv_sec = 0, .tv_nsec = timeout.count()};
  return sigtimedwait(&signals, nullptr, &time) >= 0;
}

/// Reports the state of a service to the service manager.
class Reporter {
 public:
  /// @param service, manager outlive this
  /// @param description of the service, one line
  Reporter(Service& service, const ServiceManager& manager, std::string description)
      : service_(service), manager_(manager), description_(std::move(description)) {}

  /// @return the time until the next report.
  [[nodiscard]] std::chrono::microseconds interval() const noexcept {
    if (!is_ready_) return kBusyPollInterval;
    const auto heartbeat = manager_.heartbeat_interval();
    return heartbeat ? std::min<std::chrono::microseconds>(kPollInterval, *heartbeat / 2)
                     : kPollInterval;
  }

  void report() {
    if (!is_ready_) {
      if (!service_.has_run()) return;
      manager_.report_ready(description_);
      is_ready_ = true;
    }
    if (service_.is_reachable() != is_reachable_) {
      is_reachable_ = !is_reachable_;
      manager_.report_status(is_reachable_
                                 ? description_
                                 : description_ + ", no network: the network process is down");
    }
    beat();
  }

 private:
  void beat() {
    const auto heartbeat = manager_.heartbeat_interval();
    const auto now = std::chrono::steady_clock::now();
    if (!heartbeat || now < next_heartbeat_) return;
    next_heartbeat_ = now + *heartbeat;
    if (service_.is_alive()) manager_.report_alive();
  }

  Service& service_;
  const ServiceManager& manager_;
  std::string description_;
  bool is_ready_ = false;
  bool is_reachable_ = true;
  std::chrono::steady_clock::time_point next_heartbeat_;
};

/// Reports until a signal arrives, an older service with the same bench number is found, or the
/// network is gone for good.
void watch(Service& service, const ServiceManager& manager, const sigset_t& signals,
           const std::string& description) {
  Reporter reporter(service, manager, description);
  while (!takes_signal(signals, reporter.interval()) && !service.conflict() &&
         !service.is_cut_off()) {
    reporter.report();
  }
}

/// Ends the process if it does not end in time. The axes have 1.5 s to come to rest; after that
/// only the DDS library can hang, if it runs in this process: its threads end only with the
/// process.
void end_in_time(int exit_code) {
  // The thread keeps the logger, because the default logger is destroyed once main() has returned.
  std::thread([exit_code, log = spdlog::default_logger()] {
    constexpr std::chrono::milliseconds kLongest{1'950};  // a service must end within 2 s
    std::this_thread::sleep_for(kLongest);
    log->warn(
        "text=\"the DDS library did not shut down within {} ms; the process exits without it\"",
        kLongest.count());
    _exit(exit_code);
  }).detach();
}

int serve(const Configuration& configuration, const Arguments& arguments) {
  // The signals are blocked before the first thread starts, so that only this thread receives them.
  const sigset_t signals = stop_signals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  // WireHost forks the spawner, so it too is made before the first thread starts.
  const bool has_process = effective_wire_form(configuration) == WireForm::process;
  WireSettings settings = wire_settings(configuration);
  settings.log_level = arguments.log_level;
  auto host = has_process ? std::make_shared<WireHost>(settings) : nullptr;
  const ServiceManager manager;
  std::optional<wire::LibraryLog> library_log;
  if (!has_process) library_log.emplace(log_of_the_library(configuration.bench));
  auto store = open_parameter_store(arguments.state, configuration.bench);
  Service service(configuration, arguments.journal ? open_journal(*arguments.journal) : nullptr,
                  std::move(store), std::move(host));
  if (has_process) confine_engine(manager.receives_in_network() ? Network::keep : Network::leave);
  service.start();
  watch(service, manager, signals,
        "bench " + std::to_string(configuration.bench) + ", " +
            std::to_string(configuration.axes.size()) + " axes, " +
            std::string(to_string(configuration.clock)) + ", DDS domain " +
            std::to_string(configuration.network.domain));
  const auto older = service.conflict();
  const bool is_cut_off = service.is_cut_off();
  if (!has_process) end_in_time(older ? kNumberTaken : kDone);
  manager.report_stopping();
  service.begin_shutdown();
  while (!service.is_shut_down() && !takes_signal(signals, kBusyPollInterval)) {
  }
  service.stop();
  if (older) {
    throw BenchNumberTaken(
        "bench " + std::to_string(configuration.bench) + " is already served in domain " +
        std::to_string(configuration.network.domain) + " by " + service.older_text() +
        ", which started earlier; stop that service, or choose another number with --bench");
  }
  if (is_cut_off) {
    // A confined process may not start programs, so only a new run can start another spawner.
    throw std::runtime_error(
        "the process that starts the network process has ended, so the network process cannot be "
        "restarted; start vdrived again");
  }
  return kDone;
}

int replay_journal(const Arguments& arguments) {
  const ReplayResult result = replay(*arguments.replay, {.threads = arguments.threads});
  (result.agrees ? std::cout : std::cerr) << result.text << '\n';
  return result.agrees && result.is_complete ? kDone : kFailed;
}

/// Checks all flags, including those that the present command does not use.
/// @throws BadArguments
void check_flags(const Arguments& arguments) {
  Configuration configuration = demo_configuration();
  try {
    override(configuration, arguments);
  } catch (const ConfigurationError& error) {
    throw BadArguments(error.what());
  }
}

int carry_out(const Arguments& arguments) {
  if (arguments.wire_process) return run_wire_process(*arguments.wire_process);
  check_flags(arguments);
  if (arguments.help_config) {
    std::cout << configuration_help();
    return kDone;
  }
  if (arguments.replay) return replay_journal(arguments);
  if (arguments.check) {
    const Configuration configuration = load_configuration(*arguments.check);
    const wire::NetworkSettings& network = configuration.network;
    if (!network.security.empty()) {
      static_cast<void>(wire::check_security(network.security, network.domain));
    }
    for (const std::string& warning : loop_warnings(*arguments.check)) {
      std::cerr << "vdrived: warning: " << warning << '\n';
    }
    for (const std::string& warning : start_warnings(configuration)) {
      std::cerr << "vdrived: warning: " << warning << '\n';
    }
    for (const std::string& line : mechanics_table(configuration)) std::cout << line << '\n';
    std::cout << escaped(*arguments.check, kShownOfMessage) << ": valid\n";
    return kDone;
  }
  const Configuration configuration = effective_configuration(arguments);
  if (arguments.print_config) {
    std::cout << to_yaml(configuration);
    return kDone;
  }
  return serve(configuration, arguments);
}

void print_error(std::string_view message) {
  std::cerr << prefixed_lines("vdrived: ", message) << '\n';
}

/// @return the message for an argument that no option takes.
std::string unexpected_text(const CLI::App& app, const std::string& argument) {
  if (!argument.starts_with('-')) {
    const bool has_file = app.count("--config") != 0 || app.count("--check") != 0;
    if (has_file) return in_quotes(argument) + " is one argument too many";
    return in_quotes(argument) +
           " is one argument too many; to use it as the configuration: vdrived --config " +
           escaped(argument);
  }
  const std::string name = argument.substr(0, argument.find('='));
  std::vector<std::string> known;
  for (const CLI::Option* const option : app.get_options()) {
    const bool is_hidden = option->get_group().empty();
    for (const std::string& each : option->get_lnames()) {
      if (!is_hidden) known.push_back("--" + each);
    }
  }
  return in_quotes(name) + " is not an option" + suggestion(name, known);
}

/// In other programs --check is a flag for use with --config. Here --check takes the file itself,
/// so a --config after it would be taken for the file.
/// @return the problem; nullopt if --check has a file or is not given
std::optional<std::string> check_without_file(const std::vector<std::string_view>& words) {
  static constexpr std::string_view kCheck = "--check";
  static constexpr std::string_view kConfig = "--config";
  const auto is_value = [&words](auto word) {
    return word != words.end() && !word->starts_with("--");
  };
  const auto option = std::ranges::find(words, kCheck);
  if (option == words.end() || is_value(std::next(option))) return std::nullopt;
  std::string file = "FILE";
  const auto config = std::ranges::find_if(words, [](std::string_view word) {
    return word.substr(0, word.find('=')) == kConfig;
  });
  if (config != words.end() && *config != kConfig) {
    file = escaped(config->substr(kConfig.size() + 1), kShownOfMessage);
  } else if (config != words.end() && is_value(std::next(config))) {
    file = escaped(*std::next(config), kShownOfMessage);
  }
  return "--check needs the file itself: vdrived --check " + file;
}

/// Parses and carries out the command line, and reports errors. @return the exit code
int parse_and_carry_out(int argument_count, const char* const* arguments) {
  CLI::App app{"vdrived: a bench of virtual CiA 402 servo drives on DDS", "vdrived"};
  Arguments given;
  declare(app, given);
  const std::vector<std::string_view> words(arguments, arguments + argument_count);
  if (const auto problem = check_without_file(words)) {
    print_error(*problem);
    return kUsage;
  }
  try {
    app.parse(argument_count, arguments);
  } catch (const CLI::ExtrasError&) {
    print_error(unexpected_text(app, app.remaining().front()));
    std::cerr << "Run with --help for more information.\n";
    return kUsage;
  } catch (const CLI::ValidationError& error) {  // it names the option, the value and the limits
    print_error(escaped(error.what(), kShownOfMessage));
    return kUsage;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {  // help, version
      return app.exit(error);
    }
    std::cerr << "vdrived: " << escaped(error.what(), kShownOfMessage)
              << "\nRun with --help for more information.\n";
    return kUsage;
  }
  spdlog::set_default_logger(spdlog::stderr_color_mt("vdrived"));
  is_program_of_vdrive() = true;
  spdlog::set_level(spdlog::level::from_str(given.log_level));
  try {
    refuse_empty_values(app);
    return carry_out(given);
  } catch (const BenchNumberTaken& taken) {
    print_error(taken.what());
    return kNumberTaken;
  } catch (const JournalError& error) {
    print_error(error.what());
    return kUsage;
  } catch (const BadArguments& error) {
    print_error(error.what());
    return kUsage;
  } catch (const std::exception& error) {
    print_error(error.what());
    return kFailed;
  }
}

}  // namespace

int run_command_line(int argument_count, const char* const* arguments) {
  const int code = parse_and_carry_out(argument_count, arguments);
  // Output that could not be written is an error.
  if (std::cout.flush() || code != kDone) return code;
  std::cerr << "vdrived: standard output could not be written: "
            << std::generic_category().message(errno) << '\n';
  return kFailed;
}

}  // namespace vdrive::service
