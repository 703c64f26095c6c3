// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace vdrive::judge {

/// The rules, in the order of their table.
enum class Rule : std::uint8_t {
  handshake_before_acknowledge_fell,
  handshake_no_edge,
  handshake_target_after_edge,
  handshake_not_taken,
  handshake_not_enabled,
  handshake_stream,
  handshake_relative_stays,
  handshake_short_pulse,
  state_no_such_command,
  state_not_awaited,
  state_skips_states,
  state_reset_without_edge,
  state_reset_storm,
  state_cause_not_read,
  state_quick_stop_left,
  state_transition_16,
  state_power_off_in_motion,
  state_gave_up,
  state_reset_not_awaited,
  mode_changed_in_motion,
  mode_not_in_force,
  mode_not_looked_at,
  mode_written_again,
  mode_foreign_target,
  homing_pulsed,
  homing_given_up,
  homing_start_kept,
  homing_judged_early,
  motion_target_beyond_limits,
  motion_speed_beyond_limit,
  motion_step_too_long,
  motion_set_point_repeated,
  motion_set_point_missing,
  motion_first_target,
  motion_following_error,
  motion_torque_saturated,
  motion_origin_moved,
  motion_set_point_late,
  motion_acceleration_beyond_limit,
  writers_sdo_beside_pdo,
  writers_two_sessions,
  pdo_not_operational,
  pdo_event_driven_stream,
  pdo_two_in_a_cycle,
  sync_period,
  sync_absent,
  sync_jitter,
  supervision_goes_on_after_fault,
  supervision_fall_unnoticed,
  supervision_into_limit,
  supervision_keep_alive,
  supervision_store_often,
  supervision_stop_cut_short,
  supervision_left_enabled,
};

enum class Severity : std::uint8_t {
  error,    ///< wrong on every drive
  warning,  ///< wrong on some drives; the row says which
  advice,
};

/// @return "error", "warning" or "advice".
[[nodiscard]] std::string_view to_string(Severity severity) noexcept;

/// @return the severity with this name, or nothing.
[[nodiscard]] std::optional<Severity> parse_severity(std::string_view text) noexcept;

/// A set of facts: what a source must show about an axis before a rule can be judged.
struct Fact {
  static constexpr std::uint32_t kControlword = 1U << 0U;
  static constexpr std::uint32_t kStatusword = 1U << 1U;
  static constexpr std::uint32_t kMode = 1U << 2U;  ///< commanded or shown
  static constexpr std::uint32_t kModeShown = 1U << 3U;
  static constexpr std::uint32_t kPosition = 1U << 4U;
  static constexpr std::uint32_t kFollowingError = 1U << 5U;
  static constexpr std::uint32_t kTorque = 1U << 6U;
  static constexpr std::uint32_t kPositionLimits = 1U << 7U;
  static constexpr std::uint32_t kSpeedLimit = 1U << 8U;
  static constexpr std::uint32_t kFollowingWindow = 1U << 9U;
  static constexpr std::uint32_t kTorqueLimit = 1U << 10U;
  static constexpr std::uint32_t kCyclePeriod = 1U << 11U;
  static constexpr std::uint32_t kNodeState = 1U << 12U;
  static constexpr std::uint32_t kTransmissionType = 1U << 13U;
  static constexpr std::uint32_t kKeepAlive = 1U << 14U;
  static constexpr std::uint32_t kReads = 1U << 15U;     ///< the reads of a master
  static constexpr std::uint32_t kSessions = 1U << 16U;  ///< the author of each write
  static constexpr std::uint32_t kTime = 1U << 17U;
  static constexpr std::uint32_t kSync = 1U << 18U;
  static constexpr std::uint32_t kSpeedUnit = 1U << 19U;  ///< 607Fh is in units of 6064h per second
  static constexpr std::uint32_t kLateness = 1U << 20U;   ///< whether a write was too late
  static constexpr std::uint32_t kAccelerationLimit = 1U << 21U;
  static constexpr std::uint32_t kCount = 22;
};

/// @param fact one bit of Fact
/// @return the missing fact, such as "6065h is neither read nor written".
[[nodiscard]] std::string_view missing_text(std::uint32_t fact) noexcept;

/// A row of the table of rules, which reports, documents and checks share. All text is static.
struct RuleRow {
  Rule rule{};
  std::string_view name;   ///< such as "handshake-1"
  std::string_view title;  ///< the mistake of the master, without a full stop
  Severity severity = Severity::error;
  std::string_view clause;    ///< of CiA 402, CiA 301 or the manual
  std::string_view expected;  ///< correct behaviour; for a warning, also which drives require it
  std::string_view remedy;    ///< what to do about it
  std::string_view wrong;     ///< an example
  std::string_view right;
  std::uint32_t needs = 0;  ///< facts
  bool is_figure = false;   ///< the finding has figures of the whole run, so its last text is kept
};

/// Every rule, in the order of Rule.
[[nodiscard]] std::span<const RuleRow> rules() noexcept;

[[nodiscard]] const RuleRow& row_of(Rule rule) noexcept;

/// @return the rule with this name, or nothing.
[[nodiscard]] std::optional<Rule> find_rule(std::string_view name) noexcept;

/// @return the table as Markdown, as in the page docs/reference/judge-rules.md.
[[nodiscard]] std::string rules_page();

}  // namespace vdrive::judge
