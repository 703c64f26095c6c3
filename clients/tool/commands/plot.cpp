// SPDX-License-Identifier: Apache-2.0
#include "base/scratch_directory.hpp"
#include "base/usage_error.hpp"
#include "convert.hpp"
#include "execution/command_context.hpp"
#include "execution/connection.hpp"
#include "execution/recorder.hpp"
#include "execution/recording_format.hpp"
#include "language/arguments.hpp"
#include "language/command.hpp"
#include "output/plot_columns.hpp"
#include "output/plot_picture.hpp"
#include "output/plot_traces.hpp"
#include "output/report.hpp"
#include "output_file.hpp"
#include "values/value.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/quantity.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <map>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace vdrive::tool {
namespace {

using client::Outcome;
using recording::RecordingError;

/// Plots one axis of a recording.
struct PlotCommand {
  std::string source{};                   ///< file of a recording, or an axis to record
  std::string picture{};                  ///< file of the picture, - = standard output
  std::string shown_axis{};               ///< in the recording; empty = its only one
  std::vector<PlotColumn> columns{};      ///< columns to draw, at least one
  std::optional<Duration> from{};         ///< drive time since the first sample of the axis
  std::optional<Duration> to{};           ///< drive time since the first sample of the axis
  std::optional<Duration> period{};       ///< of a tick, if the recording does not contain it
  std::optional<Duration> duration{};     ///< drive time to record; none = `source` is a file
  std::uint32_t width = kUsualPlotWidth;  ///< [px]
  std::uint32_t height = 0;               ///< [px]; 0 = from the number of panels
  std::string title{};                    ///< empty = the axis

  void declare(Arguments& arguments);
  client::Outcome run(CommandContext& context) const;
  ExitCode start(const Program& program) const;
};

/// Writes the picture.
class PictureSink {
 public:
  PictureSink(const std::string& file, Terminal& terminal) : file_(file), terminal_(terminal) {}

  /// Opens the file, before a long recording is made for it. @throws RecordingError
  void open() {
    if (file_ != "-" && !output_) output_.emplace(file_);
  }

  /// @throws RecordingError
  void put(std::string_view svg) {
    if (file_ == "-") {
      svg.remove_suffix(1);  // the terminal adds the line break
      terminal_.print(svg);
      return;
    }
    open();
    output_->write(svg);
    output_->close();
  }

 private:
  const std::string& file_;
  Terminal& terminal_;
  std::optional<recording::OutputFile> output_;
};

/// The samples of one axis in a recording.
struct AxisSamples {
  std::uint64_t first_tick = 0;
  std::uint64_t last_tick = 0;
};

/// The contents of a recording, read before anything is drawn.
struct Survey {
  recording::Contents contents;
  std::map<client::AxisId, AxisSamples> axes{};
};

/// @throws RecordingError
Survey survey_of(const std::string& file) {
  Survey survey;
  survey.contents = recording::read_recording(file, [&survey](const client::Observation& sample) {
    for (const client::AxisSnapshot& axis : sample.axes) {
      const auto [place, is_new] = survey.axes.try_emplace(axis.id);
      if (is_new) place->second.first_tick = axis.tick;
      place->second.last_tick = axis.tick;
    }
  });
  return survey;
}

/// An axis that can be drawn.
struct DrawnAxis {
  client::AxisId id;
  std::string name;
  std::chrono::nanoseconds period;
  client::Unit unit;
  AxisSamples samples;
};

/// @return the axes of a recording that have at least one sample.
std::vector<DrawnAxis> drawn_axes(const Survey& survey) {
  std::vector<DrawnAxis> axes;
  for (const recording::RecordedBench& bench : survey.contents.benches) {
    for (const recording::RecordedAxis& axis : bench.axes) {
      const auto samples = survey.axes.find(axis.id);
      if (samples == survey.axes.end()) continue;
      axes.push_back(
          {axis.id, axis.name, bench.period, axis.unit.value_or(user_unit()), samples->second});
    }
  }
  return axes;
}

/// @return such as "1.1 x".
std::string both_names(const DrawnAxis& axis) {
  return to_string(axis.id) + (axis.name.empty() ? "" : " " + escaped(axis.name));
}

/// @return the first few axes, for a message.
std::string list_of(const std::vector<DrawnAxis>& axes) {
  constexpr std::size_t kMostListed = 8;
  std::string list;
  for (std::size_t i = 0; i < std::min(axes.size(), kMostListed); ++i) {
    list += (i == 0 ? "" : ", ") + both_names(axes[i]);
  }
  if (axes.size() > kMostListed) {
    list += " and " + std::to_string(axes.size() - kMostListed) + " more";
  }
  return list;
}

/// @param text such as 1.2, a name, or 1.lift
bool is_called(const DrawnAxis& axis, const std::string& text) {
  return text == to_string(axis.id) || text == axis.name ||
         text == std::to_string(axis.id.bench) + "." + axis.name;
}

/// @param text the axis as the user has typed it; empty = the only one
client::Result<DrawnAxis> choose_axis(const std::vector<DrawnAxis>& axes, const std::string& text,
                                      const std::string& file) {
  std::vector<DrawnAxis> chosen;
  std::ranges::copy_if(axes, std::back_inserter(chosen), [&text](const DrawnAxis& axis) {
    return text.empty() || is_called(axis, text);
  });
  if (chosen.size() == 1) return chosen.front();
  if (chosen.empty()) {
    return Outcome::not_found(in_quotes(file) + " has no axis " + in_quotes(text) + "; it has " +
                              list_of(axes));
  }
  return Outcome::not_found(in_quotes(file) + " has " + counted(chosen.size(), "axis", "axes") +
                            (text.empty() ? "" : " called " + in_quotes(text)) +
                            "; choose one with --axis: " + list_of(chosen));
}

std::string seconds_text(Duration duration) {
  return to_text(std::chrono::duration<double>(duration).count()) + " s";
}

/// @return the ticks at the edges of the picture.
client::Result<AxisSamples> edges_of(const DrawnAxis& axis, const PlotCommand& command,
                                     const std::string& file) {
  const auto period = static_cast<std::uint64_t>(axis.period.count());
  const std::uint64_t ticks = axis.samples.last_tick - axis.samples.first_tick;
  const auto nanoseconds = [](const Duration& duration) {
    return static_cast<std::uint64_t>(duration.count());
  };
  const std::uint64_t begin = command.from ? (nanoseconds(*command.from) + period - 1) / period : 0;
  const std::uint64_t end = command.to ? nanoseconds(*command.to) / period : ticks;
  if (begin > ticks) {
    return Outcome::failed("--from " + seconds_text(*command.from) + " is after the end of " +
                           in_quotes(file) + ": axis " + both_names(axis) + " has " +
                           seconds_text(axis.period * static_cast<std::int64_t>(ticks)));
  }
  return AxisSamples{.first_tick = axis.samples.first_tick + begin,
                     .last_tick = axis.samples.first_tick + std::min(end, ticks)};
}

/// The result of drawing, for the last line.
struct Drawn {
  DrawnAxis axis;
  AxisSamples edges;
  std::uint64_t samples = 0;
  std::uint64_t lost = 0;
  std::uint64_t faults = 0;
  std::string svg{};
};

/// @return the samples between the edges, reduced; counts missing ones in `drawn`.
/// @throws RecordingError
PlotTraces traces_of(Drawn& drawn, const PlotCommand& command, const std::string& file) {
  PlotReduction reduction(plot_columns_in(drawn.axis.unit, command.columns), drawn.edges.first_tick,
                          drawn.edges.last_tick, plot_bins(command.width, command.columns.size()));
  (void)recording::read_recording(file, [&](const client::Observation& sample) {
    for (const client::AxisSnapshot& axis : sample.axes) {
      if (axis.id != drawn.axis.id) continue;
      reduction.take(axis);
      const bool is_inside =
          axis.tick > drawn.edges.first_tick && axis.tick <= drawn.edges.last_tick;
      if (is_inside) drawn.lost += sample.missed;
    }
  });
  return std::move(reduction).finish();
}

std::string note_of(const Drawn& drawn, const PlotTraces& traces) {
  std::string note = counted(drawn.samples, "sample", "samples") + " from tick " +
                     std::to_string(drawn.edges.first_tick);
  if (drawn.lost != 0) note += ", " + std::to_string(drawn.lost) + " lost";
  if (traces.faults_left_out != 0) {
    note += ", " + counted(traces.faults_left_out, "further fault", "further faults");
  }
  return note;
}

/// @throws RecordingError
client::Result<Drawn> draw_axis(const PlotCommand& command, const Survey& survey,
                                const std::string& file, const std::string& called) {
  std::vector<DrawnAxis> axes = drawn_axes(survey);
  if (axes.empty()) return Outcome::failed(in_quotes(called) + " has no sample to draw");
  auto axis = choose_axis(axes, command.shown_axis, called);
  if (!axis) return axis.outcome();
  if (command.period) axis->period = *command.period;
  if (axis->period.count() <= 0) {
    return Outcome::failed(in_quotes(called) + ": the period of a tick of bench " +
                           std::to_string(axis->id.bench) + " is not above 0");
  }
  const auto edges = edges_of(*axis, command, called);
  if (!edges) return edges.outcome();
  Drawn drawn{.axis = *axis, .edges = *edges};
  const PlotTraces traces = traces_of(drawn, command, file);
  if (traces.samples == 0) {
    return Outcome::failed(in_quotes(called) + " has no sample of axis " + both_names(*axis) +
                           " between --from and --to");
  }
  drawn.samples = traces.samples;
  drawn.faults = traces.faults.size() + traces.faults_left_out;
  drawn.svg = plot_svg(
      traces, {.title = command.title.empty() ? "axis " + both_names(*axis) : command.title,
               .note = note_of(drawn, traces),
               .origin = axis->samples.first_tick,
               .period = axis->period,
               .width = command.width,
               .height = command.height});
  return drawn;
}

Json plot_json(const PlotCommand& command, const Drawn& drawn, const std::string& cut) {
  Json columns = Json::array();
  for (const PlotColumn& column : command.columns) columns.push_back(column.name);
  return {{"file", command.picture},
          {"axis", to_string(drawn.axis.id)},
          {"name", drawn.axis.name},
          {"from_tick", drawn.edges.first_tick},
          {"to_tick", drawn.edges.last_tick},
          {"samples", drawn.samples},
          {"lost", drawn.lost},
          {"faults", drawn.faults},
          {"columns", std::move(columns)},
          {"cut", cut.empty() ? Json(nullptr) : Json(cut)}};
}

void report_plot(const PlotCommand& command, const Drawn& drawn, const std::string& cut,
                 const Output& output) {
  // On standard output, JSON would become a part of the picture.
  if (output.is_json && command.picture != "-") {
    output.terminal.print(to_line(plot_json(command, drawn, cut)));
    return;
  }
  output.terminal.print_error("vdrive: drew " + counted(drawn.samples, "sample", "samples") +
                              " of " + both_names(drawn.axis) + " to " +
                              in_quotes(command.picture));
  if (!cut.empty()) {
    output.terminal.print_error("vdrive: " + in_quotes(command.source) + " is incomplete: " + cut +
                                "; everything before was drawn");
  }
}

/// @param file the recording
Outcome draw_recording(const PlotCommand& command, const std::string& file, PictureSink& sink,
                       const Output& output) {
  try {
    const Survey survey = survey_of(file);
    const auto drawn = draw_axis(command, survey, file, command.source);
    if (!drawn) return drawn.outcome();
    sink.put(drawn->svg);
    report_plot(command, *drawn, survey.contents.cut, output);
    return {};
  } catch (const RecordingError& error) {
    return Outcome::failed(error.what());
  }
}

/// Records the axis to a temporary file, and draws it.
Outcome record_and_draw(const PlotCommand& command, CommandContext& context) {
  const auto axis = context.axes.axis(command.source);
  if (!axis) return axis.outcome();
  auto bench = context.session.find_bench(axis->id().bench);
  if (!bench) return bench.outcome();
  try {
    const ScratchDirectory scratch;
    PictureSink sink(command.picture, context.output.terminal);
    sink.open();
    const RecordingChoice choice{.file = scratch.file("recording.mcap"),
                                 .format = recording::Format::mcap,
                                 .duration = command.duration};
    Recorder recorder(context.session, context.output.terminal, choice);
    Outcome recorded = recorder.record({ObservedBench{*std::move(bench), {*axis}}});
    // After an interrupt, the part recorded so far is drawn.
    if (!recorded && !context.session.is_interrupted()) return recorded;
    Outcome drawn = draw_recording(command, choice.file, sink, context.output);
    return drawn ? std::move(recorded) : std::move(drawn);
  } catch (const RecordingError& error) {
    return Outcome::failed(error.what());
  }
}

/// Whether `source` is a recording. The name of an axis has neither the extension of a recording
/// nor a slash; if a file without either has the same name as an axis, --for selects the axis.
bool is_file(const PlotCommand& command) {
  std::error_code error;
  return recording::format_of(command.source) || command.source.find('/') != std::string::npos ||
         (!command.duration && std::filesystem::exists(command.source, error));
}

void check_source(const PlotCommand& command) {
  if (is_file(command)) {
    static_cast<void>(format_of_file(command.source));
    if (!command.duration) return;
    throw UsageError("--for is for recording an axis; " + in_quotes(command.source) +
                     " is a recording: select a part with --from and --to");
  }
  if (!command.duration) {
    throw UsageError(in_quotes(command.source) +
                     " is not a recording (.csv, .jsonl or .mcap); to record an axis, give --for, "
                     "such as --for 2s");
  }
  if (command.duration->count() <= 0) throw UsageError("--for must be above 0");
  if (!command.shown_axis.empty()) {
    throw UsageError("--axis is for a recording; " + in_quotes(command.source) + " is an axis");
  }
}

void check_picture(const PlotCommand& command) {
  if (command.picture != "-" && !command.picture.ends_with(".svg")) {
    throw UsageError("--output: " + in_quotes(command.picture) +
                     " does not end in .svg; - is standard output");
  }
  const std::size_t panels = count_panels(command.columns);
  const std::uint32_t least = smallest_plot_height(panels);
  if (command.height != 0 && command.height < least) {
    throw UsageError("--height " + std::to_string(command.height) + " is too low for " +
                     counted(panels, "panel", "panels") + ": give " + std::to_string(least) +
                     " or more, or fewer --columns");
  }
  if (command.from && command.to && *command.from >= *command.to) {
    throw UsageError("--from " + seconds_text(*command.from) + " must be before --to " +
                     seconds_text(*command.to));
  }
}

std::uint32_t parse_side(const std::string& text, const std::string& option, std::uint32_t least) {
  const auto side = vdrive::parse_digits<std::uint32_t>(text);
  if (side && *side >= least && *side <= kLargestPlotSide) return *side;
  throw UsageError(option + ": " + in_quotes(text) + " is not a size: write " +
                   std::to_string(least) + " to " + std::to_string(kLargestPlotSide) + " pixels");
}

void PlotCommand::declare(Arguments& arguments) {
  columns = usual_plot_columns();
  arguments
      .positional("SOURCE", source,
                  "A recording (.csv, .jsonl or .mcap), or an axis to record, with --for")
      .required()
      .completed_by(complete_axis);
  arguments.option("-o,--output", "FILE", picture, "The picture: .svg, or - for standard output")
      .required();
  arguments.option("--axis", "AXIS", shown_axis,
                   "Draw this axis of the recording; default: the only one");
  arguments
      .option("--columns", "NAMES", columns,
              "Draw these columns, separated by commas; default: position and velocity with their "
              "demand, torque, following error",
              parse_plot_columns)
      .completed_by(complete_one_of(names_of_plot_columns()));
  arguments.option("--from", "T", from, "Begin at this drive time of the recording",
                   parse_duration);
  arguments.option("--to", "T", to, "End at this drive time of the recording", parse_duration);
  arguments.option("--for", "T", duration, "Record the axis for this drive time", parse_duration);
  arguments.option("--period", "T", period,
                   "Period of a tick, if FILE does not contain it; default: 1ms",
                   [this](const std::string& text) {
                     return parse_period(text, source);
                   });
  arguments.option("--width", "PX", width, "Default: 960", [](const std::string& text) {
    return parse_side(text, "--width", kSmallestPlotWidth);
  });
  arguments.option("--height", "PX", height, "Default: by the number of panels",
                   [](const std::string& text) {
                     return parse_side(text, "--height", 1);
                   });
  arguments.option("--title", "TEXT", title, "Default: the axis");
  arguments.then([this] {
    check_source(*this);
    check_picture(*this);
  });
}

Outcome PlotCommand::run(CommandContext& context) const {
  if (duration) return record_and_draw(*this, context);
  PictureSink sink(picture, context.output.terminal);
  return draw_recording(*this, source, sink, context.output);
}

ExitCode PlotCommand::start(const Program& program) const {
  const Output output{program.terminal, program.options.json, false};
  if (duration) {
    return run_connected(program, program.options, [&](client::Session& session) {
      CommandContext context(session, output, program.commands);
      return context.axes.named(run(context));
    });
  }
  PictureSink sink(picture, program.terminal);
  return finish(draw_recording(*this, source, sink, output), Interrupt(), program.options.json,
                program.terminal);
}

}  // namespace

extern const CommandRow kPlot =
    row_of<PlotCommand>({.name = "plot",
                         .group = CommandGroup::recordings,
                         .summary = "Draw an axis of a recording as a picture (SVG)",
                         .example = "plot move.csv --axis 1.1 -o move.svg\n"
                                    "  vdrive plot 1.1 --for 2s -o now.svg",
                         .deepest = Place::shell});

}  // namespace vdrive::tool
