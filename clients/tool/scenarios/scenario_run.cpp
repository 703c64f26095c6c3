// SPDX-License-Identifier: Apache-2.0
#include "scenarios/scenario_run.hpp"

#include "base/usage_error.hpp"
#include "child_process.hpp"
#include "execution/command_context.hpp"
#include "execution/failure_report.hpp"
#include "output/live_view.hpp"
#include "output/report.hpp"
#include "scenarios/scenario_process.hpp"
#include "scenarios/scenario_verdict.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <exception>
#include <map>
#include <memory>
#include <string>
#include <utility>

namespace vdrive::tool {
namespace {

using client::Outcome;
using Clock = std::chrono::steady_clock;

/// Reports the end of a scenario. @param done number of executed lines
void report_end(const Scenario& scenario, bool passed, std::size_t done, bool is_json,
                Terminal& terminal) {
  print(end_record(scenario, passed, done, terminal), {terminal, is_json, false});
}

/// Reports the end of several scenarios. @return the failure, unless all passed.
Outcome report_all(std::size_t passed, std::size_t all, bool is_json, Terminal& terminal) {
  const std::string text =
      std::to_string(passed) + " of " + counted(all, "file", "files") + " passed";
  Outcome outcome = passed == all ? Outcome() : Outcome::failed(text);
  print_answer({{"files", all}, {"passed", passed, text}}, outcome, {terminal, is_json, false});
  return outcome;
}

/// Finds the axes and benches of scenarios. Searches only once for a missing one, because a search
/// that finds nothing lasts until its time-out.
class AxisSearch {
 public:
  explicit AxisSearch(client::Session& session) : session_(session) {}

  /// @return why this bench is missing; empty if it is present.
  const std::string& absence_of(std::uint32_t bench) {
    const auto [known, is_new] = benches_.try_emplace(bench);
    if (is_new) known->second = message_of(session_.find_bench(bench).outcome());
    return known->second;
  }

  /// @return the axes with this name, or why they are missing.
  client::Result<std::vector<client::Axis>> find(const std::string& name, AxisFinder& axes) {
    if (const auto known = names_.find(name); known != names_.end()) {
      return Outcome::not_found(known->second);
    }
    const auto id = client::parse_axis_id(name);
    if (id && !absence_of(id->bench).empty()) {
      return Outcome::not_found("no axis " + name + ": " + absence_of(id->bench));
    }
    if (!id && no_bench_found_) {
      return Outcome::not_found("no axis is named " + in_quotes(name) + ": " +
                                session_.no_bench_found().message());
    }
    auto found = axes.axes({name});
    if (!found) {
      names_.emplace(name, found.outcome().message());
      no_bench_found_ = !id && session_.find_benches().empty();
    }
    return found;
  }

 private:
  static std::string message_of(const Outcome& outcome) {
    return outcome ? std::string() : outcome.message();
  }

  client::Session& session_;
  std::map<std::uint32_t, std::string> benches_;
  std::map<std::string, std::string> names_;  ///< names that no axis has
  bool no_bench_found_ = false;               ///< no bench was found, so no axis has a name
};

/// The execution of one scenario.
class ScenarioRun {
 public:
  ScenarioRun(const Scenario& scenario, const RunOptions& options, client::Session& session,
              Terminal& terminal)
      : scenario_(scenario),
        options_(options),
        session_(session),
        terminal_(terminal),
        // No command table: a scenario cannot run scenarios.
        context_(session, {terminal, options.is_json, true}, {}) {
    context_.is_private = options.is_private;
  }

  /// Finds wrong names, benches and units before anything moves.
  /// @param units receives the lines with wrong units
  /// @return not_found with each line whose axis or bench is missing.
  Outcome find_axes(AxisSearch& search, Mistakes& units) {
    Mistakes absences;
    for (const ScenarioLine& line : scenario_.lines) {
      if (absences.is_full() || units.is_full()) break;
      const std::string absence = find_axes_of(line, search);
      if (absence.empty()) {
        check_units(line, units);
      } else {
        absences.note(place_of(line) + ": " + absence);
      }
    }
    return absences.text().empty() ? Outcome() : Outcome::not_found(absences.text());
  }

  /// @return the first failure of the lines above `finally`, otherwise of those below.
  Outcome run() {
    start_live_view();
    Outcome outcome;
    for (const ScenarioLine& line : scenario_.lines) {
      if (line.is_final) continue;
      if (outcome) {
        outcome = run_line(line);
      } else {
        add_case(line).is_skipped = true;
      }
    }
    was_interrupted_ = session_.is_interrupted();
    Outcome final_outcome = run_final_lines();
    if (outcome) {
      outcome = std::move(final_outcome);
    } else if (!final_outcome) {
      terminal_.print_error("vdrive: " + final_outcome.message());
    }
    context_.live_view = nullptr;
    live_view_.reset();
    if (!outcome) put_back();
    report_end(scenario_, static_cast<bool>(outcome), done_, options_.is_json, terminal_);
    return outcome;
  }

  /// @return whether run() was interrupted.
  [[nodiscard]] bool was_interrupted() const noexcept { return was_interrupted_; }

  [[nodiscard]] JunitSuite suite() && { return {scenario_.file, std::move(cases_)}; }

 private:
  /// @return why the axes or the bench of a line are missing; empty if all are present.
  std::string find_axes_of(const ScenarioLine& line, AxisSearch& search) {
    if (line.command.bench && !search.absence_of(*line.command.bench).empty()) {
      return search.absence_of(*line.command.bench);
    }
    std::string absences;
    for (const std::string& name : line.command.axes) {
      const auto found = search.find(name, context_.axes);
      if (!found) {
        absences += (absences.empty() ? "" : "; ") + found.outcome().message();
        continue;
      }
      for (const client::Axis& axis : *found) {
        if (std::ranges::find(axes_, axis.id()) == axes_.end()) axes_.push_back(axis.id());
      }
    }
    return absences;
  }

  [[nodiscard]] std::string place_of(const ScenarioLine& line) const {
    return escaped(scenario_.file, kShownOfMessage) + ":" + std::to_string(line.number);
  }

  JunitCase& add_case(const ScenarioLine& line) {
    return cases_.emplace_back(JunitCase{.name = name_of_line(line), .line = line.number});
  }

  /// Executes all final lines, even after a failure or an interrupt, because they clean up.
  Outcome run_final_lines() {
    Outcome outcome;
    for (const ScenarioLine& line : scenario_.lines) {
      if (!line.is_final) continue;
      session_.end_interrupt();
      Outcome done = run_line(line);
      if (!done && outcome) {
        outcome = std::move(done);
      } else if (!done) {
        terminal_.print_error("vdrive: " + done.message());
      }
    }
    return outcome;
  }

  void check_units(const ScenarioLine& line, Mistakes& units) {
    try {
      tool::check_units(line.command, context_);
    } catch (const UsageError& error) {
      units.note(place_of(line) + ": " + error.what());
    }
  }

  void start_live_view() {
    const bool wanted = options_.is_live || terminal_.is_interactive();
    if (!wanted || options_.is_json || axes_.empty()) return;
    const auto is_elsewhere = [&](const client::AxisId& id) {
      return id.bench != axes_.front().bench;
    };
    std::vector<client::AxisId> shown = axes_;
    std::erase_if(shown, is_elsewhere);
    live_view_ = std::make_unique<LiveView>(session_, terminal_, std::move(shown));
    context_.live_view = live_view_.get();
  }

  Outcome run_line(const ScenarioLine& line) {
    announce(line);
    const auto start = Clock::now();
    Outcome outcome =
        execute(line.command, context_, line.timeout ? line.timeout : options_.timeout);
    JunitCase& test = add_case(line);
    test.duration = Clock::now() - start;
    ++done_;
    if (outcome) {
      report_line(line, outcome, test.duration);
      return outcome;
    }
    FailureReport report = report_failure(line.command, outcome, context_);
    report_line(line, outcome, test.duration, report);
    test.failure = outcome.message();
    test.type = failure_type(outcome, context_.judge.found());
    test.text = failure_text(scenario_, line,
                             {.message = outcome.message(),
                              .details = std::move(report.axes),
                              .advice = std::move(report.advice)});
    return Outcome::failed(test.text);
  }

  /// Restores the bench, so that the next scenario does not find the faults of this one.
  void put_back() {
    for (const std::string& done : context_.changes.put_back(context_.axes)) {
      terminal_.print_error("vdrive: restored: " + done);
    }
  }

  void announce(const ScenarioLine& line) {
    if (options_.is_json) return;
    std::string number = std::to_string(line.number);
    number.insert(0, 4 - std::min<std::size_t>(number.size(), 4), ' ');
    terminal_.print(colored(terminal_, Color::cyan, number) + "  " +
                    escaped(line.text, kShownOfMessage));
  }

  /// @param failure nothing if the line passed
  void report_line(const ScenarioLine& line, const Outcome& outcome, Clock::duration duration,
                   const FailureReport& failure = {}) {
    if (!options_.is_json && options_.results == nullptr) return;
    Record record{{"file", scenario_.file}, {"line", line.number}, {"command", line.text}};
    add_outcome(record, outcome);
    if (context_.judge.found()) add_members(record, *context_.judge.found());
    if (!outcome) {
      record.push_back({"type", failure_type(outcome, context_.judge.found())});
      if (failure.tick) record.push_back({"tick", *failure.tick});
      record.push_back({"details", failure.axes});
      record.push_back({"advice", failure.advice});
    }
    record.push_back({"seconds", std::chrono::duration<double>(duration).count()});
    const Json result = record_json(record);
    if (options_.is_json) terminal_.print(to_line(result));
    if (options_.results != nullptr) options_.results->put(result);
  }

  const Scenario& scenario_;
  const RunOptions& options_;
  client::Session& session_;
  Terminal& terminal_;
  CommandContext context_;
  std::vector<client::AxisId> axes_;
  std::unique_ptr<LiveView> live_view_;
  std::vector<JunitCase> cases_;
  std::size_t done_ = 0;  ///< executed lines
  bool was_interrupted_ = false;
};

/// @return the suites of a report if axes of some scenarios are missing, so that none was executed.
/// @param found one outcome per scenario, in the same order
std::vector<JunitSuite> suites_without_axes(const std::vector<Scenario>& scenarios,
                                            const std::vector<Outcome>& found) {
  std::vector<JunitSuite> suites;
  suites.reserve(scenarios.size());
  for (std::size_t i = 0; i < scenarios.size(); ++i) {
    JunitCase test{.name = "axes"};
    if (found[i]) {
      test.is_skipped = true;
    } else {
      test.error = found[i].message();
    }
    suites.push_back({scenarios[i].file, {std::move(test)}});
  }
  return suites;
}

/// Several scenarios in one session.
class ScenarioRuns {
 public:
  ScenarioRuns(const std::vector<Scenario>& scenarios, const RunOptions& options,
               client::Session& session, Terminal& terminal)
      : scenarios_(scenarios), options_(options), session_(session), terminal_(terminal) {
    runs_.reserve(scenarios.size());
    for (const Scenario& scenario : scenarios) {
      runs_.push_back(std::make_unique<ScenarioRun>(scenario, options, session, terminal));
    }
  }

  /// @return not_found with each missing axis and bench, which suites() reports.
  /// @throws UsageError with each unit that an axis does not have, and with the missing axes
  Outcome find_axes() {
    AxisSearch search(session_);
    Mistakes units;
    Mistakes absences;
    std::vector<Outcome> found;
    for (const auto& run : runs_) {
      found.push_back(run->find_axes(search, units));
      if (!found.back()) absences.note(found.back().message());
    }
    if (!units.text().empty()) {
      if (!absences.text().empty()) units.note(absences.text());
      units.throw_if_any();
    }
    if (absences.text().empty()) return {};
    suites_ = suites_without_axes(scenarios_, found);
    return Outcome::not_found(absences.text());
  }

  Outcome run() {
    if (runs_.size() == 1) return run_one(0);
    std::size_t passed = 0;
    for (std::size_t i = 0; i < runs_.size() && terminal_.is_open(); ++i) {
      Outcome outcome = run_one(i);
      if (was_interrupted_) return outcome;
      if (outcome) ++passed;
      if (!outcome) terminal_.print_error("vdrive: " + outcome.message());
    }
    return report_all(passed, runs_.size(), options_.is_json, terminal_);
  }

  [[nodiscard]] const std::vector<JunitSuite>& suites() const { return suites_; }

 private:
  Outcome run_one(std::size_t place) {
    Outcome outcome = runs_[place]->run();
    was_interrupted_ = runs_[place]->was_interrupted();
    suites_.push_back(std::move(*runs_[place]).suite());
    // Releases the axes, because the next file is a separate master.
    if (Outcome released = session_.release(); !released && outcome) return released;
    return outcome;
  }

  const std::vector<Scenario>& scenarios_;
  const RunOptions& options_;
  client::Session& session_;
  Terminal& terminal_;
  bool was_interrupted_ = false;
  std::vector<std::unique_ptr<ScenarioRun>> runs_;
  std::vector<JunitSuite> suites_;
};

/// Several scenarios, each in its own process.
class ScenariosApart {
 public:
  ScenariosApart(const std::vector<Scenario>& scenarios, const RunOptions& options,
                 const std::vector<std::vector<std::string>>& processes, Interrupt& interrupt,
                 Terminal& terminal)
      : scenarios_(scenarios),
        options_(options),
        processes_(processes),
        interrupt_(interrupt),
        terminal_(terminal) {}

  Outcome run() {
    std::size_t passed = 0;
    for (std::size_t i = 0; i < scenarios_.size() && !interrupt_.happened(); ++i) {
      ScenarioVerdict verdict = run_one(scenarios_[i], processes_[i]);
      if (verdict.code == 0) ++passed;
      suites_.push_back(std::move(verdict.suite));
      // The reader has closed the output, which is not a failure.
      if (output_ == FileEnd::Stream::closed_by_reader) return {};
      if (output_ == FileEnd::Stream::failed) break;
    }
    if (interrupt_.happened()) return Outcome::failed("interrupted");
    return report_all(passed, scenarios_.size(), options_.is_json, terminal_);
  }

  [[nodiscard]] const std::vector<JunitSuite>& suites() const { return suites_; }

 private:
  ScenarioVerdict run_one(const Scenario& scenario, const std::vector<std::string>& process) {
    try {
      return run_process(scenario, process);
    } catch (const std::exception& error) {
      return report_unreported(
          scenario, failed_to_start(scenario, static_cast<int>(ExitCode::failed), error.what()));
    }
  }

  /// Runs a scenario in a process, which reports the end itself unless it ends prematurely.
  ScenarioVerdict run_process(const Scenario& scenario, const std::vector<std::string>& process) {
    process::ChildProcess run(process, {}, {.input = scenario.source, .are_shared = true});
    interrupt_.arm([&run] {
      run.send(SIGINT);
    });
    const int code = run.wait().value();
    interrupt_.disarm();
    const std::string results = run.output();
    const auto end = end_of_file(results);
    if (end) output_ = end->output;
    // A file that the process has reported as passed still counts as passed if only the output
    // could not be written. It counts as failed if the process failed afterwards, while it shut
    // down the bench.
    const bool has_ended_well = code == 0 || output_ != FileEnd::Stream::open;
    if (end && code >= 0 && (has_ended_well || !end->failure.empty() || interrupt_.happened())) {
      return verdict_of(
          scenario,
          {.code = end->failure.empty() ? 0 : code, .output = results, .errors = end->failure});
    }
    // The signal may arrive before the process can turn it into an exit code.
    if (interrupt_.happened() && results.empty()) return not_started(scenario);
    EndedRun ended{.code = code, .output = results, .errors = ""};
    if (code >= 0) ended.errors = "ended with exit code " + std::to_string(code);
    if (code == 0) ended.code = static_cast<int>(ExitCode::failed);  // it did not report its end
    return report_unreported(scenario, verdict_of(scenario, ended));
  }

  ScenarioVerdict report_unreported(const Scenario& scenario, ScenarioVerdict verdict) {
    report_end(scenario, false, verdict.done, options_.is_json, terminal_);
    for (const std::string& message : verdict.messages) {
      terminal_.print_error("vdrive: " + escaped(scenario.file, kShownOfMessage) + ": " + message);
    }
    return verdict;
  }

  const std::vector<Scenario>& scenarios_;
  const RunOptions& options_;
  const std::vector<std::vector<std::string>>& processes_;  ///< command line of each scenario
  Interrupt& interrupt_;
  Terminal& terminal_;
  FileEnd::Stream output_ = FileEnd::Stream::open;
  std::vector<JunitSuite> suites_;
};

/// @return the outcome, or why the report could not be written.
template <typename Runs>
Outcome with_report(Outcome outcome, const Runs& runs, JunitReport& junit) {
  const auto unwritten = junit.write(runs.suites());
  return outcome && unwritten ? Outcome::failed(*unwritten) : outcome;
}

}  // namespace

Outcome run_scenarios(const std::vector<Scenario>& scenarios, const RunOptions& options,
                      JunitReport& junit, client::Session& session, Terminal& terminal) {
  ScenarioRuns runs(scenarios, options, session, terminal);
  Outcome outcome = runs.find_axes();
  if (outcome) outcome = runs.run();
  return with_report(std::move(outcome), runs, junit);
}

Outcome check_scenarios(const std::vector<Scenario>& scenarios, const RunOptions& options,
                        JunitReport& junit, client::Session& session, Terminal& terminal) {
  ScenarioRuns runs(scenarios, options, session, terminal);
  Outcome found = runs.find_axes();
  return found ? found : with_report(std::move(found), runs, junit);
}

Outcome run_scenarios_apart(const std::vector<Scenario>& scenarios, const RunOptions& options,
                            JunitReport& junit,
                            const std::vector<std::vector<std::string>>& processes,
                            Interrupt& interrupt, Terminal& terminal) {
  ScenariosApart runs(scenarios, options, processes, interrupt, terminal);
  Outcome outcome = runs.run();
  return with_report(std::move(outcome), runs, junit);
}

}  // namespace vdrive::tool
