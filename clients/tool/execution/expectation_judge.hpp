// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "output/report.hpp"
#include "values/expectation.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>

namespace vdrive::tool {

class FaultWatch;
class ValueObserver;

/// Compares the status of axes with expectations, starting with the tick in which the writes of
/// earlier commands take effect.
class ExpectationJudge {
 public:
  explicit ExpectationJudge(client::Session& session) : session_(session) {}

  /// A write of this session takes effect at `tick`: earlier status of the axis does not count.
  void note_write(const client::AxisId& axis, std::uint64_t tick) { in_force_[axis] = tick; }

  /// This session has control of the axis: a wait ends when another session takes it.
  void note_control(const client::AxisId& axis) { held_.insert(axis); }

  /// @param expectation in user units
  /// @return failed, with found(), if the axis has a different value: now, at the end of `within`,
  ///         or in any tick of `throughout`. found() has `error_code` if a fault ended `within`:
  ///         the axis has been in Fault and at rest for 100 ms of drive time.
  client::Outcome judge(client::Axis& axis, const Expectation& expectation);

  /// Waits until the axis meets a condition of condition_names().
  /// @param limit drive time
  /// @return failed for an axis that stays in Fault, as in judge()
  client::Outcome await(const client::Axis& axis, const std::string& condition, Duration limit);

  /// The deviation that the last judge() found; none for other failures.
  [[nodiscard]] const std::optional<Json>& found() const noexcept { return found_; }

  void set_found(Json found) { found_ = std::move(found); }

  /// Called before the next command.
  void forget_found() { found_.reset(); }

 private:
  client::Outcome compare(client::Axis& axis, const Expectation& expectation);
  client::Outcome within(ValueObserver& observer, const client::BenchInfo& bench,
                         const Expectation& expectation);
  client::Outcome ended_by_fault(const ValueObserver& observer, const Expectation& expectation,
                                 const FaultWatch& fault);
  /// @return the outcome if `within` has passed; it also names a fault of the axis.
  client::Outcome late(const ValueObserver& observer, const Expectation& expectation,
                       const FaultWatch& fault);
  client::Outcome throughout(ValueObserver& observer, const client::BenchInfo& bench,
                             const Expectation& expectation);
  client::Outcome check_control(const client::AxisSnapshot& axis);
  /// @param mode of the axis, decides the names of bits
  client::Outcome differs(const Expectation& expectation, std::int64_t actual, std::uint64_t tick,
                          OperatingMode mode);

  client::Session& session_;
  std::map<client::AxisId, std::uint64_t> in_force_;  ///< tick of the last write
  std::set<client::AxisId> held_;                     ///< axes that this session has controlled
  std::optional<Json> found_;
};

}  // namespace vdrive::tool
