// SPDX-License-Identifier: Apache-2.0
#include "base/usage_error.hpp"
#include "exceptions/exception_file.hpp"
#include "judge/rule.hpp"
#include "judge/text_report.hpp"
#include "language/arguments.hpp"
#include "language/command.hpp"
#include "log/bus_log.hpp"
#include "node/data_sheet_reader.hpp"
#include "node/node_settings.hpp"
#include "output/judge_reports.hpp"
#include "output/junit.hpp"
#include "output/record.hpp"
#include "output/report_file.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <iostream>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace vdrive::tool {
namespace {

constexpr std::string_view kStandardInput = "-";

/// Names the mistakes of a master in the log of its bus.
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

  void declare(Arguments& arguments);
  ExitCode start(const Program& program) const;
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
    throw UsageError("--eds: " + in_quotes(name) + " is no data sheet: " + error.what());
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
  throw UsageError("--node: " + in_quotes(text) + " is no node id: write 1 to 127");
}

std::string node_name(std::uint32_t axis) {
  return "node " + std::to_string(axis);
}

bool fails(const judge::Verdict& verdict, const std::optional<judge::Severity>& fail_on) {
  return fail_on && std::ranges::any_of(verdict.findings, [&](const judge::Finding& finding) {
           return judge::row_of(finding.rule).severity <= *fail_on;
         });
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
  program.terminal.complain("vdrive: " + message);
  return ExitCode::unreadable;
}

void print_verdict(const judge::Verdict& verdict, const judge::ReportFace& face,
                   const Program& program) {
  if (program.options.json) {
    for (const Json& object : judge_json(verdict, face)) program.terminal.print(to_line(object));
    return;
  }
  std::string text = judge::text_report(verdict, face);
  while (text.ends_with('\n')) text.pop_back();
  program.terminal.print(text);
}

/// The files of reports, which are opened before the log is read.
class ReportFiles {
 public:
  explicit ReportFiles(const JudgeCommand& command)
      : fail_on_(command.fail_on.value_or(judge::Severity::advice)),
        junit_("--junit", command.junit),
        sarif_("--sarif", command.sarif),
        html_("--html", command.html) {}

  /// @return why one could not be written, or nothing.
  std::optional<std::string> write(const judge::Verdict& verdict, const judge::ReportFace& face) {
    std::optional<std::string> failure;
    const auto put = [&failure](ReportFile& file, const auto& text) {
      if (!file.is_wanted()) return;
      if (auto reason = file.write(text())) failure = std::move(reason);
    };
    put(junit_, [&] {
      return junit_xml({judge_junit(verdict, face, fail_on_)});
    });
    put(sarif_, [&] {
      return judge_sarif(verdict, face);
    });
    put(html_, [&] {
      return judge_html(verdict, face);
    });
    return failure;
  }

 private:
  judge::Severity fail_on_;
  ReportFile junit_;
  ReportFile sarif_;
  ReportFile html_;
};

std::optional<judge::Severity> parse_fail_on(const std::string& text) {
  return text == "never" ? std::nullopt : judge::parse_severity(text);
}

void JudgeCommand::declare(Arguments& arguments) {
  arguments.positional(
      "LOG", log, "Log of a CANopen bus by candump or a CAN analyser (.asc); - is standard input");
  arguments.option("--eds", "FILE", sheet,
                   "Electronic data sheet of the drives: PDO mapping and data types that the log "
                   "does not show");
  arguments.option("--node", "ID", nodes, "Judge this node only, 1 to 127; may be repeated");
  arguments.option("--exceptions", "FILE", exceptions,
                   "YAML list of what the master does on purpose: rule, axis, reason");
  arguments
      .option("--fail-on", "SEVERITY", fail_on,
              "Exit with 1 for findings of this severity and above: error (default), warning, "
              "advice, or never",
              parse_fail_on)
      .one_of({"error", "warning", "advice", "never"});
  arguments.option("--junit", "FILE", junit, "Write a JUnit report, a case for each rule");
  arguments.option("--sarif", "FILE", sarif, "Write a SARIF 2.1.0 report");
  arguments.option("--html", "FILE", html,
                   "Write a page with the table and a picture around each finding; it needs no "
                   "network");
  arguments.flag("--rules", lists_rules, "List the rules instead, as a page (Markdown)");
  arguments.then([this] {
    if (log.empty() != lists_rules) {
      throw UsageError(lists_rules ? "--rules reads no log" : "LOG is required");
    }
    for (const std::string& node : nodes) static_cast<void>(parse_node(node));
  });
}

ExitCode JudgeCommand::start(const Program& program) const {
  if (lists_rules) return list_rules(program);
  judge::DecoderSettings settings;
  for (const std::string& node : nodes) settings.nodes.insert(parse_node(node));
  canopen::DataSheet data_sheet;
  if (!sheet.empty()) {
    data_sheet = read_sheet(sheet);
    settings.sheet = &data_sheet;
  }
  const std::vector<judge::Exception> excepted = exceptions_of(exceptions);
  ReportFiles reports(*this);
  std::ifstream file;
  if (log != kStandardInput) {
    errno = 0;
    file.open(log, std::ios::binary);
    file.peek();  // a folder can be opened, and not read
    if (!file.is_open() || file.bad()) return unreadable(*this, system_reason(), program);
  }
  judge::LogVerdict result =
      judge::judge_bus_log(log == kStandardInput ? std::cin : file, settings);
  if (!result.is_readable()) {
    return unreadable(
        *this, "it has no CAN frame; record a log with candump -L, or give an .asc file", program);
  }
  judge::ReportFace face{.source = log, .name_of = node_name, .notes = result.notes};
  face.unused = judge::except(result.verdict, excepted, node_name);
  print_verdict(result.verdict, face, program);
  if (const auto failure = reports.write(result.verdict, face)) {
    program.terminal.complain("vdrive: " + *failure);
    return ExitCode::failed;
  }
  return fails(result.verdict, fail_on) ? ExitCode::failed : ExitCode::ok;
}

}  // namespace

extern const CommandRow kJudge =
    row_of<JudgeCommand>({.name = "judge",
                          .group = CommandGroup::recordings,
                          .summary = "Find the mistakes of a master in the log of a CANopen bus",
                          .example = "judge field.candump --node 5 --html findings.html\n"
                                     "  vdrive judge run.candump --eds drive.eds --fail-on warning",
                          .deepest = Place::command_line,
                          .needs_domain = false});

}  // namespace vdrive::tool
