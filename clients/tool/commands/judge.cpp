// SPDX-License-Identifier: Apache-2.0
#include "base/usage_error.hpp"
#include "exceptions/exception_file.hpp"
#include "execution/axis_finder.hpp"
#include "execution/connection.hpp"
#include "judge/bench_records.hpp"
#include "judge/rule.hpp"
#include "judge/text_report.hpp"
#include "language/arguments.hpp"
#include "language/command.hpp"
#include "language/fail_on.hpp"
#include "live/live_judge.hpp"
#include "log/bus_log.hpp"
#include "node/data_sheet_reader.hpp"
#include "node/node_settings.hpp"
#include "output/judge_reports.hpp"
#include "output/junit.hpp"
#include "output/record.hpp"
#include "output/report_file.hpp"
#include "replayed/bench_journal.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <fstream>
#include <iostream>
#include <iterator>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace vdrive::tool {
namespace {

constexpr std::string_view kStandardInput = "-";

// Judging needs every status, but none of them soon.
constexpr std::chrono::milliseconds kReceiveEvery{8};

/// The result of judging a source.
struct Judged {
  judge::Verdict verdict;
  std::vector<std::string> notes;
  judge::AxisName name_of;
};

class ReportFiles;

/// Reports the mistakes of a master: from the log of its bus, from the journal of its bench, or
/// live while its bench runs.
struct JudgeCommand {
  std::string log{};
  std::string sheet{};
  std::vector<std::string> nodes{};
  std::string exceptions{};
  std::string junit{};
  std::string sarif{};
  std::string html{};
  std::optional<judge::Severity> fail_on = judge::Severity::error;  ///< none = never fails
  bool lists_rules = false;
  bool is_live = false;                             ///< `log` names axes of a running bench
  std::optional<Duration> duration = std::nullopt;  ///< drive time; none = until interrupted

  void declare(Arguments& arguments);
  ExitCode start(const Program& program) const;

 private:
  ExitCode start_live(const Program& program) const;
  ExitCode report(const Program& program, Judged& result,
                  const std::vector<judge::Exception>& excepted, ReportFiles& reports) const;
};

std::string system_reason() {
  return std::generic_category().message(errno);
}

std::string read_whole(std::string_view option, const std::string& name) {
  errno = 0;
  std::ifstream file(name, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(file), {}};
  if (file.is_open() && !file.bad()) return text;
  throw UsageError(std::string(option) + ": cannot read " + in_quotes(name) + ": " +
                   system_reason());
}

canopen::DataSheet read_sheet(const std::string& name) {
  try {
    return canopen::read_data_sheet(read_whole("--eds", name));
  } catch (const canopen::DataSheetError& error) {
    throw UsageError("--eds: " + in_quotes(name) + " is not a data sheet: " + error.what());
  }
}

std::vector<judge::Exception> exceptions_of(const std::string& name) {
  if (name.empty()) return {};
  try {
    return judge::read_exceptions(read_whole("--exceptions", name), name);
  } catch (const UsageError&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw UsageError(error.what());
  }
}

std::uint8_t parse_node(const std::string& text) {
  const auto number = parse_digits<std::uint8_t>(text);
  if (number && *number >= canopen::kLowestNodeId && *number <= canopen::kHighestNodeId) {
    return *number;
  }
  throw UsageError("--node: " + in_quotes(text) + " is not a node-ID: write 1 to 127");
}

std::string node_name(std::uint32_t axis) {
  return "node " + std::to_string(axis);
}

ExitCode list_rules(const Program& program) {
  if (program.options.json) {
    for (const Json& rule : rules_json()) program.terminal.print(to_line(rule));
    return ExitCode::ok;
  }
  std::string page = judge::rules_page();
  while (page.ends_with('\n')) page.pop_back();
  program.terminal.print(page);
  return ExitCode::ok;
}

ExitCode unreadable(const JudgeCommand& command, const std::string& reason,
                    const Program& program) {
  const std::string message = in_quotes(command.log) + " cannot be judged: " + reason;
  if (program.options.json) {
    program.terminal.print(to_line({{"outcome", "unreadable"}, {"message", message}}));
  }
  program.terminal.print_error("vdrive: " + message);
  return ExitCode::unreadable;
}

void print_verdict(const judge::Verdict& verdict, const judge::ReportLabels& labels,
                   const Program& program) {
  if (program.options.json) {
    for (const Json& object : judge_json(verdict, labels)) program.terminal.print(to_line(object));
    return;
  }
  std::string text = judge::text_report(verdict, labels);
  while (text.ends_with('\n')) text.pop_back();
  program.terminal.print(text);
}

/// The report files, opened before the log is read.
class ReportFiles {
 public:
  explicit ReportFiles(const JudgeCommand& command)
      : fail_on_(command.fail_on.value_or(judge::Severity::advice)),
        junit_("--junit", command.junit),
        sarif_("--sarif", command.sarif),
        html_("--html", command.html) {}

  /// @return why a report could not be written, or nothing.
  std::optional<std::string> write(const judge::Verdict& verdict,
                                   const judge::ReportLabels& labels) {
    std::optional<std::string> failure;
    const auto put = [&failure](ReportFile& file, const auto& text) {
      if (!file.is_wanted()) return;
      if (auto reason = file.write(text())) failure = std::move(reason);
    };
    put(junit_, [&] {
      return junit_xml({judge_junit(verdict, labels, fail_on_)});
    });
    put(sarif_, [&] {
      return judge_sarif(verdict, labels);
    });
    put(html_, [&] {
      return judge_html(verdict, labels);
    });
    return failure;
  }

 private:
  judge::Severity fail_on_;
  ReportFile junit_;
  ReportFile sarif_;
  ReportFile html_;
};

void JudgeCommand::declare(Arguments& arguments) {
  arguments.positional("LOG", log,
                       "Log of a CANopen bus by candump or a CAN analyser (.asc), or journal of a "
                       "bench; - is standard input");
  arguments.option("--eds", "FILE", sheet,
                   "Electronic data sheet of the drives: PDO mapping and data types that the log "
                   "does not show");
  arguments.option("--node", "ID", nodes,
                   "Of a log: judge this node only, 1 to 127; may be repeated");
  arguments.option("--exceptions", "FILE", exceptions,
                   "YAML list of intended deviations of the master: rule, axis, reason");
  declare_fail_on(arguments, fail_on);
  arguments.option("--junit", "FILE", junit, "Write a JUnit report with a case for each rule");
  arguments.option("--sarif", "FILE", sarif, "Write a SARIF 2.1.0 report");
  arguments.option("--html", "FILE", html,
                   "Write a page with the table and a picture around each finding; it needs no "
                   "network");
  arguments.flag("--live", is_live,
                 "LOG is an axis or the number of a running bench: judge live until Ctrl-C");
  arguments.option("--for", "T", duration, "With --live: end after this drive time",
                   parse_duration);
  arguments.flag("--rules", lists_rules, "List the rules instead, as a page (Markdown)");
  arguments.then([this] {
    if (log.empty() != lists_rules) {
      throw UsageError(lists_rules ? "--rules reads no log" : "LOG is required");
    }
    for (const std::string& node : nodes) static_cast<void>(parse_node(node));
    if (is_live && (!sheet.empty() || !nodes.empty())) {
      throw UsageError("--eds and --node are for bus logs, but --live judges a bench");
    }
    if (duration && !is_live) throw UsageError("--for needs --live");
  });
}

Judged judge_log(const JudgeCommand& command, std::istream& log) {
  judge::DecoderSettings settings;
  for (const std::string& node : command.nodes) settings.nodes.insert(parse_node(node));
  canopen::DataSheet data_sheet;
  if (!command.sheet.empty()) {
    data_sheet = read_sheet(command.sheet);
    settings.sheet = &data_sheet;
  }
  judge::LogVerdict result = judge::judge_bus_log(log, settings);
  if (!result.is_readable()) {
    throw std::runtime_error(
        "it contains no CAN frames; record a log with candump -L, or give an .asc file or the "
        "journal of a bench");
  }
  return {
      .verdict = std::move(result.verdict), .notes = std::move(result.notes), .name_of = node_name};
}

Judged judge_bench(const JudgeCommand& command, std::istream& journal) {
  if (!command.sheet.empty() || !command.nodes.empty()) {
    throw UsageError("--eds and --node are for bus logs, but " + in_quotes(command.log) +
                     " is the journal of a bench");
  }
  judge::JournalVerdict result = judge::judge_journal(journal);
  return {.verdict = std::move(result.verdict),
          .notes = std::move(result.notes),
          .name_of = judge::axes_of_bench(result.bench)};
}

/// A bench that is judged while it runs.
class LiveRun {
 public:
  LiveRun(const JudgeCommand& command, const Program& program)
      : command_(command), program_(program) {}

  /// @return why judging ended early; `result` has the findings so far.
  client::Outcome run(client::Session& session, const Interrupt& interrupt, Judged& result) {
    AxisFinder finder(session);
    auto axes = parse_digits<std::uint32_t>(command_.log)
                    ? finder.axes_of_bench(parse_bench(command_.log))
                    : finder.axes({command_.log});
    if (!axes) return axes.outcome();
    const std::uint32_t bench = axes->front().id().bench;
    if (axes->back().id().bench != bench) {
      throw UsageError("--live judges the axes of one bench, but " + in_quotes(command_.log) +
                       " selects axes of several");
    }
    name_of_ = judge::axes_of_bench(bench);
    auto judge = judge::LiveJudge::create(session, bench, std::move(*axes));
    if (!judge) return judge.outcome();
    program_.terminal.print_error("vdrive: judging bench " + std::to_string(bench));
    client::Outcome outcome;
    while (outcome && !interrupt.happened() && !is_over(*judge)) {
      std::this_thread::sleep_for(judge::LiveJudge::kPollEvery);
      outcome = judge->poll(judge::LiveJudge::kPollEvery);
      tell_new(*judge);
    }
    result = {.verdict = judge->verdict(), .notes = {}, .name_of = name_of_};
    return interrupt.happened() ? client::Outcome() : outcome;
  }

 private:
  bool is_over(const judge::LiveJudge& judge) const {
    return command_.duration && judge.judged_time() >= *command_.duration;
  }

  /// Prints a line the first time a rule is broken on an axis.
  void tell_new(const judge::LiveJudge& judge) {
    const auto now = std::chrono::steady_clock::now();
    if (now < next_look_) return;
    next_look_ = now + std::chrono::seconds(1);
    for (const judge::Finding& finding : judge.verdict().findings) {
      if (!told_.emplace(finding.rule, finding.axis).second) continue;
      const judge::RuleRow& row = judge::row_of(finding.rule);
      program_.terminal.print_error("vdrive: " + std::string(judge::to_string(row.severity)) + " " +
                                    std::string(row.name) + " on " + name_of_(finding.axis) +
                                    " at tick " + std::to_string(finding.first.tick) + ": " +
                                    finding.happened);
    }
  }

  const JudgeCommand& command_;
  const Program& program_;
  judge::AxisName name_of_;
  std::set<std::pair<judge::Rule, std::uint32_t>> told_;
  std::chrono::steady_clock::time_point next_look_{};
};

ExitCode JudgeCommand::report(const Program& program, Judged& result,
                              const std::vector<judge::Exception>& excepted,
                              ReportFiles& reports) const {
  judge::ReportLabels labels{.source = log, .name_of = result.name_of, .notes = result.notes};
  labels.unused = judge::except(result.verdict, excepted, result.name_of);
  print_verdict(result.verdict, labels, program);
  if (const auto failure = reports.write(result.verdict, labels)) {
    program.terminal.print_error("vdrive: " + *failure);
    return ExitCode::failed;
  }
  return judge::fails(result.verdict, fail_on) ? ExitCode::failed : ExitCode::ok;
}

ExitCode JudgeCommand::start_live(const Program& program) const {
  const std::vector<judge::Exception> excepted = exceptions_of(exceptions);
  ReportFiles reports(*this);
  Interrupt interrupt;
  leave_screen_before_exit(interrupt, program.terminal);
  client::SessionOptions options = session_options(program.options);
  options.receive_coalescing = kReceiveEvery;
  client::Session session(options);
  interrupt.arm([&session] {
    session.interrupt();
  });
  Judged result;
  const client::Outcome outcome = LiveRun(*this, program).run(session, interrupt, result);
  interrupt.disarm();
  if (result.name_of) {
    const ExitCode code = report(program, result, excepted, reports);
    if (!outcome && code != ExitCode::ok) {
      program.terminal.print_error("vdrive: " + outcome.message());
    }
    if (outcome || code != ExitCode::ok) return code;
  }
  return finish(outcome, interrupt, program.options.json, program.terminal);
}

ExitCode JudgeCommand::start(const Program& program) const {
  if (lists_rules) return list_rules(program);
  if (is_live) return start_live(program);
  const std::vector<judge::Exception> excepted = exceptions_of(exceptions);
  ReportFiles reports(*this);
  std::ifstream file;
  if (log != kStandardInput) {
    errno = 0;
    file.open(log, std::ios::binary);
    file.peek();  // detects a directory, which can be opened but not read
    if (!file.is_open() || file.bad()) return unreadable(*this, system_reason(), program);
  }
  std::istream& source = log == kStandardInput ? std::cin : file;
  Judged result;
  try {
    result = judge::is_journal(source) ? judge_bench(*this, source) : judge_log(*this, source);
  } catch (const UsageError&) {
    throw;
  } catch (const std::runtime_error& error) {
    return unreadable(*this, error.what(), program);
  }
  return report(program, result, excepted, reports);
}

}  // namespace

extern const CommandRow kJudge = row_of<JudgeCommand>(
    {.name = "judge",
     .group = CommandGroup::recordings,
     .summary = "Report the mistakes of a master from a log, a journal or a running bench",
     .example = "judge field.candump --node 5 --html findings.html\n"
                "  vdrive judge run.journal --fail-on warning\n"
                "  vdrive judge 1.1 --live\n"
                "  vdrive judge run.candump --eds drive.eds",
     .deepest = Place::command_line});

}  // namespace vdrive::tool
