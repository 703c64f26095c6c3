// SPDX-License-Identifier: Apache-2.0
#include "executor.hpp"

#include "recorder.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

namespace vdrive::tool {
namespace {

using client::Outcome;
using client::OutcomeKind;

constexpr auto kNoSuchObject = wire_code(AbortCode::object_does_not_exist);
constexpr std::chrono::milliseconds kPatience{100};

/// @return ", paused" or ", rate 0.5" of a realtime bench that does not run as fast as the wall
///         clock.
std::string rate_text(const client::BenchInfo& bench) {
  if (bench.clock_mode != client::ClockMode::realtime || bench.rate == 1.0) return {};
  return bench.rate == 0.0 ? ", paused" : ", rate " + to_text(bench.rate);
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

client::CallOptions call_options(client::Until until, std::optional<Duration> timeout) {
  client::CallOptions call;
  call.until = until;
  if (timeout) call.timeout = *timeout;
  return call;
}

}  // namespace

Executor::Executor(client::Session& session, Terminal& terminal, bool is_json, bool is_quiet)
    : session_(session), terminal_(terminal), is_json_(is_json), is_quiet_(is_quiet) {}

Outcome Executor::execute(const Command& command, std::optional<Duration> timeout) {
  timeout_ = timeout;
  found_.reset();
  return named(std::visit(
      [this](const auto& word) {
        return run(word);
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
  if (benches.empty()) return Outcome::not_found("no bench was found on this domain");
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
  const auto axis = this->axis(command.axis);
  if (!axis) return axis.outcome();
  const auto status = axis->status();
  if (!status) return status.outcome();
  if (is_json_) {
    terminal_.print(to_line(status_json(*status, axis->name())));
    return {};
  }
  for (const std::string& line : status_text(*status, axis->name())) terminal_.print(line);
  return {};
}

Outcome Executor::run(const WatchCommand& command) {
  std::map<client::AxisId, std::string> names;
  std::vector<client::AxisId> ids;
  for (const std::string& name : command.axes) {
    const auto axis = this->axis(name);
    if (!axis) return axis.outcome();
    if (names.emplace(axis->id(), axis->name()).second) ids.push_back(axis->id());
  }
  using Form = WatchView::Form;
  const bool is_table = terminal_.is_interactive() && command.count == 0;
  const Form form = is_table ? Form::table : Form::lines;
  WatchView view(terminal_, std::move(names), is_json_ ? Form::json : form);
  return watch(ids, view, command.count);
}

Outcome Executor::watch(const std::vector<client::AxisId>& ids, WatchView& view,
                        std::uint64_t count) {
  auto follower = session_.follow(ids, client::Pace::observe);
  if (!follower) return follower.outcome();
  std::uint64_t shown = 0;
  // The first sample is a request: the stream of a bench in lock-step may stand still.
  auto sample = session_.observe(ids);
  for (; terminal_.is_open(); sample = follower->next(kPatience)) {
    if (sample) {
      view.take(std::move(*sample));
    } else if (sample.outcome().kind() != OutcomeKind::timed_out) {
      return sample.outcome();
    }
    if (view.refresh() && ++shown == count) return {};
  }
  return {};
}

client::Result<std::vector<client::Axis>> Executor::axes_to_record(const RecordCommand& command) {
  std::vector<std::string> names = command.axes;
  if (names.empty()) {
    const auto only = find_bench(std::nullopt, "write for example: record out.csv 2.1 2.2");
    if (!only) return only.outcome();
    for (const client::AxisInfo& axis : only->axes) names.push_back(to_string(axis.id));
  }
  std::vector<client::Axis> axes;
  for (const std::string& name : names) {
    const auto axis = this->axis(name);
    if (!axis) return axis.outcome();
    const bool twice = std::ranges::any_of(axes, [&](const client::Axis& other) {
      return other.id() == axis->id();
    });
    if (!twice) axes.push_back(*axis);
  }
  return axes;
}

Outcome Executor::run(const RecordCommand& command) {
  const auto axes = axes_to_record(command);
  if (!axes) return axes.outcome();
  std::map<std::uint32_t, RecordedBench> benches;
  std::map<client::AxisId, std::string> names;
  for (const client::Axis& axis : *axes) {
    if (!benches.contains(axis.id().bench)) {
      auto info = bench_of(axis.id());
      if (!info) return info.outcome();
      benches[axis.id().bench].info = std::move(*info);
    }
    benches[axis.id().bench].axes.push_back(axis.id());
    names[axis.id()] = axis.name();
  }
  std::vector<RecordedBench> tracks;
  tracks.reserve(benches.size());
  for (auto& [number, bench] : benches) tracks.push_back(std::move(bench));
  Recorder recorder(session_, terminal_, command, std::move(names));
  Outcome outcome = recorder.record(tracks);
  if (!recorder.has_begun()) return outcome;
  if (is_json_ && command.file != "-") {
    terminal_.print(to_line({{"file", command.file},
                             {"axes", axes->size()},
                             {"samples", recorder.samples()},
                             {"lost", recorder.lost()}}));
  } else {
    terminal_.complain("vdrive: recorded " + counted(recorder.samples(), "sample", "samples") +
                       " of " + counted(axes->size(), "axis", "axes") + ", " +
                       std::to_string(recorder.lost()) + " lost");
  }
  return outcome;
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

Outcome Executor::run(const ActionCommand& command) {
  auto axis = axis_to_command(command.axis, command.take_over);
  if (!axis) return axis.outcome();
  return report_motion(*axis, to_string(command.action), command_axis(*axis, command), false);
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
  Outcome outcome = session_.quick_stop(bench->number, call_options(command.until, timeout_));
  if (is_quiet_) return outcome;
  if (is_json_) {
    Json json{{"bench", bench->number}, {"command", "stop"}, {"axes", bench->axes.size()}};
    add_outcome(json, outcome);
    terminal_.print(to_line(json));
  } else if (outcome) {
    terminal_.print(name + ": quick stop of " + std::to_string(bench->axes.size()) +
                    (bench->axes.size() == 1 ? " axis" : " axes"));
  }
  return outcome;
}

Outcome Executor::command_axis(client::Axis& axis, const ActionCommand& command) {
  const client::CallOptions call = call_options(command.until, timeout_);
  switch (command.action) {
    case AxisAction::enable:
      return axis.enable(call);
    case AxisAction::disable:
      return axis.disable(call);
    case AxisAction::halt:
      return axis.halt(call);
    case AxisAction::resume:
      return axis.resume(call);
    case AxisAction::quick_stop:
      return axis.quick_stop(call);
    case AxisAction::reset:
      return axis.reset_fault(call);
    case AxisAction::power_cycle:
      return axis.power_cycle(call);
    case AxisAction::store:
      return axis.store();
    case AxisAction::restore:
      return axis.restore_defaults();
  }
  return Outcome::failed("unknown command");
}

Outcome Executor::run(const MoveCommand& command) {
  auto axis = axis_to_command(command.axis, command.take_over);
  if (!axis) return axis.outcome();
  client::MoveOptions options = command.options;
  options.call = call_options(options.call.until, timeout_);
  if (on_aim_ && !command.relative) on_aim_(axis->id(), command.position);
  const Outcome moved = command.relative ? axis->move_by(command.position, options)
                                         : axis->move_to(command.position, options);
  const bool leaves_ramps = options.call.until == client::Until::in_force &&
                            (options.acceleration || options.deceleration);
  if (moved && leaves_ramps && !is_quiet_) {
    terminal_.complain(
        "vdrive: the ramps of this move act while it lasts: 6083h and 6084h stay as given");
  }
  if (session_.is_interrupted()) report_interrupted_move(*axis, command, moved);
  return report_motion(*axis, "move", moved, options.call.until == client::Until::done);
}

/// Whoever interrupts a move has to know whether the axis still moves.
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

/// @param has_arrived what is left of the speed is the end of a motion
Outcome Executor::report_motion(const client::Axis& axis, std::string_view word, Outcome outcome,
                                bool has_arrived) {
  if (is_quiet_) return outcome;
  const auto status = axis.status();
  const bool is_refused_by_state =
      outcome.code() == wire_code(AbortCode::refused_in_present_device_state) &&
      word != to_string(AxisAction::reset);
  if (is_refused_by_state && status) {
    outcome = reworded(outcome, [&](const std::string& message) {
      return message + next_step(axis.id(), status->state());
    });
  }
  if (is_json_) {
    Json json{{"axis", to_string(axis.id())}, {"command", word}};
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
    terminal_.print(has_arrived ? arrival_line(*status, label) : status_line(*status, label));
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
  return write(*axis, command.object, command.value);
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

std::vector<std::string> Executor::clear_disturbances() {
  std::vector<std::string> cleared;
  for (auto& [input, axis] : std::exchange(disturbed_, {})) {
    const auto row = find_object(input.second);
    if (!row || !axis.write(input.second, 0)) continue;
    cleared.push_back(std::string(describe(*row).variable_name) + " of " + label_of(input.first));
  }
  return cleared;
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
  return report_clock(json,
                      "bench " + std::to_string(bench->number) + " rate " + json["rate"].dump(),
                      session_.set_rate(bench->number, *command.rate));
}

Outcome Executor::show_rates() {
  const auto benches = session_.find_benches();
  if (benches.empty()) return Outcome::not_found("no bench was found on this domain");
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

/// What a word about a bench's clock came to, and at which tick.
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

Outcome Executor::run(const WaitCommand& command) {
  if (benches_.empty()) {
    const auto only =
        find_bench(std::nullopt, "wait passes time on the benches whose axes the file names");
    if (!only) return only.outcome();
    benches_.insert(only->number);
  }
  for (const std::uint32_t bench : benches_) {
    const auto reached = session_.wait(bench, command.duration);
    if (!reached) return reached.outcome();
  }
  return {};
}

// One overload of many, called like the others.
Outcome Executor::run(  // NOLINT(readability-convert-member-functions-to-static)
    const DoctorCommand& /*command*/) {
  return Outcome::failed("doctor cannot be used in a scenario");
}

Outcome Executor::run(  // NOLINT(readability-convert-member-functions-to-static)
    const RunCommand& /*command*/) {
  return Outcome::failed("a scenario cannot run another one");
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
