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
  /// To be called before the track of `context` is updated with the write.
  void take(const Write& write, const Context& context);

  /// To be called after the track of `context` was updated.
  void take(const Shown& shown, const Context& context);

  void forget();

 private:
  void take_mode(const Write& write, const Context& context);
  void note_again(const Write& write, const Context& context);
  void take_word(const Write& write, const Context& context);
  void take_target(const Write& write, const Context& context);
  void leave_homing(const Context& context);
  void stay_in_homing(const Write& write, const Context& context);

  /// @return whether homing was started while bits 10 and 12 were set, and no statusword has
  ///         arrived since.
  [[nodiscard]] bool is_homing_unseen(const Context& context) const noexcept;

  std::deque<Time> again_;  ///< times at which 6060h was written with the mode already in 6061h
  std::optional<ObjectAddress> foreign_;
  std::int64_t foreign_value_ = 0;
  std::uint32_t foreign_writes_ = 0;
  std::optional<Time> homing_start_;
  bool was_attained_at_start_ = false;
  bool is_homing_shown_ = false;  ///< a statusword has arrived since the start
  bool is_start_kept_reported_ = false;
};

}  // namespace vdrive::judge
