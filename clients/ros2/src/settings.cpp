// SPDX-License-Identifier: Apache-2.0
#include "settings.hpp"

#include "settings/configuration_error.hpp"
#include "settings/yaml_reader.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wire/bench_number.hpp"
#include "vdrive/wire/ros.hpp"

#include <algorithm>
#include <array>

namespace vdrive::ros2 {
namespace {

using vdrive::settings::ConfigurationError;
using vdrive::settings::NumberLimits;
using vdrive::settings::YamlValue;

/// @return the text of a value that is not empty.
std::string text_of(const YamlValue& value) {
  std::string text = value.text();
  if (text.empty()) value.refuse("must be text");
  return text;
}

void read_topics(const YamlValue& map, TopicNames& topics) {
  const auto name = [](std::string& topic) {
    return [&topic](const YamlValue& value) {
      topic = text_of(value);
      const std::string absolute = topic.starts_with('/') ? topic : "/" + topic;
      if (!ros::check_topic(absolute).empty()) {
        value.refuse("is not the name of a topic: letters, digits and '_', parts divided by '/'");
      }
    };
  };
  map.take_keys({{"joint_states", name(topics.joint_states)},
                 {"joint_commands", name(topics.joint_commands)},
                 {"joint_trajectory", name(topics.joint_trajectory)},
                 {"enable", name(topics.enable)},
                 {"diagnostics", name(topics.diagnostics)},
                 {"rosout", name(topics.rosout)},
                 {"clock", name(topics.clock)}});
}

Interface read_interface(const YamlValue& value) {
  constexpr std::array kInterfaces{Interface::position, Interface::velocity, Interface::effort};
  return kInterfaces.at(
      value.choice({to_string(Interface::position), to_string(Interface::velocity),
                    to_string(Interface::effort)}));
}

JointSetting read_joint(const std::string& name, const YamlValue& value) {
  JointSetting joint{.name = name, .axis = {}};
  if (!value.is_map()) {
    joint.axis = text_of(value);
    return joint;
  }
  value.take_keys({{"axis",
                    [&](const YamlValue& axis) {
                      joint.axis = text_of(axis);
                    }},
                   {"interface", [&](const YamlValue& interface) {
                      joint.interface = read_interface(interface);
                    }}});
  if (joint.axis.empty()) value.refuse("needs the key axis, such as \"1.2\"");
  return joint;
}

void read_joints(const YamlValue& map, std::vector<JointSetting>& joints) {
  joints.clear();
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
  constexpr double kLongestTimeout = 3600.0;
  constexpr double kWidestTolerance = 10.0;
  constexpr double kFurthestAhead = 86'400.0;
  const YAML::Node document = vdrive::settings::read_yaml(text, file);
  if (document.IsNull()) return;
  const auto flag = [](bool& target) {
    return [&target](const YamlValue& value) {
      target = value.boolean();
    };
  };
  const auto number = [](double& target, const NumberLimits& limits) {
    return [&target, limits](const YamlValue& value) {
      target = value.number(limits);
    };
  };
  const YamlValue root(document, file, "");
  root.take_keys(
      {{"benches",
        [&](const YamlValue& value) {
          read_benches(value, settings.benches);
        }},
       {"namespace",
        [&](const YamlValue& value) {
          settings.name_space = text_of(value);
        }},
       {"rate", number(settings.rate, {Settings::kLowestRate, Settings::kHighestRate, "Hz"})},
       {"enable", flag(settings.is_enabled)},
       {"prefix_benches", flag(settings.is_prefixed)},
       {"command_timeout", number(settings.command_timeout, {0.0, kLongestTimeout, "s"})},
       {"start_tolerance", number(settings.start_tolerance, {0.0, kWidestTolerance, "rad or m"})},
       {"stamp_ahead", number(settings.stamp_ahead, {0.0, kFurthestAhead, "s"})},
       {"topics",
        [&](const YamlValue& value) {
          read_topics(value, settings.topics);
        }},
       {"joints", [&](const YamlValue& value) {
          read_joints(value, settings.joints);
        }}});
}

void resolve_topics(Settings& settings) {
  std::string& space = settings.name_space;
  if (!space.empty() && !space.starts_with('/')) space.insert(0, "/");
  while (space.ends_with('/')) space.pop_back();
  if (!space.empty() && !ros::check_topic(space).empty()) {
    throw ConfigurationError("namespace: " + ros::check_topic(space));
  }
  TopicNames& topics = settings.topics;
  const std::array all{&topics.joint_states, &topics.joint_commands, &topics.joint_trajectory,
                       &topics.enable,       &topics.diagnostics,    &topics.rosout,
                       &topics.clock};
  for (std::string* const topic : all) {
    if (!topic->starts_with('/')) *topic = space + "/" + *topic;
  }
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t other = i + 1; other < all.size(); ++other) {
      if (*all[i] != *all[other]) continue;
      throw ConfigurationError("two topics are called " + in_quotes(*all[i]));
    }
  }
}

}  // namespace vdrive::ros2
