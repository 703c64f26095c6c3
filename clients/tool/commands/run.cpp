// SPDX-License-Identifier: Apache-2.0
#include "commands/run.hpp"

#include "base/usage_error.hpp"
#include "execution/command_context.hpp"
#include "execution/connection.hpp"
#include "language/arguments.hpp"
#include "output/junit.hpp"
#include "scenarios/scenario_process.hpp"
#include "scenarios/scenario_run.hpp"

#include <exception>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::tool {
namespace {

constexpr std::string_view kScenarioHelp =
    R"(A scenario has one command per line, without 'vdrive'. # starts a comment.
In addition to the commands of the command line:
  refused CODE COMMAND...    passes if the command is refused with this code
  let NAME = VALUE           ${NAME} stands for VALUE below; --set gives another value
  finally                    lines below run last, also after a failure and Ctrl-C
In lock-step, commands that wait step the clock. The first failure ends the file.

Example:
  enable 1.1
  write 1.1 0x607A 10000
  write 1.1 0x6040 0x3F
  expect 1.1 0x6041 0x1237 --within 2ms
  expect 1.1 0x6041 0x1637 --within 11s    # arrived
  expect 1.1 torque < 500 --throughout 2s
  refused 0x06010002 write 1.1 0x6041 0    # read-only)";

}  // namespace

void RunCommand::declare(Arguments& arguments) {
  scenarios.declare(arguments, "Scenario, - for standard input; several run one after the other");
  arguments.flag("--live", live, "Show the axes while time passes, also when piped");
  if (arguments.place() != Place::command_line) return;  // a shell has its own session
  arguments.flag("--private", is_private,
                 "Run each file on a new lock-step bench that only this program can reach, instead "
                 "of a running bench; each of several files in its own process");
  benches.declare(arguments);
  benches.declare_journal(arguments);
  arguments.then([this] {
    if (!is_private && !benches.arguments().empty()) {
      throw UsageError(benches.arguments().front() +
                       " needs --private: without it, run uses a bench that is already running");
    }
    if (!benches.journal.empty() && scenarios.files.size() != 1) {
      throw UsageError("--journal needs exactly one file: with several, each has its own bench");
    }
  });
}

client::Outcome RunCommand::run(CommandContext& context) const {
  JunitReport junit(scenarios.junit);
  return run_scenarios(
      scenarios.load(context.table),
      {.is_json = context.output.is_json, .is_live = live, .timeout = context.timeout}, junit,
      context.session, context.output.terminal);
}

/// Failures before the first line of a scenario are in the report too, for example a file that
/// cannot be read or an unusable network.
ExitCode RunCommand::start(const Program& program) const {
  const GlobalOptions& options = program.options;
  if (options.is_one_of_several) return start_one_of_several(program);
  JunitReport junit(scenarios.junit);
  try {
    if (is_private) benches.check(options);
    const auto loaded = scenarios.load(program.commands);
    if (is_private) return start_privately(loaded, junit, program);
    GlobalOptions ending_at_silence = options;
    ending_at_silence.ends_at_silence = true;
    return run_connected(program, ending_at_silence, [&](client::Session& session) {
      return run_scenarios(loaded,
                           {.is_json = options.json, .is_live = live, .timeout = options.timeout},
                           junit, session, program.terminal);
    });
  } catch (const std::exception& error) {
    const std::string suite =
        scenarios.files.size() == 1 ? name_of_scenario(scenarios.files.front()) : "start";
    static_cast<void>(junit.write({{suite, {{.name = "start", .error = error.what()}}}}));
    throw;
  }
}

/// A single file is executed here, several files each in their own process.
ExitCode RunCommand::start_privately(const std::vector<Scenario>& loaded, JunitReport& junit,
                                     const Program& program) const {
  const RunOptions run = options_of_private_run(program);
  return run_interruptible(program, [&](Interrupt& interrupt) {
    {
      PrivateSession bench(benches, program.options, interrupt);
      if (loaded.size() == 1) {
        return run_scenarios(loaded, run, junit, bench.session(), program.terminal);
      }
      client::Outcome found =
          check_scenarios(loaded, run, junit, bench.session(), program.terminal);
      if (!found) return found;
    }
    std::vector<std::vector<std::string>> processes;
    processes.reserve(loaded.size());
    for (const Scenario& each : loaded) processes.push_back(command_of_one(each, program.options));
    return run_scenarios_apart(loaded, run, junit, processes, interrupt, program.terminal);
  });
}

/// The counterpart of start_privately(), in the process of one file.
ExitCode RunCommand::start_one_of_several(const Program& program) const {
  FileResults results;
  try {
    benches.check(program.options);
    const std::vector<Scenario> loaded{scenarios.load_from_input(program.commands)};
    RunOptions run = options_of_private_run(program);
    run.results = &results;
    return run_interruptible(program, [&](Interrupt& interrupt) {
      JunitReport none("");
      PrivateSession bench(benches, program.options, interrupt);
      client::Outcome outcome = run_scenarios(loaded, run, none, bench.session(), program.terminal);
      results.end(outcome ? "" : outcome.message(), program.terminal);
      return outcome;
    });
  } catch (const std::exception& error) {
    results.end(error.what(), program.terminal);
    throw;
  }
}

RunOptions RunCommand::options_of_private_run(const Program& program) const {
  return {.is_json = program.options.json,
          .is_live = live,
          .is_private = true,
          .timeout = program.options.timeout};
}

std::vector<std::string> RunCommand::command_of_one(const Scenario& scenario,
                                                    const GlobalOptions& options) const {
  std::vector<std::string> words{std::string(kOneOfSeveral), "run", "--private"};
  if (options.json) words.emplace_back("--json");
  if (live) words.emplace_back("--live");
  return command_of_process(words, scenario, scenarios, benches, options);
}

extern const CommandRow kRun = row_of<RunCommand>({.name = "run",
                                                   .group = CommandGroup::scenarios,
                                                   .summary = "Execute scenario files",
                                                   .example = "run forward.scn --junit out.xml",
                                                   .help = kScenarioHelp,
                                                   .deepest = Place::shell});

}  // namespace vdrive::tool
