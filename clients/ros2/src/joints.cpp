// SPDX-License-Identifier: Apache-2.0
#include "joints.hpp"

#include "joint_values.hpp"

#include <algorithm>

namespace vdrive::ros2 {
namespace {

/// @return whether `text` of the configuration names this axis.
bool names(const std::string& text, const client::AxisInfo& axis) {
  return text == to_string(axis.id) || text == axis.name ||
         text == std::to_string(axis.id.bench) + "." + axis.name;
}

}  // namespace

std::vector<ServedJoint> joints_of(const client::BenchInfo& bench, const Settings& settings) {
  std::vector<ServedJoint> joints;
  joints.reserve(bench.axes.size());
  for (const client::AxisInfo& axis : bench.axes) {
    ServedJoint joint{.name = axis.name,
                      .axis = axis.id,
                      .unit = axis.unit,
                      .si_per_user_unit = bridge::si_per_user_unit(axis.unit)};
    if (settings.is_prefixed) {
      joint.name = "bench" + std::to_string(bench.number) + "_" + joint.name;
    }
    const auto chosen = std::ranges::find_if(settings.joints, [&](const JointSetting& setting) {
      return names(setting.axis, axis);
    });
    if (chosen != settings.joints.end()) {
      joint.name = chosen->name;
      joint.interface = chosen->interface;
    }
    joints.push_back(std::move(joint));
  }
  return joints;
}

std::optional<std::string> JointDirectory::add(std::uint32_t bench,
                                               const std::vector<ServedJoint>& joints) {
  auto places = places_;  // a copy: of a bench that clashes no joint is added
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const auto [entry, is_new] =
        places.emplace(joints[i].name, JointPlace{bench, i, joints[i].interface});
    if (!is_new) {
      return "bench " + std::to_string(bench) + " is left out: its joint \"" + joints[i].name +
             "\" is also on bench " + std::to_string(entry->second.bench) +
             "; use --prefix, or name it with joints: in the configuration";
    }
  }
  places_ = std::move(places);
  return std::nullopt;
}

void JointDirectory::remove(std::uint32_t bench) {
  std::erase_if(places_, [bench](const auto& entry) {
    return entry.second.bench == bench;
  });
}

std::optional<JointPlace> JointDirectory::find(std::string_view name) const {
  const auto found = places_.find(name);
  if (found == places_.end()) return std::nullopt;
  return found->second;
}

}  // namespace vdrive::ros2
