// SPDX-License-Identifier: Apache-2.0
#include "output/judge_reports.hpp"

#include "judge/words.hpp"
#include "output/plot_picture.hpp"
#include "output/xml_text.hpp"
#include "vdrive/cia402/power_state.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <optional>
#include <string_view>

namespace vdrive::tool {
namespace {

Json place_json(const judge::Place& place) {
  return {{"time_ns", place.time.count()},
          {"tick", place.tick == 0 ? Json(nullptr) : Json(place.tick)},
          {"line", place.line == 0 ? Json(nullptr) : Json(place.line)}};
}

Json lines_json(const judge::Finding& finding) {
  Json lines = Json::array();
  for (const judge::Line& line : finding.lines) {
    const judge::CycleRow row = judge::cycle_row(line);
    lines.push_back({{"time_ns", line.place.time.count()},
                     {"by", row[1]},
                     {"what", row[2]},
                     {"controlword", line.controlword ? Json(*line.controlword) : Json(nullptr)},
                     {"statusword", line.statusword ? Json(*line.statusword) : Json(nullptr)},
                     {"controlword_text", row[3]},
                     {"statusword_text", row[4]},
                     {"mode", line.mode ? Json(*line.mode) : Json(nullptr)},
                     {"target", line.target ? Json(*line.target) : Json(nullptr)},
                     {"actual", line.actual ? Json(*line.actual) : Json(nullptr)},
                     {"waits_for", row[8]},
                     {"is_place", judge::is_place_of(finding, line)}});
  }
  return lines;
}

Json finding_json(const judge::Finding& finding, const judge::ReportLabels& labels) {
  const judge::RuleRow& row = judge::row_of(finding.rule);
  return {{"rule", row.name},
          {"severity", judge::to_string(row.severity)},
          {"axis", labels.name_of(finding.axis)},
          {"title", row.title},
          {"count", finding.count},
          {"first", place_json(finding.first)},
          {"last", place_json(finding.last)},
          {"happened", finding.happened},
          {"expected", row.expected},
          {"clause", row.clause},
          {"remedy", row.remedy}};
}

Json excepted_json(const judge::Verdict& verdict, const judge::ReportLabels& labels) {
  Json excepted = Json::array();
  for (const judge::Excepted& entry : verdict.excepted) {
    excepted.push_back({{"rule", judge::row_of(entry.finding.rule).name},
                        {"axis", labels.name_of(entry.finding.axis)},
                        {"count", entry.finding.count},
                        {"reason", entry.reason}});
  }
  return excepted;
}

Json unused_json(const judge::ReportLabels& labels) {
  Json unused = Json::array();
  for (const judge::Exception& exception : labels.unused) {
    unused.push_back({{"rule", judge::row_of(exception.rule).name},
                      {"axis", exception.axis.empty() ? Json(nullptr) : Json(exception.axis)},
                      {"place", exception.place}});
  }
  return unused;
}

Json unjudged_json(const judge::Verdict& verdict, const judge::ReportLabels& labels) {
  Json all = Json::array();
  for (const judge::Unjudged& unjudged : verdict.unjudged) {
    Json names = Json::array();
    for (const judge::Rule rule : unjudged.rules) names.push_back(judge::row_of(rule).name);
    Json axes = Json::array();
    for (const std::uint32_t axis : unjudged.axes) axes.push_back(labels.name_of(axis));
    all.push_back(
        {{"rules", names}, {"axes", axes}, {"reason", judge::missing_text(unjudged.fact)}});
  }
  return all;
}

Json end_json(const judge::Verdict& verdict, const judge::ReportLabels& labels) {
  const auto count = [&verdict](judge::Severity severity) {
    return std::ranges::count_if(verdict.findings, [severity](const judge::Finding& finding) {
      return judge::row_of(finding.rule).severity == severity;
    });
  };
  return {{"file", labels.source},
          {"errors", count(judge::Severity::error)},
          {"warnings", count(judge::Severity::warning)},
          {"advice", count(judge::Severity::advice)},
          {"axes", verdict.axes.size()},
          {"records", verdict.records},
          {"duration_ns", (verdict.last - verdict.first).count()},
          {"excepted", excepted_json(verdict, labels)},
          {"unused_exceptions", unused_json(labels)},
          {"not_judged", unjudged_json(verdict, labels)},
          {"notes", labels.notes}};
}

/// @return such as "node 5 at 3.200000 s, line 12: bit 4 rose ... (3 times)".
std::string message_of(const judge::Finding& finding, const judge::ReportLabels& labels) {
  std::string text = labels.name_of(finding.axis) + " at " + judge::place_text(finding.first);
  if (finding.first.line != 0) text += ", line " + std::to_string(finding.first.line);
  text += ": " + finding.happened;
  return finding.count == 1 ? text : text + " (" + counted(finding.count, "time", "times") + ")";
}

std::string rule_advice(const judge::RuleRow& row) {
  return "Expected: " + std::string(row.expected) + ".\nClause: " + std::string(row.clause) +
         ".\nDo: " + std::string(row.remedy) + ".";
}

// ---- SARIF -------------------------------------------------------------------------------------

std::string_view sarif_level(judge::Severity severity) {
  return severity == judge::Severity::advice ? "note" : judge::to_string(severity);
}

Json sarif_rules() {
  Json all = Json::array();
  for (const judge::RuleRow& row : judge::rules()) {
    all.push_back({{"id", row.name},
                   {"shortDescription", {{"text", row.title}}},
                   {"fullDescription", {{"text", std::string(row.expected) + "."}}},
                   {"help", {{"text", rule_advice(row)}}},
                   {"defaultConfiguration", {{"level", sarif_level(row.severity)}}}});
  }
  return all;
}

Json sarif_result(const judge::Finding& finding, const judge::ReportLabels& labels) {
  const judge::RuleRow& row = judge::row_of(finding.rule);
  Json physical{{"artifactLocation", {{"uri", labels.source}}}};
  if (finding.first.line != 0) physical["region"] = {{"startLine", finding.first.line}};
  const Json logical{{"name", labels.name_of(finding.axis)}, {"kind", "object"}};
  return {{"ruleId", row.name},
          {"ruleIndex", static_cast<std::size_t>(finding.rule)},
          {"level", sarif_level(row.severity)},
          {"message", {{"text", message_of(finding, labels)}}},
          {"locations", Json::array({{{"physicalLocation", physical},
                                      {"logicalLocations", Json::array({logical})}}})},
          {"occurrenceCount", finding.count}};
}

// ---- HTML --------------------------------------------------------------------------------------

/// No length limit: a page is not a message.
std::string html_text(std::string_view text) {
  return xml_text(text, text.size());
}

constexpr std::string_view kPageHead = R"(<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">
<style>
:root { color-scheme: light dark; --error: #b3261e; --warning: #8a5a00; --advice: #2a5db0; }
@media (prefers-color-scheme: dark) { :root { --error: #ff8a80; --warning: #ffc46b; --advice: #9ec1ff; } }
body { font: 15px/1.45 system-ui, sans-serif; margin: 2rem auto; max-width: 75rem; padding: 0 1rem; }
h2 { border-top: 1px solid; margin-top: 2.5rem; padding-top: 1rem; }
.error { color: var(--error); } .warning { color: var(--warning); } .advice { color: var(--advice); }
dt { font-weight: 600; float: left; clear: left; width: 6.5rem; } dd { margin: 0 0 .2rem 7rem; }
.scroll { overflow-x: auto; } table { border-collapse: collapse; font: 12.5px/1.4 ui-monospace, monospace; }
th, td { text-align: left; padding: .1rem .7rem .1rem 0; white-space: nowrap; vertical-align: top; }
tr.place { font-weight: 700; outline: 2px solid var(--error); } svg { max-width: 100%; height: auto; }
</style>
)";

void add_html_table(std::string& page, const judge::Finding& finding) {
  page += "<div class=\"scroll\" tabindex=\"0\"><table>\n<tr>";
  for (const char* const column : judge::kCycleColumns)
    page.append("<th>").append(column).append("</th>");
  page += "</tr>\n";
  for (const judge::Line& line : finding.lines) {
    page += judge::is_place_of(finding, line) ? "<tr class=\"place\">" : "<tr>";
    for (const std::string& cell : judge::cycle_row(line)) {
      page.append("<td>").append(html_text(cell)).append("</td>");
    }
    page += "</tr>\n";
  }
  page += "</table></div>\n";
}

/// The ticks around a finding as curves. One tick of the picture is one microsecond.
std::optional<PlotTraces> finding_traces(const judge::Finding& finding) {
  constexpr std::size_t kLeastSamples = 3;
  if (finding.samples.size() < kLeastSamples) return std::nullopt;
  const auto curve = [](const std::string& label) {
    return PlotTrace{.column = {.name = label, .label = label, .panel = "position [UU]"}};
  };
  PlotTrace actual = curve("actual 6064h");
  PlotTrace demand = curve("demand 6062h");
  PlotTrace target = curve("target 607Ah");
  PlotTraces traces;
  const auto tick_of = [&finding](judge::Time time) {
    const judge::Time since = time - finding.samples.front().time;
    return static_cast<std::uint64_t>(std::chrono::floor<std::chrono::microseconds>(since).count());
  };
  for (const judge::Sample& sample : finding.samples) {
    const std::uint64_t tick = tick_of(sample.time);
    const auto add = [tick](PlotTrace& trace, const std::optional<std::int64_t>& value) {
      if (value) trace.points.push_back({tick, *value});
    };
    add(actual, sample.position);
    add(demand, sample.demand);
    // A target holds until the next one.
    if (!target.points.empty()) add(target, target.points.back().value);
    add(target, sample.target);
    const PowerState state = decode_power_state(sample.statusword);
    if (traces.states.empty() || traces.states.back().state != state) {
      traces.states.push_back({.from = tick, .state = state});
    }
  }
  traces.last_tick = tick_of(finding.samples.back().time);
  traces.samples = finding.samples.size();
  for (PlotTrace* const trace : {&actual, &demand, &target}) {
    if (!trace->points.empty()) traces.traces.push_back(std::move(*trace));
  }
  if (traces.last_tick == 0 || traces.traces.empty()) return std::nullopt;
  return traces;
}

void add_html_finding(std::string& page, const judge::Finding& finding,
                      const judge::ReportLabels& labels) {
  const judge::RuleRow& row = judge::row_of(finding.rule);
  const std::string severity(judge::to_string(row.severity));
  page += "<h2 id=\"" + html_text(row.name) + "-" + std::to_string(finding.axis) +
          "\"><span class=\"" + severity + "\">" + severity + "</span> " + html_text(row.name) +
          " on " + html_text(labels.name_of(finding.axis)) + ": " + html_text(row.title) +
          "</h2>\n<dl>\n";
  const auto add = [&page](std::string_view term, std::string_view text) {
    page.append("<dt>").append(term).append("</dt><dd>").append(html_text(text)).append("</dd>\n");
  };
  std::string where = judge::place_text(finding.first);
  if (finding.first.line != 0) where += ", line " + std::to_string(finding.first.line);
  if (finding.count > 1) {
    where += "; " + counted(finding.count, "time", "times") + " until " +
             judge::place_text(finding.last);
  }
  add("where", where);
  add("happened", finding.happened);
  add("expected", row.expected);
  add("clause", row.clause);
  add("do", row.remedy);
  add("wrong", row.wrong);
  add("right", row.right);
  page += "</dl>\n";
  if (const auto traces = finding_traces(finding)) {
    page += plot_svg(*traces, {.title = labels.name_of(finding.axis) + " around " +
                                        judge::place_text(finding.first),
                               .period = std::chrono::microseconds(1)});
    page += "\n";
  }
  add_html_table(page, finding);
}

void add_html_list(std::string& page, std::string_view title,
                   const std::vector<std::string>& texts) {
  if (texts.empty()) return;
  page.append("<h2>").append(title).append("</h2>\n<ul>\n");
  for (const std::string& text : texts) page += "<li>" + html_text(text) + "</li>\n";
  page += "</ul>\n";
}

/// @return the number of axes on which a rule could not be judged.
std::size_t times_unjudged(const judge::Verdict& verdict, judge::Rule rule) {
  std::size_t axes = 0;
  for (const judge::Unjudged& lack : verdict.unjudged) {
    if (std::ranges::count(lack.rules, rule) != 0) axes += lack.axes.size();
  }
  return axes;
}

}  // namespace

std::vector<Json> judge_json(const judge::Verdict& verdict, const judge::ReportLabels& labels) {
  std::vector<Json> objects;
  for (const judge::Finding& finding : verdict.findings) {
    Json object = finding_json(finding, labels);
    object["lines"] = lines_json(finding);
    objects.push_back(std::move(object));
  }
  objects.push_back(end_json(verdict, labels));
  return objects;
}

std::vector<Json> rules_json() {
  std::vector<Json> objects;
  for (const judge::RuleRow& row : judge::rules()) {
    objects.push_back({{"rule", row.name},
                       {"severity", judge::to_string(row.severity)},
                       {"title", row.title},
                       {"clause", row.clause},
                       {"expected", row.expected},
                       {"remedy", row.remedy},
                       {"wrong", row.wrong},
                       {"right", row.right}});
  }
  return objects;
}

JunitSuite judge_junit(const judge::Verdict& verdict, const judge::ReportLabels& labels,
                       judge::Severity fail_on) {
  JunitSuite suite{.name = labels.source, .cases = {}};
  for (const judge::RuleRow& row : judge::rules()) {
    JunitCase test{.name = std::string(row.name) + " " + std::string(row.title)};
    std::string text;
    for (const judge::Finding& finding : verdict.findings) {
      if (finding.rule != row.rule) continue;
      text += message_of(finding, labels) + "\n";
      if (test.line == 0) test.line = finding.first.line;
    }
    if (text.empty()) {
      test.is_skipped = times_unjudged(verdict, row.rule) >= verdict.axes.size();
    } else if (row.severity <= fail_on) {
      test.failure = text.substr(0, text.find('\n'));
      test.type = std::string(judge::to_string(row.severity));
      test.text = text + rule_advice(row);
    } else {
      test.output = text + rule_advice(row);
    }
    suite.cases.push_back(std::move(test));
  }
  return suite;
}

std::string judge_sarif(const judge::Verdict& verdict, const judge::ReportLabels& labels) {
  Json results = Json::array();
  for (const judge::Finding& finding : verdict.findings)
    results.push_back(sarif_result(finding, labels));
  for (const judge::Excepted& excepted : verdict.excepted) {
    Json result = sarif_result(excepted.finding, labels);
    result["suppressions"] =
        Json::array({{{"kind", "external"}, {"justification", excepted.reason}}});
    results.push_back(std::move(result));
  }
  Json notes = Json::array();
  for (const judge::Unjudged& unjudged : verdict.unjudged) {
    notes.push_back(
        {{"level", "note"},
         {"message", {{"text", "not judged: " + judge::unjudged_text(unjudged, labels.name_of)}}}});
  }
  for (const std::string& note : labels.notes) {
    notes.push_back({{"level", "note"}, {"message", {{"text", note}}}});
  }
  const Json run{
      {"tool",
       {{"driver",
         {{"name", "vdrive judge"}, {"version", VDRIVE_VERSION}, {"rules", sarif_rules()}}}}},
      {"invocations",
       Json::array({{{"executionSuccessful", true}, {"toolExecutionNotifications", notes}}})},
      {"results", results}};
  const Json log{{"$schema", "https://json.schemastore.org/sarif-2.1.0.json"},
                 {"version", "2.1.0"},
                 {"runs", Json::array({run})}};
  return log.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string judge_html(const judge::Verdict& verdict, const judge::ReportLabels& labels) {
  const std::string title = html_text(labels.source) + ": " + judge::summary_text(verdict);
  std::string page(kPageHead);
  page += "<title>" + title + "</title>\n</head>\n<body>\n<h1>" + title + "</h1>\n<ul>\n";
  for (const judge::Finding& finding : verdict.findings) {
    const judge::RuleRow& row = judge::row_of(finding.rule);
    page += "<li><a href=\"#" + html_text(row.name) + "-" + std::to_string(finding.axis) + "\">" +
            html_text(row.name) + "</a> <span class=\"" +
            html_text(judge::to_string(row.severity)) + "\">" +
            html_text(judge::to_string(row.severity)) + "</span> on " +
            html_text(labels.name_of(finding.axis)) + ": " + html_text(row.title) + " (" +
            counted(finding.count, "time", "times") + ")</li>\n";
  }
  page += "</ul>\n";
  for (const judge::Finding& finding : verdict.findings) add_html_finding(page, finding, labels);
  std::vector<std::string> texts;
  for (const judge::Excepted& excepted : verdict.excepted) {
    texts.push_back(std::string(judge::row_of(excepted.finding.rule).name) + " on " +
                    labels.name_of(excepted.finding.axis) + ": " + excepted.reason);
  }
  add_html_list(page, "Excepted", texts);
  texts.clear();
  for (const judge::Unjudged& unjudged : verdict.unjudged) {
    texts.push_back(judge::unjudged_text(unjudged, labels.name_of));
  }
  add_html_list(page, "Not judged", texts);
  add_html_list(page, "Source", labels.notes);
  return page + "</body>\n</html>\n";
}

}  // namespace vdrive::tool
