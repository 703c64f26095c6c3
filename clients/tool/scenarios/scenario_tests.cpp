// SPDX-License-Identifier: Apache-2.0
#include "scenarios/scenario_tests.hpp"

#include "base/service_program.hpp"
#include "base/usage_error.hpp"
#include "child_process.hpp"
#include "language/scenario.hpp"
#include "language/variables.hpp"
#include "output/junit.hpp"
#include "output/report.hpp"
#include "private_bench.hpp"
#include "terminal/terminal.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <sstream>
#include <thread>
#include <utility>
#include <vector>

namespace vdrive::tool {
namespace {

using Clock = std::chrono::steady_clock;

// Of an interrupted scenario: its final lines, in lock-step.
constexpr std::chrono::seconds kFinalLines{20};

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

/// What became of a file.
struct Result {
  int code = static_cast<int>(ExitCode::interrupted);
  std::vector<std::string> messages;  ///< of a failure
  JunitSuite suite;
};

JunitCase skipped_case(const std::string& name) {
  JunitCase test;
  test.name = name;
  test.is_skipped = true;
  return test;
}

/// What `vdrive run --json` has written about each line.
std::map<std::size_t, JunitCase> cases_of(const std::string& output) {
  std::map<std::size_t, JunitCase> cases;
  for (const std::string& text : lines_of(output)) {
    const Json json = Json::parse(text, nullptr, false);
    // What a command of the scenario reads is no verdict.
    if (!json.is_object() || !json.contains("line") || !json.contains("outcome")) continue;
    JunitCase test;
    test.duration = std::chrono::duration_cast<std::chrono::nanoseconds>(
        std::chrono::duration<double>(json.value("seconds", 0.0)));
    if (json["outcome"] != "ok") test.failure = json.value("message", "");
    cases.emplace(json["line"].get<std::size_t>(), std::move(test));
  }
  return cases;
}

/// One run of all files.
class ScenarioTests {
 public:
  ScenarioTests(const ScenarioTestOptions& tests, const GlobalOptions& options,
                std::vector<Scenario> scenarios, Terminal& terminal)
      : tests_(tests),
        options_(options),
        scenarios_(std::move(scenarios)),
        service_(find_service(tests.service)),
        terminal_(terminal),
        results_(scenarios_.size()) {
    for (std::size_t i = 0; i < scenarios_.size(); ++i) {
      results_[i].suite = {scenarios_[i].file, {skipped_case("start")}};
    }
  }

  void run() {
    const std::size_t jobs = std::min<std::size_t>(tests_.jobs, scenarios_.size());
    std::vector<std::jthread> workers;
    workers.reserve(jobs);
    for (std::size_t i = 0; i < jobs; ++i) {
      workers.emplace_back([this] {
        work();
      });
    }
  }

  /// Ends what runs; nothing further starts. Any thread.
  void interrupt() {
    const std::scoped_lock lock(mutex_);
    is_interrupted_ = true;
    for (const auto& [place, job] : jobs_) job();
  }

  [[nodiscard]] std::vector<JunitSuite> suites() const {
    std::vector<JunitSuite> suites;
    suites.reserve(results_.size());
    for (const Result& result : results_) suites.push_back(result.suite);
    return suites;
  }

  /// @return the exit code of the first file that failed.
  [[nodiscard]] ExitCode conclude() {
    const auto failed = std::ranges::find_if(results_, [](const Result& result) {
      return result.code != 0;
    });
    const auto passed = static_cast<std::size_t>(std::ranges::count(results_, 0, &Result::code));
    const std::string text =
        std::to_string(passed) + " of " + counted(results_.size(), "file", "files") + " passed";
    if (options_.json) {
      terminal_.print(to_line({{"files", results_.size()}, {"passed", passed}}));
    } else {
      terminal_.print(text);
    }
    return failed == results_.end() ? ExitCode::ok : static_cast<ExitCode>(failed->code);
  }

 private:
  void work() {
    while (const auto place = take_next()) {
      const auto start = Clock::now();
      Result& result = results_[*place];
      try {
        test(*place, result);
      } catch (const std::exception& error) {
        set_error(result, static_cast<int>(ExitCode::failed), error.what());
      }
      report(scenarios_[*place], result, Clock::now() - start);
    }
  }

  std::optional<std::size_t> take_next() {
    const std::scoped_lock lock(mutex_);
    if (is_interrupted_ || next_ == scenarios_.size()) return std::nullopt;
    return next_++;
  }

  /// Registers how to end what a worker runs, while it runs.
  class Job {
   public:
    Job(ScenarioTests& owner, std::size_t place, std::function<void()> end)
        : owner_(owner), place_(place) {
      const std::scoped_lock lock(owner_.mutex_);
      if (owner_.is_interrupted_) end();
      owner_.jobs_[place_] = std::move(end);
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

  void test(std::size_t place, Result& result) {
    process::PrivateBench bench(service_, arguments_of_service());
    {
      const Job job(*this, place, [&bench] {
        bench.end();
      });
      if (const auto problem = bench.wait_until_ready()) {
        if (!is_interrupted_) set_error(result, static_cast<int>(ExitCode::failed), *problem);
        return;
      }
    }
    process::ChildProcess run(command_to_run(scenarios_[place], bench.domain()));
    const Job job(*this, place, [&run] {
      run.send(SIGINT);
    });
    judge(scenarios_[place], run, wait_for(run), result);
  }

  /// An interrupted scenario ends by itself; one that does not is killed.
  int wait_for(process::ChildProcess& run) {
    constexpr std::chrono::milliseconds kCheckPeriod{200};
    std::optional<Clock::time_point> deadline;
    while (true) {
      if (const auto code = run.wait(kCheckPeriod)) return *code;
      if (is_interrupted_ && !deadline) deadline = Clock::now() + kFinalLines;
      if (deadline && Clock::now() > *deadline) run.send(SIGKILL);
    }
  }

  [[nodiscard]] std::vector<std::string> command_to_run(const Scenario& scenario,
                                                        std::uint32_t domain) const {
    // The bench has just started, on a machine that is busy with the others.
    constexpr std::chrono::seconds kTimeout{60};
    const auto timeout = std::chrono::duration_cast<std::chrono::microseconds>(
        options_.timeout.value_or(Duration(kTimeout)));
    std::vector<std::string> command{process::own_program(),
                                     "--domain",
                                     std::to_string(domain),
                                     "--timeout",
                                     std::to_string(timeout.count()) + "us",
                                     "run",
                                     "--json"};
    if (!options_.security.empty())
      command.insert(command.end(), {"--security", options_.security});
    for (const auto& [name, value] : settings_of(tests_.scenarios.settings)) {
      // Another file's variable is unknown there.
      if (scenario.variables.contains(name)) {
        command.emplace_back("--set");
        command.emplace_back(name).append("=").append(value);
      }
    }
    command.insert(command.end(), {"--", scenario.file});
    return command;
  }

  [[nodiscard]] std::vector<std::string> arguments_of_service() const {
    std::vector<std::string> arguments{"--clock", "lockstep"};
    if (!tests_.configuration.empty()) {
      arguments.insert(arguments.end(), {"--config", tests_.configuration});
    }
    return arguments;
  }

  static void set_error(Result& result, int code, const std::string& message) {
    result.code = code;
    result.messages = {message};
    JunitCase error;
    error.name = "start";
    error.error = message;
    result.suite.cases = {std::move(error)};
  }

  static void judge(const Scenario& scenario, const process::ChildProcess& run, int code,
                    Result& result) {
    auto cases = cases_of(run.output());
    result.code = code >= 0 ? code : static_cast<int>(ExitCode::failed);
    result.messages = lines_of(run.errors());
    if (code < 0) result.messages.push_back("ended by signal " + std::to_string(-code));
    if (code != 0 && cases.empty()) {
      const std::string why = result.messages.empty() ? "interrupted" : result.messages.back();
      std::vector<std::string> messages = std::move(result.messages);
      set_error(result, result.code, why);
      result.messages = std::move(messages);
      return;
    }
    result.suite.cases.clear();
    for (const ScenarioLine& line : scenario.lines) {
      const std::string name = "line " + std::to_string(line.number) + ": " + line.text;
      const auto found = cases.find(line.number);
      JunitCase& test = result.suite.cases.emplace_back(
          found == cases.end() ? skipped_case(name) : std::move(found->second));
      test.name = name;
    }
  }

  void report(const Scenario& scenario, const Result& result, Clock::duration duration) {
    const auto milliseconds = std::chrono::duration_cast<std::chrono::milliseconds>(duration);
    if (options_.json) {
      Json json{{"file", scenario.file},
                {"passed", result.code == 0},
                {"lines", scenario.lines.size()},
                {"seconds", static_cast<double>(milliseconds.count()) / 1000.0}};
      if (result.code != 0) json["messages"] = result.messages;
      terminal_.print(to_line(json));
      return;
    }
    const bool passed = result.code == 0;
    terminal_.print(
        colored(terminal_, passed ? Color::green : Color::red, passed ? "passed" : "failed") +
        "  " + escaped(scenario.file, kShownOfMessage) + ", " +
        counted(scenario.lines.size(), "line", "lines") + ", " +
        std::to_string(milliseconds.count()) + " ms");
    if (passed) return;
    for (const std::string& message : result.messages) terminal_.complain(message);
  }

  const ScenarioTestOptions& tests_;
  const GlobalOptions& options_;
  const std::vector<Scenario> scenarios_;
  const std::string service_;
  Terminal& terminal_;
  std::vector<Result> results_;  ///< each written by one worker
  std::atomic<bool> is_interrupted_ = false;
  std::mutex mutex_;  ///< guards what follows
  std::size_t next_ = 0;
  std::map<std::size_t, std::function<void()>> jobs_;  ///< how to end them
};

/// A configuration that cannot be used is one mistake, not one a file.
void check_configuration(const std::string& service, const std::string& configuration) {
  if (configuration.empty()) return;
  process::ChildProcess check({service, "--check", configuration});
  if (check.wait() != 0) {
    std::string text = check.errors();
    while (text.ends_with('\n')) text.pop_back();
    throw UsageError("--config: " + text);
  }
}

std::vector<Scenario> load_files(const ScenarioFiles& scenarios, CommandTable commands) {
  if (std::ranges::find(scenarios.files, "-") != scenarios.files.end()) {
    throw UsageError("test reads files only: write 'vdrive run -' for standard input");
  }
  return scenarios.load(commands);
}

}  // namespace

ExitCode run_scenario_tests(const ScenarioTestOptions& tests, const Program& program,
                            Interrupt& interrupt) {
  JunitReport junit(tests.scenarios.junit);
  std::optional<ScenarioTests> running;
  try {
    check_configuration(find_service(tests.service), tests.configuration);
    running.emplace(tests, program.options, load_files(tests.scenarios, program.commands),
                    program.terminal);
  } catch (const std::exception& error) {
    static_cast<void>(junit.write({{"start", {{.name = "start", .error = error.what()}}}}));
    throw;
  }
  interrupt.arm([&running] {
    running->interrupt();
  });
  running->run();
  interrupt.disarm();
  const ExitCode code = running->conclude();
  if (const auto unwritten = junit.write(running->suites())) {
    program.terminal.complain("vdrive: " + *unwritten);
    if (code == ExitCode::ok) return ExitCode::failed;
  }
  return interrupt.happened() ? ExitCode::interrupted : code;
}

}  // namespace vdrive::tool
