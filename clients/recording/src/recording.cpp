// SPDX-License-Identifier: Apache-2.0
#include "recording.hpp"

#include "topic_names.hpp"
#include "vdrive/number_text.hpp"

#include <algorithm>

namespace vdrive::recording {

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
  // The units of an angle have names that no unit of a length has.
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

}  // namespace vdrive::recording
