// SPDX-License-Identifier: Apache-2.0
#include "commands/record.hpp"

#include "execution/command_context.hpp"
#include "execution/recording_format.hpp"
#include "language/arguments.hpp"
#include "vdrive/wording.hpp"

#include <map>
#include <utility>

namespace vdrive::tool {
namespace {

using client::Outcome;

// With a stream that constantly loses samples, the last line would otherwise be as long as the
// recording.
constexpr std::size_t kMostGaps = 100;

/// @param count the counted items: "missed" samples, "skipped" ticks
Json gaps_json(const recording::GapList& list, const char* count) {
  Json gaps = Json::array();
  for (const recording::Gap& gap : list.kept()) {
    if (gaps.size() == kMostGaps) break;
    gaps.push_back(
        {{"bench", gap.bench}, {"after", gap.after}, {"before", gap.before}, {count, gap.count}});
  }
  return gaps;
}

Json recording_json(const RecordingChoice& choice, std::size_t axes,
                    const recording::Summary& summary) {
  const recording::GapList& missed = summary.gaps.missed();
  const recording::GapList& skipped = summary.gaps.jumps();
  const Json gaps = gaps_json(missed, "missed");
  const Json jumps = gaps_json(skipped, "skipped");
  Json json{{"file", choice.file},
            {"axes", axes},
            {"samples", summary.samples},
            {"lost", missed.total()},
            {"gaps", gaps},
            {"gaps_left_out", missed.kept().size() - gaps.size() + missed.left_out()},
            {"skipped", skipped.total()},
            {"jumps_left_out", skipped.kept().size() - jumps.size() + skipped.left_out()},
            {"jumps", jumps}};
  if (choice.format == recording::Format::mcap) {
    json["events"] = summary.events;
    json["events_lost"] = summary.events_lost;
  }
  return json;
}

std::string recording_text(const RecordingChoice& choice, std::size_t axes,
                           const recording::Summary& summary) {
  constexpr std::size_t kMostGapsOfText = 4;
  const std::uint64_t lost = summary.gaps.missed().total();
  std::string text = "vdrive: recorded " + counted(summary.samples, "sample", "samples") + " of " +
                     counted(axes, "axis", "axes") + ", " + std::to_string(lost) + " lost";
  if (lost != 0) text += " " + summary.gaps.missed().text(kMostGapsOfText);
  if (summary.gaps.jumps().total() != 0) {
    text += ", " + counted(summary.gaps.jumps().total(), "tick", "ticks") +
            " skipped by a jump of the tick number " + summary.gaps.jumps().text(kMostGapsOfText);
  }
  if (choice.format == recording::Format::mcap) {
    text += ", " + counted(summary.events, "event", "events");
    if (summary.events_lost != 0) text += " and " + std::to_string(summary.events_lost) + " lost";
  }
  return text;
}

/// Prints a summary of the recording as the last line.
void report_recording(const RecordingChoice& choice, std::size_t axes,
                      const recording::Summary& summary, const Output& output) {
  // On standard output, JSON would become a line of the recording.
  if (output.is_json && choice.file != "-") {
    output.terminal.print(to_line(recording_json(choice, axes, summary)));
  } else {
    output.terminal.print_error(recording_text(choice, axes, summary));
  }
}

client::Result<std::vector<client::Axis>> axes_to_record(const std::vector<std::string>& names,
                                                         CommandContext& context) {
  if (!names.empty()) return context.axes.axes(names);
  const auto only =
      find_bench(context.session, std::nullopt, "write for example: record out.csv 2.1 2.2");
  if (!only) return only.outcome();
  return context.axes.axes_of_bench(only->number);
}

}  // namespace

void RecordCommand::declare(Arguments& arguments) {
  arguments
      .positional(
          "FILE", choice.file,
          "CSV, JSON lines or MCAP by its ending: .csv, .jsonl, .mcap; - is standard output")
      .required();
  arguments.then([this, &is_json = arguments.is_json()] {
    if (choice.file != "-") {
      choice.format = format_of_file(choice.file);
    } else if (is_json) {
      choice.format = recording::Format::json_lines;
    }
  });
  arguments.axes(axes, "default: every axis of the only bench");
  arguments.option("--for", "T", choice.duration, "Stop after this drive time", parse_duration);
  arguments.option("--count", "N", choice.count, "Stop after N samples", parse_count);
  arguments.option("--lost-after", "T", choice.lost_after,
                   "End when a bench has sent nothing for this wall time; default: 1min",
                   parse_duration);
}

Outcome RecordCommand::run(CommandContext& context) const {
  const auto found = axes_to_record(axes, context);
  if (!found) return found.outcome();
  std::map<std::uint32_t, ObservedBench> benches;
  for (const client::Axis& axis : *found) {
    ObservedBench& bench = benches[axis.id().bench];
    if (bench.axes.empty()) {
      auto info = context.session.find_bench(axis.id().bench);
      if (!info) return info.outcome();
      bench.info = std::move(*info);
    }
    bench.axes.push_back(axis);
  }
  std::vector<ObservedBench> tracks;
  tracks.reserve(benches.size());
  for (auto& [number, bench] : benches) tracks.push_back(std::move(bench));
  Recorder recorder(context.session, context.output.terminal, choice);
  const EndOfProgress end_of_progress(context.progress);  // the progress line uses the recorder
  context.progress.tell([&recorder] {
    return recorder.progress();
  });
  Outcome recorded = recorder.record(tracks);
  context.progress.end();
  if (recorder.has_begun()) {
    report_recording(choice, found->size(), recorder.summary(), context.output);
  }
  return recorded;
}

extern const CommandRow kRecord =
    row_of<RecordCommand>({.name = "record",
                           .group = CommandGroup::recordings,
                           .summary = "Record the status stream of axes to a file",
                           .example = "record move.csv 1.1 1.2 --for 5s",
                           .deepest = Place::shell});

}  // namespace vdrive::tool
