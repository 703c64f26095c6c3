// SPDX-License-Identifier: Apache-2.0
#include "settings.hpp"

#include "settings/configuration_error.hpp"
#include "settings/rows.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wire/bench_number.hpp"
#include "vdrive/wire/ros.hpp"

#include <algorithm>
#include <array>
#include <set>
#include <string_view>
#include <utility>

namespace vdrive::ros2 {
namespace {

using vdrive::settings::ConfigurationError;
using vdrive::settings::IntegerLimits;
using vdrive::settings::key;
using vdrive::settings::kOneOf;
using vdrive::settings::NumberLimits;
using vdrive::settings::Row;
using vdrive::settings::section;
using vdrive::settings::TextRule;
using vdrive::settings::YamlValue;

constexpr TextRule kText{.if_empty = "must be text"};

struct TopicRow {
  std::string_view key;
  std::string TopicNames::*name;
};

constexpr std::array kTopics{TopicRow{"joint_states", &TopicNames::joint_states},
                             TopicRow{"joint_commands", &TopicNames::joint_commands},
                             TopicRow{"joint_trajectory", &TopicNames::joint_trajectory},
                             TopicRow{"enable", &TopicNames::enable},
                             TopicRow{"diagnostics", &TopicNames::diagnostics},
                             TopicRow{"rosout", &TopicNames::rosout},
                             TopicRow{"clock", &TopicNames::clock}};

bool is_topic(const std::string& name) {
  return ros::check_topic(name.starts_with('/') ? name : "/" + name).empty();
}

constexpr TextRule kTopic{
    .if_empty = kText.if_empty,
    .fits = is_topic,
    .refusal = "is not the name of a topic: letters, digits and '_', parts separated by '/'"};

template <std::size_t... kPlaces>
constexpr auto topic_rows(std::index_sequence<kPlaces...> /*topics*/) {
  return std::to_array({key<kTopics[kPlaces].name>(kTopics[kPlaces].key, kTopic)...});
}

constexpr auto kTopicRows = topic_rows(std::make_index_sequence<kTopics.size()>());

constexpr auto kJointRows = std::to_array<Row<JointSetting>>({
    key<&JointSetting::axis>("axis", kText, {}, {.needed = "needs the key axis, such as \"1.2\""}),
    key<&JointSetting::interface>(
        "interface",
        kOneOf<CommandInterface::position, CommandInterface::velocity, CommandInterface::effort>),
});

/// A joint is given as the name of its axis, or as a map.
void read_joints(const YamlValue& map, Settings& settings) {
  std::vector<JointSetting>& joints = settings.joints;
  joints.clear();  // the key replaces earlier joints
  map.for_each_entry({}, [&](const std::string& name, const YamlValue& value) {
    JointSetting joint{.name = name, .axis = {}};
    if (value.is_map()) {
      read_section(value, kJointRows, joint);
    } else {
      read_value(value, kText, joint.axis);
    }
    joints.push_back(joint);
    const bool is_twice = std::ranges::count(joints, joint.axis, &JointSetting::axis) > 1;
    if (is_twice) value.refuse("the axis already has a joint");
  });
}

// A value beyond these limits is probably in the wrong unit.
constexpr auto kRows = std::to_array<Row<Settings>>({
    key<&Settings::benches>("benches", IntegerLimits{1, wire::kHighestBench, ""}),
    key<&Settings::name_space>("namespace", kText),
    key<&Settings::rate>("rate", NumberLimits{Settings::kLowestRate, Settings::kHighestRate, "Hz"}),
    key<&Settings::is_enabled>("enable"),
    key<&Settings::is_prefixed>("prefix_benches"),
    key<&Settings::command_timeout>("command_timeout", NumberLimits{0.0, 3'600.0, "s"}),
    key<&Settings::start_tolerance>("start_tolerance", NumberLimits{0.0, 10.0, "rad or m"}),
    key<&Settings::stamp_ahead>("stamp_ahead", NumberLimits{0.0, 86'400.0, "s"}),
    section<kTopicRows, &Settings::topics>("topics"),
    {.key = "joints", .then = read_joints},
});

}  // namespace

void read_settings(const std::string& text, const std::string& file, Settings& settings) {
  const YAML::Node document = vdrive::settings::read_yaml(text, file);
  if (!document.IsNull()) read_section(YamlValue(document, file, ""), kRows, settings);
}

void resolve_topics(Settings& settings) {
  std::string& space = settings.name_space;
  if (!space.empty() && !space.starts_with('/')) space.insert(0, "/");
  while (space.ends_with('/')) space.pop_back();
  if (!space.empty() && !ros::check_topic(space).empty()) {
    throw ConfigurationError("namespace: " + ros::check_topic(space));
  }
  std::set<std::string> taken;
  for (const TopicRow& row : kTopics) {
    std::string& topic = settings.topics.*row.name;
    if (!topic.starts_with('/')) topic.insert(0, space + "/");
    if (!taken.insert(topic).second) {
      throw ConfigurationError("two topics are called " + in_quotes(topic));
    }
  }
}

}  // namespace vdrive::ros2
