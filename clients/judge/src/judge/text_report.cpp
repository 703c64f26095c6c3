// SPDX-License-Identifier: Apache-2.0
#include "judge/text_report.hpp"

#include "judge/words.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <cstddef>
#include <string_view>

namespace vdrive::judge {
namespace {

std::string decoded_word(std::uint16_t word, const std::string& words) {
  return hex_text(word) + " " + words;
}

void add_row(std::string& text, std::string_view mark, const CycleRow& row,
             const std::array<std::size_t, kCycleColumns.size()>& widths) {
  std::string line(mark);
  for (std::size_t i = 0; i < row.size(); ++i) {
    line.append(row[i]).append(widths[i] - row[i].size() + 2, ' ');
  }
  while (line.ends_with(' ')) line.pop_back();
  text.append(line).append("\n");
}

void add_table(std::string& text, const Finding& finding) {
  std::vector<CycleRow> rows;
  CycleRow head;
  std::ranges::copy(kCycleColumns, head.begin());
  std::array<std::size_t, kCycleColumns.size()> widths{};
  const auto widen = [&](const CycleRow& row) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  };
  widen(head);
  for (const Line& line : finding.lines) widen(rows.emplace_back(cycle_row(line)));
  add_row(text, "    ", head, widths);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    add_row(text, is_place_of(finding, finding.lines[i]) ? "  > " : "    ", rows[i], widths);
  }
}

void add_finding(std::string& text, const Finding& finding, const ReportLabels& labels) {
  const RuleRow& row = row_of(finding.rule);
  text.append("\n").append(to_string(row.severity)).append(" ").append(row.name);
  text.append(" on ")
      .append(labels.name_of(finding.axis))
      .append(": ")
      .append(row.title)
      .append("\n");
  text.append("  where     ").append(place_text(finding.first));
  if (finding.first.line != 0) text.append(", line ").append(std::to_string(finding.first.line));
  if (finding.count > 1) {
    text.append(", and ").append(counted(finding.count - 1, "more time", "more times"));
    text.append(" until ").append(place_text(finding.last));
  }
  text.append("\n  happened  ").append(finding.happened);
  text.append("\n  expected  ").append(row.expected);
  text.append("\n  clause    ").append(row.clause);
  text.append("\n  do        ").append(row.remedy).append("\n\n");
  add_table(text, finding);
}

}  // namespace

CycleRow cycle_row(const Line& line) {
  const std::int8_t mode = line.mode.value_or(0);
  const auto number = [](const std::optional<std::int32_t>& value) {
    return value ? std::to_string(*value) : std::string();
  };
  return {place_text(line.place),
          writer_text(line),
          event_text(line),
          line.controlword
              ? decoded_word(*line.controlword, controlword_text(*line.controlword, mode))
              : std::string(),
          line.statusword ? decoded_word(*line.statusword, statusword_text(*line.statusword, mode))
                          : std::string(),
          line.mode ? std::to_string(mode) : std::string(),
          number(line.target),
          number(line.actual),
          std::string(waiting_text(line.waiting))};
}

bool is_place_of(const Finding& finding, const Line& line) {
  return line.place == finding.first;
}

std::string summary_text(const Verdict& verdict) {
  std::array<std::uint64_t, 3> by_severity{};
  for (const Finding& finding : verdict.findings) {
    ++by_severity[static_cast<std::size_t>(row_of(finding.rule).severity)];
  }
  std::string text = verdict.findings.empty()
                         ? std::string("no finding")
                         : counted(verdict.findings.size(), "finding", "findings");
  text += " on " + counted(verdict.axes.size(), "axis", "axes");
  if (verdict.findings.empty()) return text;
  text += ": " + counted(by_severity[0], "error", "errors") + ", " +
          counted(by_severity[1], "warning", "warnings") + ", " +
          counted(by_severity[2], "piece of advice", "pieces of advice");
  return text;
}

std::string unjudged_text(const Unjudged& unjudged, const AxisName& name_of) {
  std::string text;
  for (const Rule rule : unjudged.rules) {
    text.append(text.empty() ? "" : ", ").append(row_of(rule).name);
  }
  text += " on ";
  constexpr std::size_t kMostAxes = 8;
  for (std::size_t i = 0; i < std::min(unjudged.axes.size(), kMostAxes); ++i) {
    text.append(i == 0 ? "" : ", ").append(name_of(unjudged.axes[i]));
  }
  if (unjudged.axes.size() > kMostAxes) {
    text += " and " + std::to_string(unjudged.axes.size() - kMostAxes) + " more";
  }
  return text.append(": ").append(missing_text(unjudged.fact));
}

std::string text_report(const Verdict& verdict, const ReportLabels& labels) {
  std::string text = labels.source + ": " + summary_text(verdict) + "; " +
                     counted(verdict.records, "record", "records") + " in " +
                     duration_text(verdict.last - verdict.first) + "\n";
  for (const Finding& finding : verdict.findings) add_finding(text, finding, labels);
  if (!verdict.excepted.empty()) text += "\nexcepted:\n";
  for (const Excepted& excepted : verdict.excepted) {
    const Finding& finding = excepted.finding;
    text.append("  ").append(row_of(finding.rule).name).append(" on ");
    text.append(labels.name_of(finding.axis)).append(", ");
    text.append(counted(finding.count, "time", "times")).append(": ");
    text.append(excepted.reason).append("\n");
  }
  if (!labels.unused.empty()) text += "\nunused exceptions:\n";
  for (const Exception& exception : labels.unused) {
    text.append("  ").append(exception.place).append(": ").append(row_of(exception.rule).name);
    if (!exception.axis.empty()) text.append(" on ").append(exception.axis);
    text.append("\n");
  }
  if (!verdict.unjudged.empty()) text += "\nnot judged:\n";
  for (const Unjudged& unjudged : verdict.unjudged) {
    text.append("  ").append(unjudged_text(unjudged, labels.name_of)).append("\n");
  }
  if (!labels.notes.empty()) text += "\nsource:\n";
  for (const std::string& note : labels.notes) text.append("  ").append(note).append("\n");
  return text;
}

}  // namespace vdrive::judge
