// SPDX-License-Identifier: Apache-2.0
#include "simulation/master.hpp"

#include "vdrive/cia402/homing_method.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/cia402/power_state.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <algorithm>
#include <array>

namespace vdrive::simulation {
namespace {

constexpr std::int64_t kKeepAlive = 25 * kMillisecond;
constexpr std::int64_t kUnitsPerTurn = 4'096;
constexpr std::array<std::uint16_t, 22> kWordsInOperation{
    0x000F, 0x000F, 0x000F, 0x000F, 0x000F, 0x000F, 0x000F, 0x001F, 0x001F, 0x001F, 0x001F,
    0x001F, 0x003F, 0x003F, 0x005F, 0x007F, 0x007F, 0x010F, 0x0002, 0x0006, 0x0007, 0x0000};
constexpr std::int8_t kNoMode = 5;  // of 6060h

/// What masters set beside their set-points: offsets, touch probes, 60C2h, the buffer of records,
/// ways round the range of a modulo axis.
struct Setting {
  ObjectAddress address;
  std::array<std::int64_t, 6> values;
};

constexpr std::array kSettings{Setting{{0x60B0, 0}, {0, 0, 100, -100, 50, -50}},
                               Setting{{0x60B1, 0}, {0, 0, 2'000, -2'000, 5'000, -5'000}},
                               Setting{{0x60B2, 0}, {0, 0, 50, -50, 200, -200}},
                               Setting{{0x60B8, 0}, {0, 0x0011, 0x0033, 0x0037, 0x3300, 0x373B}},
                               Setting{{0x60C2, 1}, {0, 1, 2, 4, 10, 20}},
                               Setting{{0x60C4, 2}, {1, 1, 1, 2, 4, 16}},
                               Setting{{0x60C4, 6}, {0, 1, 1, 1, 1, 1}},
                               Setting{{0x60D0, 1}, {1, 2, 3, 5, 1, 5}},
                               Setting{{0x60F2, 0}, {0, 1, 2, 2 + 64, 2 + 128, 2 + 192}}};

std::int32_t near_to(std::int32_t value, std::int64_t change) {
  return static_cast<std::int32_t>(std::clamp<std::int64_t>(value + change, INT32_MIN, INT32_MAX));
}

void add_object(msg::AxisCommand& command, ObjectAddress address, std::int64_t value) {
  auto& object = command.objects.emplace_back();
  object.index = address.index;
  object.subindex = address.subindex;
  object.value = value;
}

void add_member(msg::AxisCommand& command, std::uint16_t member) {
  command.members |= member;
}

}  // namespace

Master::Master(std::size_t place, const Temper& temper, std::uint64_t seed, Stamps& stamps,
               Happenings& happenings)
    : place_(place), temper_(temper), random_(seed), stamps_(stamps), happenings_(happenings) {
  begin_session();
}

/// The program starts, or starts again: without knowledge of earlier runs.
void Master::begin_session() {
  session_ = random_.next() | 1U;
  client_ = session_;
  last_request_ = 0;
  epoch_ = 0;
  sequence_ = 0;
  happenings_.record("begins a session", {place_, session_});
}

void Master::act(const View& view, Post& post) {
  now_ = next_;
  next_ = now_ + random_.between(200 * kMicrosecond, temper_.longest_pause);
  if (incarnation_ != view.incarnation && random_.per_mille(300)) {  // it takes time to notice
    incarnation_ = view.incarnation;
    epoch_ = 0;
    sequence_ = 0;
  }
  if (incarnation_ == view.incarnation && random_.per_mille(temper_.haste)) look_up_epoch(view);
  if (random_.per_mille(temper_.lapses)) {
    lapse(post);
    return;
  }
  const std::uint64_t choice = random_.below(1'000);
  if (choice < temper_.greed) {
    take_axes(view, post, true);
  } else if (choice >= 990 || (epoch_ == 0 && choice < 600)) {
    take_axes(view, post, false);
  } else if (choice >= 985) {
    release(view, post);
  } else if (choice >= 978) {
    store(view, post);
  } else if (choice >= 900) {
    send_request(view, post);
  } else if (epoch_ == 0 || choice >= 300 || now_ - last_frame_ >= kKeepAlive) {
    send_frame(view, post);
  }
}

/// Silence, a program that is stopped and continued, or one that restarts.
void Master::lapse(Post& post) {
  const std::int64_t until = now_ + random_.between(50 * kMillisecond, 700 * kMillisecond);
  switch (random_.below(3)) {
    case 0:
      happenings_.record("falls silent", {place_});
      break;
    case 1:
      happenings_.record("stands still", {place_});
      post.hold_back(place_, until);
      break;
    default:
      begin_session();
      break;
  }
  next_ = until;
}

std::vector<std::uint16_t> Master::some_axes(const View& view) {
  std::vector<std::uint16_t> axes;
  const auto share = static_cast<std::uint64_t>(random_.between(100, 900));
  for (std::size_t index = 0; index < view.statuses.size(); ++index) {
    if (random_.per_mille(share)) axes.push_back(static_cast<std::uint16_t>(index + 1));
  }
  if (random_.per_mille(temper_.rudeness)) {
    axes.push_back(static_cast<std::uint16_t>(random_.below(view.statuses.size() + 2)));
  }
  return axes;
}

std::uint32_t Master::new_stamp(std::uint64_t incarnation, std::uint32_t epoch) {
  stamps_.push_back({.incarnation = incarnation, .session = session_, .epoch = epoch});
  return kFirstStamp + static_cast<std::uint32_t>(stamps_.size()) - 1;
}

void Master::post(msg::CommandFrame frame, Post& post) {
  happenings_.record("sends frame", {place_, frame.session, frame.epoch, frame.sequence_number,
                                     frame.apply_at_tick, frame.flags, frame.axes.size()});
  last_frame_ = now_;
  post.send(place_, std::move(frame), now_);
}

void Master::post(msg::Request request, Post& post) {
  happenings_.record("sends request", {place_, request.session, request.request_id,
                                       wire::number(request.kind), request.axes.size()});
  post.send(place_, std::move(request), now_);
}

msg::Request Master::new_request(msg::RequestKind kind) {
  msg::Request request;
  request.client = client_;
  request.request_id = ++last_request_;
  request.bench = kBench;
  request.incarnation = random_.per_mille(100) ? 0 : incarnation_;
  request.session = session_;
  request.kind = kind;
  return request;
}

void Master::take_axes(const View& view, Post& post, bool by_force) {
  auto request = new_request(by_force ? msg::RequestKind::take_over : msg::RequestKind::acquire);
  request.axes = some_axes(view);
  if (random_.per_mille(temper_.haste)) guess_epoch(view);
  this->post(std::move(request), post);
}

/// The status of an owned axis gives what an answer would, and cannot be lost for long.
void Master::look_up_epoch(const View& view) {
  for (const wire::Ownership& owner : view.owners) {
    if (owner.session == session_) epoch_ = owner.epoch;
  }
}

/// The next epoch of the bench, unless another master is faster: commands in this one arrive right
/// behind the change of hands, and in that of another where somebody was.
void Master::guess_epoch(const View& view) {
  for (const wire::Ownership& owner : view.owners) epoch_ = std::max(epoch_, owner.epoch);
  ++epoch_;
}

void Master::release(const View& view, Post& post) {
  auto request = new_request(msg::RequestKind::release);
  if (random_.per_mille(500)) {
    request.axes.push_back(static_cast<std::uint16_t>(1 + random_.below(view.statuses.size())));
  }
  this->post(std::move(request), post);
}

/// Reads, and writes of command objects and others, to own axes, free ones and those of others.
void Master::send_request(const View& view, Post& post) {
  constexpr std::array<std::uint16_t, 8> kRead{0x607A, 0x6067, 0x6041, 0x6064,
                                               0x607A, 0x6067, 0x603F, 0x2000};
  const bool writes = random_.per_mille(500);
  auto request = new_request(writes ? msg::RequestKind::write : msg::RequestKind::read);
  for (std::uint64_t count = random_.below(4); count > 0; --count) {
    auto& object = request.objects.emplace_back();
    object.axis = static_cast<std::uint16_t>(1 + random_.below(view.statuses.size()));
    if (!writes) {
      object.index = random_.pick<std::uint16_t>(kRead);
      continue;
    }
    write_any(object, view, request);
  }
  if (random_.per_mille(temper_.rudeness)) request.client = 0;
  this->post(std::move(request), post);
}

void Master::write_any(msg::ObjectAccess& object, const View& view, const msg::Request& request) {
  switch (random_.below(6)) {
    case 0:
      object.index = 0x6040;
      object.value = word_for(view.statuses[object.axis - 1U]);
      break;
    case 1:
      object.index = 0x607A;
      object.value = random_.between(-20, 20) * kUnitsPerTurn;
      break;
    case 2:
      object.index = 0x60FF;
      object.value = random_.between(-120'000, 120'000);
      break;
    case 3:
      object.index = 0x6060;
      object.value = random_.per_mille(900) ? draw_mode() : kNoMode;
      break;
    case 4: {
      const Setting& setting = random_.pick<Setting>(kSettings);
      object.index = setting.address.index;
      object.subindex = setting.address.subindex;
      object.value = random_.pick<std::int64_t>(setting.values);
      break;
    }
    default:
      object.index = 0x6067;
      object.value = new_stamp(request.incarnation, 0);
      break;
  }
}

/// Stores or forgets axes, as a request or by their objects.
void Master::store(const View& view, Post& post) {
  const bool forgets = random_.per_mille(250);
  const bool writes = random_.per_mille(300);
  auto request =
      new_request(writes ? msg::RequestKind::write
                         : (forgets ? msg::RequestKind::restore : msg::RequestKind::store));
  for (std::int64_t count = random_.between(1, 3); count > 0; --count) {
    const auto axis = static_cast<std::uint16_t>(1 + random_.below(view.statuses.size()));
    if (!writes) {
      request.axes.push_back(axis);
      continue;
    }
    auto& object = request.objects.emplace_back();
    object.axis = axis;
    object.index = forgets ? 0x1011 : 0x1010;
    object.subindex = 1;
    object.value =
        forgets != random_.per_mille(temper_.rudeness) ? kRestoreSignature : kStoreSignature;
  }
  this->post(std::move(request), post);
}

msg::CommandFrame Master::new_frame(const View& view) {
  msg::CommandFrame frame;
  frame.bench = kBench;
  frame.incarnation = incarnation_ == 0 ? view.incarnation : incarnation_;
  frame.session = session_;
  frame.epoch = epoch_;
  frame.sequence_number = ++sequence_;
  return frame;
}

void Master::send_frame(const View& view, Post& post) {
  if (random_.per_mille(temper_.rudeness) && old_frame_.sequence_number != 0) {
    this->post(old_frame_, post);  // once more
    return;
  }
  msg::CommandFrame frame = new_frame(view);
  time_frame(view, frame);
  frame.flags = (random_.per_mille(200) ? msg::FRAME_ALL_OR_NOTHING : 0U) |
                (random_.per_mille(30) ? msg::FRAME_CANCEL_PENDING : 0U) |
                (random_.per_mille(500) ? msg::FRAME_WANT_REPLY : 0U);
  const auto share =
      static_cast<std::uint64_t>(random_.per_mille(200) ? 0 : random_.between(50, 600));
  for (std::size_t index = 0; index < view.statuses.size(); ++index) {
    if (random_.per_mille(share)) {
      auto& command = frame.axes.emplace_back();
      command.axis = static_cast<std::uint16_t>(index + 1);
      fill(command, view.statuses[index], frame);
    }
  }
  if (random_.per_mille(temper_.rudeness)) spoil(frame);
  if (random_.per_mille(100)) old_frame_ = frame;
  this->post(std::move(frame), post);
}

void Master::time_frame(const View& view, msg::CommandFrame& frame) {
  if (random_.per_mille(250)) {
    const std::int64_t ahead = random_.per_mille(20) ? 20'000 : random_.between(-3, 150);
    frame.apply_at_tick = static_cast<std::uint64_t>(
        std::max<std::int64_t>(1, static_cast<std::int64_t>(view.tick) + ahead));
  }
  if (random_.per_mille(150)) {
    frame.valid_until_tick = std::max(view.tick, frame.apply_at_tick) + random_.below(20);
  }
}

/// One member is wrong, as in a program with a mistake.
void Master::spoil(msg::CommandFrame& frame) {
  switch (random_.below(7)) {
    case 0:
      ++frame.epoch;
      break;
    case 1:
      --frame.epoch;
      break;
    case 2:
      frame.flags |= 0x10U;
      break;
    case 3:
      frame.session = 0;
      break;
    case 4:
      frame.axes.emplace_back().axis = static_cast<std::uint16_t>(random_.below(100));
      break;
    case 5:
      if (!frame.axes.empty()) frame.axes.push_back(frame.axes.front());
      break;
    default:
      if (!frame.axes.empty()) frame.axes.back().members = 0x80;
      break;
  }
}

std::uint16_t Master::word_for(const AxisStatus& status) {
  switch (decode_power_state(status.ds402_statusword)) {
    case PowerState::fault:
      return random_.per_mille(700) ? 0x0080 : 0x000F;
    case PowerState::switch_on_disabled:
      return random_.per_mille(700) ? 0x000F : 0x0006;
    case PowerState::ready_to_switch_on:
      return random_.per_mille(700) ? 0x000F : 0x0007;
    case PowerState::operation_enabled:
      return random_.pick<std::uint16_t>(kWordsInOperation);
    default:
      return 0x000F;
  }
}

/// Profile position most often, else any mode or none.
std::int8_t Master::draw_mode() {
  const OperatingMode mode = random_.per_mille(300)
                                 ? OperatingMode::profile_position
                                 : random_.pick<OperatingModeRow>(kOperatingModes).mode;
  return static_cast<std::int8_t>(mode);
}

/// What the mode in force takes: targets anywhere, streamed ones near to the demand.
void Master::add_set_point(msg::AxisCommand& command, const AxisStatus& status) {
  switch (static_cast<OperatingMode>(status.op_mode_actual)) {
    case OperatingMode::velocity:
      add_object(command, {0x6042, 0}, random_.between(-2'200, 2'200));
      break;
    case OperatingMode::profile_velocity:
      add_object(command, {0x60FF, 0}, random_.between(-120'000, 120'000));
      break;
    case OperatingMode::profile_torque:
    case OperatingMode::cyclic_synchronous_torque:
      add_object(command, {0x6071, 0}, random_.between(-800, 800));
      break;
    case OperatingMode::homing:
      add_object(command, {0x6098, 0}, random_.pick<HomingMethodRow>(kHomingMethods).number);
      break;
    case OperatingMode::interpolated_position:
      add_object(command, {0x60C1, 1},
                 near_to(status.position_demand_value, random_.between(-200, 200)));
      break;
    case OperatingMode::cyclic_synchronous_position:
      add_member(command, msg::HAS_POSITION_USER_TARGET_VALUE);
      command.position_user_target_value =
          near_to(status.position_demand_value, random_.between(-200, 200));
      break;
    case OperatingMode::cyclic_synchronous_velocity:
      add_object(command, {0x60FF, 0},
                 near_to(status.velocity_demand_value, random_.between(-10'000, 10'000)));
      break;
    default:
      add_member(command, msg::HAS_POSITION_USER_TARGET_VALUE);
      command.position_user_target_value =
          static_cast<std::int32_t>(random_.between(-20 * kUnitsPerTurn, 20 * kUnitsPerTurn));
      break;
  }
}

void Master::add_setting(msg::AxisCommand& command) {
  const Setting& setting = random_.pick<Setting>(kSettings);
  add_object(command, setting.address, random_.pick<std::int64_t>(setting.values));
}

/// A command that suits the state of the axis, with a stamp that identifies its sender.
void Master::fill(msg::AxisCommand& command, const AxisStatus& status,
                  const msg::CommandFrame& frame) {
  add_object(command, {0x6067, 0}, new_stamp(frame.incarnation, frame.epoch));
  if (random_.per_mille(850)) {
    add_member(command, msg::HAS_DS402_CONTROLWORD);
    command.ds402_controlword = word_for(status);
  }
  if (status.op_mode_actual == 0 || random_.per_mille(40)) {
    add_member(command, msg::HAS_OP_MODE_CMD);
    command.op_mode_cmd = random_.per_mille(980) ? draw_mode() : kNoMode;
  }
  if (random_.per_mille(300)) {
    add_member(command, msg::HAS_PROFILE_VELOCITY);
    command.profile_velocity = static_cast<std::uint32_t>(random_.between(1'000, 130'000));
  }
  add_set_point(command, status);
  if (random_.per_mille(60)) add_setting(command);
  if (random_.per_mille(temper_.rudeness)) {
    const std::uint16_t index = random_.per_mille(500) ? 0x6041 : 0x6040;
    add_object(command, {index, 0}, 0);
  }
}

// ---- what comes back --------------------------------------------------------------------------

void Master::on(const msg::Reply& reply) {
  if (reply.client != client_ || reply.incarnation != incarnation_) return;
  epoch_ = std::max(epoch_, reply.epoch);  // an earlier answer may arrive later
  if (reply.epoch == 0) epoch_ = 0;
}

void Master::on(const msg::CommandReply& reply) {
  if (reply.session != session_ || reply.incarnation != incarnation_) return;
  const bool gone = std::ranges::any_of(reply.refusals, [](const msg::Refusal& refusal) {
    return refusal.axis == 0 && refusal.reason == msg::Reason::stale_epoch;
  });
  if (gone && random_.per_mille(300)) epoch_ = 0;
}

}  // namespace vdrive::simulation
