// SPDX-License-Identifier: Apache-2.0
#include "tool.hpp"

#include "base/usage_error.hpp"
#include "diagnosis/doctor.hpp"
#include "diagnosis/measurement.hpp"
#include "execution/executor.hpp"
#include "language/bench_names.hpp"
#include "language/grammar.hpp"
#include "output/report.hpp"
#include "scenarios/scenario_run.hpp"
#include "scenarios/scenario_tests.hpp"
#include "scenarios/shell.hpp"
#include "terminal/interrupt.hpp"
#include "terminal/keys.hpp"
#include "values/value.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wire/ports.hpp"

#include <chrono>
#include <exception>
#include <optional>

namespace vdrive::tool {
namespace {

using client::Outcome;
using client::OutcomeKind;

client::SessionOptions session_options(const GlobalOptions& options) {
  client::SessionOptions session;
  session.domain = options.domain;
  session.interfaces = options.interfaces;
  session.peers = options.peers;
  session.discovery_servers = options.discovery_servers;
  session.security = options.security;
  if (options.timeout) {
    session.find_timeout = std::chrono::ceil<std::chrono::milliseconds>(*options.timeout);
  } else if (!options.security.empty()) {
    session.find_timeout = client::SessionOptions::kFindTimeoutOfClosedMode;
  }
  return session;
}

/// The exit code, and on standard error what went wrong.
ExitCode finish(const Outcome& outcome, const Interrupt& interrupt, bool is_json,
                Terminal& terminal) {
  terminal.end_live();
  if (interrupt.happened()) return ExitCode::interrupted;
  // The reader of a pipe has ended: that ends a stream, it is not an error.
  if (!terminal.is_open()) return ExitCode::ok;
  if (outcome) return ExitCode::ok;
  terminal.complain("vdrive: " + outcome.message());
  if (is_json && outcome.kind() == OutcomeKind::not_found) {
    Json json;
    add_outcome(json, outcome);
    terminal.print(to_line(json));
  }
  return exit_code_of(outcome.kind());
}

/// @param work what to do with the session
template <typename Work>
ExitCode run_connected(const GlobalOptions& options, Terminal& terminal, const Work& work) {
  Interrupt interrupt;
  interrupt.before_exit([&terminal] {
    terminal.leave_screen_at_once();
    KeyInput::restore_at_once();
  });
  client::Session session(session_options(options));
  interrupt.arm([&session] {
    session.interrupt();
  });
  const Outcome outcome = work(session);
  const ExitCode code = finish(outcome, interrupt, options.json, terminal);
  interrupt.disarm();
  return code;
}

/// What ends a scenario before its first line is in the report too: a file that cannot be read, a
/// network that cannot be used.
ExitCode run_files(const RunCommand& run, const GlobalOptions& options, Terminal& terminal) {
  JunitReport junit(run.junit);
  try {
    const auto scenarios = load_scenarios(run.files, settings_of(run.settings));
    return run_connected(options, terminal, [&](client::Session& session) {
      return run_scenarios(
          scenarios, {.is_json = options.json, .is_live = run.live, .timeout = options.timeout},
          junit, session, terminal);
    });
  } catch (const std::exception& error) {
    const std::string suite = run.files.size() == 1 ? name_of_scenario(run.files.front()) : "start";
    static_cast<void>(junit.write({{suite, {{.name = "start", .error = error.what()}}}}));
    throw;
  }
}

ExitCode run_tests(const TestCommand& test, const GlobalOptions& options, Terminal& terminal) {
  Interrupt interrupt;
  return run_scenario_tests(test, options, interrupt, terminal);
}

ExitCode measure(const BenchCommand& bench, const GlobalOptions& options, Terminal& terminal) {
  Interrupt interrupt;
  return run_measurement(bench, options.json, interrupt, terminal);
}

ExitCode open_shell(const GlobalOptions& options, Terminal& terminal) {
  Interrupt interrupt;
  interrupt.before_exit([&terminal] {
    terminal.leave_screen_at_once();
  });
  client::Session session(session_options(options));
  return run_shell(options, session, interrupt, terminal);
}

/// The options of the network in a command line that is not whole yet.
GlobalOptions network_of(const std::vector<std::string>& words) {
  GlobalOptions options;
  options.domain = client::default_domain();
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

/// What the completion of a shell calls: a person waits for it, and no error is shown.
ExitCode complete(const std::vector<std::string>& words, Terminal& terminal) {
  constexpr std::chrono::milliseconds kPatience{400};
  std::optional<client::Session> session;
  const auto names_in_session = [&] {
    if (!session) {
      GlobalOptions options = network_of(words);
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
    for (const std::string& word : complete_words(words, names)) terminal.print(word);
  } catch (const std::exception&) {
    return ExitCode::failed;
  }
  return ExitCode::ok;
}

/// The doctor checks the machine also where no session can be opened.
ExitCode see_doctor(const GlobalOptions& options, Terminal& terminal) {
  const Outcome outcome = run_doctor(options, terminal, [&options] {
    return client::Session(session_options(options)).find_benches();
  });
  return finish(outcome, Interrupt(), false, terminal);
}

ExitCode run_command(std::vector<std::string> arguments, Terminal& terminal) {
  if (!arguments.empty() && arguments.front() == "__complete") {
    return complete({arguments.begin() + 1, arguments.end()}, terminal);
  }
  const Invocation invocation = parse_command_line(std::move(arguments));
  if (!invocation.command) {
    std::string text = invocation.text;
    while (text.ends_with('\n')) text.pop_back();
    terminal.print(text);
    return ExitCode::ok;
  }
  if (const auto* dictionary = std::get_if<DictionaryCommand>(&*invocation.command)) {
    print_dictionary(*dictionary, invocation.options.json, terminal);
    return ExitCode::ok;
  }
  if (const auto* convert = std::get_if<ConvertCommand>(&*invocation.command)) {
    return finish(convert_recording(*convert, invocation.options.json, terminal), Interrupt(),
                  invocation.options.json, terminal);
  }
  if (std::holds_alternative<DoctorCommand>(*invocation.command)) {
    return see_doctor(invocation.options, terminal);
  }
  if (const auto* run = std::get_if<RunCommand>(&*invocation.command)) {
    return run_files(*run, invocation.options, terminal);
  }
  if (const auto* test = std::get_if<TestCommand>(&*invocation.command)) {
    return run_tests(*test, invocation.options, terminal);
  }
  if (const auto* bench = std::get_if<BenchCommand>(&*invocation.command)) {
    return measure(*bench, invocation.options, terminal);
  }
  if (std::holds_alternative<ShellCommand>(*invocation.command)) {
    return open_shell(invocation.options, terminal);
  }
  GlobalOptions options = invocation.options;
  // Its --timeout limits the wait, not the search for the bench.
  if (std::holds_alternative<AwaitCommand>(*invocation.command)) options.timeout.reset();
  return run_connected(options, terminal, [&](client::Session& session) {
    return Executor(session, terminal, invocation.options.json, false)
        .execute(*invocation.command, invocation.options.timeout);
  });
}

}  // namespace

ExitCode run_tool(std::vector<std::string> arguments) {
  Terminal terminal;
  try {
    return run_command(std::move(arguments), terminal);
  } catch (const UsageError& error) {
    terminal.complain(std::string("vdrive: ") + error.what());
    return ExitCode::usage;
  } catch (const std::exception& error) {
    terminal.complain(std::string("vdrive: ") + error.what());
    return ExitCode::failed;
  }
}

}  // namespace vdrive::tool
