// SPDX-License-Identifier: Apache-2.0
#include "tool.hpp"

#include "base/usage_error.hpp"
#include "command_table.hpp"
#include "execution/command_context.hpp"
#include "execution/connection.hpp"
#include "language/bench_names.hpp"
#include "language/command_line.hpp"
#include "language/global_options.hpp"
#include "terminal/terminal.hpp"
#include "values/value.hpp"
#include "vdrive/wire/ports.hpp"

#include <algorithm>
#include <chrono>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace vdrive::tool {
namespace {

/// The network options in an incomplete command line.
GlobalOptions network_of(const std::vector<std::string>& words) {
  GlobalOptions options;
  options.domain = wire::default_domain();
  for (std::size_t i = 1; i < words.size(); ++i) {
    const std::string& name = words[i - 1];
    if (name == "--domain") {
      options.domain =
          static_cast<std::uint32_t>(parse_number(words[i], "domain", wire::kHighestDomain));
    } else if (name == "--interface") {
      options.interfaces.push_back(words[i]);
    } else if (name == "--peer") {
      options.peers.push_back(words[i]);
    } else if (name == "--discovery-server") {
      options.discovery_servers.push_back(words[i]);
    } else if (name == "--security") {
      options.security = words[i];
    }
  }
  return options;
}

/// Completes words for a user's shell. Gives up soon, because the user is waiting, and prints no
/// error.
ExitCode complete(const std::vector<std::string>& words, const std::shared_ptr<wire::LocalBus>& bus,
                  Terminal& terminal) {
  constexpr std::chrono::milliseconds kPatience{400};
  std::optional<client::Session> session;
  const auto names_in_session = [&] {
    if (!session) {
      GlobalOptions options = network_of(words);
      options.bus = bus;
      options.timeout = kPatience;
      session.emplace(session_options(options));
    }
    return names_of(*session);
  };
  const BenchNames names{.axes =
                             [&] {
                               return names_in_session().axes();
                             },
                         .benches =
                             [&] {
                               return names_in_session().benches();
                             }};
  try {
    for (const std::string& word : complete_words(commands(), words, names)) terminal.print(word);
  } catch (const std::exception&) {
    return ExitCode::failed;
  }
  return ExitCode::ok;
}

/// Executes a command in its own session.
ExitCode run_in_session(const Command& command, const Program& program) {
  GlobalOptions options = program.options;
  if (command.limits_itself) options.timeout.reset();
  options.ends_at_silence = !command.bridges_silence;
  return run_connected(program, options, [&](client::Session& session) {
    CommandContext context(session, {program.terminal, program.options.json, false},
                           program.commands);
    return execute(command, context, program.options.timeout);
  });
}

ExitCode run_command(std::vector<std::string> arguments, const std::shared_ptr<wire::LocalBus>& bus,
                     Terminal& terminal) {
  if (!arguments.empty() && arguments.front() == "__complete") {
    return complete({arguments.begin() + 1, arguments.end()}, bus, terminal);
  }
  const bool is_one_of_several = !arguments.empty() && arguments.front() == kOneOfSeveral;
  if (is_one_of_several) arguments.erase(arguments.begin());
  Invocation invocation = parse_command_line(commands(), std::move(arguments));
  if (!invocation.command) {
    std::string text = invocation.text;
    while (text.ends_with('\n')) text.pop_back();
    terminal.print(text);
    return ExitCode::ok;
  }
  invocation.options.bus = bus;
  invocation.options.is_one_of_several = is_one_of_several;
  const Command& command = *invocation.command;
  const Program program{invocation.options, commands(), terminal};
  if (command.row->start != nullptr) return command.row->start(command.arguments, program);
  return run_in_session(command, program);
}

/// @return the exit code; failures have been reported.
ExitCode run_reported(std::vector<std::string> arguments,
                      const std::shared_ptr<wire::LocalBus>& bus, Terminal& terminal) {
  // Searched for in the words, because a command line with a mistake has no parsed options.
  const bool is_json = std::ranges::find(arguments, "--json") != arguments.end();
  try {
    return run_command(std::move(arguments), bus, terminal);
  } catch (const UsageError& error) {
    return report_usage(error.what(), is_json, terminal);
  } catch (const NotRun& error) {
    terminal.print_error(std::string("vdrive: ") + error.what());
    return ExitCode::not_run;
  } catch (const std::exception& error) {
    terminal.print_error(std::string("vdrive: ") + error.what());
    return ExitCode::failed;
  }
}

}  // namespace

ExitCode run_tool(std::vector<std::string> arguments, const std::shared_ptr<wire::LocalBus>& bus) {
  Terminal terminal;
  const ExitCode code = run_reported(std::move(arguments), bus, terminal);
  const auto failure = terminal.write_failure();
  if (!failure) return code;
  terminal.print_error("vdrive: " + *failure);
  return code == ExitCode::ok ? ExitCode::failed : code;
}

}  // namespace vdrive::tool
