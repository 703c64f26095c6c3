// SPDX-License-Identifier: Apache-2.0
#include "convert.hpp"

#include "base/usage_error.hpp"
#include "execution/connection.hpp"
#include "execution/recording_format.hpp"
#include "language/arguments.hpp"
#include "language/command.hpp"
#include "output/report.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <optional>
#include <string>

namespace vdrive::tool {
namespace {

using client::Outcome;

Json contents_json(const std::string& file, const recording::Contents& contents) {
  return {{"file", file},
          {"samples", contents.samples},
          {"rows", contents.rows},
          {"events_left_out", contents.events},
          {"parameters_left_out", contents.parameters},
          {"cut", contents.cut.empty() ? Json(nullptr) : Json(contents.cut)}};
}

std::string contents_text(const std::string& file, const recording::Contents& contents) {
  std::string text = "vdrive: wrote " + counted(contents.samples, "sample", "samples") + ", " +
                     counted(contents.rows, "row", "rows") + " to " + in_quotes(file);
  if (contents.events + contents.parameters != 0) {
    text += "; omitted " + counted(contents.events, "event", "events") + " and " +
            counted(contents.parameters, "set of parameters", "sets of parameters");
  }
  return text;
}

/// Converts a recording to another format.
struct ConvertCommand {
  std::string from{};
  std::string to{};
  std::optional<Duration> period{};  ///< of a tick, if `from` does not contain it

  void declare(Arguments& arguments);
  ExitCode start(const Program& program) const;
};

Outcome convert(const ConvertCommand& command, bool is_json, Terminal& terminal) {
  try {
    const recording::Contents contents = recording::convert({.from = command.from,
                                                             .to = command.to,
                                                             .period = command.period,
                                                             .version = VDRIVE_VERSION});
    if (is_json) {
      terminal.print(to_line(contents_json(command.to, contents)));
      return {};
    }
    terminal.print_error(contents_text(command.to, contents));
    if (!contents.cut.empty()) {
      terminal.print_error("vdrive: " + in_quotes(command.from) +
                           " is incomplete: " + contents.cut + "; everything before was converted");
    }
    return {};
  } catch (const recording::RecordingError& error) {
    return Outcome::failed(error.what());
  }
}

void ConvertCommand::declare(Arguments& arguments) {
  arguments.positional("FROM", from, "The recording: .csv, .jsonl or .mcap").required();
  arguments.positional("TO", to, "The new file: .csv, .jsonl or .mcap by its ending").required();
  arguments.then([this] {
    if (format_of_file(from) != format_of_file(to)) return;
    throw UsageError(in_quotes(from) + " and " + in_quotes(to) + " have the same format");
  });
  arguments.option("--period", "T", period,
                   "Period of a tick, if FROM does not contain it; default: 1ms",
                   [this](const std::string& text) {
                     return parse_period(text, from);
                   });
}

ExitCode ConvertCommand::start(const Program& program) const {
  return finish(convert(*this, program.options.json, program.terminal), Interrupt(),
                program.options.json, program.terminal);
}

}  // namespace

extern const CommandRow kConvert =
    row_of<ConvertCommand>({.name = "convert",
                            .group = CommandGroup::recordings,
                            .summary = "Write the status of a recording in another format",
                            .example = "convert run.mcap run.csv",
                            .deepest = Place::command_line});

}  // namespace vdrive::tool
