// SPDX-License-Identifier: Apache-2.0
#include "base/exit_code.hpp"
#include "base/scratch_directory.hpp"
#include "base/usage_error.hpp"
#include "child_process.hpp"
#include "language/arguments.hpp"
#include "language/command.hpp"
#include "language/fail_on.hpp"
#include "language/scenario.hpp"
#include "output/junit.hpp"
#include "output/report.hpp"
#include "private_domain.hpp"
#include "scenarios/private_benches.hpp"
#include "scenarios/scenario_files.hpp"
#include "scenarios/scenario_judge.hpp"
#include "scenarios/scenario_process.hpp"
#include "scenarios/scenario_verdict.hpp"
#include "scenarios/shards.hpp"
#include "terminal/interrupt.hpp"
#include "terminal/terminal.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <exception>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace vdrive::tool {
namespace {

using Clock = std::chrono::steady_clock;

// Wall time for the final lines of an interrupted scenario; its bench is in lock-step.
constexpr std::chrono::seconds kFinalLines{20};

/// Runs each scenario on a private bench, several in parallel, and writes one report. Each has its
/// own process, `vdrive run --private`, so that a crash fails only one file.
struct TestCommand {
  ScenarioFiles scenarios{};
  PrivateBenches benches{};
  std::size_t jobs = 0;                       ///< files in parallel; 0 = one per processor
  std::optional<Shard> shard = std::nullopt;  ///< the shard of the files to run; none = all
  bool merges = false;                        ///< runs nothing: the files are reports to merge
  bool judges = false;                        ///< judges the scenarios, as masters
  std::optional<judge::Severity> fail_on = judge::Severity::error;  ///< severity of findings that
                                                                    ///< fail; none = never
  bool names_fail_on = false;                                       ///< given on the command line

  void declare(Arguments& arguments);

  /// @return the result of conclude() or, with `merges`, the result in the merged reports.
  /// @throws UsageError before anything starts: for a mistake in a file, in the configuration or in
  ///         an option, and for a report that cannot be written.
  ExitCode start(const Program& program) const;

 private:
  ExitCode merge(const Program& program) const;
};

std::string passed_text(std::size_t passed, std::size_t files) {
  return std::to_string(passed) + " of " + counted(files, "file", "files") + " passed";
}

/// One run of all files.
class ScenarioTests {
 public:
  ScenarioTests(const TestCommand& tests, const GlobalOptions& options,
                std::vector<Scenario> scenarios, Terminal& terminal)
      : tests_(tests), options_(options), scenarios_(std::move(scenarios)), terminal_(terminal) {
    verdicts_.reserve(scenarios_.size());
    for (const Scenario& scenario : scenarios_) verdicts_.push_back(not_started(scenario));
    if (tests_.judges) journals_.emplace();
  }

  void run() {
    const std::size_t processors = std::max(std::thread::hardware_concurrency(), 1U);
    const std::size_t jobs =
        std::min(tests_.jobs == 0 ? processors : tests_.jobs, scenarios_.size());
    std::vector<std::jthread> workers;
    workers.reserve(jobs);
    for (std::size_t i = 0; i < jobs; ++i) {
      workers.emplace_back([this] {
        work();
      });
    }
  }

  /// Ends the running scenarios; no further ones start. Thread-safe.
  void interrupt() {
    const std::scoped_lock lock(mutex_);
    is_interrupted_ = true;
    for (const auto& [place, run] : jobs_) run->send(SIGINT);
  }

  [[nodiscard]] std::vector<JunitSuite> suites() const {
    std::vector<JunitSuite> suites;
    suites.reserve(verdicts_.size());
    for (const ScenarioVerdict& verdict : verdicts_) suites.push_back(verdict.suite);
    return suites;
  }

  /// @return the exit code of the first failed file; not_run only if none failed, because such a
  ///         file may pass when repeated.
  [[nodiscard]] ExitCode conclude() {
    const auto passed =
        static_cast<std::size_t>(std::ranges::count(verdicts_, 0, &ScenarioVerdict::code));
    Record record;
    if (tests_.shard) {
      record = {{"shard", tests_.shard->number, "shard " + std::to_string(tests_.shard->number)},
                {"shards", tests_.shard->count, "of " + std::to_string(tests_.shard->count) + ":"}};
    }
    record.push_back({"files", verdicts_.size()});
    record.push_back({"passed", passed, passed_text(passed, verdicts_.size())});
    print(record, {terminal_, options_.json, false});
    ExitCode first = ExitCode::ok;
    for (const ScenarioVerdict& verdict : verdicts_) {
      if (verdict.code == 0) continue;
      if (first == ExitCode::ok || first == ExitCode::not_run) {
        first = static_cast<ExitCode>(verdict.code);
      }
    }
    return first;
  }

 private:
  void work() {
    while (const auto place = take_next()) {
      const auto start = Clock::now();
      const Scenario& scenario = scenarios_[*place];
      ScenarioVerdict& verdict = verdicts_[*place];
      try {
        verdict =
            scenario.mistake.empty()
                ? test(*place)
                : failed_to_start(scenario, static_cast<int>(ExitCode::usage), scenario.mistake);
      } catch (const std::exception& error) {
        verdict = failed_to_start(scenario, static_cast<int>(ExitCode::not_run), error.what());
      }
      report(scenario, verdict, Clock::now() - start);
    }
  }

  std::optional<std::size_t> take_next() {
    const std::scoped_lock lock(mutex_);
    if (is_interrupted_ || next_ == scenarios_.size()) return std::nullopt;
    return next_++;
  }

  /// Registers the process of a worker while it runs.
  class Job {
   public:
    Job(ScenarioTests& owner, std::size_t place, process::ChildProcess& run)
        : owner_(owner), place_(place) {
      const std::scoped_lock lock(owner_.mutex_);
      if (owner_.is_interrupted_) run.send(SIGINT);
      owner_.jobs_[place_] = &run;
    }

    ~Job() {
      const std::scoped_lock lock(owner_.mutex_);
      owner_.jobs_.erase(place_);
    }

    Job(const Job&) = delete;
    Job& operator=(const Job&) = delete;

   private:
    ScenarioTests& owner_;
    const std::size_t place_;
  };

  ScenarioVerdict test(std::size_t place) {
    const Scenario& scenario = scenarios_[place];
    PrivateBenches benches = tests_.benches;
    if (journals_) benches.journal = journals_->file(std::to_string(place) + ".journal");
    process::ChildProcess run(command_of_process({"run", "--private", "--json"}, scenario,
                                                 tests_.scenarios, benches, options_));
    const Job job(*this, place, run);
    const int code = wait_for(run);
    // The signal may arrive before the program can turn it into an exit code.
    const bool has_ended_by_it = code == static_cast<int>(ExitCode::interrupted) || code == -SIGINT;
    if (is_interrupted_ && has_ended_by_it && run.output().empty()) return not_started(scenario);
    ScenarioVerdict verdict =
        verdict_of(scenario, {.code = code, .output = run.output(), .errors = run.errors()});
    // A scenario that never began, or was interrupted, is not judged as a master.
    const bool has_run = verdict.done > 0 && code != static_cast<int>(ExitCode::interrupted);
    if (journals_ && has_run) {
      judge_scenario(scenario, benches.journal, tests_.fail_on, verdict);
      std::error_code kept;  // ignored: the directory is removed in the end
      std::filesystem::remove(benches.journal, kept);
    }
    return verdict;
  }

  /// Waits for a scenario to end; kills it if it does not end within kFinalLines of an interrupt.
  int wait_for(process::ChildProcess& run) {
    constexpr std::chrono::milliseconds kCheckPeriod{200};  // checks for an interrupt, which does
                                                            // not wake the wait
    std::optional<Clock::time_point> deadline;
    while (true) {
      if (const auto code = run.wait(kCheckPeriod)) return *code;
      if (is_interrupted_ && !deadline) deadline = Clock::now() + kFinalLines;
      if (deadline && Clock::now() > *deadline) run.send(SIGKILL);
    }
  }

  void report(const Scenario& scenario, const ScenarioVerdict& verdict, Clock::duration duration) {
    const auto milliseconds = std::chrono::duration_cast<std::chrono::milliseconds>(duration);
    const bool passed = verdict.code == 0;
    Record record = end_record(scenario, passed, verdict.done, terminal_);
    record.back().text += ",";
    record.push_back({"seconds", static_cast<double>(milliseconds.count()) / 1000.0,
                      std::to_string(milliseconds.count()) + " ms"});
    if (!passed) record.push_back({"messages", verdict.messages});
    print(record, {terminal_, options_.json, false});
    for (const std::string& note : verdict.notes) terminal_.print_error(note);
    if (passed || options_.json) return;
    for (const std::string& message : verdict.messages) terminal_.print_error(message);
  }

  const TestCommand& tests_;
  const GlobalOptions& options_;
  const std::vector<Scenario> scenarios_;
  Terminal& terminal_;
  std::optional<ScratchDirectory> journals_;  ///< of the running files
  std::vector<ScenarioVerdict> verdicts_;     ///< by file; each is written by one worker
  std::atomic<bool> is_interrupted_ = false;
  std::mutex mutex_;  ///< guards next_ and jobs_
  std::size_t next_ = 0;
  std::map<std::size_t, process::ChildProcess*> jobs_;  ///< running
};

std::vector<Scenario> load_files(const ScenarioFiles& scenarios, CommandTable commands) {
  if (std::ranges::find(scenarios.files, "-") != scenarios.files.end()) {
    throw UsageError("test reads files only: write 'vdrive run -' for standard input");
  }
  return scenarios.load(commands, Mistake::is_kept);
}

std::size_t parse_jobs(const std::string& text) {
  constexpr std::uint64_t kMostJobs = process::PrivateDomain::kMostOfOneUser;
  const std::uint64_t jobs = parse_number(text, "number of jobs", kMostJobs);
  if (jobs == 0) throw UsageError("--jobs: at least one file must run");
  return jobs;
}

void TestCommand::declare(Arguments& arguments) {
  scenarios.declare(arguments, "Scenario");
  benches.declare(arguments);
  arguments.option("--jobs", "N", jobs,
                   "How many files run at the same time; default: one per processor", parse_jobs);
  arguments.option("--shard", "I/N", shard,
                   "Run only the files of shard I of N; /N takes I from the job's "
                   "JOB_COMPLETION_INDEX (Kubernetes) or SLURM_ARRAY_TASK_ID",
                   parse_shard);
  arguments.flag("--judge", judges,
                 "Judge each scenario as a master, as 'vdrive judge' does; a line '# judge: off "
                 "RULE because REASON' in it is an exception");
  declare_fail_on(arguments, fail_on, &names_fail_on);
  arguments.flag("--merge", merges,
                 "Merge reports instead of running: each FILE is the report of a shard, or a "
                 "directory of reports; --junit writes them as one");
  arguments.then([this] {
    if (names_fail_on && !judges) throw UsageError("--fail-on is for --judge");
    if (merges && (shard || jobs != 0 || judges || !scenarios.settings.empty() ||
                   !benches.arguments().empty())) {
      throw UsageError("--merge runs nothing: of the other options it takes --junit only");
    }
  });
}

ExitCode TestCommand::start(const Program& program) const {
  if (merges) return merge(program);
  Interrupt interrupt;
  JunitReport junit(scenarios.junit);
  std::optional<Shard> part = shard;
  std::optional<ScenarioTests> running;
  try {
    // An unusable configuration is reported once, not for each file.
    benches.check(program.options);
    std::vector<Scenario> loaded = load_files(scenarios, program.commands);
    // All files are read, so that the check of variables does not depend on the shard.
    if (part) loaded = dealt_to(*part, std::move(loaded));
    running.emplace(*this, program.options, std::move(loaded), program.terminal);
  } catch (const std::exception& error) {
    static_cast<void>(junit.write({{"start", {{.name = "start", .error = error.what()}}}}, part));
    throw;
  }
  interrupt.arm([&running] {
    running->interrupt();
  });
  running->run();
  interrupt.disarm();
  const ExitCode code = running->conclude();
  if (const auto unwritten = junit.write(running->suites(), part)) {
    program.terminal.print_error("vdrive: " + *unwritten);
    if (code == ExitCode::ok) return ExitCode::not_run;
  }
  return interrupt.happened() ? ExitCode::interrupted : code;
}

ExitCode TestCommand::merge(const Program& program) const {
  const std::vector<std::string> files = report_files(scenarios.files, scenarios.junit);
  JunitReport junit(scenarios.junit);
  MergedReports merged;
  try {
    merged = merge_reports(files);
  } catch (const UsageError& error) {
    static_cast<void>(junit.write({{"merge", {{.name = "merge", .error = error.what()}}}}));
    throw;
  }
  for (const std::string& message : merged.messages) {
    program.terminal.print_error("vdrive: " + message);
  }
  const std::size_t present = merged.shards - merged.missing.size();
  print({{"shards", merged.shards,
          std::to_string(present) + " of " + counted(merged.shards, "shard", "shards") + ":"},
         {"missing", merged.missing},
         {"files", merged.files},
         {"passed", merged.passed, passed_text(merged.passed, merged.files)}},
        {program.terminal, program.options.json, false});
  if (const auto unwritten = junit.write(merged.suites)) {
    program.terminal.print_error("vdrive: " + *unwritten);
    if (merged.code == ExitCode::ok) return ExitCode::not_run;
  }
  return merged.code;
}

}  // namespace

extern const CommandRow kTest =
    row_of<TestCommand>({.name = "test",
                         .group = CommandGroup::scenarios,
                         .summary = "Run scenario files in parallel, each on a separate bench",
                         .example = "test tests/*.scn --config bench.yaml --junit out.xml",
                         .deepest = Place::command_line});

}  // namespace vdrive::tool
