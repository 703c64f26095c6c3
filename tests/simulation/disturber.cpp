// SPDX-License-Identifier: Apache-2.0
#include "simulation/disturber.hpp"

#include "support/programs/generator.hpp"

#include <algorithm>
#include <array>
#include <cerrno>

namespace vdrive::simulation {
namespace {

constexpr std::int64_t kLongestPause = 120 * kMillisecond;
constexpr std::uint64_t kFlood = 1'300;        // more than the inbox holds
constexpr std::uint64_t kMostOperations = 24;  // of a save, with both halves of its writes
constexpr std::array<double, 6> kRates{1.0, 0.5, 2.0, 10.0, 0.0, 200.0};

}  // namespace

struct Disturber::Present {
  const View& view;
  Bench& bench;
  SimulatedTime& time;
  Post& post;
};

/// A kind of disturbance. A new kind is a row.
struct Disturber::Disturbance {
  std::uint64_t weight;
  bool Disturbances::*group;
  void (Disturber::*happen)(const Present&);
};

const std::vector<Disturber::Disturbance>& Disturber::disturbances() {
  static const std::vector<Disturbance> rows{
      {200, &Disturbances::test_bench, &Disturber::set_input},
      {260, &Disturbances::test_bench, &Disturber::heal},
      {60, &Disturbances::test_bench, &Disturber::power_cycle},
      {20, &Disturbances::test_bench, &Disturber::take_snapshot},
      {20, &Disturbances::test_bench, &Disturber::restore_snapshot},
      {10, &Disturbances::test_bench, &Disturber::drop_snapshot},
      {30, &Disturbances::test_bench, &Disturber::change_rate},
      {40, &Disturbances::test_bench, &Disturber::read},
      {30, &Disturbances::host, &Disturber::stall},
      {20, &Disturbances::host, &Disturber::hold_answers},
      {2, &Disturbances::host, &Disturber::flood},
      {5, &Disturbances::restarts, &Disturber::restart},
      {40, &Disturbances::disk, &Disturber::store},
      {16, &Disturbances::disk, &Disturber::fill_disk},
      {16, &Disturbances::disk, &Disturber::fail_save},
      {4, &Disturbances::disk, &Disturber::kill_in_save},
  };
  return rows;
}

Disturber::Disturber(std::size_t place, const Disturbances& which, std::uint64_t seed, Disk& disk,
                     Happenings& happenings)
    : place_(place),
      which_(which),
      random_(seed),
      disk_(disk),
      happenings_(happenings),
      client_(random_.bits() | 1U) {}

void Disturber::act(const View& view, Bench& bench, SimulatedTime& time, Post& post) {
  now_ = next_;
  next_ = now_ + random_.between(kMillisecond, kLongestPause);
  const Present present{view, bench, time, post};
  std::uint64_t all = 0;
  for (const Disturbance& row : disturbances()) all += row.weight;
  std::uint64_t choice = random_.below(all);
  for (const Disturbance& row : disturbances()) {
    if (choice < row.weight) {
      if (which_.*row.group) (this->*row.happen)(present);
      break;
    }
    choice -= row.weight;
  }
  if (bench.rate() == 0.0 && random_.per_mille(300)) {  // no actor waits for ever
    msg::Request request = new_request(msg::RequestKind::set_rate);
    request.rate = 1.0;
    this->post(std::move(request), present);
  }
}

void Disturber::on(const msg::Reply& reply) {
  if (reply.client == client_ && reply.snapshot != 0) last_snapshot_ = reply.snapshot;
}

bool Disturber::wants_restart() {
  return std::exchange(wants_restart_, false);
}

msg::Request Disturber::new_request(msg::RequestKind kind) {
  msg::Request request;
  request.client = client_;
  request.request_id = ++last_request_;
  request.bench = kBench;
  request.kind = kind;
  return request;
}

void Disturber::post(msg::Request request, const Present& present) {
  happenings_.record("test bench requests", {request.request_id, wire::number(request.kind)});
  present.post.send(place_, std::move(request), now_);
}

void Disturber::set_input(const Present& present) {
  if (ailments_.size() >= 4) return;
  auto request = new_request(msg::RequestKind::write);
  auto& object = request.objects.emplace_back();
  object.axis = static_cast<std::uint16_t>(1 + random_.below(present.view.statuses.size()));
  const test::Write disturbance = test::draw_disturbance(random_);
  object.index = disturbance.object.index;
  object.value = disturbance.value;
  ailments_.push_back({object.axis, object.index});
  post(std::move(request), present);
}

/// Clears a disturbance repeatedly until the bench shows that it is cleared, because a message may
/// be lost.
void Disturber::heal(const Present& present) {
  auto request = new_request(msg::RequestKind::write);
  for (const Ailment& ailment : ailments_) {
    auto& object = request.objects.emplace_back();
    object.axis = ailment.axis;
    object.index = ailment.index;
  }
  std::erase_if(ailments_, [&](const Ailment& ailment) {
    return present.bench.model()
               .registers(ailment.axis - 1U)
               .test_inputs[ailment.index - 0x5E00U] == 0;
  });
  if (!request.objects.empty()) post(std::move(request), present);
}

void Disturber::power_cycle(const Present& present) {
  auto request = new_request(msg::RequestKind::power_cycle);
  for (std::uint64_t count = random_.below(3); count > 0; --count) {
    request.axes.push_back(
        static_cast<std::uint16_t>(random_.below(present.view.statuses.size() + 1)));
  }
  post(std::move(request), present);
}

void Disturber::take_snapshot(const Present& present) {
  post(new_request(msg::RequestKind::take_snapshot), present);
}

void Disturber::restore_snapshot(const Present& present) {
  auto request = new_request(msg::RequestKind::restore_snapshot);
  request.snapshot = last_snapshot_;
  post(std::move(request), present);
}

void Disturber::drop_snapshot(const Present& present) {
  auto request = new_request(msg::RequestKind::drop_snapshot);
  request.snapshot = last_snapshot_;
  post(std::move(request), present);
}

void Disturber::change_rate(const Present& present) {
  auto request = new_request(msg::RequestKind::set_rate);
  request.rate = random_.pick<double>(kRates);
  post(std::move(request), present);
}

void Disturber::read(const Present& present) {
  auto request = new_request(msg::RequestKind::read);
  for (std::uint64_t count = random_.below(msg::MAX_OBJECTS_PER_REQUEST + 1); count > 0; --count) {
    auto& object = request.objects.emplace_back();
    object.axis = static_cast<std::uint16_t>(random_.below(present.view.statuses.size() + 2));
    object.index = 0x607A;
  }
  post(std::move(request), present);
}

/// Stops the tick thread for a while: late ticks, a backlog, or a jump.
void Disturber::stall(const Present& present) {
  present.time.late = random_.per_mille(800)
                          ? random_.between(100 * kMicrosecond, 90 * kMillisecond)
                          : random_.between(100 * kMillisecond, 3'000 * kMillisecond);
  happenings_.record("the clock stalls", {static_cast<std::uint64_t>(present.time.late)});
}

void Disturber::hold_answers(const Present& present) {
  present.bench.hold_answers(now_ + random_.between(kMillisecond, 300 * kMillisecond));
  happenings_.record("answers are held", {});
}

void Disturber::flood(const Present& present) {
  happenings_.record("a flood", {});
  for (std::uint64_t count = 0; count < kFlood; ++count) {
    auto request = new_request(msg::RequestKind::read);
    present.post.send(place_, std::move(request), now_);
  }
}

void Disturber::restart(const Present& /*present*/) {
  wants_restart_ = true;
}

void Disturber::store(const Present& present) {
  auto request =
      new_request(random_.per_mille(750) ? msg::RequestKind::store : msg::RequestKind::restore);
  for (std::uint64_t count = random_.below(4); count > 0; --count) {
    request.axes.push_back(
        static_cast<std::uint16_t>(random_.below(present.view.statuses.size() + 1)));
  }
  post(std::move(request), present);
}

/// Fills the disk or, more often, makes room again.
void Disturber::fill_disk(const Present& /*present*/) {
  const bool full = random_.per_mille(200);
  disk_.fill(full);
  happenings_.record("the disk is full", {full ? 1U : 0U});
}

void Disturber::fail_save(const Present& /*present*/) {
  constexpr std::array kErrors{EIO, ENOSPC, EROFS, EDQUOT, EACCES};
  const auto operation = 1 + random_.below(kMostOperations);
  const int error = random_.pick<int>(kErrors);
  disk_.fail_in(operation, error);
  happenings_.record("the disk fails", {operation, static_cast<std::uint64_t>(error)});
}

void Disturber::kill_in_save(const Present& /*present*/) {
  const auto operation = 1 + random_.below(kMostOperations);
  disk_.kill_in(operation);
  happenings_.record("the next save is cut short", {operation});
}

}  // namespace vdrive::simulation
