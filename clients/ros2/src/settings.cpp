// SPDX-License-Identifier: Apache-2.0
#include "settings.hpp"

#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wire/bench_number.hpp"
#include "vdrive/wire/ros.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <utility>

namespace vdrive::ros2 {
namespace {

/// A value of the document; each error has its file, line and key.
class Value {
 public:
  Value(const YAML::Node& node, std::string file, std::string key)
      : node_(node), file_(std::move(file)), key_(std::move(key)) {}

  [[noreturn]] void refuse(const std::string& problem) const {
    const std::string shown = node_.IsScalar() ? " " + in_quotes(node_.Scalar()) : "";
    throw BadSettings(file_ + ":" + std::to_string(node_.Mark().line + 1) + ": " + key_ + shown +
                      ": " + problem);
  }

  [[nodiscard]] std::string text() const {
    if (!node_.IsScalar() || node_.Scalar().empty()) refuse("must be text");
    return node_.Scalar();
  }

  [[nodiscard]] double number(double lowest, double highest, const std::string& unit) const {
    const auto value = node_.IsScalar() ? parse_number(node_.Scalar()) : std::nullopt;
    if (!value || *value < lowest || *value > highest) {
      refuse("must be a number from " + to_text(lowest) + " to " + to_text(highest) +
             (unit.empty() ? "" : " " + unit));
    }
    return *value;
  }

  [[nodiscard]] bool boolean() const {
    bool value = false;
    if (!node_.IsScalar() || !YAML::convert<bool>::decode(node_, value)) {
      refuse("must be true or false");
    }
    return value;
  }

  using Visit = std::function<void(const std::string& key, const Value& value)>;

  void for_each_entry(const Visit& visit) const {
    if (!node_.IsMap()) refuse("must be a map");
    std::set<std::string> seen;
    for (const auto& entry : node_) {
      if (!entry.first.IsScalar()) refuse("has a key that is not text");
      const std::string& key = entry.first.Scalar();
      const Value value(entry.second, file_, key_.empty() ? key : key_ + "." + key);
      if (!seen.insert(key).second) value.refuse("occurs twice");
      visit(key, value);
    }
  }

  void for_each_element(const std::function<void(const Value&)>& visit) const {
    if (!node_.IsSequence()) refuse("must be a list");
    for (const auto& element : node_) visit(Value(element, file_, key_));
  }

  [[nodiscard]] bool is_map() const { return node_.IsMap(); }

 private:
  YAML::Node node_;
  std::string file_;
  std::string key_;
};

using Setter = std::function<void(const Value& value)>;

/// @throws BadSettings for a key that has no setter.
void read_map(const Value& map, const std::map<std::string, Setter>& setters) {
  map.for_each_entry([&](const std::string& key, const Value& value) {
    const auto setter = setters.find(key);
    if (setter != setters.end()) return setter->second(value);
    std::string known;
    for (const auto& [name, unused] : setters) known += (known.empty() ? "" : ", ") + name;
    value.refuse("is not a key here; the keys are " + known);
  });
}

void read_topics(const Value& map, TopicNames& topics) {
  const auto name = [](std::string& topic) {
    return [&topic](const Value& value) {
      topic = value.text();
      const std::string absolute = topic.starts_with('/') ? topic : "/" + topic;
      if (!wire::ros::check_topic(absolute).empty()) {
        value.refuse("is not the name of a topic: letters, digits and '_', parts divided by '/'");
      }
    };
  };
  read_map(map, {{"joint_states", name(topics.joint_states)},
                 {"joint_commands", name(topics.joint_commands)},
                 {"joint_trajectory", name(topics.joint_trajectory)},
                 {"enable", name(topics.enable)},
                 {"diagnostics", name(topics.diagnostics)},
                 {"rosout", name(topics.rosout)},
                 {"clock", name(topics.clock)}});
}

Interface read_interface(const Value& value) {
  const std::string text = value.text();
  for (const Interface interface : {Interface::position, Interface::velocity, Interface::effort}) {
    if (text == to_string(interface)) return interface;
  }
  value.refuse("must be position, velocity or effort");
}

JointSetting read_joint(const std::string& name, const Value& value) {
  JointSetting joint{.name = name, .axis = {}};
  if (!value.is_map()) {
    joint.axis = value.text();
    return joint;
  }
  read_map(value, {{"axis",
                    [&](const Value& axis) {
                      joint.axis = axis.text();
                    }},
                   {"interface", [&](const Value& interface) {
                      joint.interface = read_interface(interface);
                    }}});
  if (joint.axis.empty()) value.refuse("needs the key axis, such as \"1.2\"");
  return joint;
}

void read_joints(const Value& map, std::vector<JointSetting>& joints) {
  joints.clear();
  map.for_each_entry([&](const std::string& name, const Value& value) {
    joints.push_back(read_joint(name, value));
    const bool is_twice = std::ranges::count(joints, joints.back().axis, &JointSetting::axis) > 1;
    if (is_twice) value.refuse("the axis has another joint already");
  });
}

void read_benches(const Value& list, std::vector<std::uint32_t>& benches) {
  benches.clear();
  list.for_each_element([&](const Value& element) {
    const double number = element.number(1, wire::kHighestBench, "");
    const auto whole = static_cast<std::uint32_t>(number);
    if (static_cast<double>(whole) != number) element.refuse("must be a whole number");
    benches.push_back(whole);
  });
}

}  // namespace

std::string read_settings_file(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw BadSettings("--config: cannot read " + in_quotes(file));
  std::string text(kLargestSettingsFile + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  if (text.size() <= kLargestSettingsFile) return text;
  stream.clear();
  const auto size = stream.seekg(0, std::ios::end).tellg();  // -1 of a pipe
  throw BadSettings("--config: " + in_quotes(file) + " has " +
                    (size < 0 ? "more than " + std::to_string(kLargestSettingsFile)
                              : std::to_string(static_cast<std::streamoff>(size))) +
                    " bytes; at most " + std::to_string(kLargestSettingsFile) + " are read");
}

void read_settings(const std::string& text, const std::string& file, Settings& settings) {
  constexpr double kLongestTimeout = 3600.0;
  constexpr double kWidestTolerance = 10.0;
  constexpr double kFurthestAhead = 86'400.0;
  YAML::Node document;
  try {
    document = YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw BadSettings(file + ":" + std::to_string(error.mark.line + 1) + ": " + error.msg);
  }
  if (document.IsNull()) return;
  const auto flag = [](bool& target) {
    return [&target](const Value& value) {
      target = value.boolean();
    };
  };
  read_map(Value(document, file, ""),
           {{"benches",
             [&](const Value& value) {
               read_benches(value, settings.benches);
             }},
            {"namespace",
             [&](const Value& value) {
               settings.name_space = value.text();
             }},
            {"rate",
             [&](const Value& value) {
               settings.rate = value.number(Settings::kLowestRate, Settings::kHighestRate, "Hz");
             }},
            {"enable", flag(settings.is_enabled)},
            {"prefix_benches", flag(settings.is_prefixed)},
            {"command_timeout",
             [&](const Value& value) {
               settings.command_timeout = value.number(0.0, kLongestTimeout, "s");
             }},
            {"start_tolerance",
             [&](const Value& value) {
               settings.start_tolerance = value.number(0.0, kWidestTolerance, "rad or m");
             }},
            {"stamp_ahead",
             [&](const Value& value) {
               settings.stamp_ahead = value.number(0.0, kFurthestAhead, "s");
             }},
            {"topics",
             [&](const Value& value) {
               read_topics(value, settings.topics);
             }},
            {"joints", [&](const Value& value) {
               read_joints(value, settings.joints);
             }}});
}

void resolve_topics(Settings& settings) {
  std::string& space = settings.name_space;
  if (!space.empty() && !space.starts_with('/')) space.insert(0, "/");
  while (space.ends_with('/')) space.pop_back();
  if (!space.empty() && !wire::ros::check_topic(space).empty()) {
    throw BadSettings("namespace: " + wire::ros::check_topic(space));
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
      if (*all[i] == *all[other]) throw BadSettings("two topics are called " + in_quotes(*all[i]));
    }
  }
}

}  // namespace vdrive::ros2
