// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/findings.hpp"
#include "judge/record.hpp"

#include <cstdint>
#include <optional>

namespace vdrive::judge {

/// Whether the master monitors its drive: faults, loss of enable, limits, keep-alives, end of the
/// run.
class SupervisionRules {
 public:
  /// To be called before the track of `context` is updated with the write.
  void take(const Write& write, const Context& context);

  /// To be called after the track of `context` was updated.
  void take(const Shown& shown, const Context& context);
  void take(const KeepAlive& sign, const Context& context);

  /// To be called before the track of `context` is updated.
  static void take(const Network& network, const Context& context);

  /// To be called when the run has ended and the source has shown its end.
  static void end(const Context& context);

  void forget();

 private:
  void take_motion(const Context& context);
  void take_streamed(std::int64_t target, const Context& context);

  std::optional<Time> fell_;     ///< when Operation enabled was lost without a command or a fault
  std::uint32_t blind_ = 0;      ///< motion commands since the fault or the loss
  std::optional<Time> limited_;  ///< since when bit 11 has been set
  std::uint32_t outwards_ = 0;   ///< targets further outwards since then
  std::optional<std::int64_t> last_target_;
  std::optional<Time> stored_;
  std::optional<Time> last_sign_;
  Time longest_silence_{};
};

}  // namespace vdrive::judge
