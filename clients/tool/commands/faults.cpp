// SPDX-License-Identifier: Apache-2.0
#include "convert.hpp"
#include "execution/command_context.hpp"
#include "execution/recording_format.hpp"
#include "language/arguments.hpp"
#include "language/command.hpp"
#include "output/record.hpp"
#include "recording.hpp"
#include "vdrive/cia402/error_code.hpp"
#include "vdrive/client/fault_story.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::tool {
namespace {

using client::KeptWindow;
using client::Outcome;
using client::Window;
using client::WindowCause;

/// The most writes shown as text; --json has all.
constexpr std::size_t kMostWrites = 30;

std::string place_name(const client::BenchInfo& bench, std::uint16_t axis) {
  return axis == 0 ? "bench " + std::to_string(bench.number)
                   : to_string(client::AxisId{bench.number, axis});
}

std::string cause_text(const WindowCause& cause) {
  if (cause.kind != WindowCause::Kind::fault) return std::string(to_string(cause.kind));
  std::array<char, 32> code{};
  std::snprintf(code.data(), code.size(), "%04Xh ", cause.code);  // NOLINT(*-vararg)
  return code.data() + std::string(describe(static_cast<ErrorCode>(cause.code)));
}

/// The names of sessions for the texts of one bench.
client::SessionText session_texts(client::Session& session, std::uint32_t bench) {
  return [&session, bench](std::uint64_t number) {
    return client::owner_text(number, session.find_name(bench, number));
  };
}

Json cause_json(const client::BenchInfo& bench, const WindowCause& cause) {
  return {{"kind", to_string(cause.kind)},
          {"axis", cause.axis == 0 ? Json(nullptr) : Json(place_name(bench, cause.axis))},
          {"code", cause.code},
          {"tick", cause.tick},
          {"session", session_json(cause.session)}};
}

Json window_json(const client::BenchInfo& bench, const KeptWindow& window) {
  Json causes = Json::array();
  for (const WindowCause& cause : window.causes) causes.push_back(cause_json(bench, cause));
  return {{"bench", bench.number},
          {"window", window.number},
          {"first_tick", window.first_tick},
          {"last_tick", window.last_tick},
          {"is_open", window.is_open},
          {"causes", std::move(causes)},
          {"more_causes", window.more_causes}};
}

std::string window_text(const client::BenchInfo& bench, const KeptWindow& window) {
  const WindowCause& first = window.causes.front();
  std::string text = std::to_string(window.number) + "  tick " + std::to_string(first.tick) + "  " +
                     place_name(bench, first.axis) + "  " + cause_text(first);
  const std::size_t more = window.causes.size() + window.more_causes - 1;
  if (more > 0) text += ", and " + counted(more, "further cause", "further causes");
  if (window.is_open) text += " (until tick " + std::to_string(window.last_tick) + ")";
  return text;
}

Outcome list_windows_of(const client::BenchInfo& bench, CommandContext& context) {
  const auto windows = context.session.windows(bench.number);
  if (!windows) return windows.outcome();
  const Output& output = context.output;
  if (windows->empty() && !output.is_json) {
    output.terminal.print("bench " + std::to_string(bench.number) + " has recorded no faults");
  }
  for (const KeptWindow& window : *windows) {
    output.terminal.print(output.is_json ? to_line(window_json(bench, window))
                                         : window_text(bench, window));
  }
  return {};
}

Outcome list_windows(std::optional<std::uint32_t> number, CommandContext& context) {
  const auto benches = benches_to_show(context.session, number);
  if (!benches) return benches.outcome();
  for (const client::BenchInfo& bench : *benches) {
    if (Outcome listed = list_windows_of(bench, context); !listed) return listed;
  }
  return {};
}

/// The axes of a window: those of its causes. If no cause names an axis (a window on request, or
/// one about a master), all axes up to the limit of one request.
std::vector<client::AxisId> axes_of_window(const client::BenchInfo& bench,
                                           const KeptWindow& window) {
  std::set<std::uint16_t> numbers;
  for (const WindowCause& cause : window.causes) {
    if (cause.axis != 0) numbers.insert(cause.axis);
  }
  std::vector<client::AxisId> axes;
  for (const auto& axis : bench.axes) {
    if (axes.size() == client::kMostAxesAtOnce) break;
    if (numbers.empty() || numbers.contains(axis.id.axis)) axes.push_back(axis.id);
  }
  return axes;
}

/// @return the drive time from the first cause to `tick` [ms].
std::string offset_text(const client::BenchInfo& bench, const KeptWindow& window,
                        std::uint64_t tick) {
  const auto ticks = static_cast<std::int64_t>(tick - window.causes.front().tick);
  const double time =
      std::chrono::duration<double, std::milli>(bench.period).count() * static_cast<double>(ticks);
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%+9.1f ms", time);  // NOLINT(*-vararg)
  return text.data();
}

std::string write_text(const client::AxisWrite& write, const client::SessionText& name) {
  using Kind = client::AxisWrite::Kind;
  if (write.kind == Kind::power_cycle) return "power cycle";
  if (write.kind == Kind::connection_loss) return "its master fell silent";
  std::string text = object_text(write.object) + " = " + std::to_string(write.value);
  if (write.reason != 0) text += write.is_late ? ", too late" : ", refused";
  if (write.means == client::AxisWrite::Means::bench) return text + ", by the bench";
  return text + (write.session == 0 ? "" : ", by " + name(write.session));
}

class ShownWindow {
 public:
  ShownWindow(const client::BenchInfo& bench, const Window& window, const client::SessionText& name)
      : bench_(bench), window_(window), name_(name) {}

  void print_text(Terminal& terminal) const {
    for (const WindowCause& cause : window_.kept.causes) {
      const client::FaultStory story = story_of(window_, cause, bench_, name_);
      terminal.print(story.title);
      for (const std::string& line : story.lines) terminal.print("  " + line);
      if (!story.remedy.empty()) terminal.print("  -> " + story.remedy);
    }
    const auto& writes = window_.writes;
    terminal.print(counted(window_.samples.size(), "tick", "ticks") + ", " +
                   counted(writes.size(), "write", "writes") + ":");
    const std::size_t left_out = writes.size() - std::min(writes.size(), kMostWrites);
    if (left_out > 0) terminal.print("  (" + std::to_string(left_out) + " earlier ones: --json)");
    for (std::size_t at = left_out; at < writes.size(); ++at) {
      terminal.print("  " + offset_text(bench_, window_.kept, writes[at].tick) + "  " +
                     place_name(bench_, writes[at].axis) + "  " + write_text(writes[at], name_));
    }
    for (const client::WindowBreak& broken : window_.breaks) {
      terminal.print("  " + offset_text(bench_, window_.kept, broken.tick) + "  " +
                     break_text(broken.kind));
    }
  }

  void print_json(Terminal& terminal) const {
    Json json = window_json(bench_, window_.kept);
    Json stories = Json::array();
    for (const WindowCause& cause : window_.kept.causes) {
      const client::FaultStory story = story_of(window_, cause, bench_, name_);
      stories.push_back({{"title", story.title}, {"lines", story.lines}, {"remedy", story.remedy}});
    }
    json["stories"] = std::move(stories);
    Json writes = Json::array();
    for (const client::AxisWrite& write : window_.writes) {
      writes.push_back({{"tick", write.tick},
                        {"axis", place_name(bench_, write.axis)},
                        {"object", object_text(write.object)},
                        {"value", write.value},
                        {"session", session_json(write.session)},
                        {"reason", write.reason},
                        {"text", write_text(write, name_)}});
    }
    json["writes"] = std::move(writes);
    Json events = Json::array();
    for (const client::WindowEvent& event : window_.events) {
      events.push_back(
          {{"tick", event.tick},
           {"axis", event.axis == 0 ? Json(nullptr) : Json(place_name(bench_, event.axis))},
           {"kind", to_string(event.kind)},
           {"code", event.code},
           {"session", session_json(event.session)}});
    }
    json["events"] = std::move(events);
    terminal.print(to_line(json));
  }

 private:
  static std::string break_text(client::WindowBreak::Kind kind) {
    switch (kind) {
      case client::WindowBreak::Kind::restored:
        return "a snapshot was restored";
      case client::WindowBreak::Kind::jumped:
        return "the tick number jumped";
      case client::WindowBreak::Kind::missing:
        break;
    }
    return "recording was interrupted before this tick";
  }

  const client::BenchInfo& bench_;
  const Window& window_;
  const client::SessionText& name_;
};

/// @throws RecordingError when the file cannot be written
void write_file(const std::string& file, const client::BenchInfo& bench, const Window& window,
                const std::vector<client::AxisId>& axes) {
  const auto writer = recording::open_recording(file, VDRIVE_VERSION);
  writer->begin({recording::describe(bench, axes)});
  recording::Summary summary;
  auto event = window.events.begin();
  for (const client::Observation& sample : window.samples) {
    writer->status(sample);
    summary.gaps.note_sample(sample);
    ++summary.samples;
    for (; event != window.events.end() && event->tick <= sample.tick; ++event) {
      writer->event({.bench = bench.number,
                     .incarnation = bench.incarnation,
                     .axis = event->axis,
                     .kind = event->kind,
                     .tick = event->tick,
                     .session = event->session,
                     .code = event->code,
                     .text = std::string(to_string(event->kind))});
      ++summary.events;
    }
  }
  writer->finish(summary);
}

struct FaultsCommand {
  std::optional<std::uint64_t> number{};  ///< none = list the windows
  std::vector<std::string> axes{};
  std::optional<std::uint32_t> bench{};
  std::string file{};

  void declare(Arguments& arguments) {
    std::string& action = arguments.text();
    std::string& text = arguments.text();
    arguments.positional("ACTION", action, "show; default: list what the benches keep")
        .completed_by(complete_one_of({"show"}));
    arguments.positional("N", text, "Number of the window, as the list prints it");
    arguments.axes(axes, "default: those that have faulted");
    arguments.bench(bench);
    arguments.option("--to", "FILE", file, "Write its ticks and events as .csv, .jsonl or .mcap");
    arguments.then([this, &action, &text] {
      if (action.empty()) return;
      if (action != "show") {
        throw UsageError(in_quotes(action) + " is not an action: write show" +
                         suggestion(action, {"show"}));
      }
      if (text.empty()) throw UsageError("'faults show' takes the number of a window");
      constexpr auto kHighest = std::numeric_limits<std::int64_t>::max();
      number = parse_number(text, "window number", kHighest);
      if (!file.empty()) static_cast<void>(format_of_file(file));
    });
  }

  Outcome run(CommandContext& context) const {
    if (!number) return list_windows(bench, context);
    const auto found =
        find_bench(context.session, bench, "write for example: faults show 3 --bench 2");
    if (!found) return found.outcome();
    auto wanted = axes_to_show(*found, context);
    if (!wanted) return wanted.outcome();
    const auto window = context.session.window(*number, *wanted);
    if (!window) return window.outcome();
    if (!file.empty()) {
      try {
        write_file(file, *found, *window, *wanted);
      } catch (const recording::RecordingError& error) {
        return Outcome::failed(error.what());
      }
    }
    const client::SessionText name = session_texts(context.session, found->number);
    const ShownWindow shown(*found, *window, name);
    if (context.output.is_json) {
      shown.print_json(context.output.terminal);
    } else {
      shown.print_text(context.output.terminal);
    }
    return {};
  }

 private:
  [[nodiscard]] client::Result<std::vector<client::AxisId>> axes_to_show(
      const client::BenchInfo& of_bench, CommandContext& context) const {
    if (!axes.empty()) {
      const auto named = context.axes.axes(axes);
      if (!named) return named.outcome();
      std::vector<client::AxisId> ids;
      for (const client::Axis& axis : *named) {
        ids.push_back(axis.id());
        if (axis.id().bench == of_bench.number) continue;
        return Outcome::not_found("axis " + to_string(axis.id()) + " is not on bench " +
                                  std::to_string(of_bench.number) + ", whose fault is shown");
      }
      return ids;
    }
    const auto windows = context.session.windows(of_bench.number);
    if (!windows) return windows.outcome();
    const auto window = std::ranges::find(*windows, *number, &KeptWindow::number);
    if (window == windows->end()) {
      return Outcome::not_found("bench " + std::to_string(of_bench.number) + " keeps no window " +
                                std::to_string(*number) + "; vdrive faults lists what it keeps");
    }
    return axes_of_window(of_bench, *window);
  }
};

}  // namespace

extern const CommandRow kFaults =
    row_of<FaultsCommand>({.name = "faults",
                           .group = CommandGroup::bench,
                           .summary = "Show the latest faults and what led to one of them",
                           .example = "faults\n  vdrive faults show 3 --to fault.mcap",
                           .deepest = Place::shell});

}  // namespace vdrive::tool
