// SPDX-License-Identifier: Apache-2.0
#include "recording.hpp"

#include "topic_names.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <string_view>

namespace vdrive::recording {
namespace {

/// @return such as "between the ticks 12 and 15 of bench 1 (2)".
std::string place_of(const Gap& gap) {
  const std::string after = std::to_string(gap.after);
  const std::string where =
      gap.before == 0 ? "after the tick " + after
                      : "between the ticks " + after + " and " + std::to_string(gap.before);
  return where + " of bench " + std::to_string(gap.bench) + " (" + std::to_string(gap.count) + ")";
}

}  // namespace

RecordedBench describe(const client::BenchInfo& bench, const std::vector<client::AxisId>& axes) {
  constexpr std::size_t kHexDigits = 16;
  RecordedBench recorded{.number = bench.number, .period = bench.period};
  recorded.facts = {{"name", bench.name},
                    {"clock", std::string(to_string(bench.clock_mode))},
                    {"status_every_ticks", std::to_string(bench.status_every_ticks)},
                    {"incarnation", hex(bench.incarnation, kHexDigits)},
                    {"dictionary_version", bench.dictionary_version},
                    {"service_version", bench.service_version}};
  const std::vector<std::string> topics = bridge::topic_names(bench.axes);
  recorded.axes.reserve(axes.size());
  for (const client::AxisId& id : axes) {
    const auto info = std::ranges::find(bench.axes, id, &client::AxisInfo::id);
    if (info == bench.axes.end()) continue;
    const auto place = static_cast<std::size_t>(info - bench.axes.begin());
    recorded.axes.push_back(
        {.id = id, .name = info->name, .topic = topics[place], .unit = info->unit});
  }
  return recorded;
}

void name_topics(RecordedBench& bench) {
  std::vector<client::AxisInfo> infos;
  infos.reserve(bench.axes.size());
  for (const RecordedAxis& axis : bench.axes) {
    client::AxisInfo& info = infos.emplace_back();
    info.id = axis.id;
    info.name = axis.name;
  }
  const std::vector<std::string> topics = bridge::topic_names(infos);
  for (std::size_t i = 0; i < topics.size(); ++i) bench.axes[i].topic = topics[i];
}

std::optional<client::Unit> unit_from(std::string_view name, std::string_view size) {
  const auto number = parse_number(size);
  client::Unit unit{
      .kind = client::UnitKind::rotary, .name = std::string(name), .size = number.value_or(0.0)};
  // Units of angle and units of length have different names.
  if (check_unit_name(unit.kind, name)) unit.kind = client::UnitKind::linear;
  return is_usable(unit) ? std::optional(unit) : std::nullopt;
}

std::map<client::AxisId, std::string> names_of(const std::vector<RecordedBench>& benches) {
  std::map<client::AxisId, std::string> names;
  for (const RecordedBench& bench : benches) {
    for (const RecordedAxis& axis : bench.axes) names[axis.id] = axis.name;
  }
  return names;
}

void GapList::add(const Gap& gap) {
  total_ += gap.count;
  if (kept_.size() < kKept) {
    kept_.push_back(gap);
  } else {
    ++left_out_;
  }
}

std::string GapList::text(std::size_t most) const {
  std::string text;
  const std::size_t named = std::min(most, kept_.size());
  for (std::size_t i = 0; i < named; ++i) {
    if (i != 0) text += ", ";
    text += place_of(kept_[i]);
  }
  const std::uint64_t others = kept_.size() - named + left_out_;
  const std::string noun = "further " + std::string(noun_);
  if (others != 0) text += ", and " + counted(others, noun, noun + "s");
  return text;
}

void GapLog::note_sample(const client::Observation& sample) {
  std::uint64_t& last = last_ticks_[sample.axes.front().id.bench];
  Gap gap{.bench = sample.axes.front().id.bench, .after = last, .before = sample.tick};
  last = sample.tick;
  gap.count = sample.missed;
  if (gap.count != 0) missed_.add(gap);
  gap.count = sample.skipped;
  if (gap.count != 0) jumps_.add(gap);
}

void GapLog::note_lost_end(std::uint32_t bench, std::uint64_t missed) {
  if (missed != 0) missed_.add({.bench = bench, .after = last_ticks_[bench], .count = missed});
}

}  // namespace vdrive::recording
