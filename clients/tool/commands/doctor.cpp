// SPDX-License-Identifier: Apache-2.0
#include "diagnosis/checks.hpp"
#include "execution/connection.hpp"
#include "language/arguments.hpp"
#include "language/command.hpp"
#include "terminal/columns.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <exception>
#include <future>
#include <iterator>
#include <string>
#include <vector>

namespace vdrive::tool {
namespace {

using client::Outcome;

void show_finding(const Finding& finding, const Output& output) {
  const Color color = finding.severity == Severity::good   ? Color::green
                      : finding.severity == Severity::hint ? Color::yellow
                                                           : Color::red;
  Record record = finding_record(finding);
  std::string& word = record.front().text;
  word = colored(output.terminal, color, padded(word, 8));
  print(record, output);
  const bool has_advice = !output.is_json && !finding.advice.empty();
  if (has_advice) output.terminal.print("         -> " + finding.advice);
}

/// Checks this machine and finds the benches on the domain. @return failed if there is a problem
Outcome diagnose(const GlobalOptions& options, const Output& output) {
  std::vector<Finding> findings = check_host(read_host(options.interfaces), options);
  try {
    // In parallel, because both wait for the network.
    auto ros = std::async(std::launch::async, [&options] {
      return read_ros(options);
    });
    // Inside `try`, so that the machine is checked even if no session can be opened.
    client::Session session(session_options(options));
    const auto benches = session.find_benches();
    std::ranges::move(check_troubles(session.network_troubles()), std::back_inserter(findings));
    std::ranges::move(check_benches(benches, options), std::back_inserter(findings));
    std::ranges::move(check_ros(ros.get(), options), std::back_inserter(findings));
  } catch (const std::exception& error) {
    findings.push_back(
        {.severity = Severity::problem,
         .subject = "benches",
         .text = error.what(),
         .advice = "solve this problem first; until then the tool cannot search for benches"});
  }
  for (const Finding& finding : findings) show_finding(finding, output);
  const auto problems = std::ranges::count(findings, Severity::problem, &Finding::severity);
  if (problems == 0) return {};
  return Outcome::failed(counted(static_cast<std::uint64_t>(problems), "problem", "problems"));
}

struct DoctorCommand {
  void declare(Arguments& /*arguments*/) {}

  static ExitCode start(const Program& program) {
    const Output output{program.terminal, program.options.json, false};
    return finish(diagnose(program.options, output), Interrupt(), false, program.terminal);
  }
};

}  // namespace

extern const CommandRow kDoctor =
    row_of<DoctorCommand>({.name = "doctor",
                           .group = CommandGroup::machine,
                           .summary = "Check this machine and its network, and suggest changes",
                           .example = "doctor --interface 10.0.0.1",
                           .deepest = Place::command_line});

}  // namespace vdrive::tool
