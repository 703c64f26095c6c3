// SPDX-License-Identifier: Apache-2.0
#include "simulation/master.hpp"

#include "support/programs/generator.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <algorithm>
#include <array>

namespace vdrive::simulation {
namespace {

constexpr std::int64_t kKeepAlive = 25 * kMillisecond;
constexpr std::int8_t kNoMode = 5;  // no valid mode of 6060h

void assign(auto& object, const test::Write& write) {
  object.index = write.object.index;
  object.subindex = write.object.subindex;
  object.value = write.value;
}

void add_object(msg::AxisCommand& command, const test::Write& write) {
  assign(command.objects.emplace_back(), write);
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

/// The program starts or restarts, with no knowledge of earlier runs.
void Master::begin_session() {
  session_ = random_.bits() | 1U;
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

/// Falls silent, is stopped and continued, or restarts.
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

/// The status of an owned axis carries the same epoch as an answer, and cannot be lost for long.
void Master::look_up_epoch(const View& view) {
  for (const wire::Ownership& owner : view.owners) {
    if (owner.session == session_) epoch_ = owner.epoch;
  }
}

/// Guesses the next epoch of the bench. The guess is right if no other master is faster: then
/// commands in this epoch arrive right after the change of owner. Otherwise they are in the epoch
/// of the other master.
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

/// Reads, and writes to command objects and others, on own axes, free axes and those of others.
void Master::send_request(const View& view, Post& post) {
  constexpr std::array<std::uint16_t, 8> kRead{0x607A, 0x6067, 0x6041, 0x6064,
                                               0x607A, 0x6067, 0x603F, 0x2000};
  const bool writes = random_.per_mille(500);
  auto request = new_request(writes ? msg::RequestKind::write : msg::RequestKind::read);
  for (std::uint64_t count = random_.below(4); count > 0; --count) {
    auto& object = request.objects.emplace_back();
    object.axis = static_cast<std::uint16_t>(1 + random_.below(view.statuses.size()));
    if (writes) {
      assign(object, any_write(view.statuses[object.axis - 1U], request));
    } else {
      object.index = random_.pick<std::uint16_t>(kRead);
    }
  }
  if (random_.per_mille(temper_.rudeness)) request.client = 0;
  this->post(std::move(request), post);
}

test::Write Master::any_write(const AxisStatus& status, const msg::Request& request) {
  switch (random_.below(6)) {
    case 0:
      return {{0x6040, 0}, test::draw_controlword(status, random_)};
    case 1:
      return {{0x607A, 0}, random_.between(-20, 20) * test::kUnitsPerTurn};
    case 2:
      return {{0x60FF, 0}, random_.between(-120'000, 120'000)};
    case 3:
      return {{0x6060, 0}, random_.per_mille(900) ? test::draw_mode(random_) : kNoMode};
    case 4:
      return test::draw_setting(random_);
    default:
      return {{0x6067, 0}, new_stamp(request.incarnation, 0)};
  }
}

/// Stores axes or deletes what is stored, as a request or through their objects.
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
    const bool is_restored = forgets != random_.per_mille(temper_.rudeness);
    const std::uint16_t index = forgets ? 0x1011 : 0x1010;
    assign(object, {{index, 1}, is_restored ? kRestoreSignature : kStoreSignature});
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

/// Spoils one member, as a program with a bug would.
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

/// A command that suits the state of the axis, with a stamp that identifies its sender.
void Master::fill(msg::AxisCommand& command, const AxisStatus& status,
                  const msg::CommandFrame& frame) {
  add_object(command, {{0x6067, 0}, new_stamp(frame.incarnation, frame.epoch)});
  if (random_.per_mille(850)) {
    add_member(command, msg::HAS_DS402_CONTROLWORD);
    command.ds402_controlword = test::draw_controlword(status, random_);
  }
  if (status.op_mode_actual == 0 || random_.per_mille(40)) {
    add_member(command, msg::HAS_OP_MODE_CMD);
    command.op_mode_cmd = random_.per_mille(980) ? test::draw_mode(random_) : kNoMode;
  }
  if (random_.per_mille(300)) {
    add_member(command, msg::HAS_PROFILE_VELOCITY);
    command.profile_velocity = static_cast<std::uint32_t>(random_.between(1'000, 130'000));
  }
  const test::Write set_point = test::draw_set_point(status, random_);
  if (set_point.object == ObjectAddress{0x607A, 0}) {
    add_member(command, msg::HAS_POSITION_USER_TARGET_VALUE);
    command.position_user_target_value = static_cast<std::int32_t>(set_point.value);
  } else {
    add_object(command, set_point);
  }
  if (random_.per_mille(60)) add_object(command, test::draw_setting(random_));
  if (random_.per_mille(temper_.rudeness)) {
    const std::uint16_t index = random_.per_mille(500) ? 0x6041 : 0x6040;
    add_object(command, {{index, 0}, 0});
  }
}

// ---- answers -----------------------------------------------------------------------------------

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
