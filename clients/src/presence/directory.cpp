// SPDX-License-Identifier: Apache-2.0
#include "presence/directory.hpp"

#include "vdrive/wire/conversion.hpp"
#include "vdrive_messages_description.hpp"

#include <algorithm>

namespace vdrive::client {
namespace {

AxisInfo axis_info(std::uint32_t bench, const msg::AxisDescription& axis) {
  return {.id = {bench, axis.axis},
          .name = axis.name.to_string(),
          .supported_drive_modes = axis.supported_drive_modes,
          .user_position_lower_limit = axis.user_position_lower_limit,
          .user_position_upper_limit = axis.user_position_upper_limit,
          .app_speed_limit = axis.app_speed_limit,
          .unit = wire::unit_of(axis)};
}

void describe(BenchInfo& info, const msg::BenchDescription& message) {
  info.number = message.bench;
  info.incarnation = message.incarnation;
  info.name = message.name.to_string();
  info.clock_mode = wire::from_message(message.clock_mode);
  info.period = std::chrono::microseconds(std::max<std::uint32_t>(message.period_us, 1));
  info.status_every_ticks = std::max<std::uint32_t>(message.status_every_ticks, 1);
  info.user_units_per_revolution = message.user_units_per_revolution;
  info.dictionary_version = message.dictionary_version.to_string();
  info.service_version = message.service_version.to_string();
}

void note_figures(std::vector<Figure>& figures, const msg::BenchState& message) {
  auto figure = figures.begin();
  wire::for_each_figure<msg::BenchState>([&](const auto& member) {
    (figure++)->value = message.*member.pointer;
  });
}

}  // namespace

void Directory::on_description(const msg::BenchDescription& message, const wire::Source& source,
                               Clock::time_point now) {
  Entry* const entry = entry_of({message.bench, message.incarnation}, now);
  if (entry == nullptr) return;
  entry->offline = !message.alive;
  if (entry->offline) return;
  describe(entry->info, message);
  entry->source = source;
  entry->part_count = message.parts;
  if (!entry->parts.contains(message.part) && !has_room_for_part(now)) return;
  std::vector<AxisInfo>& axes = entry->parts[message.part];
  axes.clear();
  for (const msg::AxisDescription& axis : message.axes) {
    axes.push_back(axis_info(message.bench, axis));
  }
}

void Directory::on_state(const msg::BenchState& message, Clock::time_point now) {
  const BenchKey key{message.bench, message.incarnation};
  note_sample(key, message.tick, now);
  note_time(key, {message.tick, message.skipped_ticks});
  const auto found = entries_.find(key);
  if (found == entries_.end()) return;
  Entry& entry = found->second;
  entry.info.rate = message.rate;
  note_figures(entry.info.figures, message);
  entry.info.wire_starts = message.wire_starts;
  entry.info.longest_silence = std::chrono::microseconds(message.longest_silence_us);
  entry.rate_time = now;
  entry.steppers = message.steppers;
  entry.slowest_stepper = message.slowest_stepper;
}

void Directory::note_sender(const BenchKey& key, const wire::Source& source) {
  const auto entry = entries_.find(key);
  if (entry != entries_.end()) entry->second.source = source;
}

std::optional<wire::Source> Directory::source_of(const BenchKey& key) const {
  const auto entry = entries_.find(key);
  if (entry == entries_.end() || entry->second.source == wire::Source{}) return std::nullopt;
  return entry->second.source;
}

Directory::Entry* Directory::entry_of(const BenchKey& key, Clock::time_point now) {
  if (!entries_.contains(key) && entries_.size() >= kMostRuns && !forget_the_most_silent(now)) {
    return nullptr;
  }
  Entry& entry = entries_[key];
  entry.newest = now;
  return &entry;
}

bool Directory::has_room_for_part(Clock::time_point now) {
  const auto parts = [this] {
    std::size_t count = 0;
    for (const auto& [key, entry] : entries_) count += entry.parts.size();
    return count;
  };
  while (parts() >= kMostParts) {
    if (!forget_the_most_silent(now)) return false;
  }
  return true;
}

bool Directory::forget_the_most_silent(Clock::time_point now) {
  const auto oldest = std::ranges::min_element(entries_, {}, [](const auto& item) {
    return item.second.newest;
  });
  // A run whose samples arrive is never displaced by runs that only publish a description.
  if (oldest == entries_.end() || now - oldest->second.newest < kForgetAfter) return false;
  entries_.erase(oldest);
  return true;
}

std::vector<SeenRun> Directory::seen_runs(Clock::time_point now) const {
  std::vector<SeenRun> runs;
  const bool is_excused = presence_.is_excused(now);
  for (const auto& [key, entry] : entries_) {
    const auto silence = silence_of(entry, now);
    if (entry.part_count == 0 || (!silence && !entry.newest_sample && !entry.offline)) continue;
    const auto age = silence.value_or(now - entry.newest_sample.value_or(now));
    const bool stands = entry.info.clock_mode == ClockMode::lockstep ||
                        (entry.info.clock_mode == ClockMode::realtime && entry.info.rate == 0.0);
    runs.push_back({.key = key,
                    .age = is_excused ? Clock::duration() : age,
                    .is_offline = entry.offline,
                    .is_streaming = !stands});
  }
  return runs;
}

void Directory::set_rate(const BenchKey& key, double rate) {
  const auto entry = entries_.find(key);
  if (entry != entries_.end()) entry->second.info.rate = rate;
}

bool Directory::is_paused(const BenchKey& key, Clock::time_point since) const {
  const auto entry = entries_.find(key);
  return entry != entries_.end() && entry->second.info.clock_mode == ClockMode::realtime &&
         entry->second.info.rate == 0.0 && entry->second.rate_time > since;
}

std::uint32_t Directory::steppers(const BenchKey& key) const {
  const auto entry = entries_.find(key);
  return entry == entries_.end() ? 0 : entry->second.steppers;
}

std::uint64_t Directory::slowest_stepper(const BenchKey& key) const {
  const auto entry = entries_.find(key);
  return entry == entries_.end() ? 0 : entry->second.slowest_stepper;
}

bool Directory::is_restarted(const BenchKey& key, Clock::time_point now) const {
  const auto* const run = find_run(key.number, now);
  return run != nullptr && run->first.incarnation != key.incarnation;
}

void Directory::note_sample(const BenchKey& key, std::uint64_t tick, Clock::time_point now) {
  Entry* const entry = entry_of(key, now);
  if (entry == nullptr) return;
  entry->newest_sample = now;
  entry->info.tick = std::max(entry->info.tick, tick);
}

void Directory::note_time(const BenchKey& key, const RunTime& time) {
  const auto found = entries_.find(key);
  if (found == entries_.end()) return;
  Entry& entry = found->second;
  if (entry.time && time.tick <= entry.time->tick) return;
  if (entry.time) entry.skipped += ticks_skipped(*entry.time, time);
  entry.time = time;
}

/// A realtime bench counts as present only after its first state sample, which has the rate: the
/// description has none, and a paused bench would appear to be running.
std::optional<Directory::Clock::duration> Directory::silence_of(const Entry& entry,
                                                                Clock::time_point now) const {
  if (entry.info.clock_mode == ClockMode::realtime && !entry.newest_sample) return std::nullopt;
  return presence_.silence(entry.source, entry.newest_sample, now);
}

bool Directory::is_heard(const Entry& entry, std::chrono::milliseconds patience,
                         Clock::time_point now) const {
  if (entry.offline) return false;
  const auto silence = silence_of(entry, now);
  return silence && *silence < patience;
}

bool Directory::is_present(const Entry& entry, Clock::time_point now) const {
  return entry.part_count != 0 && entry.parts.size() == entry.part_count &&
         is_heard(entry, kPresence, now);
}

template <typename Visit>
void Directory::for_each_present(Clock::time_point now, const Visit& visit) const {
  std::optional<std::uint32_t> last;
  for (const auto& run : entries_) {
    if (run.first.number == last || !is_present(run.second, now)) continue;
    last = run.first.number;
    visit(run);
  }
}

PresentBench Directory::whole(const Entry& entry, Clock::time_point now) const {
  PresentBench bench{entry.info, entry.source};
  bench.info.sample_age = silence_of(entry, now).value_or(Clock::duration());
  for (const auto& [part, axes] : entry.parts) {
    bench.info.axes.insert(bench.info.axes.end(), axes.begin(), axes.end());
  }
  return bench;
}

std::vector<PresentBench> Directory::present(Clock::time_point now) const {
  std::vector<PresentBench> benches;
  for_each_present(now, [&](const auto& run) {
    benches.push_back(whole(run.second, now));
  });
  return benches;
}

std::size_t Directory::count_present(Clock::time_point now) const {
  std::size_t count = 0;
  for_each_present(now, [&](const auto& /*run*/) {
    ++count;
  });
  return count;
}

const std::pair<const BenchKey, Directory::Entry>* Directory::find_run(
    std::uint32_t number, Clock::time_point now) const {
  for (auto run = entries_.lower_bound({.number = number});
       run != entries_.end() && run->first.number == number; ++run) {
    if (is_present(run->second, now)) return &*run;
  }
  return nullptr;
}

std::optional<PresentBench> Directory::find(std::uint32_t number, Clock::time_point now) const {
  const auto* const run = find_run(number, now);
  return run == nullptr ? std::nullopt : std::optional(whole(run->second, now));
}

std::optional<PresentBench> Directory::find_without_axes(std::uint32_t number,
                                                         Clock::time_point now) const {
  const auto* const run = find_run(number, now);
  if (run == nullptr) return std::nullopt;
  return PresentBench{run->second.info, run->second.source};
}

std::size_t Directory::described() const {
  return static_cast<std::size_t>(std::ranges::count_if(entries_, [](const auto& item) {
    return item.second.part_count != 0;
  }));
}

bool Directory::has_shown_itself(const wire::Source& source, Clock::time_point now) const {
  return std::ranges::any_of(entries_, [&](const auto& item) {
    const Entry& entry = item.second;
    return entry.source == source && (entry.offline || is_present(entry, now));
  });
}

bool Directory::expects_more(Clock::time_point now) const {
  return std::ranges::any_of(entries_, [&](const auto& item) {
    const Entry& entry = item.second;
    return !entry.offline && !is_present(entry, now) && now - entry.newest < kPresence;
  });
}

bool Directory::is_alive(const BenchKey& key, std::chrono::milliseconds patience,
                         Clock::time_point now) const {
  const auto entry = entries_.find(key);
  return entry != entries_.end() && is_heard(entry->second, patience, now);
}

std::optional<std::chrono::milliseconds> Directory::age(const BenchKey& key,
                                                        Clock::time_point now) const {
  const auto entry = entries_.find(key);
  if (entry == entries_.end()) return std::nullopt;
  const auto silence = silence_of(entry->second, now);
  if (!silence) return std::nullopt;
  return std::chrono::duration_cast<std::chrono::milliseconds>(*silence);
}

BenchKey Directory::newest_run(std::uint32_t number) const {
  BenchKey newest{number, 0};
  std::optional<Clock::time_point> heard;
  for (const auto& [key, entry] : entries_) {
    if (key.number != number || (heard && entry.newest <= *heard)) continue;
    newest = key;
    heard = entry.newest;
  }
  return newest;
}

std::optional<Unit> Directory::unit_of(const AxisId& axis) const {
  const auto run = entries_.find(newest_run(axis.bench));
  if (run == entries_.end()) return std::nullopt;
  for (const auto& [part, axes] : run->second.parts) {
    const auto found = std::ranges::find(axes, axis, &AxisInfo::id);
    if (found != axes.end()) return found->unit;
  }
  return std::nullopt;
}

std::optional<std::uint32_t> Directory::ended_bench() const {
  std::optional<std::uint32_t> bench;
  Clock::time_point heard;
  for (const auto& [key, entry] : entries_) {
    if (!entry.offline || (bench && entry.newest <= heard)) continue;
    bench = key.number;
    heard = entry.newest;
  }
  return bench;
}

bool Directory::is_offline(const BenchKey& key) const {
  const auto entry = entries_.find(key);
  return entry != entries_.end() && entry->second.offline;
}

std::uint64_t Directory::tick(const BenchKey& key) const {
  const auto entry = entries_.find(key);
  return entry == entries_.end() ? 0 : entry->second.info.tick;
}

std::optional<std::uint64_t> Directory::driven_tick(const BenchKey& key) const {
  const auto entry = entries_.find(key);
  if (entry == entries_.end() || !entry->second.time) return std::nullopt;
  return entry->second.time->tick - entry->second.skipped;
}

}  // namespace vdrive::client
