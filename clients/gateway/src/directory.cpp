// SPDX-License-Identifier: Apache-2.0
#include "directory.hpp"

#include "topic_names.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/number_text.hpp"

#include <algorithm>

namespace vdrive::gateway {
namespace {

// A sub-index is written with two decimal digits, because parse_address reads it as decimal.
constexpr std::size_t kDigitsOfSubindex = 2;
static_assert(std::ranges::all_of(kObjectRows, [](const ObjectDescription& object) {
  return object.address.subindex < 100;
}));

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
    const std::string digits = std::to_string(object.subindex);
    text.append(":").append(kDigitsOfSubindex - digits.size(), '0').append(digits);
  }
  return text;
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
  const auto object = parse_address(name.substr(last + 1));
  if (!object || !find_object(object->address())) return std::nullopt;
  const auto place = static_cast<std::size_t>(axis - bench->axis_names.begin());
  return ParameterAddress{.axis = bench->info.axes[place].id, .object = object->address()};
}

}  // namespace vdrive::gateway
