// SPDX-License-Identifier: Apache-2.0
#include "topic_names.hpp"

#include <algorithm>
#include <cctype>
#include <set>
#include <utility>

namespace vdrive::bridge {
namespace {

std::string plain_name(const client::AxisInfo& axis) {
  std::string name = axis.name;
  std::ranges::replace_if(
      name,
      [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) == 0;
      },
      '_');
  return name.empty() ? "axis" + std::to_string(axis.id.axis) : name;
}

}  // namespace

std::string bench_topic(std::uint32_t bench) {
  return "bench" + std::to_string(bench);
}

std::vector<std::string> topic_names(std::span<const client::AxisInfo> axes) {
  std::set<std::string> taken;
  std::vector<std::string> names;
  names.reserve(axes.size());
  for (const client::AxisInfo& axis : axes) {
    std::string name = plain_name(axis);
    while (!taken.insert(name).second) name.append("_").append(std::to_string(axis.id.axis));
    names.push_back(std::move(name));
  }
  return names;
}

bool are_same_axes(std::span<const client::AxisInfo> a, std::span<const client::AxisInfo> b) {
  return std::ranges::equal(a, b, [](const client::AxisInfo& one, const client::AxisInfo& other) {
    return one.id == other.id && one.name == other.name && one.unit == other.unit;
  });
}

}  // namespace vdrive::bridge
