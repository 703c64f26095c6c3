// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/findings.hpp"
#include "judge/record.hpp"

#include <cstdint>
#include <optional>

namespace vdrive::judge {

/// Whether the master looks at its drive: faults, falls, limits, signs of life, the end.
class SupervisionRules {
 public:
  /// Before the track of `context` has the write.
  void take(const Write& write, const Context& context);

  /// After the track of `context` has what was shown.
  void take(const Shown& shown, const Context& context);
  void take(const KeepAlive& sign, const Context& context);

  /// Before the track of `context` has it.
  static void take(const Network& network, const Context& context);

  /// The run has ended, and the source has shown its end.
  static void end(const Context& context);

  void forget();

 private:
  void take_motion(const Context& context);
  void take_streamed(std::int64_t target, const Context& context);

  std::optional<Time> fell_;     ///< out of Operation enabled, without a command or a fault
  std::uint32_t blind_ = 0;      ///< commands of motion since the fault or the fall
  std::optional<Time> limited_;  ///< bit 11 is up
  std::uint32_t outwards_ = 0;   ///< targets further out since
  std::optional<std::int64_t> last_target_;
  std::optional<Time> stored_;
  std::optional<Time> last_sign_;
  Time longest_silence_{};
};

}  // namespace vdrive::judge
