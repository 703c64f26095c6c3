// SPDX-License-Identifier: Apache-2.0
#include "simulation/control_model.hpp"

#include "vdrive/cia402/controlword.hpp"
#include "vdrive/cia402/power_state.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <sstream>

namespace vdrive::simulation {
namespace {

constexpr auto kLocalControl = static_cast<msg::Reason>(0x08000021);
constexpr auto kReadOnly = static_cast<msg::Reason>(0x06010002);
constexpr auto kNoObject = static_cast<msg::Reason>(0x06020000);
constexpr auto kCannotStore = static_cast<msg::Reason>(0x08000020);
constexpr auto kHardwareError = static_cast<msg::Reason>(0x06060000);
constexpr auto kNotInFrames = static_cast<msg::Reason>(0x06040041);
constexpr auto kOutOfRange = static_cast<msg::Reason>(0x06090030);
constexpr std::uint16_t kStoreObject = 0x1010;
constexpr std::uint16_t kRestoreObject = 0x1011;
constexpr std::int64_t kSave = 0x65766173;
constexpr std::int64_t kLoad = 0x64616F6C;
constexpr std::uint16_t kHalt = 0x0100;
constexpr std::uint16_t kHaltOfOther = 0x010F;
constexpr std::uint16_t kQuickStop = 0x0002;
constexpr std::size_t kMostWaiting = 1'024;
constexpr std::size_t kMostSnapshots = 16;
constexpr std::uint64_t kMostOverlooked = 1'024;  // numbers below the highest
constexpr std::size_t kMostKept = 1'024;          // answers
constexpr std::ptrdiff_t kMostKeptOfOne = 128;
constexpr std::array<std::uint16_t, 10> kCommandObjects{0x6040, 0x6042, 0x6060, 0x6071, 0x607A,
                                                        0x60B0, 0x60B1, 0x60B2, 0x60C1, 0x60FF};
constexpr std::array<std::int64_t, 10> kModes{0, 1, 2, 3, 4, 6, 7, 8, 9, 10};
constexpr std::uint16_t kKnownMembers = 0x7F;
constexpr std::uint32_t kKnownFlags = 7;

bool is_command_object(std::uint16_t index) {
  return std::ranges::find(kCommandObjects, index) != kCommandObjects.end();
}

bool is_store_object(std::uint16_t index) {
  return index == kStoreObject || index == kRestoreObject;
}

bool is_test_input(std::uint16_t index) {
  return index >= 0x5E00 && index <= 0x5E0A;
}

/// @return the reason that an actor gets for writing this value, if it may write at all.
msg::Reason verdict(ObjectAddress address, std::int64_t value, bool is_modulo) {
  constexpr std::int64_t kHighestOption = 2;  // of 60F2h on an axis without a range
  switch (address.index) {
    case 0x6041:
      return kReadOnly;
    case 0x2000:
      return kNoObject;
    case 0x6060:
      return std::ranges::find(kModes, value) == kModes.end() ? kOutOfRange : msg::Reason::none;
    case 0x60F2:
      return value > kHighestOption && !is_modulo ? kOutOfRange : msg::Reason::none;
    default:
      return msg::Reason::none;
  }
}

template <typename... Parts>
std::string text(const Parts&... parts) {
  std::ostringstream stream;
  (stream << ... << parts);
  return stream.str();
}

}  // namespace

std::string ControlModel::words_of(const FrameAnswer& answer) {
  std::string words = text("answer to frame ", answer.sequence, " of session ", answer.session,
                           " in tick ", answer.tick);
  for (const Refused& refused : answer.refusals) {
    words += text(", axis ", refused.axis, " object ", refused.index, " refused with ",
                  wire::number(refused.reason));
  }
  return words;
}

std::string ControlModel::words_of(const Answer& answer) {
  return text("answer to request ", answer.request_id, " of client ", answer.client, " reason ",
              wire::number(answer.reason), " axis ", answer.refused_axis, " owner ", answer.owner,
              " epoch ", answer.epoch, " last sequence ", answer.last_sequence);
}

std::string ControlModel::words_of(const Registers& registers) {
  return text("6040h ", registers.controlword, " 6060h ", int{registers.mode}, " 607Ah ",
              registers.target, " 6067h ", registers.stamp, " 6081h ", registers.velocity);
}

ControlModel::ControlModel(const service::Configuration& configuration, std::uint64_t incarnation,
                           Happenings& happenings)
    : configuration_(configuration),
      incarnation_(incarnation),
      happenings_(happenings),
      rate_(configuration.clock == service::ClockMode::realtime ? configuration.rate : 0.0),
      axes_(configuration.axes.size()) {
  for (std::size_t index = 0; index < axes_.size(); ++index) {
    const auto& axis = configuration.axes[index];
    axes_[index].number = axis.number;
    axes_[index].is_modulo =
        std::ranges::any_of(axis.configuration.parameters, [](const InitialValue& initial) {
          return initial.address.index == 0x607B;
        });
  }
  count_watchdog();
}

void ControlModel::store_with(StoreModel& stores, const StoredSet& loaded) {
  stores_ = &stores;
  for (Axis& axis : axes_) {
    if (const auto stored = loaded.find(axis.number); stored != loaded.end()) {
      axis.memory = stored->second;
    }
    power_up(axis);
  }
}

/// The registers get their stored values or their defaults. Test bench inputs are not part of the
/// drive.
void ControlModel::power_up(Axis& axis) {
  const StoredValues values = axis.memory.value_or(StoredValues{});
  from_memory_.insert(values.stamp);
  axis.registers = {.stamp = values.stamp,
                    .velocity = values.velocity,
                    .test_inputs = axis.registers.test_inputs};
}

// ---- sessions ----------------------------------------------------------------------------------

ControlModel::Axis* ControlModel::axis_of(std::uint16_t number) {
  return number >= 1 && number <= axes_.size() ? &axes_[number - 1U] : nullptr;
}

ControlModel::Session* ControlModel::find(std::uint64_t session) {
  const auto found = std::ranges::find(sessions_, session, &Session::id);
  return session == 0 || found == sessions_.end() ? nullptr : &*found;
}

ControlModel::Session& ControlModel::find_or_add(std::uint64_t session) {
  Session* const known = find(session);
  return known != nullptr
             ? *known
             : sessions_.emplace_back(Session{.id = session, .last_message_tick = tick_});
}

bool ControlModel::owns_any(std::uint64_t session) const {
  return std::ranges::any_of(axes_, [&](const Axis& axis) {
    return axis.owner == session;
  });
}

void ControlModel::renew(Session& session, bool revoked) {
  if (revoked) {
    revocations_->try_emplace({incarnation_, session.epoch}, happenings_.tick());
  }
  session.epoch = owns_any(session.id) ? ++last_epoch_ : 0;
  for (Axis& axis : axes_) {
    if (axis.owner == session.id) axis.epoch = session.epoch;
  }
}

void ControlModel::note_message(std::uint64_t session) {
  if (Session* const known = find(session)) known->last_message_tick = tick_;
}

void ControlModel::expect_event(msg::EventKind kind, std::uint64_t session) {
  ++events_[{kind, session}];
}

/// The time-out of a master is wall time, so the number of ticks grows with the rate.
void ControlModel::count_watchdog() {
  const auto watchdog = effective_watchdog(configuration_);
  if (watchdog) {
    const double period = static_cast<double>(configuration_.period.count()) * 1e-3;
    watchdog_ = static_cast<std::uint64_t>(
        std::ceil(static_cast<double>(watchdog->count()) * std::max(rate_, 1.0) / period - 1e-9));
  }
}

bool ControlModel::time_stands() const {
  return configuration_.clock == service::ClockMode::lockstep ||
         (configuration_.clock == service::ClockMode::realtime && rate_ == 0.0);
}

void ControlModel::jump(std::uint64_t ticks) {
  tick_ += ticks;
  for (Session& session : sessions_) session.last_message_tick += ticks;
}

// ---- waiting frames ----------------------------------------------------------------------------

template <typename Condition>
void ControlModel::drop(Condition condition) {
  for (auto place = waiting_.begin(); place != waiting_.end();) {
    if (condition(place->frame)) {
      refuse(place->frame, msg::Reason::cancelled);
      place = waiting_.erase(place);
    } else {
      ++place;
    }
  }
}

void ControlModel::drop_of_session(std::uint64_t session) {
  drop([&](const msg::CommandFrame& frame) {
    return frame.session == session;
  });
}

void ControlModel::drop_of_axis(std::uint16_t number) {
  drop([&](const msg::CommandFrame& frame) {
    return std::ranges::any_of(frame.axes, [&](const auto& command) {
      return command.axis == number;
    });
  });
}

void ControlModel::begin_tick() {
  while (!waiting_.empty() && waiting_.front().tick <= tick_ + 1) {
    const msg::CommandFrame frame = std::move(waiting_.front().frame);
    waiting_.pop_front();
    if (frame.valid_until_tick != 0 && frame.valid_until_tick <= tick_) {
      refuse(frame, msg::Reason::too_late);
    } else {
      apply(frame);
    }
  }
  for (Session& session : sessions_) {
    if (watchdog_ != 0 && tick_ - session.last_message_tick > watchdog_ && owns_any(session.id)) {
      lose(session);
    }
  }
  ++tick_;
}

void ControlModel::lose(Session& session) {
  for (Axis& axis : axes_) {
    if (axis.owner == session.id) {
      axis.owner = axis.epoch = 0;
      axis.last_sequence = 0;
      axis.causes.lost = true;
    }
  }
  renew(session, true);
  session.must_acquire = true;
  drop_of_session(session.id);
  ++lost_masters_;
  expect_event(msg::EventKind::master_lost, session.id);
}

void ControlModel::end_tick(std::span<const AxisStatus> statuses) {
  for (std::size_t index = 0; index < axes_.size(); ++index) {
    const bool enabled =
        decode_power_state(statuses[index].ds402_statusword) == PowerState::operation_enabled;
    if (axes_[index].was_enabled && !enabled) drop_of_axis(static_cast<std::uint16_t>(index + 1));
    axes_[index].was_enabled = enabled;
    axes_[index].causes = {};
  }
  restored_ = false;
}

// ---- frames -----------------------------------------------------------------------------------

void ControlModel::Numbers::take(std::uint64_t number) {
  highest = std::max(highest, number);
  taken.insert(number);
}

bool ControlModel::Numbers::has_forgotten(std::uint64_t number) const {
  return number <= highest && highest - number >= kMostOverlooked;
}

/// The oldest answer is dropped first, but no sender may use up all the room.
template <typename Kept>
void ControlModel::keep(std::deque<Kept>& memory, const Kept& answer) {
  const auto is_of_the_same = [&](const Kept& other) {
    return sender_of(other) == sender_of(answer);
  };
  if (std::ranges::count_if(memory, is_of_the_same) == kMostKeptOfOne) {
    memory.erase(std::ranges::find_if(memory, is_of_the_same));
  } else if (memory.size() == kMostKept) {
    memory.pop_front();
  }
  memory.push_back(answer);
}

void ControlModel::arrive(const msg::CommandFrame& frame) {
  if (frame.incarnation != incarnation_ || frame.session == 0) {
    refuse(frame,
           frame.session == 0 && frame.incarnation == incarnation_ ? msg::Reason::bad_session
                                                                   : msg::Reason::wrong_incarnation,
           false);
    return;
  }
  Session& session = find_or_add(frame.session);
  session.last_message_tick = tick_;
  if (is_repeat(frame)) return;
  if (const msg::Reason reason = judge(frame); reason != msg::Reason::none) {
    refuse(frame, reason);
    return;
  }
  const bool cancels = (frame.flags & msg::FRAME_CANCEL_PENDING) != 0;
  if (cancels || !frame.axes.empty()) session.last_command = frame.sequence_number;
  if (cancels) drop_of_session(frame.session);
  if (frame.apply_at_tick <= tick_ + 1) {
    apply(frame);
  } else if (waiting_.size() == kMostWaiting) {
    refuse(frame, msg::Reason::queue_full);
  } else {
    const auto place = std::ranges::upper_bound(waiting_, frame.apply_at_tick, {}, &Waiting::tick);
    waiting_.insert(place, {frame.apply_at_tick, frame});
  }
}

bool ControlModel::is_waiting(const msg::CommandFrame& frame) const {
  return std::ranges::any_of(waiting_, [&](const Waiting& waiting) {
    return waiting.frame.session == frame.session &&
           waiting.frame.sequence_number == frame.sequence_number;
  });
}

/// A repeat gets the first answer again; kept_of() finds that answer once it has been checked.
bool ControlModel::is_repeat(const msg::CommandFrame& frame) {
  Numbers& numbers = frames_[frame.session];
  const std::uint64_t number = frame.sequence_number;
  if (numbers.has_forgotten(number)) {
    if (!is_waiting(frame)) refuse(frame, msg::Reason::too_late, false);
    return true;
  }
  if (!numbers.taken.contains(number)) {
    numbers.take(number);
    return false;
  }
  frame_answers_.push_back({.session = frame.session,
                            .sequence = number,
                            .tick = tick_ + 1,
                            .is_wanted = true,
                            .is_repeat = true,
                            .is_kept = false,
                            .refusals = {{.reason = msg::Reason::too_late}}});
  return true;
}

msg::Reason ControlModel::judge(const msg::CommandFrame& frame) {
  Session& session = *find(frame.session);
  session.last_sequence = std::max(session.last_sequence, frame.sequence_number);
  if (frame.sequence_number <= session.last_command) return msg::Reason::too_late;
  if (session.epoch != frame.epoch) return msg::Reason::stale_epoch;
  if (session.epoch == 0) return msg::Reason::not_owner;
  return (frame.flags & ~kKnownFlags) != 0 ? msg::Reason::unknown_flags : judge_time(frame);
}

msg::Reason ControlModel::judge_time(const msg::CommandFrame& frame) const {
  const std::uint64_t next = tick_ + 1;
  const std::uint64_t at = frame.apply_at_tick == 0 ? next : frame.apply_at_tick;
  const auto furthest =
      static_cast<std::uint64_t>(std::chrono::seconds{10} / configuration_.period);
  if (at < next ||
      (frame.valid_until_tick != 0 && at <= tick_ + furthest && frame.valid_until_tick < at)) {
    return msg::Reason::too_late;
  }
  return at > tick_ + furthest ? msg::Reason::too_far_ahead : msg::Reason::none;
}

void ControlModel::refuse(const msg::CommandFrame& frame, msg::Reason reason, bool is_kept) {
  ++refused_frames_;
  frame_answers_.push_back({.session = frame.session,
                            .sequence = frame.sequence_number,
                            .tick = tick_ + 1,
                            .is_wanted = true,
                            .is_kept = is_kept,
                            .refusals = {{.reason = reason}}});
}

void ControlModel::apply(const msg::CommandFrame& frame) {
  FrameAnswer answer{.session = frame.session,
                     .sequence = frame.sequence_number,
                     .tick = tick_ + 1,
                     .is_wanted = (frame.flags & msg::FRAME_WANT_REPLY) != 0,
                     .refusals = {}};
  std::set<std::uint16_t> named;
  std::vector<const msg::AxisCommand*> commands;
  for (const auto& command : frame.axes) {
    const msg::Reason reason = judge_command(command, frame.session, named);
    if (reason == msg::Reason::none) {
      commands.push_back(&command);
    } else {
      answer.refusals.push_back({.axis = command.axis, .reason = reason});
    }
  }
  if ((frame.flags & msg::FRAME_ALL_OR_NOTHING) == 0) {
    for (const auto* const command : commands) {
      write_members(*command, answer);
      write_controlword(*command, frame.sequence_number);
    }
  } else if (answer.refusals.empty()) {
    const std::vector<Axis> before = axes_;
    for (const auto* const command : commands) write_members(*command, answer);
    if (!answer.refusals.empty()) axes_ = before;
    for (const auto* const command : commands) {
      if (answer.refusals.empty()) write_controlword(*command, frame.sequence_number);
    }
  }
  answer.is_wanted = answer.is_wanted || !answer.refusals.empty();
  frame_answers_.push_back(std::move(answer));
}

msg::Reason ControlModel::judge_command(const msg::AxisCommand& command, std::uint64_t session,
                                        std::set<std::uint16_t>& named) {
  const Axis* const axis = axis_of(command.axis);
  if (axis == nullptr) return msg::Reason::unknown_axis;
  if (!named.insert(command.axis).second) return msg::Reason::axis_twice;
  if (axis->owner != session) return msg::Reason::not_owner;
  return (command.members & ~kKnownMembers) != 0 ? msg::Reason::unknown_members : msg::Reason::none;
}

bool ControlModel::write_members(const msg::AxisCommand& command, FrameAnswer& answer) {
  Axis& axis = *axis_of(command.axis);
  const auto put = [&](ObjectAddress address, std::int64_t value) {
    const bool is_out = address.index == 0x6040 || is_store_object(address.index);
    const msg::Reason code = is_out ? kNotInFrames : write(axis, command.axis, address, value);
    if (code != msg::Reason::none) {
      answer.refusals.push_back({command.axis, address.index, address.subindex, code});
    }
  };
  if ((command.members & msg::HAS_OP_MODE_CMD) != 0) {
    put({0x6060, 0}, command.op_mode_cmd);
  }
  if ((command.members & msg::HAS_POSITION_USER_TARGET_VALUE) != 0) {
    put({0x607A, 0}, command.position_user_target_value);
  }
  if ((command.members & msg::HAS_PROFILE_VELOCITY) != 0) {
    put({0x6081, 0}, command.profile_velocity);
  }
  for (const auto& object : command.objects) {
    put({object.index, object.subindex}, object.value);
  }
  return answer.refusals.empty();
}

void ControlModel::write_controlword(const msg::AxisCommand& command, std::uint64_t sequence) {
  Axis& axis = *axis_of(command.axis);
  ++commands_;
  if ((command.members & msg::HAS_DS402_CONTROLWORD) != 0) {
    write(axis, command.axis, {0x6040, 0}, command.ds402_controlword);
  }
  axis.last_sequence = sequence;
}

msg::Reason ControlModel::write(Axis& axis, std::uint16_t number, ObjectAddress address,
                                std::int64_t value) {
  if (const msg::Reason code = verdict(address, value, axis.is_modulo); code != msg::Reason::none) {
    return code;
  }
  Registers& registers = axis.registers;
  switch (address.index) {
    case 0x6040: {
      const auto word = static_cast<std::uint16_t>(value);
      const bool halts = (value & kHalt) != 0 && (registers.controlword & kHalt) == 0;
      const PowerCommand command = decode_command(word, registers.controlword);
      registers.controlword = word;
      axis.causes.commanded = true;
      if (command == PowerCommand::disable_voltage || command == PowerCommand::shutdown) {
        axis.causes.switched_off = true;
      }
      if (halts) drop_of_axis(number);
      break;
    }
    case 0x6060:
      registers.mode = static_cast<std::int8_t>(value);
      break;
    case 0x607A:
      registers.target = static_cast<std::int32_t>(value);
      break;
    case 0x6067:
      registers.stamp = static_cast<std::uint32_t>(value);
      break;
    case 0x6081:
      registers.velocity = static_cast<std::uint32_t>(value);
      break;
    default:
      if (is_test_input(address.index)) registers.test_inputs[address.index - 0x5E00U] = value;
      break;
  }
  return msg::Reason::none;
}

// ---- requests ---------------------------------------------------------------------------------

void ControlModel::arrive(const msg::Request& request) {
  Answer answer;
  ++last_storing_;
  ordered_ = 0;
  if (request.client == 0) {
    finish(request, msg::Reason::bad_session, answer, false);
    return;
  }
  if (request.incarnation != 0 && request.incarnation != incarnation_) {
    finish(request, msg::Reason::wrong_incarnation, answer, false);
    return;
  }
  if (is_repeat(request)) return;
  note_message(request.session);
  const msg::Reason reason = carry_out(request, answer);
  if (ordered_ > 0) {
    storings_[last_storing_] = {request, reason, std::move(answer), ordered_};
    return;
  }
  finish(request, reason, answer);
}

bool ControlModel::is_storing(const msg::Request& request) const {
  return std::ranges::any_of(storings_, [&](const auto& storing) {
    return storing.second.request.client == request.client &&
           storing.second.request.request_id == request.request_id;
  });
}

bool ControlModel::is_repeat(const msg::Request& request) {
  Numbers& numbers = requests_[request.client];
  const std::uint64_t number = request.request_id;
  const bool is_forgotten = numbers.has_forgotten(number);
  if (!is_forgotten && !numbers.taken.contains(number)) {
    numbers.take(number);
    return false;
  }
  note_message(request.session);
  const auto kept = std::ranges::find_if(kept_answers_, [&](const Answer& answer) {
    return answer.client == request.client && answer.request_id == number;
  });
  if (kept != kept_answers_.end() && !is_forgotten) {
    answers_.push_back(*kept);
  } else if (is_forgotten ? !is_storing(request) : numbers.answered.contains(number)) {
    Answer answer;
    finish(request, msg::Reason::too_late, answer, false);
  }
  return true;
}

bool ControlModel::has_frames_of(const msg::Request& step) {
  if (step.last_sequence == 0) return true;
  const Session* const session = find(step.session);
  return session != nullptr && session->last_sequence >= step.last_sequence;
}

void ControlModel::expect_step_answer(const msg::Request& request, msg::Reason reason) {
  Answer answer;
  finish(request, reason, answer);
}

void ControlModel::finish(const msg::Request& request, msg::Reason reason, Answer& answer,
                          bool is_kept) {
  const Session* const session = find(request.session);
  answer.client = request.client;
  answer.request_id = request.request_id;
  answer.reason = reason;
  answer.epoch = session == nullptr ? 0 : session->epoch;
  answer.last_sequence = session == nullptr ? 0 : session->last_sequence;
  Numbers& numbers = requests_[request.client];
  if (is_kept && !numbers.has_forgotten(request.request_id)) {
    numbers.answered.insert(request.request_id);
    keep(kept_answers_, answer);
  }
  answers_.push_back(std::move(answer));
}

msg::Reason ControlModel::carry_out(const msg::Request& request, Answer& answer) {
  switch (request.kind) {
    case msg::RequestKind::read:
      return read_objects(request, answer);
    case msg::RequestKind::write:
      return write_objects(request, answer);
    case msg::RequestKind::acquire:
      return take(request, false, answer);
    case msg::RequestKind::take_over:
      return take(request, true, answer);
    case msg::RequestKind::release:
      return release(request, answer);
    case msg::RequestKind::store:
    case msg::RequestKind::restore:
      return store_axes(request, answer);
    case msg::RequestKind::power_cycle:
      return power_cycle(request, answer);
    case msg::RequestKind::set_rate:
      return set_rate(request);
    case msg::RequestKind::take_snapshot:
    case msg::RequestKind::restore_snapshot:
    case msg::RequestKind::drop_snapshot:
      return snapshot(request, answer);
    case msg::RequestKind::step:
    case msg::RequestKind::join_clock:
    case msg::RequestKind::leave_clock:
      return msg::Reason::wrong_clock_mode;
    default:
      return msg::Reason::unknown_kind;
  }
}

/// Names the first axis of a refusal, and its owner.
void ControlModel::name_axis(std::uint16_t number, Answer& answer) {
  if (answer.refused_axis == 0) {
    answer.refused_axis = number;
    const Axis* const axis = axis_of(number);
    answer.owner = axis == nullptr ? 0 : axis->owner;
  }
}

msg::Reason ControlModel::read_objects(const msg::Request& request, Answer& answer) {
  msg::Reason reason = request.objects.empty() ? msg::Reason::nothing_done : msg::Reason::none;
  for (const auto& object : request.objects) {
    const Axis* const axis = axis_of(object.axis);
    answer.values.emplace_back();
    if (axis == nullptr) {
      reason = msg::Reason::unknown_axis;
      answer.codes.push_back(reason);
      name_axis(object.axis, answer);
      continue;
    }
    answer.codes.push_back(object.index == 0x2000 ? kNoObject : msg::Reason::none);
    if (object.index == 0x607A) {
      answer.values.back() = axis->registers.target;
    } else if (object.index == 0x6067) {
      answer.values.back() = axis->registers.stamp;
    }
  }
  return reason;
}

msg::Reason ControlModel::write_objects(const msg::Request& request, Answer& answer) {
  msg::Reason reason = request.objects.empty() ? msg::Reason::nothing_done : msg::Reason::none;
  for (const auto& object : request.objects) {
    const msg::Reason code = write_object(object, request.session, answer.codes.size());
    answer.codes.push_back(code);
    answer.values.emplace_back();
    if (code == msg::Reason::unknown_axis) reason = code;
    if (code == msg::Reason::unknown_axis || code == kLocalControl) name_axis(object.axis, answer);
  }
  return reason;
}

/// A stop by a session that does not own the axis: only the stop takes effect.
void ControlModel::stop(Axis& axis, std::uint16_t number, bool by_halt) {
  const std::uint16_t present = axis.registers.controlword;
  const auto word = by_halt ? static_cast<std::uint16_t>(present | kHalt) : kQuickStop;
  if (word == present) return;
  write(axis, number, {0x6040, 0}, word);
  drop_of_axis(number);
}

msg::Reason ControlModel::write_object(const msg::ObjectAccess& object, std::uint64_t session,
                                       std::size_t place) {
  Axis* const axis = axis_of(object.axis);
  if (axis == nullptr) return msg::Reason::unknown_axis;
  const bool is_strange = axis->owner != 0 && axis->owner != session;
  const bool is_quick_stop = object.index == 0x6040 && (object.value & 0x0096) == 0x0002;
  const bool is_halt = object.index == 0x6040 && (object.value & 0x019F) == kHaltOfOther;
  if ((is_quick_stop && (axis->owner == 0 || is_strange)) || (is_halt && is_strange)) {
    stop(*axis, object.axis, is_halt);
    return msg::Reason::none;
  }
  if (is_strange && !is_test_input(object.index)) return kLocalControl;
  if (is_store_object(object.index)) return store_by_write(*axis, object, place);
  const ObjectAddress address{object.index, object.subindex};
  if (axis->owner != 0 || !is_command_object(object.index)) {
    return write(*axis, object.axis, address, object.value);
  }
  if (session == 0) return kLocalControl;
  Session& record = find_or_add(session);
  if (record.must_acquire) return msg::Reason::stale_epoch;
  const msg::Reason code = write(*axis, object.axis, address, object.value);
  if (code == msg::Reason::none) {
    axis->owner = session;
    axis->last_sequence = 0;
    renew(record, false);
    record.last_message_tick = tick_;
    expect_event(msg::EventKind::control_changed, session);
  }
  return code;
}

// ---- stores -----------------------------------------------------------------------------------

msg::Reason ControlModel::store_axes(const msg::Request& request, Answer& answer) {
  if (stores_ == nullptr) return kCannotStore;
  if (const auto reason = refuse_strangers(request, false, answer); reason != msg::Reason::none) {
    return reason;
  }
  for (const std::uint16_t number : request.axes) {
    order(*axis_of(number), request.kind == msg::RequestKind::restore, StoreModel::kNoObject);
  }
  return msg::Reason::none;
}

msg::Reason ControlModel::store_by_write(Axis& axis, const msg::ObjectAccess& object,
                                         std::size_t place) {
  const bool forgets = object.index == kRestoreObject;
  if (object.value != (forgets ? kLoad : kSave) || stores_ == nullptr) return kCannotStore;
  order(axis, forgets, place);
  return msg::Reason::none;
}

/// Stores the current values of the registers.
void ControlModel::order(const Axis& axis, bool forget, std::size_t object) {
  StoreModel::Order order;
  order.request = last_storing_;
  order.axis = axis.number;
  order.object = object;
  if (!forget) {
    order.values = StoredValues{axis.registers.stamp, axis.registers.velocity};
  }
  stores_->order(order);
  ++ordered_;
}

void ControlModel::take_back_stores(std::size_t count) {
  for (; count > 0; --count) {
    const StoreModel::Order order = stores_->take_back();
    Storing& storing = storings_.at(order.request);
    if (!order.failed) {
      axis_of(order.axis)->memory = order.values;
    } else if (order.object == StoreModel::kNoObject) {
      storing.reason = kHardwareError;
      name_axis(order.axis, storing.answer);
    } else {
      storing.answer.codes[order.object] = kHardwareError;
    }
    if (--storing.orders == 0) {
      finish(storing.request, storing.reason, storing.answer);
      storings_.erase(order.request);
    }
  }
}

// ---- control ----------------------------------------------------------------------------------

msg::Reason ControlModel::refuse_strangers(const msg::Request& request, bool by_force,
                                           Answer& answer) {
  if (request.axes.empty()) return msg::Reason::nothing_done;
  for (const std::uint16_t number : request.axes) {
    const Axis* const axis = axis_of(number);
    const bool is_strange =
        axis != nullptr && axis->owner != 0 && axis->owner != request.session && !by_force;
    if (axis == nullptr || is_strange) {
      name_axis(number, answer);
      return axis == nullptr ? msg::Reason::unknown_axis : kLocalControl;
    }
  }
  return msg::Reason::none;
}

msg::Reason ControlModel::take(const msg::Request& request, bool by_force, Answer& answer) {
  if (request.session == 0) return msg::Reason::bad_session;
  if (const auto reason = refuse_strangers(request, by_force, answer);
      reason != msg::Reason::none) {
    return reason;
  }
  find_or_add(request.session);
  bool gained = false;
  for (const std::uint16_t number : request.axes) {
    Axis& axis = *axis_of(number);
    if (axis.owner == request.session) continue;
    if (Session* const loser = find(axis.owner)) {
      axis.owner = 0;
      renew(*loser, true);
      loser->must_acquire = true;
      drop_of_session(loser->id);
      expect_event(msg::EventKind::control_changed, loser->id);
    }
    axis.owner = request.session;
    axis.last_sequence = 0;
    gained = true;
  }
  Session& session = find_or_add(request.session);
  session.last_message_tick = tick_;
  session.must_acquire = false;
  if (gained) {
    renew(session, false);
    expect_event(msg::EventKind::control_changed, session.id);
  }
  return msg::Reason::none;
}

msg::Reason ControlModel::release(const msg::Request& request, Answer& answer) {
  if (request.session == 0) return msg::Reason::bad_session;
  if (!owns_any(request.session)) return msg::Reason::nothing_done;
  for (const std::uint16_t number : request.axes) {
    const Axis* const axis = axis_of(number);
    if (axis == nullptr || axis->owner != request.session) {
      name_axis(number, answer);
      return axis == nullptr ? msg::Reason::unknown_axis : msg::Reason::not_owner;
    }
  }
  for (std::size_t index = 0; index < axes_.size(); ++index) {
    const bool named =
        request.axes.empty() || std::ranges::find(request.axes, index + 1) != request.axes.end();
    if (named && axes_[index].owner == request.session) {
      axes_[index].owner = axes_[index].epoch = 0;
      axes_[index].last_sequence = 0;
    }
  }
  renew(*find(request.session), true);
  drop_of_session(request.session);
  expect_event(msg::EventKind::control_changed, request.session);
  return msg::Reason::none;
}

msg::Reason ControlModel::power_cycle(const msg::Request& request, Answer& answer) {
  if (const auto reason = refuse_strangers(request, false, answer); reason != msg::Reason::none) {
    return reason;
  }
  for (const std::uint16_t number : request.axes) {
    Axis& axis = *axis_of(number);
    drop_of_axis(number);
    power_up(axis);
    axis.causes.cycled = true;
  }
  return msg::Reason::none;
}

msg::Reason ControlModel::set_rate(const msg::Request& request) {
  if (configuration_.clock != service::ClockMode::realtime) return msg::Reason::wrong_clock_mode;
  const double rate = request.rate;
  if (rate != 0.0 && !(rate >= 0.1 && rate <= 100.0)) return msg::Reason::out_of_range;
  if (rate != rate_) {
    rate_ = rate;
    count_watchdog();
    for (Session& session : sessions_) session.last_message_tick = tick_;
  }
  return msg::Reason::none;
}

msg::Reason ControlModel::snapshot(const msg::Request& request, Answer& answer) {
  if (!time_stands()) return msg::Reason::time_passes;
  if (request.kind == msg::RequestKind::take_snapshot) {
    if (snapshots_.size() == kMostSnapshots) return msg::Reason::too_many_snapshots;
    auto& kept = snapshots_[++last_snapshot_];
    for (const Axis& axis : axes_) kept.push_back(axis.registers);
    return msg::Reason::none;
  }
  const auto kept = snapshots_.find(request.snapshot);
  if (kept == snapshots_.end()) return msg::Reason::unknown_snapshot;
  if (request.kind == msg::RequestKind::drop_snapshot) {
    snapshots_.erase(kept);
    return msg::Reason::none;
  }
  for (std::size_t index = 0; index < axes_.size(); ++index) {
    if (axes_[index].owner != 0 && axes_[index].owner != request.session) {
      name_axis(static_cast<std::uint16_t>(index + 1), answer);
      return kLocalControl;
    }
  }
  drop([](const msg::CommandFrame&) {
    return true;
  });
  for (std::size_t index = 0; index < axes_.size(); ++index) {
    axes_[index].registers = kept->second[index];
  }
  restored_ = true;
  return msg::Reason::none;
}

// ---- messages of the bench ---------------------------------------------------------------------

void ControlModel::check(const msg::CommandReply& reply) {
  FrameAnswer seen{.session = reply.session,
                   .sequence = reply.sequence_number,
                   .tick = reply.tick,
                   .is_wanted = reply.ignored_set_points.empty(),
                   .refusals = {}};
  for (const auto& refusal : reply.refusals) {
    seen.refusals.push_back({refusal.axis, refusal.index, refusal.subindex, refusal.reason});
  }
  // Without a refusal, an unrequested answer is sent only if a set-point was ignored.
  const auto is_due = [&](const FrameAnswer& due) {
    return due.session == seen.session && due.sequence == seen.sequence && due.tick == seen.tick &&
           due.refusals == seen.refusals && (due.is_wanted || !seen.is_wanted);
  };
  const auto is_skipped = [&](const FrameAnswer& due) {
    return due.is_repeat ? kept_of(due) == nullptr : !due.is_wanted && !is_due(due);
  };
  while (!frame_answers_.empty() && is_skipped(frame_answers_.front())) frame_answers_.pop_front();
  if (frame_answers_.empty()) {
    happenings_.fail(Invariant::kAnswered, 0, "no further answer to a frame", words_of(seen));
    return;
  }
  const FrameAnswer front = frame_answers_.front();
  const FrameAnswer& due = front.is_repeat ? *kept_of(front) : front;
  if (!is_due(due)) happenings_.fail(Invariant::kAnswered, 0, words_of(due), words_of(seen));
  frame_answers_.pop_front();
  if (front.is_kept) {
    frames_[seen.session].answered.insert(seen.sequence);
    keep(kept_frame_answers_, seen);
  }
}

/// @return the answer that the repeated frame must get, by the answers so far; nullptr = none.
const ControlModel::FrameAnswer* ControlModel::kept_of(const FrameAnswer& due) const {
  const auto kept = std::ranges::find_if(kept_frame_answers_, [&](const FrameAnswer& answer) {
    return answer.session == due.session && answer.sequence == due.sequence;
  });
  if (kept != kept_frame_answers_.end()) return &*kept;
  const auto numbers = frames_.find(due.session);
  const bool was_answered =
      numbers != frames_.end() && numbers->second.answered.contains(due.sequence);
  return was_answered ? &due : nullptr;
}

void ControlModel::check(const msg::Reply& reply) {
  const Answer seen{.client = reply.client,
                    .request_id = reply.request_id,
                    .reason = reply.reason,
                    .refused_axis = reply.refused_axis,
                    .owner = reply.owner_session,
                    .epoch = reply.epoch,
                    .last_sequence = reply.last_sequence,
                    .codes = {},
                    .values = {}};
  if (answers_.empty()) {
    happenings_.fail(Invariant::kAnswered, 0, "no further answer to a request", words_of(seen));
    return;
  }
  const Answer due = std::move(answers_.front());
  answers_.pop_front();
  if (head_of(due) != head_of(seen)) {
    happenings_.fail(Invariant::kAnswered, due.refused_axis, words_of(due), words_of(seen));
    return;
  }
  check_objects(due, reply);
}

void ControlModel::check_objects(const Answer& due, const msg::Reply& reply) {
  for (std::size_t place = 0; place < due.codes.size(); ++place) {
    const bool is_there = place < reply.objects.size();
    const msg::Reason code = is_there ? reply.objects[place].abort_code : msg::Reason::none;
    if (!is_there || code != due.codes[place]) {
      happenings_.fail(Invariant::kAnswered, is_there ? reply.objects[place].axis : 0,
                       text("object ", place, " code ", wire::number(due.codes[place])),
                       text("code ", wire::number(code)));
    } else if (due.values[place] && reply.objects[place].value != *due.values[place]) {
      happenings_.fail(Invariant::kCommanded, reply.objects[place].axis,
                       text("reads ", *due.values[place]),
                       text("reads ", reply.objects[place].value));
    }
  }
}

void ControlModel::check_stamp(std::uint16_t axis, std::uint32_t stamp) {
  if (stamp < kFirstStamp || stamp - kFirstStamp >= stamps_->size()) return;
  if (from_memory_.contains(stamp)) {
    return;  // it was checked when it was stored, perhaps in an earlier run
  }
  const Stamped& command = (*stamps_)[stamp - kFirstStamp];
  if (command.incarnation != 0 && command.incarnation != incarnation_) {
    happenings_.fail(Invariant::kRevoked, axis, text("commands for incarnation ", incarnation_),
                     text("one for ", command.incarnation));
  }
  const auto revoked = revocations_->find({command.incarnation, command.epoch});
  const bool stays = stamp == axes_[axis - 1U].registers.stamp;  // executed while it was current
  if (command.epoch != 0 && revoked != revocations_->end() && !stays) {
    happenings_.fail(Invariant::kRevoked, axis,
                     text("epoch ", command.epoch, " ended in tick ", revoked->second),
                     text("its command ", stamp, " of session ", command.session, " is in force"));
  }
}

void ControlModel::check(const msg::AxisParameters& parameters) {
  const std::uint16_t axis = parameters.axis;
  check_stamp(axis, parameters.position_target_reached_window);
  const Registers& due = axes_[axis - 1U].registers;
  const Registers seen{.controlword = parameters.ds402_controlword,
                       .mode = parameters.op_mode_cmd,
                       .target = parameters.position_user_target_value,
                       .stamp = parameters.position_target_reached_window,
                       .velocity = parameters.profile_velocity,
                       .test_inputs = due.test_inputs};
  if (seen != due) happenings_.fail(Invariant::kCommanded, axis, words_of(due), words_of(seen));
}

void ControlModel::check(const service::EventRecord& event) {
  if (event.kind == msg::EventKind::master_lost || event.kind == msg::EventKind::control_changed) {
    --events_[{event.kind, event.session}];
  }
}

void ControlModel::check_events() {
  for (const auto& [what, balance] : events_) {
    if (balance != 0) {
      const bool is_loss = what.first == msg::EventKind::master_lost;
      happenings_.fail(is_loss ? Invariant::kWatchdog : Invariant::kOwner, 0,
                       text(balance > 0 ? "an" : "no", " event of kind ", wire::number(what.first),
                            " about session ", what.second),
                       text(-balance, " too many"));
    }
  }
  events_.clear();
}

void ControlModel::check_owners(std::span<const wire::Ownership> owners) {
  for (std::size_t index = 0; index < axes_.size(); ++index) {
    const Axis& due = axes_[index];
    const wire::Ownership& seen = owners[index];
    if (due.owner != seen.session || due.epoch != seen.epoch ||
        due.last_sequence != seen.last_sequence) {
      happenings_.fail(
          Invariant::kOwner, index + 1,
          text("session ", due.owner, " epoch ", due.epoch, " frame ", due.last_sequence),
          text("session ", seen.session, " epoch ", seen.epoch, " frame ", seen.last_sequence));
    }
  }
}

void ControlModel::check_all_answered() {
  const auto is_settled = [this](const FrameAnswer& due) {
    return due.is_repeat ? kept_of(due) == nullptr : !due.is_wanted;
  };
  while (!frame_answers_.empty() && is_settled(frame_answers_.front())) frame_answers_.pop_front();
  if (!frame_answers_.empty()) {
    const FrameAnswer& due = frame_answers_.front();
    happenings_.fail(Invariant::kAnswered, 0,
                     text("an answer to frame ", due.sequence, " of session ", due.session),
                     "none");
  }
  if (!answers_.empty()) {
    happenings_.fail(Invariant::kAnswered, 0,
                     text("an answer to request ", answers_.front().request_id, " of client ",
                          answers_.front().client),
                     "none");
  }
}

}  // namespace vdrive::simulation
