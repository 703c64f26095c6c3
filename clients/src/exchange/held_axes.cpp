// SPDX-License-Identifier: Apache-2.0
#include "exchange/held_axes.hpp"

#include "base/drive_words.hpp"

#include <algorithm>
#include <utility>

namespace vdrive::client {

std::mutex& HeldAxes::send_mutex_of(std::uint32_t bench) {
  const std::scoped_lock lock(mutex_);
  return send_mutexes_[bench];
}

std::unique_lock<std::mutex> HeldAxes::lock_sending(std::uint32_t bench) {
  return std::unique_lock(send_mutex_of(bench));
}

std::unique_lock<std::mutex> HeldAxes::try_lock_sending(std::uint32_t bench) {
  return {send_mutex_of(bench), std::try_to_lock};
}

/// Called with the mutex held. Another run of the service starts empty.
HeldAxes::Holding& HeldAxes::holding(const BenchKey& key) {
  Holding& holding = held_axes_[key.number];
  if (holding.key != key) {
    holding = {};
    holding.key = key;
  }
  return holding;
}

bool HeldAxes::note_acquired(const BenchKey& key, std::span<const std::uint16_t> axes,
                             std::uint32_t epoch, bool needs_keep_alive) {
  const std::scoped_lock lock(mutex_);
  Holding& held = holding(key);
  const bool is_new = held.epoch != epoch;
  if (is_new) held.epoch_since = held.sequence + 1;
  held.epoch = epoch;
  held.needs_keep_alive = needs_keep_alive;
  held.axes.insert(axes.begin(), axes.end());
  return is_new;
}

void HeldAxes::note_answer(const msg::CommandReply& reply) {
  const bool is_lost = std::ranges::any_of(reply.refusals, [](const msg::Refusal& refusal) {
    return refusal.axis == 0 && (refusal.reason == msg::Reason::stale_epoch ||
                                 refusal.reason == msg::Reason::wrong_incarnation);
  });
  if (!is_lost) return;
  const BenchKey key{reply.bench, reply.incarnation};
  const std::scoped_lock lock(mutex_);
  const auto held = held_axes_.find(key.number);
  if (held == held_axes_.end() || held->second.key != key) return;
  if (reply.sequence_number >= held->second.epoch_since) held->second.axes.clear();
}

bool HeldAxes::holds(const BenchKey& key, std::span<const std::uint16_t> axes) {
  const std::scoped_lock lock(mutex_);
  const std::set<std::uint16_t>& held = holding(key).axes;
  return std::ranges::all_of(axes, [&held](std::uint16_t axis) {
    return held.contains(axis);
  });
}

void HeldAxes::note_running(const BenchKey& key, std::span<const std::uint16_t> axes,
                            std::uint64_t sequence) {
  const std::scoped_lock lock(mutex_);
  auto& running = holding(key).running;
  for (const std::uint16_t axis : axes) running[axis] = {.sequence = sequence};
}

bool HeldAxes::is_running(const BenchKey& key, std::uint16_t axis) {
  const std::scoped_lock lock(mutex_);
  return holding(key).running.contains(axis);
}

void HeldAxes::forget_running(const BenchKey& key, std::span<const std::uint16_t> axes) {
  const std::scoped_lock lock(mutex_);
  auto& running = holding(key).running;
  for (const std::uint16_t axis : axes) running.erase(axis);
}

void HeldAxes::note_seen(const BenchKey& key, std::span<const AxisSnapshot> axes) {
  // In the tick of the command an axis may still show the standstill of the previous mode.
  constexpr std::uint64_t kModeChange = 1;
  const std::scoped_lock lock(mutex_);
  const auto held = held_axes_.find(key.number);
  if (held == held_axes_.end() || held->second.key != key || held->second.running.empty()) return;
  for (const AxisSnapshot& axis : axes) {
    const auto found = held->second.running.find(axis.id.axis);
    if (found == held->second.running.end()) continue;
    Running& running = found->second;
    if (!running.since && axis.last_sequence >= running.sequence) running.since = axis.tick;
    const bool is_taken = axis.owner_session != 0 && axis.owner_session != session_;
    const bool counts = running.since && axis.tick > *running.since + kModeChange;
    if (is_taken || !is_driven(axis) || (counts && rests(axis))) held->second.running.erase(found);
  }
}

/// Called with the mutex held. Axes that are kept are left to the watchdog of the bench, which acts
/// when this session falls silent.
std::optional<ReleasedAxes> HeldAxes::give_back(Holding& held) {
  if (held.axes.empty()) return std::nullopt;
  ReleasedAxes given{.key = held.key, .axes = {}, .kept = {}};
  for (const std::uint16_t axis : held.axes) {
    (held.running.contains(axis) ? given.kept : given.axes).push_back(axis);
  }
  held.axes.clear();
  return given;
}

std::vector<ReleasedAxes> HeldAxes::drop_all() {
  const std::scoped_lock lock(mutex_);
  std::vector<ReleasedAxes> dropped;
  for (auto& [bench, held] : held_axes_) {
    if (auto given = give_back(held)) dropped.push_back(std::move(*given));
  }
  return dropped;
}

std::optional<ReleasedAxes> HeldAxes::drop(std::uint32_t bench) {
  const std::scoped_lock lock(mutex_);
  const auto held = held_axes_.find(bench);
  return held == held_axes_.end() ? std::nullopt : give_back(held->second);
}

std::vector<BenchKey> HeldAxes::to_keep_alive() const {
  const std::scoped_lock lock(mutex_);
  std::vector<BenchKey> keys;
  for (const auto& [bench, held] : held_axes_) {
    if (held.needs_keep_alive && !held.axes.empty()) keys.push_back(held.key);
  }
  return keys;
}

msg::CommandFrame HeldAxes::frame_of(Holding& held) const {
  msg::CommandFrame frame;
  frame.bench = held.key.number;
  frame.incarnation = held.key.incarnation;
  frame.session = session_;
  frame.epoch = held.epoch;
  frame.sequence_number = ++held.sequence;
  return frame;
}

msg::CommandFrame HeldAxes::next_frame(const BenchKey& key) {
  const std::scoped_lock lock(mutex_);
  return frame_of(holding(key));
}

std::optional<msg::CommandFrame> HeldAxes::next_keep_alive(const BenchKey& key) {
  const std::scoped_lock lock(mutex_);
  Holding& held = held_axes_.at(key.number);
  if (held.key != key) return std::nullopt;
  return frame_of(held);
}

std::uint64_t HeldAxes::last_sequence(const BenchKey& key) {
  const std::scoped_lock lock(mutex_);
  return holding(key).sequence;
}

}  // namespace vdrive::client
