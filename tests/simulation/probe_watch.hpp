// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "simulation/happenings.hpp"
#include "support/programs/model.hpp"
#include "vdrive/axis_bank.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace vdrive::simulation {

/// Checks the touch probes of one axis (60B8h to 60BDh, 60D5h to 60D8h) from time to time.
class ProbeWatch {
 public:
  static constexpr std::size_t kEdges = 4;  ///< positive and negative, of two probes

  /// The probe objects of the axis.
  struct Look {
    unsigned function = 0;                         ///< 60B8h
    unsigned status = 0;                           ///< 60B9h
    std::array<std::int64_t, kEdges> positions{};  ///< 60BAh to 60BDh [UU]
    std::array<std::uint16_t, kEdges> counters{};  ///< 60D5h to 60D8h
  };

  ProbeWatch(std::uint16_t number, const test::AxisLimits& limits)
      : number_(number), limits_(limits) {}

  [[nodiscard]] static Look look_at(const AxisBank& bank, std::size_t axis);

  /// @param ticks an upper bound of the ticks since the last check
  void check(const Look& now, std::uint64_t ticks, Happenings& happenings);

  /// Forgets the last look: the following checks start again.
  void begin() { has_last_ = false; }

 private:
  void check_status(const Look& now, Happenings& happenings) const;
  void check_positions(const Look& now, Happenings& happenings) const;
  void check_counters(const Look& now, std::uint64_t ticks, Happenings& happenings) const;

  std::uint16_t number_;
  test::AxisLimits limits_;
  Look last_;
  bool has_last_ = false;
};

}  // namespace vdrive::simulation
