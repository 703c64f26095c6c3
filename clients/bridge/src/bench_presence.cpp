// SPDX-License-Identifier: Apache-2.0
#include "bench_presence.hpp"

#include <algorithm>
#include <utility>

namespace vdrive::bridge {
namespace {

using Kind = PresenceChange::Kind;

void renew(BenchRecord& record, client::BenchInfo&& found, BenchRecord::Clock::time_point now) {
  record.newest_sample = now - found.sample_age;
  record.info = std::move(found);
}

}  // namespace

std::vector<PresenceChange> Presence::take(std::vector<client::BenchInfo> found,
                                           Clock::time_point now) {
  Changes changes;
  const std::scoped_lock lock(mutex_);
  for (client::BenchInfo& info : found) {
    const bool is_wanted =
        rules_.wanted.empty() || std::ranges::count(rules_.wanted, info.number) > 0;
    if (is_wanted && !info.axes.empty()) take_one(std::move(info), now, changes);
  }
  remove_ended(now, changes);
  return changes;
}

void Presence::take_one(client::BenchInfo&& found, Clock::time_point now, Changes& changes) {
  const std::uint32_t bench = found.number;
  const auto known = benches_.find(bench);
  if (known != benches_.end() && rules_.continues(known->second.info, found)) {
    if (known->second.info.incarnation != found.incarnation) {
      // It was found, so it is alive: a report of its silence may be older than this.
      known->second.is_alive = true;
      known->second.is_offline = false;
      changes.push_back({Kind::renewed, bench});
    }
    renew(known->second, std::move(found), now);
    return;
  }
  if (known != benches_.end()) {
    benches_.erase(known);
    changes.push_back({Kind::replaced, bench});
  }
  renew(benches_[bench], std::move(found), now);
  changes.push_back({Kind::came, bench});
}

void Presence::remove_ended(Clock::time_point now, Changes& changes) {
  std::erase_if(benches_, [&](const auto& entry) {
    const BenchRecord& record = entry.second;
    const bool has_gone = record.is_offline || now - record.newest_sample > rules_.patience;
    if (has_gone) changes.push_back({Kind::went, entry.first});
    return has_gone;
  });
}

void Presence::refresh(std::vector<client::BenchInfo> found, Clock::time_point now) {
  const std::scoped_lock lock(mutex_);
  for (client::BenchInfo& info : found) {
    const auto known = benches_.find(info.number);
    const bool is_same =
        known != benches_.end() && known->second.info.incarnation == info.incarnation;
    if (is_same) renew(known->second, std::move(info), now);
  }
}

void Presence::note(const client::ServiceChange& change, Clock::time_point now) {
  const std::scoped_lock lock(mutex_);
  const auto known = benches_.find(change.bench);
  if (known == benches_.end()) return;
  BenchRecord& record = known->second;
  record.is_offline = change.news == client::ServiceNews::went_offline;
  record.is_alive = !record.is_offline && change.news != client::ServiceNews::fell_silent;
  record.newest_sample = now - change.silence;
}

std::optional<BenchRecord> Presence::find(std::uint32_t bench) const {
  const std::scoped_lock lock(mutex_);
  const auto known = benches_.find(bench);
  if (known == benches_.end()) return std::nullopt;
  return known->second;
}

std::vector<BenchRecord> Presence::all() const {
  const std::scoped_lock lock(mutex_);
  std::vector<BenchRecord> records;
  records.reserve(benches_.size());
  for (const auto& [number, record] : benches_) records.push_back(record);
  return records;
}

}  // namespace vdrive::bridge
