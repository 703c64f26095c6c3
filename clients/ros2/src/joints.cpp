// SPDX-License-Identifier: Apache-2.0
#include "joints.hpp"

#include "joint_values.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <utility>

namespace vdrive::ros2 {
namespace {

constexpr std::size_t kMostNamed = 8;       // known joints in a message
constexpr std::size_t kMostCompared = 256;  // known joints compared with an unknown one
constexpr std::size_t kMostUnknown = 256;   // unknown names whose text is kept

/// @return whether `text` from the configuration refers to this axis.
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

OperatingMode mode_of(CommandInterface interface) noexcept {
  if (interface == CommandInterface::velocity) return OperatingMode::cyclic_synchronous_velocity;
  if (interface == CommandInterface::effort) return OperatingMode::cyclic_synchronous_torque;
  return OperatingMode::cyclic_synchronous_position;
}

client::SetPoint begin_stream(std::uint16_t axis, OperatingMode mode) {
  return {.axis = axis, .mode = mode, .objects = client::objects_before_stream()};
}

std::optional<std::string> JointDirectory::add(std::uint32_t bench,
                                               const std::vector<ServedJoint>& joints) {
  auto places = places_;  // a copy, so that no joint of a bench that clashes is added
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
  unknown_.clear();
  return std::nullopt;
}

void JointDirectory::remove(std::uint32_t bench) {
  unknown_.clear();
  std::erase_if(places_, [bench](const auto& entry) {
    return entry.second.bench == bench;
  });
}

std::optional<JointPlace> JointDirectory::find(std::string_view name) const {
  const auto found = places_.find(name);
  if (found == places_.end()) return std::nullopt;
  return found->second;
}

std::string JointDirectory::unknown(std::string_view name) const {
  const auto known = unknown_.find(name);
  if (known != unknown_.end()) return known->second;
  // Bounded, because any program may send any number of names.
  if (unknown_.size() >= kMostUnknown) unknown_.clear();
  return unknown_.emplace(name, describe_unknown(name)).first->second;
}

std::string JointDirectory::describe_unknown(std::string_view name) const {
  if (places_.empty()) return "is unknown: no bench is served yet";
  // A name with an error after its first characters is sorted next to the right one.
  auto near = places_.lower_bound(name);
  for (std::size_t i = 0; i < kMostCompared / 2 && near != places_.begin(); ++i) --near;
  std::vector<std::string> candidates;
  for (; near != places_.end() && candidates.size() < kMostCompared; ++near) {
    candidates.push_back(near->first);
  }
  std::string text = "is unknown" + suggestion(name, candidates) + "; known:";
  std::size_t named = 0;
  for (const auto& [joint, place] : places_) {
    if (named == kMostNamed) break;
    text += (named++ == 0 ? " " : ", ") + escaped(joint);
  }
  const std::size_t more = places_.size() - named;
  return more == 0 ? text : text + " and " + std::to_string(more) + " more";
}

}  // namespace vdrive::ros2
