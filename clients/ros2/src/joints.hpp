// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "settings.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/client/bench.hpp"
#include "vdrive/client/session.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::ros2 {

/// An axis as a ROS joint.
struct ServedJoint {
  std::string name;
  client::AxisId axis;
  client::Unit unit;
  double si_per_user_unit = 1.0;  ///< [rad or m]
  std::optional<CommandInterface> interface {};

  /// @return its name in reports, such as "joint x".
  [[nodiscard]] std::string label() const { return "joint " + name; }

  /// @return "rad" or "m".
  [[nodiscard]] const char* unit_name() const noexcept {
    return unit.kind == client::UnitKind::rotary ? "rad" : "m";
  }
};

/// The joints of a bench, one per axis, in the order of its axes. A joint has the name from the
/// configuration, otherwise that of its axis, with the prefix "bench1_" if the settings ask for it.
[[nodiscard]] std::vector<ServedJoint> joints_of(const client::BenchInfo& bench,
                                                 const Settings& settings);

/// @return the mode in which a drive follows set-points of this interface.
[[nodiscard]] OperatingMode mode_of(CommandInterface interface) noexcept;

/// @return the set-point sent to an axis before a stream, or with its first set-point: its mode
///         (6060h), and 0 in 60C2h:01, 60B0h, 60B1h and 60B2h.
[[nodiscard]] client::SetPoint begin_stream(std::uint16_t axis, OperatingMode mode);

/// Identifies a joint by its bench and its place among the axes.
struct JointPlace {
  std::uint32_t bench = 0;
  std::size_t place = 0;
  std::optional<CommandInterface> interface {};  ///< the only one permitted by the configuration

  friend bool operator==(const JointPlace&, const JointPlace&) = default;
};

/// The joints by name. A name refers to one axis.
class JointDirectory {
 public:
  /// Adds the joints of a bench, all or none.
  /// @return why it adds none, with the joint whose name occurs twice or on another bench; nothing
  ///         if it adds all.
  [[nodiscard]] std::optional<std::string> add(std::uint32_t bench,
                                               const std::vector<ServedJoint>& joints);

  void remove(std::uint32_t bench);

  [[nodiscard]] std::optional<JointPlace> find(std::string_view name) const;

  /// @param name not the name of a joint
  /// @return the words that follow the name in a message: that it is unknown, the nearest name, and
  ///         the first known ones.
  [[nodiscard]] std::string unknown(std::string_view name) const;

 private:
  using Texts = std::map<std::string, std::string, std::less<>>;

  [[nodiscard]] std::string describe_unknown(std::string_view name) const;

  std::map<std::string, JointPlace, std::less<>> places_;
  /// Cached, because a robot may command an unknown joint a thousand times per second: the nearest
  /// name is searched for only once.
  mutable Texts unknown_;
};

}  // namespace vdrive::ros2
