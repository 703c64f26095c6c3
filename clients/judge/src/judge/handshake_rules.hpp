// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/findings.hpp"
#include "judge/record.hpp"

#include <cstdint>
#include <optional>

namespace vdrive::judge {

/// Set-points of profile position: bits 4, 5, 6 and 12 (CiA 402-2).
class HandshakeRules {
 public:
  /// To be called before the track of `context` is updated with the write.
  void take(const Write& write, const Context& context);

  /// To be called after the track of `context` was updated.
  void take(const Shown& shown, const Context& context);

  void forget();

 private:
  void take_word(const Write& write, std::uint16_t word, const Context& context);
  void watch_pulse(std::uint16_t word, const Context& context);
  void end_pulse(const Context& context);
  void take_target(const Write& write, const Context& context);
  void rise(std::uint16_t word, const Context& context);
  void fall(std::uint16_t word, const Context& context);
  void stay(const Write& write, const Context& context);
  void note_stream(const Context& context);

  /// The edge that is waiting for its acknowledge.
  struct Edge {
    Time time{};
    bool had_target = false;  ///< 607Ah was written since the previous edge
    bool is_acknowledged = false;
    bool is_reported = false;
  };

  /// A rising edge of bit 4 or 7.
  struct Pulse {
    std::uint16_t bit = 0;
    Time time{};
  };

  std::optional<Edge> edge_;   ///< while bit 4 is set in Operation enabled
  bool saw_disabled_ = false;  ///< the source shows the axis from before it was enabled
  bool has_taken_ = false;     ///< there was a set-point since Operation enabled
  bool has_target_ = false;    ///< 607Ah was written since the last edge
  std::uint32_t targets_without_edge_ = 0;  ///< other values of 607Ah while bit 4 stays set
  Time first_without_edge_{};
  bool is_relative_left_ = false;    ///< bit 6 stayed set when bit 4 fell
  bool had_absolute_ = false;        ///< there was an earlier set-point with bit 6 = 0
  std::uint32_t relative_kept_ = 0;  ///< set-points with a bit 6 that was never cleared
  std::optional<Pulse> pulse_;
  std::uint32_t stream_targets_ = 0;
  std::uint32_t stream_edges_ = 0;
  Time last_target_{};
};

}  // namespace vdrive::judge
