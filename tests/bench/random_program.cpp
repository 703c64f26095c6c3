// SPDX-License-Identifier: Apache-2.0
#include "bench/random_program.hpp"

#include "base/event_limiter.hpp"
#include "bench/carry_out.hpp"
#include "support/process_tree.hpp"
#include "support/programs/generator.hpp"
#include "support/programs/model.hpp"
#include "vdrive/axis_status.hpp"
#include "vdrive/cia402/power_state.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/number_text.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <stdexcept>
#include <utility>

namespace vdrive::bench {
namespace {

using namespace std::chrono_literals;
using client::Axis;
using client::AxisGroup;
using client::CallOptions;
using client::Disturbance;
using client::Session;
using client::SetPoint;
using client::SetPointFrame;
using client::Until;

constexpr std::uint32_t kBench = 1;
constexpr CallOptions kAtOnce{.timeout = 2s, .until = Until::in_force};
// A call that waits for the end steps tick by tick; it need not succeed.
constexpr CallOptions kToTheEnd{.timeout = 50ms, .until = Until::done};

// A bench accepts 1,024 frames that nobody has waited for.
constexpr std::uint32_t kFramesOfALongBurst = 150;
constexpr std::uint32_t kFramesOfABurst = 25;

client::GroupCallOptions group_options(bool to_the_end) {
  if (to_the_end) return {.timeout = 20ms, .until = Until::done, .progress = {}};
  return {.timeout = 2s, .until = Until::in_force, .progress = {}};
}

constexpr std::uint16_t kEnabled = 0x000F;

constexpr ObjectAddress kProfileVelocity{0x6081, 0};
constexpr ObjectAddress kPositioningOption{0x60F2, 0};
constexpr ObjectAddress kStoreParameters{0x1010, 1};

std::string text_of(const client::SetPointRefusal& refusal) {
  return "axis " + to_string(refusal.axis) + ", " + object_text(refusal.object) + ", code " +
         hex(static_cast<std::uint32_t>(refusal.code), 8);
}

/// The image between a power cycle and the next tick belongs to no tick.
void expect_valid(const AxisStatus& status) {
  const PowerState state = decode_power_state(status.ds402_statusword);
  if (state == PowerState::not_ready_to_switch_on) return;
  const char* const violated = test::violated_invariant(status, state);
  if (violated != nullptr) throw std::runtime_error(std::string("violated: ") + violated);
}

using Refusals = std::vector<client::SetPointRefusal>;

/// @return the first difference, or an empty text.
std::string difference_of(const Refusals& one, const Refusals& other) {
  const auto [here, there] = std::ranges::mismatch(one, other);
  if (here == one.end() && there == other.end()) return "";
  return "refusal " + std::to_string(here - one.begin()) + ": " +
         (here == one.end() ? "none" : text_of(*here)) + "; " +
         (there == other.end() ? "none" : text_of(*there));
}

}  // namespace

// ---- observations -------------------------------------------------------------------------------

void ProgramLog::note(const client::Outcome& outcome) {
  std::string message = outcome.message();
  if (const client::AxisOwner* const owner = outcome.owner()) {
    // Over a network the name of the owner's program may arrive too late.
    const std::string end = to_string(*owner);
    if (message.ends_with(end)) message.resize(message.size() - end.size());
    message += "axis " + to_string(owner->axis) + " of " + numbers_.name_of(owner->session);
  }
  text_ << to_string(outcome.kind()) << ' ' << outcome.code() << ' '
        << numbers_.without_numbers(std::move(message)) << '\n';
}

void ProgramLog::note(const client::Result<client::Observation>& seen) {
  note(seen.outcome());
  if (!seen) return;
  text_ << "tick " << seen->tick;
  note(seen->axes);
}

void ProgramLog::note(const client::Result<client::GroupStatus>& status) {
  note(status.outcome());
  if (!status) return;
  text_ << "group " << to_string(status->state) << " tick " << status->tick << " queued "
        << status->queued;
  note(status->axes);
}

void ProgramLog::note(const client::Result<client::Readings>& readings) {
  note(readings.outcome());
  if (!readings) return;
  text_ << "read in " << readings->tick;
  for (const client::ObjectReading& object : readings->objects) {
    text_ << ' ' << static_cast<std::uint32_t>(object.code) << '/' << object.value;
  }
  text_ << '\n';
}

void ProgramLog::note(const std::vector<client::AxisSnapshot>& axes) {
  for (const client::AxisSnapshot& axis : axes) {
    text_ << ' ' << numbers_.name_of(axis.owner_session) << '/' << axis.owner_epoch << '/'
          << axis.last_sequence;
    for (const StatusMember& member : status_members()) {
      if (member.is_published) text_ << ' ' << member.value(axis.status);
    }
  }
  text_ << '\n';
}

std::string difference_of(const std::string& one, const std::string& other) {
  if (one == other) return "";
  std::istringstream lines(one);
  std::istringstream other_lines(other);
  std::string before;
  while (true) {
    std::string line;
    std::string other_line;
    const bool is_there = static_cast<bool>(std::getline(lines, line));
    const bool is_other_there = static_cast<bool>(std::getline(other_lines, other_line));
    if (is_there != is_other_there || line != other_line) {
      return before + "< " + line + "\n> " + other_line + '\n';
    }
    before += "  " + line + '\n';
  }
}

// ---- the program -------------------------------------------------------------------------------

struct RandomProgram::Command {
  const char* name;
  void (RandomProgram::*carry_out)();
};

RandomProgram::RandomProgram(Session& first, Session& second, const test::SessionNumbers& numbers,
                             std::uint32_t seed)
    : first_(first),
      second_(second),
      random_(seed),
      axes_(first.axes(kBench).value()),
      axes_of_second_(second.axes(kBench).value()),
      log_(numbers) {
  for (const Axis& axis : axes_) ids_.push_back(axis.id());
  group_ = AxisGroup::create(first, axes_).value();
}

std::string RandomProgram::run() {
  static constexpr auto kCommands = std::to_array<Command>({
      {"move", &RandomProgram::move},
      {"move", &RandomProgram::move},
      {"write", &RandomProgram::write},
      {"read", &RandomProgram::read},
      {"disturb", &RandomProgram::disturb},
      {"store", &RandomProgram::store},
      {"power cycle", &RandomProgram::power_cycle},
      {"jog", &RandomProgram::jog},
      {"step", &RandomProgram::step},
      {"step", &RandomProgram::step},
      {"burst", &RandomProgram::send_burst},
      {"burst", &RandomProgram::send_burst},
      {"burst ahead", &RandomProgram::send_burst_ahead},
      {"group", &RandomProgram::use_group},
      {"group", &RandomProgram::use_group},
      {"group", &RandomProgram::use_group},
      {"stream", &RandomProgram::stream},
      {"control", &RandomProgram::take_control},
      {"second session", &RandomProgram::use_second_session},
      {"second session", &RandomProgram::use_second_session},
      {"clock", &RandomProgram::use_clock},
      {"clock", &RandomProgram::use_clock},
      {"snapshot", &RandomProgram::use_snapshot},
  });
  if (below(4) != 0) enable_group();  // otherwise most commands would be refused
  observe();
  for (int count = 0; count < kCommandsOfAProgram; ++count) {
    const Command what = below(3) == 0 ? Command{"command", &RandomProgram::command}
                                       : kCommands.at(below(kCommands.size()));
    log_.begin(what.name);
    (this->*what.carry_out)();
    observe();
  }
  clock_.reset();
  return log_.text();
}

void RandomProgram::observe() {
  const auto seen = first_.observe(ids_);
  log_.note(seen);
  if (!seen) return;
  seen_ = *seen;
  for (const client::AxisSnapshot& axis : seen_.axes) expect_valid(axis.status);
}

/// Makes a call of one axis. Calls that end by themselves are waited for.
void RandomProgram::command() {
  using enum test::Intent::Kind;
  static constexpr std::array kKinds{enable,      enable,  move_by, halt,   resume,      quick_stop,
                                     reset_fault, disable, home,    run_at, apply_torque};
  const std::size_t place = below(axes_.size());
  const test::Intent intent =
      test::draw_intent(seen_.axes.at(place).status, kKinds, kReach, random_);
  const bool is_awaited =
      intent.kind == move_by || intent.kind == home || (intent.kind == run_at && below(2) == 0);
  log_.begin(to_string(intent));
  log_.note(carry_out(axes_[place], intent, is_awaited ? kToTheEnd : kAtOnce));
}

void RandomProgram::move() {
  log_.note(any_axis().move_to(
      any_target(), {.velocity = 1'000 + below(50'000), .queue = below(2) == 0, .call = kAtOnce}));
}

// No controlword is written, because the client library assumes that only it sets bits 4 to 8.
void RandomProgram::write() {
  const std::size_t place = below(axes_.size());
  const AxisStatus& status = seen_.axes.at(place).status;
  test::Write write{kProfileVelocity, below(200'000)};
  if (below(2) == 0) write = test::draw_setting(random_);
  if (below(4) == 0) write = test::draw_set_point(status, random_);
  if (below(8) == 0) write = {{0x6060, 0}, test::draw_mode(random_)};
  log_.begin(to_string(write));
  log_.note(axes_[place].write(write.object, write.value));
  log_.note(first_.step(kBench, 1));
}

void RandomProgram::read() {
  const std::array objects{kProfileVelocity, ObjectAddress{0x6064, 0}, ObjectAddress{0x7FFF, 1}};
  log_.note(any_axis().read(objects));
}

void RandomProgram::disturb() {
  Axis& axis = any_axis();
  constexpr std::array kFaults{Disturbance::over_current, Disturbance::encoder_failure,
                               Disturbance::positive_limit, Disturbance::connection_loss};
  switch (below(8)) {
    case 0:
    case 1:
      return log_.note(axis.disturb(kFaults[below(kFaults.size())]));
    case 2:
    case 3:
    case 4:
      return log_.note(axis.disturb(Disturbance::load_torque, below(2'000)));
    default:
      return log_.note(axis.end_disturbances());
  }
}

void RandomProgram::store() {
  log_.note(any_axis().store());
}

void RandomProgram::power_cycle() {
  log_.note(any_axis().power_cycle(kAtOnce));
}

void RandomProgram::jog() {
  std::uint32_t left = below(20);
  log_.note(any_axis().jog(static_cast<std::int32_t>(below(2'000)) - 1'000,
                           [&left](const client::AxisSnapshot& /*axis*/) {
                             return left-- > 0;
                           },
                           {.call = kToTheEnd}));
}

void RandomProgram::step() {
  log_.note(first_.step(kBench, 1 + below(400)));
}

// ---- set-points that nobody waits for ----------------------------------------------------------

SetPoint RandomProgram::set_point(std::size_t place, OperatingMode mode, std::int32_t number) {
  SetPoint point{.axis = ids_[place].axis};
  const auto way = static_cast<std::int32_t>(below(20)) - 10;
  switch (mode) {
    case OperatingMode::cyclic_synchronous_velocity:
      point.velocity = 10 * number + way;
      break;
    case OperatingMode::cyclic_synchronous_torque:
      point.torque = static_cast<std::int16_t>(way);
      break;
    default:
      point.position = seen_.axes[place].status.position_demand_value + number + way;
      break;
  }
  if (number == 0) {
    point.mode = mode;
    point.controlword = kEnabled;
    // The last object is refused: a frame cannot store parameters.
    point.objects = {{kProfileVelocity, below(200'000)}, {kPositioningOption, below(4)}};
    if (below(4) == 0) point.objects.push_back({kStoreParameters, 1});
  }
  return point;
}

/// @param first_tick the tick of the first frame; 0 = each is for the next tick
void RandomProgram::send(std::uint64_t first_tick) {
  constexpr std::array kModes{
      OperatingMode::cyclic_synchronous_position, OperatingMode::cyclic_synchronous_velocity,
      OperatingMode::cyclic_synchronous_torque, OperatingMode::profile_position};
  const OperatingMode mode = kModes[below(kModes.size())];
  const std::size_t axes = 1 + below(ids_.size());
  if (below(8) != 0) log_.note(first_.acquire(std::span(ids_).first(axes)));
  const std::uint32_t count = 1 + below(below(8) == 0 ? kFramesOfALongBurst : kFramesOfABurst);
  std::vector<SetPointFrame> frames(count);
  for (std::uint32_t number = 0; number < count; ++number) {
    SetPointFrame& frame = frames[number];
    frame.tick = first_tick == 0 ? 0 : first_tick + number;
    frame.drops_waiting = below(100) == 0;
    for (std::size_t place = 0; place < axes; ++place) {
      frame.axes.push_back(set_point(place, mode, static_cast<std::int32_t>(number)));
    }
  }
  log_.note(first_.send_set_points(kBench, frames));
  log_.note(first_.step(kBench, 1 + below(2 * std::size_t{count})));
}

void RandomProgram::send_burst() {
  send(0);
}

/// Some frames of the burst arrive too late.
void RandomProgram::send_burst_ahead() {
  send(seen_.tick + below(20));
}

// ---- groups ------------------------------------------------------------------------------------

Eigen::VectorXd RandomProgram::any_targets() {
  Eigen::VectorXd targets(static_cast<Eigen::Index>(ids_.size()));
  for (double& target : targets) target = any_target();
  return targets;
}

void RandomProgram::enable_group() {
  log_.note(group_->enable_all(group_options(true)));
}

void RandomProgram::use_group() {
  if (below(2) == 0) enable_group();
  const client::GroupCallOptions options = group_options(below(4) == 0);
  switch (below(12)) {
    case 0:
    case 1:
    case 2:
    case 3:
      return log_.note(group_->move_together(any_targets(), {.call = options}));
    case 4:
      return log_.note(group_->move_by(any_targets() / 1'000, {.call = options}));
    case 5:
      log_.note(group_->queue_move(any_targets()));
      return log_.note(group_->wait_all(group_options(true)));
    case 6:
      return log_.note(group_->halt_all(options));
    case 7:
      return log_.note(group_->resume_all(options));
    case 8:
      return log_.note(group_->quick_stop_all(options));
    case 9:
      return log_.note(group_->reset_all(options));
    case 10:
      return log_.note(group_->take_over());
    default:
      return log_.note(group_->poll());
  }
}

void RandomProgram::stream() {
  constexpr std::array kStreamed{client::Streamed::positions, client::Streamed::velocities,
                                 client::Streamed::torques};
  const client::Streamed what = kStreamed[below(kStreamed.size())];
  if (below(4) != 0) enable_group();
  log_.note(group_->start_streaming({.what = what}));
  Eigen::VectorXd points = Eigen::VectorXd::Zero(std::ssize(ids_));
  for (Eigen::Index i = 0; i < points.size() && what == client::Streamed::positions; ++i) {
    points[i] = seen_.axes[static_cast<std::size_t>(i)].status.position_demand_value;
  }
  for (std::uint32_t count = below(10); count > 0; --count) {
    points.array() += below(10);
    log_.note(group_->stream(points));
  }
  log_.note(group_->stop_streaming(group_options(true)));
}

// ---- control and time --------------------------------------------------------------------------

// A request does not advance the tick, and of two equal events in one tick a session receives only
// one. Therefore time must pass after a change of control.

void RandomProgram::take_control() {
  Axis& axis = any_axis();
  switch (below(3)) {
    case 0:
      log_.note(axis.acquire());
      break;
    case 1:
      log_.note(axis.take_over());
      break;
    default:
      log_.note(first_.release(kBench));
      break;
  }
  log_.note(first_.step(kBench, 1));
}

void RandomProgram::use_second_session() {
  using enum test::Intent::Kind;
  static constexpr std::array kOfSecond{enable, move_to, halt, quick_stop, run_at};
  Axis& axis = axes_of_second_[below(axes_of_second_.size())];
  // While only the first session steps the clock, there is no tick by which a frame of the second
  // one is certain to be in force.
  switch (below(clock_ ? 5 : 10)) {
    case 0:
      log_.note(axis.acquire());
      break;
    case 1:
    case 2:
      log_.note(axis.take_over());
      break;
    case 3:
      log_.note(second_.release(kBench));
      break;
    case 4:
      log_.note(second_.step(kBench, 1));
      break;
    default:
      log_.note(carry_out(axis, test::draw_intent(kOfSecond, kReach, random_), kAtOnce));
      break;
  }
  log_.note(first_.step(kBench, 1));
}

void RandomProgram::use_clock() {
  if (!clock_) {
    auto joined = client::StepClock::join(first_, std::array{kBench});
    log_.note(joined.outcome());
    if (joined) clock_ = std::move(*joined);
  } else if (below(3) == 0) {
    clock_.reset();
    log_.note(client::Outcome());
  } else {
    const auto reached = clock_->step(1 + below(100));
    log_.note(reached.outcome());
    if (reached) log_.note(client::Result<std::uint64_t>(reached->front()));
  }
  log_.note(first_.step(kBench, 1));
}

void RandomProgram::use_snapshot() {
  const auto taken = first_.take_snapshot(kBench);
  log_.note(taken);
  if (!taken) return;
  log_.note(first_.step(kBench, 1 + below(10)));
  log_.note(first_.restore_snapshot(kBench, *taken));
  log_.note(first_.step(kBench, 1));
  log_.note(first_.drop_snapshot(kBench, *taken));
}

// ---- the bench ---------------------------------------------------------------------------------

ProgrammedBench::ProgrammedBench(Session& first, Session& second)
    : first_(first),
      second_(second),
      numbers_({{first.id(), "the first session"}, {second.id(), "the second session"}}),
      events_of_first_(first, numbers_),
      events_of_second_(second, numbers_),
      axes_(first.axes(kBench).value()),
      axis_of_second_(second.axes(kBench).value().front()),
      group_(AxisGroup::create(first, axes_).value()),
      begin_(first.take_snapshot(kBench).value()) {
  for (const Axis& axis : axes_) ids_.push_back(axis.id());
  first_.on_set_point_refusal([this](const client::SetPointRefusal& refusal) {
    const std::scoped_lock lock(mutex_);
    refusals_.push_back(refusal);
  });
}

ProgrammedBench::~ProgrammedBench() {
  first_.on_set_point_refusal({});
}

std::vector<client::SetPointRefusal> ProgrammedBench::refusals() const {
  const std::scoped_lock lock(mutex_);
  return refusals_;
}

std::string ProgrammedBench::run(std::uint32_t seed) {
  put_back();
  std::string log = RandomProgram(first_, second_, numbers_, seed).run();
  await_events();
  return log;
}

void ProgrammedBench::put_back() {
  group_.take_over().or_throw();  // restoring requires that no other session has an axis
  first_.restore_snapshot(kBench, begin_).outcome().or_throw();
  first_.step(kBench, 1).outcome().or_throw();
  // A running axis is released only when it has been seen to stop.
  for (Session* const session : {&first_, &second_}) {
    session->observe(ids_).outcome().or_throw();
    session->release(kBench).or_throw();
  }
}

/// The change of control causes an event that is unique because of its epoch.
void ProgrammedBench::await_events() {
  axis_of_second_.take_over().or_throw();
  first_.step(kBench, 1).outcome().or_throw();
  Axis& axis = axes_.front();
  axis.take_over().or_throw();
  const std::uint32_t epoch = axis.status().value().owner_epoch;
  const bool have_come = test::holds_soon([&] {
    return std::ranges::all_of(std::array{&events_of_first_, &events_of_second_},
                               [&](const test::EventLog* log) {
                                 return log->numbers_of(client::EventKind::control_changed,
                                                        axis.id().axis, epoch, first_.id())
                                            .told > 0;
                               });
  });
  if (!have_come) throw std::runtime_error("an event has not come");
}

std::string ProgrammedBench::difference_from(const ProgrammedBench& other) const {
  std::string difference = difference_of(events_of_first_, other.events_of_first_);
  if (!difference.empty()) return "first sessions: " + difference;
  difference = difference_of(events_of_second_, other.events_of_second_);
  if (!difference.empty()) return "second sessions: " + difference;
  difference = difference_of(events_of_first_, events_of_second_);
  if (!difference.empty()) return "sessions of one bench: " + difference;
  return difference_of(refusals(), other.refusals());
}

/// Causes more events than a bench passes on in a second. No program lets the second session take
/// snapshots.
void ProgrammedBench::cause_equal_events() {
  constexpr auto kMost = static_cast<std::uint32_t>(service::EventLimiter::kEqual.burst);
  for (std::uint32_t i = 0; i < 2 * kMost; ++i) {
    second_.drop_snapshot(kBench, second_.take_snapshot(kBench).value()).or_throw();
    ++caused_;
  }
}

/// @return whether some events of cause_equal_events() were left out. If so, all earlier
///         events that were left out are counted, too: their number is reported no later.
bool ProgrammedBench::is_left_out_after_wait() const {
  constexpr std::uint32_t kTaken = 1;
  const auto numbers_in = [&](const test::EventLog& log) {
    return log.numbers_of(client::EventKind::snapshot, 0, kTaken, second_.id());
  };
  const bool are_counted = test::holds_soon([&] {
    first_.observe(ids_).outcome().or_throw();  // a bench in this process works only during calls
    return numbers_in(events_of_first_).all == caused_ &&
           numbers_in(events_of_second_).all == caused_;
  });
  if (!are_counted) throw std::runtime_error("an event was neither told nor counted");
  return numbers_in(events_of_first_).told < caused_;
}

std::string ProgrammedBench::await_same_news(ProgrammedBench& other) {
  // Both benches may have left out the same number of events, so equality means nothing until all
  // are reported.
  bool are_all_told = false;
  while (!are_all_told) {
    cause_equal_events();
    other.cause_equal_events();
    const bool is_left_out = is_left_out_after_wait();
    are_all_told = other.is_left_out_after_wait() && is_left_out;
  }
  std::string difference;
  (void)test::holds_soon([&] {
    for (const ProgrammedBench* const bench : std::array<const ProgrammedBench*, 2>{this, &other}) {
      bench->first_.observe(bench->ids_).outcome().or_throw();
    }
    difference = difference_from(other);
    return difference.empty();
  });
  return difference;
}

}  // namespace vdrive::bench
