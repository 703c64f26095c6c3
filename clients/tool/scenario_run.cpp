// SPDX-License-Identifier: Apache-2.0
#include "scenario_run.hpp"

#include "live_view.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <chrono>
#include <memory>

namespace vdrive::tool {
namespace {

using client::Outcome;
using Clock = std::chrono::steady_clock;

/// One run: what it needs, and what it has found out so far.
class ScenarioRun {
 public:
  ScenarioRun(const Scenario& scenario, const RunOptions& options, JunitReport& junit,
              client::Session& session, Terminal& terminal)
      : scenario_(scenario),
        options_(options),
        junit_(junit),
        session_(session),
        terminal_(terminal),
        executor_(session, terminal, options.is_json, true) {}

  Outcome run() {
    if (Outcome found = find_axes(); !found) {
      cases_.push_back({.name = "axes", .error = found.message()});
      static_cast<void>(junit_.write(scenario_.file, cases_));
      return found;
    }
    start_live_view();
    Outcome outcome;
    for (const ScenarioLine& line : scenario_.lines) {
      if (outcome) {
        outcome = run_line(line);
      } else {
        cases_.push_back({.name = name_of(line), .is_skipped = true});
      }
    }
    live_view_.reset();
    if (!outcome) clear_disturbances();
    report(outcome);
    const auto unwritten = junit_.write(scenario_.file, cases_);
    return outcome && unwritten ? Outcome::failed(*unwritten) : outcome;
  }

 private:
  [[nodiscard]] std::string place_of(const ScenarioLine& line) const {
    return escaped(scenario_.file, kShownOfMessage) + ":" + std::to_string(line.number);
  }

  static std::string name_of(const ScenarioLine& line) {
    return "line " + std::to_string(line.number) + ": " + line.text;
  }

  /// A name or a bench that is wrong is found before anything moves.
  Outcome find_axes() {
    for (const ScenarioLine& line : scenario_.lines) {
      if (const auto number = bench_of(line.command)) {
        const auto bench = session_.find_bench(number);
        if (!bench) return Outcome::not_found(place_of(line) + ": " + bench.outcome().message());
      }
      for (const std::string& name : axes_of(line.command)) {
        const auto axis = executor_.axis(name);
        if (!axis) return Outcome::not_found(place_of(line) + ": " + axis.outcome().message());
        if (std::ranges::find(axes_, axis->id()) == axes_.end()) axes_.push_back(axis->id());
      }
    }
    return {};
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
    executor_.on_aim([this](const client::AxisId& axis, std::int64_t target) {
      if (live_view_) live_view_->aim(axis, target);
    });
  }

  Outcome run_line(const ScenarioLine& line) {
    announce(line);
    const auto start = Clock::now();
    Outcome outcome =
        executor_.execute(line.command, line.timeout ? line.timeout : options_.timeout);
    JunitCase& test = cases_.emplace_back();
    test.name = name_of(line);
    test.duration = Clock::now() - start;
    if (!outcome) test.failure = outcome.message();
    if (options_.is_json) print_json(line, outcome);
    if (outcome) return outcome;
    return Outcome::failed(place_of(line) + ": " + escaped(line.text, kShownOfMessage) + ": " +
                           outcome.message());
  }

  /// Who runs the next scenario finds the bench without the faults of this one.
  void clear_disturbances() {
    for (const std::string& cleared : executor_.clear_disturbances()) {
      terminal_.complain("vdrive: cleared " + cleared);
    }
  }

  void announce(const ScenarioLine& line) {
    if (options_.is_json) return;
    std::string number = std::to_string(line.number);
    number.insert(0, 4 - std::min<std::size_t>(number.size(), 4), ' ');
    terminal_.print(colored(terminal_, Color::cyan, number) + "  " +
                    escaped(line.text, kShownOfMessage));
  }

  void print_json(const ScenarioLine& line, const Outcome& outcome) {
    Json json{{"file", scenario_.file}, {"line", line.number}, {"command", line.text}};
    add_outcome(json, outcome);
    if (executor_.found()) json.update(*executor_.found());
    terminal_.print(to_line(json));
  }

  void report(const Outcome& outcome) {
    if (options_.is_json) {
      terminal_.print(to_line({{"file", scenario_.file},
                               {"passed", static_cast<bool>(outcome)},
                               {"lines", scenario_.lines.size()}}));
    } else if (outcome) {
      terminal_.print(colored(terminal_, Color::green, "passed") + "  " + scenario_.file + ", " +
                      counted(scenario_.lines.size(), "line", "lines"));
    }
  }

  const Scenario& scenario_;
  const RunOptions& options_;
  JunitReport& junit_;
  client::Session& session_;
  Terminal& terminal_;
  Executor executor_;
  std::vector<client::AxisId> axes_;
  std::unique_ptr<LiveView> live_view_;
  std::vector<JunitCase> cases_;
};

}  // namespace

Outcome run_scenario(const Scenario& scenario, const RunOptions& options, JunitReport& junit,
                     client::Session& session, Terminal& terminal) {
  return ScenarioRun(scenario, options, junit, session, terminal).run();
}

}  // namespace vdrive::tool
