// SPDX-License-Identifier: Apache-2.0
#include "execution/executor.hpp"

#include "convert.hpp"
#include "execution/recorder.hpp"
#include "output/event_view.hpp"
#include "terminal/columns.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <limits>
#include <utility>

namespace vdrive::tool {
namespace {

using client::Outcome;
using client::OutcomeKind;

constexpr auto kNoSuchObject = wire_code(AbortCode::object_does_not_exist);
constexpr std::chrono::milliseconds kPatienceOfWatch{100};

/// @return ", paused" or ", rate 0.5" of a realtime bench that does not run as fast as the wall
///         clock.
std::string rate_text(const client::BenchInfo& bench) {
  if (bench.clock_mode != client::ClockMode::realtime || bench.rate == 1.0) return {};
  return bench.rate == 0.0 ? ", paused" : ", rate " + to_text(bench.rate);
}

Outcome take_over_all(std::vector<client::Axis>& axes) {
  for (client::Axis& axis : axes) {
    if (Outcome taken = axis.take_over(); !taken) return taken;
  }
  return {};
}

/// Takes what each bench has sent since the last call; waits for a while where nothing has come.
Outcome take_samples(std::vector<client::Follower>& followers, WatchView& view) {
  const auto patience = kPatienceOfWatch / followers.size();
  for (client::Follower& follower : followers) {
    auto sample = follower.next(patience);
    // A bench whose time stands still must not hold up what the others send.
    for (; sample; sample = follower.next(std::chrono::milliseconds(0))) {
      view.take(std::move(*sample));
    }
    if (sample.outcome().kind() != OutcomeKind::timed_out) return sample.outcome();
  }
  return {};
}

/// @return whether no key ends the view.
bool press_all(KeyInput& keys, WatchView& view) {
  while (const auto key = keys.next()) {
    if (!view.press(*key)) return false;
  }
  return true;
}

/// @return the command that axes get together, none of what goes to each by a request of its own.
std::optional<client::EachCommand> each_command_of(AxisAction action) {
  switch (action) {
    case AxisAction::enable:
      return client::EachCommand::enable;
    case AxisAction::disable:
      return client::EachCommand::disable;
    case AxisAction::halt:
      return client::EachCommand::halt;
    case AxisAction::resume:
      return client::EachCommand::resume;
    case AxisAction::quick_stop:
      return client::EachCommand::quick_stop;
    case AxisAction::reset:
      return client::EachCommand::reset_fault;
    case AxisAction::power_cycle:
      return client::EachCommand::power_cycle;
    case AxisAction::store:
    case AxisAction::restore:
      break;
  }
  return std::nullopt;
}

/// The ticks that the number jumped over, which are no loss.
void add_jumps(const recording::GapLog& log, std::size_t most, Json& json) {
  Json jumps = Json::array();
  for (const recording::Jump& jump : log.jumps()) {
    if (jumps.size() == most) break;
    jumps.push_back({{"bench", jump.bench},
                     {"after", jump.after},
                     {"before", jump.before},
                     {"skipped", jump.skipped}});
  }
  json["skipped"] = log.skipped();
  json["jumps_left_out"] = log.jumps().size() - jumps.size() + log.jumps_left_out();
  json["jumps"] = std::move(jumps);
}

AxisFace face_of(const client::Axis& axis) {
  return {axis.name(), axis.unit()};
}

/// @return an outcome of the same kind in other words.
Outcome reworded(const Outcome& outcome, const std::function<std::string(std::string)>& words) {
  std::string message = outcome.message();
  switch (outcome.kind()) {
    case OutcomeKind::ok:
      return {};
    case OutcomeKind::timed_out:
      return Outcome::timed_out(words(std::move(message)));
    case OutcomeKind::not_found:
      return Outcome::not_found(words(std::move(message)));
    case OutcomeKind::lost:
      return Outcome::lost(words(std::move(message)));
    case OutcomeKind::failed:
      return Outcome::failed(words(std::move(message)));
    case OutcomeKind::refused:
      break;
  }
  // A refusal ends with its code and the code's meaning, and would get them twice.
  const std::string end = Outcome::refused(outcome.code(), "").message();
  if (message.ends_with(end)) message.resize(message.size() - end.size());
  return Outcome::refused(outcome.code(), words(std::move(message)));
}

}  // namespace

Executor::Executor(client::Session& session, Terminal& terminal, bool is_json, bool is_quiet)
    : session_(session), terminal_(terminal), is_json_(is_json), is_quiet_(is_quiet) {}

Outcome Executor::execute(const Command& command, std::optional<Duration> timeout) {
  timeout_ = timeout;
  found_.reset();
  return named(std::visit(
      [this](const auto& each) {
        return this->run(each);
      },
      command));
}

client::Result<client::Axis> Executor::axis(const std::string& name) {
  const auto known = axes_.find(name);
  if (known != axes_.end()) return known->second;
  auto found = session_.axis(name);
  if (!found) return found;
  axes_.emplace(name, *found);
  if (name != to_string(found->id())) typed_names_[found->id()] = name;
  benches_.insert(found->id().bench);
  return found;
}

client::CallOptions Executor::call_options(client::Until until) const {
  client::CallOptions call;
  call.until = until;
  if (timeout_) call.timeout = *timeout_;
  return call;
}

void Executor::on_aim(std::function<void(const client::AxisId&, std::int64_t)> handler) {
  on_aim_ = std::move(handler);
}

/// @return an axis as the user calls it.
std::string Executor::label_of(const client::AxisId& axis) const {
  const auto typed = typed_names_.find(axis);
  return typed == typed_names_.end() ? to_string(axis) : escaped(typed->second);
}

/// The client's messages call an axis by its number. @return them with the name that was typed:
/// "axis gantry_left (7.1)".
Outcome Executor::named(const Outcome& outcome) const {
  return reworded(outcome, [this](std::string message) {
    for (const auto& [id, name] : typed_names_) {
      const std::string number = "axis " + to_string(id);
      const std::string both = "axis " + escaped(name) + " (" + to_string(id) + ")";
      for (std::size_t at = message.find(number); at != std::string::npos;
           at = message.find(number, at + both.size())) {
        const std::size_t end = at + number.size();
        const bool goes_on = end < message.size() && message[end] >= '0' && message[end] <= '9';
        if (!goes_on) message.replace(at, number.size(), both);
      }
    }
    return message;
  });
}

/// @param how_to_name what to write where there are several benches
client::Result<client::BenchInfo> Executor::find_bench(std::optional<std::uint32_t> number,
                                                       std::string_view how_to_name) {
  auto bench = session_.find_bench(number);
  if (bench || number || session_.find_benches().size() < 2) return bench;
  return Outcome::not_found(bench.outcome().message() + "; " + std::string(how_to_name));
}

client::Result<client::BenchInfo> Executor::bench_of(const client::AxisId& axis) {
  return session_.find_bench(axis.bench);
}

// ---- what is there ---------------------------------------------------------------------------

Outcome Executor::run(const ListCommand& /*command*/) {
  const auto benches = session_.find_benches();
  if (benches.empty()) return session_.no_bench_found();
  for (const client::BenchInfo& bench : benches) {
    if (Outcome listed = list_bench(bench); !listed) return listed;
  }
  return {};
}

Outcome Executor::list_bench(const client::BenchInfo& bench) {
  std::vector<client::AxisId> ids;
  for (const client::AxisInfo& axis : bench.axes) ids.push_back(axis.id);
  const auto seen = session_.observe(ids);
  if (!seen) return seen.outcome();
  if (!is_json_) {
    terminal_.print(colored(terminal_, Color::bold,
                            "bench " + std::to_string(bench.number) + " " + escaped(bench.name)) +
                    ", " + std::string(to_string(bench.clock_mode)) + ", tick " +
                    std::to_string(seen->tick) + " of " + std::to_string(bench.period.count()) +
                    " us" + rate_text(bench));
  }
  for (std::size_t i = 0; i < bench.axes.size(); ++i) {
    const client::AxisInfo& info = bench.axes[i];
    terminal_.print(is_json_ ? to_line(list_json(bench, info, seen->axes[i]))
                             : list_text(info, seen->axes[i]));
  }
  return {};
}

Outcome Executor::run(const StatusCommand& command) {
  const auto found = command.axes.empty() ? axes_of_all_benches() : axes(command.axes);
  if (!found) return found.outcome();
  for (const client::Axis& axis : *found) {
    if (Outcome shown = show_status(axis, found->size() == 1); !shown) return shown;
  }
  return {};
}

/// @param is_only_one in full, else on one line
Outcome Executor::show_status(const client::Axis& axis, bool is_only_one) {
  const auto status = axis.status();
  if (!status) return status.outcome();
  if (is_json_) {
    terminal_.print(to_line(status_json(*status, face_of(axis))));
  } else if (is_only_one) {
    for (const std::string& line : status_text(*status, face_of(axis))) terminal_.print(line);
  } else {
    const std::string line = status_line(
        *status, padded(to_string(axis.id()), 6) + " " + padded(escaped(axis.name()), 16),
        axis.unit());
    const auto color = color_of(*status);
    terminal_.print(color ? colored(terminal_, *color, line) : line);
  }
  return {};
}

Outcome Executor::run(const WatchCommand& command) {
  const auto found = command.axes.empty() ? axes_of_all_benches() : axes(command.axes);
  if (!found) return found.outcome();
  std::map<client::AxisId, AxisFace> faces;
  std::map<std::uint32_t, std::vector<client::AxisId>> benches;
  for (const client::Axis& axis : *found) {
    const auto bench = bench_of(axis.id());
    if (!bench) return bench.outcome();
    faces.emplace(axis.id(), AxisFace{axis.name(), axis.unit(), bench->name});
    benches[axis.id().bench].push_back(axis.id());
  }
  using Form = WatchView::Form;
  const bool is_table = terminal_.is_interactive() && command.count == 0;
  const Form form = is_table ? Form::table : Form::lines;
  WatchView view(terminal_, std::move(faces), is_json_ ? Form::json : form);
  return watch(benches, view, command.count);
}

Outcome Executor::follow(const std::map<std::uint32_t, std::vector<client::AxisId>>& benches,
                         WatchView& view, std::vector<client::Follower>& followers) {
  followers.reserve(benches.size());
  for (const auto& [bench, ids] : benches) {
    auto follower = session_.follow(ids, client::Pace::observe);
    if (!follower) return follower.outcome();
    followers.push_back(std::move(*follower));
    // The first sample is a request: the stream of a bench in lock-step may stand still.
    auto first = session_.observe(ids);
    if (first) {
      view.take(std::move(*first));
    } else if (first.outcome().kind() != OutcomeKind::timed_out) {
      return first.outcome();
    }
  }
  return {};
}

Outcome Executor::watch(const std::map<std::uint32_t, std::vector<client::AxisId>>& benches,
                        WatchView& view, std::uint64_t count) {
  std::vector<client::Follower> followers;
  if (Outcome outcome = follow(benches, view, followers); !outcome) return outcome;
  std::uint64_t shown = 0;
  std::optional<KeyInput> keys;
  if (terminal_.is_interactive() && count == 0) keys.emplace();
  while (terminal_.is_open()) {
    if (keys && !press_all(*keys, view)) return {};
    if (view.refresh() && ++shown == count) return {};
    if (Outcome seen = take_samples(followers, view); !seen) return seen;
  }
  return {};
}

client::Result<std::vector<client::Axis>> Executor::axes_to_record(const RecordCommand& command) {
  if (!command.axes.empty()) return axes(command.axes);
  const auto only = find_bench(std::nullopt, "write for example: record out.csv 2.1 2.2");
  if (!only) return only.outcome();
  return axes_of_bench(only->number);
}

/// What was recorded, as the last line.
void Executor::report_recording(const RecordCommand& command, std::size_t axes,
                                const recording::Summary& summary) {
  constexpr std::size_t kMostGaps = 100;
  constexpr std::size_t kMostGapsOfText = 4;
  const std::uint64_t lost = summary.gaps.missed();
  if (is_json_ && command.file != "-") {
    Json gaps = Json::array();
    for (const recording::Gap& gap : summary.gaps.gaps()) {
      if (gaps.size() == kMostGaps) break;
      gaps.push_back({{"bench", gap.bench},
                      {"after", gap.after},
                      {"before", gap.before},
                      {"missed", gap.missed}});
    }
    const std::uint64_t left_out =
        summary.gaps.gaps().size() - gaps.size() + summary.gaps.left_out();
    Json json{{"file", command.file}, {"axes", axes}, {"samples", summary.samples},
              {"lost", lost},         {"gaps", gaps}, {"gaps_left_out", left_out}};
    add_jumps(summary.gaps, kMostGaps, json);
    if (command.format == recording::Format::mcap) {
      json["events"] = summary.events;
      json["events_lost"] = summary.events_lost;
    }
    terminal_.print(to_line(json));
    return;
  }
  std::string text = "vdrive: recorded " + counted(summary.samples, "sample", "samples") + " of " +
                     counted(axes, "axis", "axes") + ", " + std::to_string(lost) + " lost";
  if (lost != 0) text += " " + summary.gaps.text(kMostGapsOfText);
  if (summary.gaps.skipped() != 0) {
    text += ", " + counted(summary.gaps.skipped(), "tick", "ticks") +
            " skipped by a jump of the tick number " + summary.gaps.jumps_text(kMostGapsOfText);
  }
  if (command.format == recording::Format::mcap) {
    text += ", " + counted(summary.events, "event", "events");
    if (summary.events_lost != 0) text += " and " + std::to_string(summary.events_lost) + " lost";
  }
  terminal_.complain(text);
}

Outcome Executor::run(const RecordCommand& command) {
  const auto axes = axes_to_record(command);
  if (!axes) return axes.outcome();
  std::map<std::uint32_t, ObservedBench> benches;
  for (const client::Axis& axis : *axes) {
    if (!benches.contains(axis.id().bench)) {
      auto info = bench_of(axis.id());
      if (!info) return info.outcome();
      benches[axis.id().bench].info = std::move(*info);
    }
    benches[axis.id().bench].axes.push_back(axis);
  }
  std::vector<ObservedBench> tracks;
  tracks.reserve(benches.size());
  for (auto& [number, bench] : benches) tracks.push_back(std::move(bench));
  Recorder recorder(session_, terminal_, command);
  Outcome recorded = recorder.record(tracks);
  if (recorder.has_begun()) report_recording(command, axes->size(), recorder.summary());
  return recorded;
}

Outcome convert_recording(const ConvertCommand& command, bool is_json, Terminal& terminal) {
  try {
    const recording::Contents contents = recording::convert({.from = command.from,
                                                             .to = command.to,
                                                             .period = command.period,
                                                             .version = VDRIVE_VERSION});
    if (is_json) {
      Json json{{"file", command.to},
                {"samples", contents.samples},
                {"rows", contents.rows},
                {"events_left_out", contents.events},
                {"parameters_left_out", contents.parameters},
                {"cut", contents.cut.empty() ? Json(nullptr) : Json(contents.cut)}};
      terminal.print(to_line(json));
      return {};
    }
    std::string text = "vdrive: wrote " + counted(contents.samples, "sample", "samples") + ", " +
                       counted(contents.rows, "row", "rows") + " to " + in_quotes(command.to);
    if (contents.events + contents.parameters != 0) {
      text += "; left out " + counted(contents.events, "event", "events") + " and " +
              counted(contents.parameters, "set of parameters", "sets of parameters");
    }
    terminal.complain(text);
    if (!contents.cut.empty()) {
      terminal.complain("vdrive: " + in_quotes(command.from) + " is incomplete: " + contents.cut +
                        "; everything before was converted");
    }
    return {};
  } catch (const recording::RecordingError& error) {
    return Outcome::failed(error.what());
  }
}

Outcome unknown_object(const client::AxisId& axis, const ObjectName& object) {
  return Outcome::refused(kNoSuchObject, "axis " + to_string(axis) + " has no object " +
                                             in_quotes(object.text) +
                                             object_suggestion(object.text));
}

void print_dictionary(DictionaryCommand command, bool is_json, Terminal& terminal) {
  if (is_json) command.format = TableFormat::json;
  for (const std::string& line : dictionary_lines(command)) {
    if (!terminal.is_open()) return;
    terminal.print(line);
  }
}

Outcome Executor::run(const DictionaryCommand& command) {
  print_dictionary(command, is_json_, terminal_);
  return {};
}

// ---- motion ----------------------------------------------------------------------------------

/// Several axes get the command together, and one that fails does not keep it from the others.
/// @return the first failure.
Outcome Executor::run(const ActionCommand& command) {
  auto found = axes(command.axes);
  if (!found) return found.outcome();
  if (command.take_over) {
    if (Outcome taken = take_over_all(*found); !taken) return taken;
  }
  const std::vector<Outcome> outcomes = carry_out(*found, command);
  const auto shown = is_quiet_ ? Statuses() : statuses_of(*found);
  Outcome first_failure;
  std::set<std::string> reports;  // the loss of a bench is the same failure for all its axes
  for (std::size_t i = 0; i < found->size(); ++i) {
    const client::Axis& axis = (*found)[i];
    const auto status = shown.find(axis.id());
    Outcome reported = report(axis, to_string(command.action), outcomes[i],
                              status == shown.end() ? nullptr : &status->second, false);
    if (reported && command.action == AxisAction::enable) held_.insert(axis.id());
    if (reported || reports.insert(reported.message()).second) {
      keep_first_failure(std::move(reported), first_failure);
    }
  }
  return first_failure;
}

void Executor::keep_first_failure(Outcome reported, Outcome& first_failure) {
  if (reported) return;
  if (first_failure) {
    first_failure = std::move(reported);
  } else {
    terminal_.complain("vdrive: " + named(reported).message());
  }
}

std::vector<Outcome> Executor::carry_out(std::vector<client::Axis>& axes,
                                         const ActionCommand& command) {
  if (const auto each = each_command_of(command.action)) {
    return session_.command_each(axes, *each, call_options(command.until));
  }
  // What a disk keeps waits for no drive time.
  std::vector<Outcome> outcomes;
  outcomes.reserve(axes.size());
  for (client::Axis& axis : axes) {
    outcomes.push_back(command.action == AxisAction::store ? axis.store()
                                                           : axis.restore_defaults());
  }
  return outcomes;
}

/// @return what the axes show, without those of a bench that does not answer.
Executor::Statuses Executor::statuses_of(const std::vector<client::Axis>& axes) {
  std::map<std::uint32_t, std::vector<client::AxisId>> benches;
  for (const client::Axis& axis : axes) benches[axis.id().bench].push_back(axis.id());
  Statuses shown;
  for (const auto& [bench, ids] : benches) {
    const auto seen = session_.observe(ids);
    if (!seen) continue;
    for (const client::AxisSnapshot& axis : seen->axes) shown.emplace(axis.id, axis);
  }
  return shown;
}

client::Result<client::Axis> Executor::axis_to_command(const std::string& name, bool take_over) {
  auto axis = this->axis(name);
  if (!axis || !take_over) return axis;
  if (Outcome taken = axis->take_over(); !taken) return taken;
  return axis;
}

Outcome Executor::run(const StopCommand& command) {
  const auto bench = session_.find_bench(command.bench);
  if (!bench) return bench.outcome();
  const std::string name = "bench " + std::to_string(bench->number);
  Outcome outcome = session_.quick_stop(bench->number, call_options(command.until));
  if (is_quiet_) return outcome;
  if (is_json_) {
    Json json{{"bench", bench->number}, {"command", "stop"}, {"axes", bench->axes.size()}};
    add_outcome(json, outcome);
    terminal_.print(to_line(json));
  } else if (outcome) {
    terminal_.print(name + ": quick stop of " + counted(bench->axes.size(), "axis", "axes"));
  }
  return outcome;
}

Outcome Executor::run(const MoveCommand& command) {
  auto axis = axis_to_command(command.axis, command.take_over);
  if (!axis) return axis.outcome();
  const auto position = static_cast<std::int32_t>(user_units(*axis, command.position));
  const client::MoveOptions options{.velocity = limit(*axis, command.velocity),
                                    .acceleration = limit(*axis, command.acceleration),
                                    .deceleration = limit(*axis, command.deceleration),
                                    .queue = command.queue,
                                    .call = call_options(command.until)};
  if (on_aim_ && !command.relative) on_aim_(axis->id(), position);
  const Outcome moved =
      command.relative ? axis->move_by(position, options) : axis->move_to(position, options);
  if (moved) held_.insert(axis->id());
  const bool leaves_ramps = options.call.until == client::Until::in_force &&
                            (options.acceleration || options.deceleration);
  if (moved && leaves_ramps && !is_quiet_) {
    terminal_.complain(
        "vdrive: the ramps of this move act while it lasts: 6083h and 6084h stay as given");
  }
  if (session_.is_interrupted()) report_interrupted_move(*axis, command, moved);
  return report_motion(*axis, "move", moved, options.call.until == client::Until::done);
}

/// After an interrupted move the message shows whether the axis still moves.
void Executor::report_interrupted_move(client::Axis& axis, const MoveCommand& command,
                                       const Outcome& moved) {
  if (!command.stop_on_interrupt) {
    if (!moved) terminal_.complain("vdrive: " + moved.message());
    return;
  }
  const Outcome halted = axis.halt();
  terminal_.complain("vdrive: interrupted; " +
                     (halted ? "axis " + to_string(axis.id()) + " is halted" : halted.message()));
}

/// @return what to do first where the power state has refused a command, or nothing.
std::string Executor::next_step(const client::AxisId& axis, PowerState state) const {
  const bool is_fault = state == PowerState::fault || state == PowerState::fault_reaction_active;
  if (is_fault) return "; reset it first: vdrive reset " + label_of(axis);
  if (state == PowerState::operation_enabled) return {};
  return "; enable it first: vdrive enable " + label_of(axis);
}

Outcome Executor::report_motion(const client::Axis& axis, std::string_view command, Outcome outcome,
                                bool has_arrived) {
  if (is_quiet_) return outcome;
  const auto status = axis.status();
  return report(axis, command, std::move(outcome), status ? &*status : nullptr, has_arrived);
}

/// @param status what the axis shows now, none where it is not known
/// @param has_arrived what is left of the speed is the end of a motion
Outcome Executor::report(const client::Axis& axis, std::string_view command, Outcome outcome,
                         const client::AxisSnapshot* status, bool has_arrived) {
  if (is_quiet_) return outcome;
  const bool is_refused_by_state =
      outcome.code() == wire_code(AbortCode::refused_in_present_device_state) &&
      command != to_string(AxisAction::reset);
  if (is_refused_by_state && status) {
    outcome = reworded(outcome, [&](const std::string& message) {
      return message + next_step(axis.id(), status->state());
    });
  }
  if (is_json_) {
    Json json{{"axis", to_string(axis.id())}, {"command", command}};
    add_outcome(json, named(outcome));
    if (status) {
      json["tick"] = status->tick;
      json["state"] = to_string(status->state());
      json["statusword"] = status->status.ds402_statusword;
      json["position"] = status->status.load_position_actual_value;
    }
    terminal_.print(to_line(json));
  } else if (outcome && status) {
    const std::string label = label_of(axis.id());
    terminal_.print(has_arrived ? arrival_line(*status, label, axis.unit())
                                : status_line(*status, label, axis.unit()));
  }
  return outcome;
}

// ---- objects ---------------------------------------------------------------------------------

Outcome Executor::run(const ReadCommand& command) {
  const auto axis = this->axis(command.axis);
  if (!axis) return axis.outcome();
  std::vector<ObjectAddress> addresses;
  for (const ObjectName& object : command.objects) {
    if (object.address) addresses.push_back(*object.address);
  }
  client::Readings readings;
  if (!addresses.empty()) {
    auto answer = axis->read(addresses);
    if (!answer) return answer.outcome();
    readings = std::move(*answer);
  }
  Outcome outcome;
  auto next = readings.objects.begin();
  for (const ObjectName& object : command.objects) {
    const client::ObjectReading reading =
        object.address ? *next++ : client::ObjectReading{{}, AbortCode::object_does_not_exist, 0};
    Outcome printed = print_reading(axis->id(), object, reading, readings.tick);
    if (outcome) outcome = std::move(printed);
  }
  return outcome;
}

Outcome Executor::print_reading(const client::AxisId& axis, const ObjectName& object,
                                const client::ObjectReading& reading, std::uint64_t tick) {
  const auto code = wire_code(reading.code);
  if (is_json_) {
    Json json = object_json(axis, object);
    if (code == 0) {
      json["value"] = reading.value;
    } else {
      json["code"] = hex(code, 8);
      json["message"] = vdrive::describe(reading.code);
    }
    json["tick"] = tick;
    terminal_.print(to_line(json));
  } else if (code == 0) {
    terminal_.print(reading_text(label_of(axis), object, reading.value));
  }
  if (code == 0) return {};
  if (!object.address) return unknown_object(axis, object);
  return Outcome::refused(code,
                          "read of " + object.text + " of axis " + to_string(axis) + " refused");
}

Outcome Executor::run(const WriteCommand& command) {
  auto axis = axis_to_command(command.axis, command.take_over);
  if (!axis) return axis.outcome();
  return write(*axis, command.object,
               command.quantity ? user_units(*axis, *command.quantity) : command.value);
}

Outcome Executor::write(client::Axis& axis, const ObjectName& object, std::int64_t value) {
  constexpr std::uint16_t kTarget = 0x607A;
  const auto tick = object.address
                        ? axis.write(*object.address, value)
                        : client::Result<std::uint64_t>(unknown_object(axis.id(), object));
  if (is_json_ && !is_quiet_) {
    Json json = object_json(axis.id(), object);
    json["value"] = value;
    add_outcome(json, named(tick.outcome()));
    if (tick) json["tick"] = *tick;
    terminal_.print(to_line(json));
  } else if (tick && !is_quiet_) {
    terminal_.print(reading_text(label_of(axis.id()), object, value) + ", in force at tick " +
                    std::to_string(*tick));
  }
  if (!tick) return tick.outcome();
  in_force_[axis.id()] = *tick;
  note_disturbance(axis, *object.address, value);
  if (on_aim_ && object.address->index == kTarget) on_aim_(axis.id(), value);
  if (!is_quiet_) note_limits(axis, *object.address);
  return {};
}

void Executor::note_disturbance(const client::Axis& axis, ObjectAddress object,
                                std::int64_t value) {
  if (!has_role(object, Role::test_input)) return;
  disturbed_.erase(std::pair(axis.id(), object));
  if (value != 0) disturbed_.emplace(std::pair(axis.id(), object), axis);
}

std::vector<std::string> Executor::put_back() {
  std::vector<std::string> done;
  for (const auto& [bench, rate] : std::exchange(rates_before_, {})) {
    if (!session_.set_rate(bench, rate)) continue;
    done.push_back("rate of bench " + std::to_string(bench) + " is " + to_text(rate));
  }
  for (auto& [input, axis] : std::exchange(disturbed_, {})) {
    const auto row = find_object(input.second);
    if (!row || !axis.write(input.second, 0)) continue;
    done.push_back(std::string(describe(*row).variable_name) + " of " + label_of(input.first) +
                   " is 0");
  }
  return done;
}

/// The drive takes every value of 607Dh, and uses them with 3535h and in the right order only.
void Executor::note_limits(const client::Axis& axis, ObjectAddress written) {
  using namespace vdrive::literals;
  const std::array limits{describe("app_position_limit_switch"_object).address,
                          describe("user_position_lower_limit"_object).address,
                          describe("user_position_upper_limit"_object).address};
  if (std::ranges::find(limits, written) == limits.end()) return;
  const auto values = axis.read(limits);
  if (!values) return;  // the write itself has succeeded
  const std::int64_t lower = values->objects[1].value;
  const std::int64_t upper = values->objects[2].value;
  if (values->objects[0].value == 0) {
    if (written == limits[0]) return;
    terminal_.complain(
        "vdrive: the software limits are off: app_position_limit_switch (3535h) = 1 switches them "
        "on");
  } else if (lower >= upper) {
    terminal_.complain(
        "vdrive: the software limits are not in force: user_position_lower_limit (607Dh:1) = " +
        std::to_string(lower) +
        " is not below user_position_upper_limit (607Dh:2) = " + std::to_string(upper));
  }
}

Outcome Executor::run(const DisturbCommand& command) {
  auto axis = this->axis(command.axis);
  if (!axis) return axis.outcome();
  for (const Disturbance& input : command.inputs) {
    if (Outcome written = write(*axis, input.object, input.value); !written) return written;
  }
  if (!command.duration) return {};
  const auto waited = session_.wait(axis->id().bench, *command.duration);
  // Cleared in any case: an interrupt does not mean a disturbance without end.
  for (const Disturbance& input : command.inputs) {
    if (Outcome written = write(*axis, input.object, 0); !written) return written;
  }
  return waited.outcome();
}

// ---- drive time ------------------------------------------------------------------------------

Outcome Executor::run(const StepCommand& command) {
  const auto bench = find_bench(command.bench, "write for example: step 1000 --bench 2");
  if (!bench) return bench.outcome();
  return report_clock({{"bench", bench->number}, {"ticks", command.ticks}},
                      "bench " + std::to_string(bench->number),
                      session_.step(bench->number, command.ticks));
}

Outcome Executor::run(const RateCommand& command) {
  if (!command.rate) return show_rates();
  const auto bench = find_bench(command.bench, "write for example: rate 2 0.5");
  if (!bench) return bench.outcome();
  const Json json{{"bench", bench->number}, {"rate", *command.rate}};
  const auto set = session_.set_rate(bench->number, *command.rate);
  if (set) rates_before_.emplace(bench->number, bench->rate);
  return report_clock(
      json, "bench " + std::to_string(bench->number) + " rate " + json["rate"].dump(), set);
}

Outcome Executor::show_rates() {
  const auto benches = session_.find_benches();
  if (benches.empty()) return session_.no_bench_found();
  for (const client::BenchInfo& bench : benches) {
    const bool has_rate = bench.clock_mode == client::ClockMode::realtime;
    if (is_json_) {
      terminal_.print(to_line({{"bench", bench.number},
                               {"clock", to_string(bench.clock_mode)},
                               {"rate", has_rate ? Json(bench.rate) : Json(nullptr)}}));
      continue;
    }
    terminal_.print("bench " + std::to_string(bench.number) + " " +
                    std::string(to_string(bench.clock_mode)) +
                    (has_rate ? " rate " + to_text(bench.rate) : std::string()));
  }
  return {};
}

/// What a command about a bench's clock came to, and at which tick.
Outcome Executor::report_clock(Json json, const std::string& text,
                               const client::Result<std::uint64_t>& tick) {
  if (is_quiet_) return tick.outcome();
  if (is_json_) {
    add_outcome(json, tick.outcome());
    if (tick) json["tick"] = *tick;
    terminal_.print(to_line(json));
  } else if (tick) {
    terminal_.print(text + " tick " + std::to_string(*tick));
  }
  return tick.outcome();
}

Outcome Executor::run(const SnapshotCommand& command) {
  using Action = SnapshotCommand::Action;
  if (command.action == Action::list) return list_snapshots(command);
  const auto bench = find_bench(command.bench, "write for example: snapshot take --bench 2");
  if (!bench) return bench.outcome();
  std::uint64_t number = command.snapshot;
  Outcome outcome;
  if (command.action == Action::take) {
    const auto taken = session_.take_snapshot(bench->number);
    outcome = taken.outcome();
    number = taken ? *taken : 0;
  } else if (command.action == Action::restore) {
    outcome = session_.restore_snapshot(bench->number, number).outcome();
  } else {
    outcome = session_.drop_snapshot(bench->number, number);
  }
  if (!outcome || is_quiet_) return outcome;
  if (is_json_) {
    terminal_.print(to_line(
        {{"bench", bench->number}, {"action", to_string(command.action)}, {"snapshot", number}}));
  } else {
    terminal_.print("bench " + std::to_string(bench->number) + " snapshot " +
                    std::to_string(number));
  }
  return {};
}

/// Of one bench, or of all where none is named.
Outcome Executor::list_snapshots(const SnapshotCommand& command) {
  std::vector<client::BenchInfo> benches;
  if (command.bench) {
    auto bench = session_.find_bench(command.bench);
    if (!bench) return bench.outcome();
    benches.push_back(std::move(*bench));
  } else {
    benches = session_.find_benches();
    if (benches.empty()) return session_.no_bench_found();
  }
  for (const client::BenchInfo& bench : benches) {
    const auto kept = session_.snapshots(bench.number);
    if (!kept) return kept.outcome();
    print_snapshots(bench, *kept);
  }
  return {};
}

void Executor::print_snapshots(const client::BenchInfo& bench,
                               std::span<const client::KeptSnapshot> kept) {
  const std::string name = "bench " + std::to_string(bench.number);
  if (kept.empty() && !is_json_) terminal_.print(name + " keeps no snapshot");
  for (const client::KeptSnapshot& snapshot : kept) {
    terminal_.print(is_json_ ? to_line({{"bench", bench.number},
                                        {"action", "list"},
                                        {"snapshot", snapshot.number},
                                        {"tick", snapshot.tick}})
                             : name + " snapshot " + std::to_string(snapshot.number) +
                                   ", taken at tick " + std::to_string(snapshot.tick) + ", " +
                                   counted(bench.axes.size(), "axis", "axes"));
  }
}

Outcome Executor::run(const WaitCommand& command) {
  if (benches_.empty()) {
    const auto only =
        find_bench(std::nullopt, "wait applies to the benches whose axes the file names");
    if (!only) return only.outcome();
    benches_.insert(only->number);
  }
  for (const std::uint32_t bench : benches_) {
    const auto reached = session_.wait(bench, command.duration);
    if (Outcome reported = report_clock({{"bench", bench}, {"command", "wait"}},
                                        "bench " + std::to_string(bench), reached);
        !reported) {
      return reported;
    }
  }
  return {};
}

Outcome Executor::run(const EventsCommand& command) {
  EventChoice choice{.bench = {}, .axis = {}, .follow = command.follow, .is_json = is_json_};
  const bool is_number = std::ranges::all_of(command.of, [](char c) {
    return c >= '0' && c <= '9';
  });
  if (command.of.empty()) {
    if (session_.find_benches().empty()) return session_.no_bench_found();
  } else if (is_number) {
    choice.bench = static_cast<std::uint32_t>(
        parse_number(command.of, "bench number", std::numeric_limits<std::uint32_t>::max()));
    const auto bench = session_.find_bench(choice.bench);
    if (!bench) return bench.outcome();
  } else {
    const auto axis = this->axis(command.of);
    if (!axis) return axis.outcome();
    choice.axis = axis->id();
  }
  return show_events(session_, choice, terminal_);
}

Outcome Executor::run(const std::shared_ptr<const RefusedCommand>& command) {
  const Outcome outcome = execute(command->command, timeout_);
  if (outcome.kind() == OutcomeKind::refused && outcome.code() == command->code) return {};
  found_ = Json{{"expected", hex(command->code, 8)},
                {"actual", outcome ? "accepted" : outcome.message()}};
  return Outcome::failed("expected the refusal " + hex(command->code, 8) +
                         ", actual: " + (outcome ? std::string("accepted") : outcome.message()));
}

}  // namespace vdrive::tool
