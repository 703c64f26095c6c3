// SPDX-License-Identifier: Apache-2.0
#include "vdrive/client/session.hpp"

#include "base/ask.hpp"
#include "base/drive_words.hpp"
#include "session/session_core.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"
#include "vdrive/wire/origin.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::client {
namespace {

std::vector<BenchInfo> infos_of(std::vector<PresentBench>&& benches) {
  std::vector<BenchInfo> infos;
  infos.reserve(benches.size());
  for (PresentBench& bench : benches) infos.push_back(std::move(bench.info));
  return infos;
}

void require_own_process(const SessionCore& core) {
  if (Outcome here = core.discovery.check_process(); !here) throw OutcomeError(here);
}

/// The numbers of axes by bench, each once.
/// @return not_found if one is not there.
Result<std::map<std::uint32_t, std::vector<std::uint16_t>>> find_by_bench(
    SessionCore& core, std::span<const AxisId> axes) {
  core.failure.rethrow();
  std::map<std::uint32_t, std::vector<std::uint16_t>> numbers;
  for (const AxisId& axis : axes) {
    if (const auto found = core.discovery.find_axis(to_string(axis)); !found) {
      return found.outcome();
    }
    std::vector<std::uint16_t>& of_bench = numbers[axis.bench];
    if (std::ranges::find(of_bench, axis.axis) == of_bench.end()) of_bench.push_back(axis.axis);
  }
  return numbers;
}

/// @return refused if an axis appears twice.
Outcome check_each_once(std::span<const AxisId> axes) {
  std::set<AxisId> seen;
  for (const AxisId& id : axes) {
    if (seen.insert(id).second) continue;
    return Outcome::refused(wire::number(msg::Reason::axis_twice),
                            "axis " + to_string(id) + " is named twice");
  }
  return {};
}

/// @return failed if it is too short.
Outcome check_period(std::chrono::milliseconds period) {
  constexpr std::chrono::milliseconds kShortest{1};  // 0 would keep a processor busy
  if (period >= kShortest) return {};
  return Outcome::failed("the period of the reports is " + std::to_string(period.count()) +
                         " ms: it must be 1 ms or more");
}

msg::AxisCommand command_of(const SetPoint& point) {
  using namespace literals;
  msg::AxisCommand command;
  command.axis = point.axis;
  std::uint16_t members = 0;
  if (point.mode) {
    members |= msg::HAS_OP_MODE_CMD;
    command.op_mode_cmd = static_cast<std::int8_t>(*point.mode);
  }
  if (point.position) {
    members |= msg::HAS_POSITION_USER_TARGET_VALUE;
    command.position_user_target_value = *point.position;
  }
  if (point.velocity) {
    add_object(command, kObjectRows["target_velocity"_object].address, *point.velocity);
  }
  if (point.torque) {
    add_object(command, kObjectRows["target_torque"_object].address, *point.torque);
  }
  for (const ObjectValue& value : point.objects) {
    add_object(command, value.object, value.value);
  }
  if (point.controlword) {
    members |= msg::HAS_DS402_CONTROLWORD;
    command.ds402_controlword = *point.controlword;
  }
  command.members = members;
  return command;
}

/// @return whether an active mode takes the object as its target, offset or data record.
bool is_target(const ObjectValue& value) {
  const auto row = find_object(value.object);
  if (!row) return false;
  const Change change = vdrive::describe(*row).change;
  return change == Change::target || change == Change::planned_target || change == Change::record;
}

/// @return whether the axis may keep running after this set-point.
bool sets_in_motion(const SetPoint& point) {
  return point.position || point.velocity || point.torque ||
         std::ranges::any_of(point.objects, is_target);
}

FrameContent content_of(const SetPointFrame& frame, std::span<const SetPoint> axes) {
  FrameContent content{.commands = {}, .apply_at_tick = frame.tick};
  content.commands.reserve(axes.size());
  for (const SetPoint& point : axes) {
    content.commands.push_back(command_of(point));
    if (sets_in_motion(point)) content.moved.push_back(point.axis);
  }
  return content;
}

/// Adds the frame in parts that a bench accepts. A frame without axes is sent too, as a keep-alive.
void add_contents(const SetPointFrame& frame, std::vector<FrameContent>& contents) {
  const std::size_t first = contents.size();
  std::span<const SetPoint> left(frame.axes);
  do {
    const auto part = left.first(std::min(left.size(), kMostAxesAtOnce));
    contents.push_back(content_of(frame, part));
    left = left.subspan(part.size());
  } while (!left.empty());
  if (frame.drops_waiting) contents[first].flags = msg::FRAME_CANCEL_PENDING;
}

Outcome check_objects(std::span<const SetPointFrame> frames) {
  static_assert(kMostObjectsOfSetPoint == msg::MAX_OBJECTS_PER_AXIS);
  for (const SetPointFrame& frame : frames) {
    for (const SetPoint& point : frame.axes) {
      const std::size_t count =
          point.objects.size() + (point.velocity ? 1U : 0U) + (point.torque ? 1U : 0U);
      if (count <= kMostObjectsOfSetPoint) continue;
      return Outcome::failed("the set-point of axis " + std::to_string(point.axis) + " has " +
                             std::to_string(count) + " objects; at most " +
                             std::to_string(kMostObjectsOfSetPoint) + " are allowed");
    }
  }
  return {};
}

}  // namespace

std::vector<ObjectValue> objects_before_stream() {
  using namespace literals;
  constexpr std::array kLeftOvers{"interpolation_time_period"_object, "position_offset"_object,
                                  "velocity_offset"_object, "torque_offset"_object};
  std::vector<ObjectValue> objects;
  objects.reserve(kLeftOvers.size());
  for (const ObjectRow row : kLeftOvers) {
    objects.push_back({.object = vdrive::describe(row).address, .value = 0});
  }
  return objects;
}

struct StatusReports::State {
  explicit State(std::shared_ptr<SessionCore> shared)
      : core(std::move(shared)), thread(core->reports) {}

  std::shared_ptr<SessionCore> core;
  ReportThread thread;
};

StatusReports::StatusReports(std::unique_ptr<State, End> state) : state_(std::move(state)) {}

void StatusReports::End::operator()(State* state) const noexcept {
  if (state->core->discovery.check_process()) delete state;  // NOLINT(*-owning-memory): a deleter
}

StatusReports::~StatusReports() = default;
StatusReports::StatusReports(StatusReports&&) noexcept = default;
StatusReports& StatusReports::operator=(StatusReports&&) noexcept = default;

Session::Session(const SessionOptions& options) : core_(wire::made_here<SessionCore>(options)) {}

Session::~Session() {
  core_->end();
}

std::uint64_t Session::id() const noexcept {
  return core_->id;
}

std::optional<SessionName> Session::find_name(std::uint32_t bench, std::uint64_t session) {
  if (!core_->discovery.check_process()) return std::nullopt;
  return core_->names.find(bench, session);
}

std::optional<SessionName> Session::known_name(std::uint32_t bench, std::uint64_t session) {
  if (!core_->discovery.check_process()) return std::nullopt;
  return core_->names.known(bench, session);
}

std::vector<BenchInfo> Session::find_benches() {
  core_->failure.rethrow();
  return infos_of(core_->discovery.find_benches());
}

std::vector<std::string> Session::network_troubles() const {
  return core_->discovery.network_troubles();
}

Outcome Session::no_bench_found() const {
  return core_->discovery.no_bench_found();
}

std::vector<BenchInfo> Session::present_benches() const {
  return infos_of(core_->discovery.present());
}

Result<BenchInfo> Session::find_bench(std::optional<std::uint32_t> number) {
  core_->failure.rethrow();
  auto bench = core_->discovery.find_bench(number);
  if (!bench) return bench.outcome();
  return std::move(bench->info);
}

Result<Axis> Session::axis(std::string_view text) {
  core_->failure.rethrow();
  auto axis = core_->discovery.find_axis(text);
  if (!axis) return axis.outcome();
  return Axis(core_, std::move(*axis));
}

Result<std::vector<Axis>> Session::axes(std::optional<std::uint32_t> bench) {
  core_->failure.rethrow();
  auto found = core_->discovery.find_bench(bench);
  if (!found) return found.outcome();
  std::vector<Axis> axes;
  axes.reserve(found->info.axes.size());
  for (AxisInfo& info : found->info.axes) axes.push_back(Axis(core_, std::move(info)));
  return axes;
}

Result<std::uint64_t> Session::step(std::uint32_t bench, std::uint64_t ticks) {
  const auto target = core_->links.connect(bench);
  if (!target) return target.outcome();
  const auto reached = core_->clocks.step(*target, ticks, {});
  if (!reached) return reached.outcome();
  return reached->tick;
}

bool Session::steps_at_once(std::uint32_t bench, std::uint64_t ticks) const {
  if (!core_->discovery.check_process()) return true;  // forked: step() reports that
  const auto target = core_->discovery.present_target(bench);
  return target && core_->clocks.steps_at_once(*target, ticks);
}

Result<std::uint64_t> Session::set_rate(std::uint32_t bench, double rate) {
  const auto target = core_->links.connect(bench);
  if (!target) return target.outcome();
  return core_->clocks.set_rate(*target, rate);
}

Result<std::uint64_t> Session::wait(std::uint32_t bench, std::chrono::nanoseconds duration) {
  const auto target = core_->links.connect(bench);
  if (!target) return target.outcome();
  return core_->observer.wait_for_ticks(*target, ticks_of(duration, target->period));
}

Result<std::uint64_t> Session::wait_for_tick(std::uint32_t bench, std::uint64_t tick) {
  const auto target = core_->links.connect(bench);
  if (!target) return target.outcome();
  return core_->observer.wait_for_tick(*target, tick);
}

Outcome Session::send_set_points(std::uint32_t bench, std::span<const SetPointFrame> frames) {
  if (Outcome checked = check_objects(frames); !checked) return checked;
  const auto target = core_->links.connect(bench);
  if (!target) return target.outcome();
  std::vector<FrameContent> contents;
  contents.reserve(frames.size());
  for (const SetPointFrame& frame : frames) add_contents(frame, contents);
  return core_->exchange.send_unawaited(*target, contents);
}

Outcome Session::acquire(std::span<const AxisId> axes) {
  const auto numbers = numbers_of(axes);
  if (!numbers) return numbers.outcome();
  const auto target = core_->links.connect(axes.front().bench);
  if (!target) return target.outcome();
  std::span<const std::uint16_t> left(*numbers);
  while (!left.empty()) {
    const auto part = left.first(std::min<std::size_t>(left.size(), msg::MAX_AXES_PER_FRAME));
    if (Outcome taken = core_->control.acquire(*target, part); !taken) {
      return core_->names.with_session_name(*target, std::move(taken));
    }
    left = left.subspan(part.size());
  }
  return {};
}

Result<Observation> Session::observe(std::span<const AxisId> axes) {
  const auto numbers = numbers_of(axes);
  if (!numbers) return numbers.outcome();
  const auto target = core_->links.connect(axes.front().bench);
  if (!target) return target.outcome();
  auto seen = core_->observer.observe(*target, *numbers);
  if (seen) core_->held_axes.note_seen(target->key, seen->axes);
  return seen;
}

Result<Follower> Session::follow(std::vector<AxisId> axes, Pace pace) {
  auto numbers = numbers_of(axes);
  if (!numbers) return numbers.outcome();
  if (Outcome once = check_each_once(axes); !once) return once;
  const auto target = core_->links.connect(axes.front().bench);
  if (!target) return target.outcome();
  return core_->follow(*target, std::move(*numbers), pace);
}

void Session::on_event(std::function<void(const Event&)> observer, EventHistory history) {
  require_own_process(*core_);
  core_->events.watch(std::move(observer), history);
}

void Session::on_set_point_refusal(std::function<void(const SetPointRefusal&)> observer) {
  require_own_process(*core_);
  core_->refusals.watch(std::move(observer));
}

Outcome Session::on_status(std::span<const AxisId> axes, std::chrono::milliseconds period,
                           std::function<void(const Observation&)> observer,
                           std::function<void(const Outcome&)> ended) {
  if (Outcome here = core_->discovery.check_process(); !here) return here;
  if (observer) {
    if (Outcome good = check_period(period); !good) return good;
  }
  core_->status_reports.stop();
  if (!observer) return {};
  const auto numbers = find_by_bench(*core_, axes);
  if (!numbers) return numbers.outcome();
  core_->statuses.watch(core_->status_reports, *numbers, period, std::move(observer),
                        std::move(ended));
  return {};
}

Result<StatusReports> Session::report_status(std::span<const AxisId> axes,
                                             std::chrono::milliseconds period,
                                             std::function<void(const Observation&)> observer,
                                             std::function<void(const Outcome&)> ended) {
  if (Outcome good = check_period(period); !good) return good;
  const auto numbers = find_by_bench(*core_, axes);
  if (!numbers) return numbers.outcome();
  std::unique_ptr<StatusReports::State, StatusReports::End> state(new StatusReports::State(core_));
  core_->statuses.watch(state->thread, *numbers, period, std::move(observer), std::move(ended));
  return StatusReports(std::move(state));
}

void Session::watch_services(std::function<void(const ServiceChange&)> observer) {
  require_own_process(*core_);
  core_->watcher.watch(std::move(observer));
}

Outcome Session::release(std::uint32_t bench) {
  if (Outcome here = core_->discovery.check_process(); !here) return here;
  return core_->control.release(bench);
}

Outcome Session::release() {
  if (Outcome here = core_->discovery.check_process(); !here) return here;
  return core_->control.release();
}

void Session::abandon() noexcept {
  core_->abandon();
}

void Session::interrupt() noexcept {
  core_->wakeup.interrupt();
}

void Session::end_interrupt() noexcept {
  core_->wakeup.end_interrupt();
}

bool Session::is_interrupted() const noexcept {
  return core_->wakeup.is_interrupted();
}

}  // namespace vdrive::client
