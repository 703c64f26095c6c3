// SPDX-License-Identifier: Apache-2.0
#include "settings.hpp"

#include "settings/configuration_error.hpp"
#include "settings/yaml_reader.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wire/bench_number.hpp"
#include "vdrive/wire/ros.hpp"

#include <algorithm>
#include <array>
#include <set>
#include <string_view>

namespace vdrive::ros2 {
namespace {

using vdrive::settings::ConfigurationError;
using vdrive::settings::NumberLimits;
using vdrive::settings::YamlValue;

/// Reads a text that is not empty.
void read_text(const YamlValue& value, std::string& text) {
  text = value.text();
  if (text.empty()) value.refuse("must be text");
}

void read_flag(const YamlValue& value, bool& flag) {
  flag = value.boolean();
}

/// @return what reads the value of a key into `target`.
template <typename Target>
auto into(Target& target, void (*read)(const YamlValue& value, Target& target)) {
  return [&target, read](const YamlValue& value) {
    read(value, target);
  };
}

/// The same for a number within limits.
auto into(double& target, const NumberLimits& limits) {
  return [&target, limits](const YamlValue& value) {
    target = value.number(limits);
  };
}

struct TopicRow {
  std::string_view key;
  std::string TopicNames::*name;
};

constexpr std::array kTopicRows{TopicRow{"joint_states", &TopicNames::joint_states},
                                TopicRow{"joint_commands", &TopicNames::joint_commands},
                                TopicRow{"joint_trajectory", &TopicNames::joint_trajectory},
                                TopicRow{"enable", &TopicNames::enable},
                                TopicRow{"diagnostics", &TopicNames::diagnostics},
                                TopicRow{"rosout", &TopicNames::rosout},
                                TopicRow{"clock", &TopicNames::clock}};

void read_topics(const YamlValue& map, TopicNames& topics) {
  std::array<std::string_view, kTopicRows.size()> keys;
  std::ranges::transform(kTopicRows, keys.begin(), &TopicRow::key);
  map.for_each_entry(keys, [&](const std::string& key, const YamlValue& value) {
    std::string& topic = topics.*std::ranges::find(kTopicRows, key, &TopicRow::key)->name;
    read_text(value, topic);
    const std::string absolute = topic.starts_with('/') ? topic : "/" + topic;
    if (!ros::check_topic(absolute).empty()) {
      value.refuse("is not the name of a topic: letters, digits and '_', parts divided by '/'");
    }
  });
}

void read_interface(const YamlValue& value, std::optional<CommandInterface>& interface) {
  constexpr std::array kInterfaces{CommandInterface::position, CommandInterface::velocity,
                                   CommandInterface::effort};
  interface = kInterfaces.at(value.choice(
      {to_string(kInterfaces[0]), to_string(kInterfaces[1]), to_string(kInterfaces[2])}));
}

JointSetting read_joint(const std::string& name, const YamlValue& value) {
  JointSetting joint{.name = name, .axis = {}};
  if (!value.is_map()) {
    read_text(value, joint.axis);
    return joint;
  }
  value.take_keys({{"axis", into(joint.axis, read_text)},
                   {"interface", into(joint.interface, read_interface)}});
  if (joint.axis.empty()) value.refuse("needs the key axis, such as \"1.2\"");
  return joint;
}

void read_joints(const YamlValue& map, std::vector<JointSetting>& joints) {
  joints.clear();  // the key replaces, it does not add
  map.for_each_entry({}, [&](const std::string& name, const YamlValue& value) {
    joints.push_back(read_joint(name, value));
    const bool is_twice = std::ranges::count(joints, joints.back().axis, &JointSetting::axis) > 1;
    if (is_twice) value.refuse("the axis has another joint already");
  });
}

void read_benches(const YamlValue& list, std::vector<std::uint32_t>& benches) {
  benches.clear();
  list.for_each_element([&](const YamlValue& element) {
    benches.push_back(static_cast<std::uint32_t>(element.integer({1, wire::kHighestBench, ""})));
  });
}

}  // namespace

void read_settings(const std::string& text, const std::string& file, Settings& settings) {
  // Beyond these a value is a mistake in its unit.
  constexpr double kLongestTimeout = 3600.0;
  constexpr double kWidestTolerance = 10.0;
  constexpr double kFurthestAhead = 86'400.0;
  const YAML::Node document = vdrive::settings::read_yaml(text, file);
  if (document.IsNull()) return;
  const YamlValue root(document, file, "");
  root.take_keys(
      {{"benches", into(settings.benches, read_benches)},
       {"namespace", into(settings.name_space, read_text)},
       {"rate", into(settings.rate, {Settings::kLowestRate, Settings::kHighestRate, "Hz"})},
       {"enable", into(settings.is_enabled, read_flag)},
       {"prefix_benches", into(settings.is_prefixed, read_flag)},
       {"command_timeout", into(settings.command_timeout, {0.0, kLongestTimeout, "s"})},
       {"start_tolerance", into(settings.start_tolerance, {0.0, kWidestTolerance, "rad or m"})},
       {"stamp_ahead", into(settings.stamp_ahead, {0.0, kFurthestAhead, "s"})},
       {"topics", into(settings.topics, read_topics)},
       {"joints", into(settings.joints, read_joints)}});
}

void resolve_topics(Settings& settings) {
  std::string& space = settings.name_space;
  if (!space.empty() && !space.starts_with('/')) space.insert(0, "/");
  while (space.ends_with('/')) space.pop_back();
  if (!space.empty() && !ros::check_topic(space).empty()) {
    throw ConfigurationError("namespace: " + ros::check_topic(space));
  }
  std::set<std::string> taken;
  for (const TopicRow& row : kTopicRows) {
    std::string& topic = settings.topics.*row.name;
    if (!topic.starts_with('/')) topic.insert(0, space + "/");
    if (!taken.insert(topic).second) {
      throw ConfigurationError("two topics are called " + in_quotes(topic));
    }
  }
}

}  // namespace vdrive::ros2
