// SPDX-License-Identifier: Apache-2.0
#include "roster.hpp"

#include <algorithm>
#include <set>
#include <utility>

namespace vdrive::bridge {
namespace {

void renew(BenchRecord& record, client::BenchInfo&& found, BenchRecord::Clock::time_point now) {
  record.newest_sample = now - found.sample_age;
  record.info = std::move(found);
}

}  // namespace

bool Roster::take(std::vector<client::BenchInfo> found, Clock::time_point now) {
  const Changes changes = compare(std::move(found), now);
  // Without the lock: the host may wait for its threads, and those may call the roster.
  for (const client::BenchInfo& bench : changes.renewed) host_.renew(bench);
  for (const auto& [bench, is_replaced] : changes.ended) host_.remove(bench, is_replaced);
  bool has_changed = !changes.ended.empty() || !changes.renewed.empty();
  for (const client::BenchInfo& bench : changes.unserved) {
    if (offer(bench)) has_changed = true;
  }
  return has_changed;
}

bool Roster::is_wanted(const client::BenchInfo& found) const {
  if (found.axes.empty()) return false;
  return wanted_.empty() || std::ranges::count(wanted_, found.number) > 0;
}

Roster::Changes Roster::compare(std::vector<client::BenchInfo>&& found, Clock::time_point now) {
  Changes changes;
  std::set<std::uint32_t> present;
  const std::scoped_lock lock(mutex_);
  for (client::BenchInfo& info : found) {
    if (!is_wanted(info)) continue;
    present.insert(info.number);
    compare_one(std::move(info), now, changes);
  }
  remove_ended(now, changes);
  for (auto& [number, record] : benches_) {
    if (!present.contains(number)) {
      record.left_out.clear();
    } else if (!record.is_served) {
      changes.unserved.push_back(record.info);
    }
  }
  return changes;
}

void Roster::compare_one(client::BenchInfo&& found, Clock::time_point now, Changes& changes) {
  const auto known = benches_.find(found.number);
  if (known == benches_.end() || !host_.continues(known->second.info, found)) {
    if (known != benches_.end()) {
      if (known->second.is_served) changes.ended.emplace_back(found.number, true);
      benches_.erase(known);
    }
    renew(benches_[found.number], std::move(found), now);
    return;
  }
  BenchRecord& record = known->second;
  if (record.info.incarnation != found.incarnation) {
    // It was just found, so it is alive; a report of its silence may be older.
    record.is_alive = true;
    record.is_offline = false;
    if (record.is_served) changes.renewed.push_back(found);
  }
  renew(record, std::move(found), now);
}

void Roster::remove_ended(Clock::time_point now, Changes& changes) {
  std::erase_if(benches_, [&](const auto& entry) {
    const BenchRecord& record = entry.second;
    const bool has_gone = record.is_offline || now - record.newest_sample > kPatience;
    if (has_gone && record.is_served) changes.ended.emplace_back(entry.first, false);
    return has_gone;
  });
}

/// @return whether the bench is now served.
bool Roster::offer(const client::BenchInfo& bench) {
  const std::optional<std::string> reason = host_.add(bench);
  {
    const std::scoped_lock lock(mutex_);
    BenchRecord& record = benches_.at(bench.number);
    record.is_served = !reason;
    const std::string before = std::exchange(record.left_out, reason.value_or(""));
    if (!reason || *reason == before) return !reason;
  }
  host_.leave_out(bench, *reason);
  return false;
}

void Roster::refresh(std::vector<client::BenchInfo> found, Clock::time_point now) {
  const std::scoped_lock lock(mutex_);
  for (client::BenchInfo& info : found) {
    const auto known = benches_.find(info.number);
    const bool is_same =
        known != benches_.end() && known->second.info.incarnation == info.incarnation;
    if (is_same) renew(known->second, std::move(info), now);
  }
}

void Roster::note(const client::ServiceChange& change, Clock::time_point now) {
  const std::scoped_lock lock(mutex_);
  const auto known = benches_.find(change.bench);
  if (known == benches_.end()) return;
  BenchRecord& record = known->second;
  record.is_offline = change.news == client::ServiceNews::went_offline;
  record.is_alive = !record.is_offline && change.news != client::ServiceNews::fell_silent;
  record.newest_sample = now - change.silence;
}

std::optional<BenchRecord> Roster::find(std::uint32_t bench) const {
  const std::scoped_lock lock(mutex_);
  const auto known = benches_.find(bench);
  if (known == benches_.end()) return std::nullopt;
  return known->second;
}

std::vector<BenchRecord> Roster::all() const {
  const std::scoped_lock lock(mutex_);
  std::vector<BenchRecord> records;
  records.reserve(benches_.size());
  for (const auto& [number, record] : benches_) records.push_back(record);
  return records;
}

std::map<std::uint32_t, std::string> Roster::left_out() const {
  const std::scoped_lock lock(mutex_);
  std::map<std::uint32_t, std::string> reasons;
  for (const auto& [number, record] : benches_) {
    if (!record.left_out.empty()) reasons.emplace(number, record.left_out);
  }
  return reasons;
}

}  // namespace vdrive::bridge
