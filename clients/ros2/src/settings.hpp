// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/session.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::ros2 {

/// The quantity by which a joint is commanded.
enum class CommandInterface : std::uint8_t { position, velocity, effort };

[[nodiscard]] constexpr std::string_view to_string(CommandInterface interface) noexcept {
  constexpr std::array<std::string_view, 3> kNames{"position", "velocity", "effort"};
  return kNames[static_cast<std::size_t>(interface)];
}

/// Names of topics: those that begin with '/' are absolute, the others are prefixed with the
/// namespace.
struct TopicNames {
  std::string joint_states = "joint_states";
  std::string joint_commands = "robot_joint_commands";
  std::string joint_trajectory = "joint_trajectory";
  std::string enable = "enable";
  std::string diagnostics = "/diagnostics";
  std::string rosout = "/rosout";
  std::string clock = "/clock";
};

/// A joint named in the configuration.
struct JointSetting {
  std::string name;
  std::string axis;                              ///< "1.2", "1.lift" or the name of the axis
  std::optional<CommandInterface> interface {};  ///< the only one that may command it
};

/// The settings of vdrive-ros2.
struct Settings {
  static constexpr double kLowestRate = 1.0;
  static constexpr double kHighestRate = 1000.0;

  client::SessionOptions session{};
  std::vector<std::uint32_t> benches{};  ///< empty = every bench
  std::string name_space{};              ///< such as "/cell1"
  double rate = 100.0;                   ///< joint state messages per second
  bool is_enabled = false;               ///< axes are enabled as soon as their bench is found
  bool is_prefixed = false;              ///< joints are called bench1_x
  double command_timeout = 0.0;          ///< [s] after which a joint brakes; 0 = never
  double start_tolerance = 0.01;         ///< [rad or m] between a joint and a point at time 0
  double stamp_ahead = 60.0;  ///< [s] that a stamp may be ahead of the time of its bench; 0 = any
  TopicNames topics{};
  std::vector<JointSetting> joints{};
};

/// Reads a YAML document; its keys replace the values in `settings`.
/// @throws settings::ConfigurationError with file, line, key, value and limit
void read_settings(const std::string& text, const std::string& file, Settings& settings);

/// Prefixes the topics with the namespace.
/// @throws settings::ConfigurationError for a name that ROS does not permit.
void resolve_topics(Settings& settings);

}  // namespace vdrive::ros2
