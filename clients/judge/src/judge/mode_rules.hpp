// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/findings.hpp"
#include "judge/record.hpp"

#include <cstdint>
#include <deque>
#include <optional>

namespace vdrive::judge {

/// 6060h and 6061h, targets of the modes, and homing (CiA 402-2).
class ModeRules {
 public:
  /// Before the track of `context` has the write.
  void take(const Write& write, const Context& context);

  /// After the track of `context` has what was shown.
  void take(const Shown& shown, const Context& context);

  void forget();

 private:
  void take_mode(const Write& write, const Context& context);
  void note_again(const Write& write, const Context& context);
  void take_word(const Write& write, const Context& context);
  void take_target(const Write& write, const Context& context);
  void leave_homing(const Context& context);
  void stay_in_homing(const Write& write, const Context& context);

  /// @return whether homing was started and no statusword came since, while bits 10 and 12 were up.
  [[nodiscard]] bool is_homing_unseen(const Context& context) const noexcept;

  std::deque<Time> again_;  ///< 6060h = 6061h was written
  std::optional<ObjectAddress> foreign_;
  std::int64_t foreign_value_ = 0;
  std::uint32_t foreign_writes_ = 0;
  std::optional<Time> homing_start_;
  bool was_attained_at_start_ = false;
  bool is_homing_shown_ = false;  ///< a statusword came since the start
  bool is_start_kept_reported_ = false;
};

}  // namespace vdrive::judge
