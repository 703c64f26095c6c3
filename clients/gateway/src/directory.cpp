// SPDX-License-Identifier: Apache-2.0
#include "directory.hpp"

#include "topic_names.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/number_text.hpp"

#include <algorithm>

namespace vdrive::gateway {
namespace {

constexpr std::string_view kHexPrefix = "0x";

}  // namespace

bool have_same_topics(const client::BenchInfo& a, const client::BenchInfo& b) {
  return a.period == b.period && bridge::are_same_axes(a.axes, b.axes);
}

KnownBench known_bench(client::BenchInfo info) {
  KnownBench bench;
  bench.topic = bridge::bench_topic(info.number);
  bench.axis_names = bridge::topic_names(info.axes);
  bench.info = std::move(info);
  return bench;
}

std::string object_key(ObjectAddress object) {
  std::string text = hex(object.index, 4);
  if (object.subindex != 0) {
    text.append(":").append(hex(object.subindex, 2).substr(kHexPrefix.size()));
  }
  return text;
}

std::optional<ObjectAddress> parse_object(std::string_view text) {
  if (!text.starts_with(kHexPrefix) && !text.starts_with("0X")) return std::nullopt;
  text.remove_prefix(kHexPrefix.size());
  ObjectAddress address;
  const auto colon = text.find(':');
  if (colon != std::string_view::npos) {
    const auto sub = parse_digits<std::uint8_t>(text.substr(colon + 1), 16);
    if (!sub) return std::nullopt;
    address.subindex = *sub;
  }
  const auto index = parse_digits<std::uint16_t>(text.substr(0, colon), 16);
  if (!index) return std::nullopt;
  address.index = *index;
  if (!find_object(address)) return std::nullopt;
  return address;
}

std::string parameter_name(const KnownBench& bench, std::size_t axis, ObjectAddress object) {
  return bench.topic + "/" + bench.axis_names[axis] + "/" + object_key(object);
}

std::optional<ParameterAddress> find_parameter(const std::vector<KnownBench>& benches,
                                               std::string_view name) {
  if (name.starts_with('/')) name.remove_prefix(1);
  const auto first = name.find('/');
  const auto last = name.rfind('/');
  if (first == std::string_view::npos || first == last) return std::nullopt;
  const auto bench = std::ranges::find(benches, name.substr(0, first), &KnownBench::topic);
  if (bench == benches.end()) return std::nullopt;
  const auto axis = std::ranges::find(bench->axis_names, name.substr(first + 1, last - first - 1));
  if (axis == bench->axis_names.end()) return std::nullopt;
  const auto object = parse_object(name.substr(last + 1));
  if (!object) return std::nullopt;
  const auto place = static_cast<std::size_t>(axis - bench->axis_names.begin());
  return ParameterAddress{.axis = bench->info.axes[place].id, .object = *object};
}

}  // namespace vdrive::gateway
