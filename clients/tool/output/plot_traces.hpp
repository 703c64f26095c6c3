// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "output/plot_columns.hpp"
#include "vdrive/cia402/power_state.hpp"
#include "vdrive/client/axis_snapshot.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdrive::tool {

/// A value of a recording.
struct PlotPoint {
  std::uint64_t tick = 0;
  std::int64_t value = 0;

  friend bool operator==(const PlotPoint&, const PlotPoint&) = default;
};

struct PlotTrace {
  PlotColumn column;
  std::vector<PlotPoint> points{};
};

/// A power state, from one tick until the next PlotState.
struct PlotState {
  std::uint64_t from = 0;
  PowerState state = PowerState::not_ready_to_switch_on;
};

/// A tick in which 603Fh shows a new error.
struct PlotFault {
  std::uint64_t tick = 0;
  std::uint16_t code = 0;
};

/// The plotted data of one axis.
struct PlotTraces {
  std::uint64_t first_tick = 0;
  std::uint64_t last_tick = 0;
  std::uint64_t samples = 0;
  std::vector<PlotTrace> traces{};
  std::vector<PlotState> states{};
  std::vector<PlotFault> faults{};    ///< the first kMostPlotFaults
  std::uint64_t faults_left_out = 0;  ///< beyond kMostPlotFaults
};

inline constexpr std::size_t kMostPlotFaults = 50;

/// Reduces the samples of one axis, while they are read, to what a picture can show: per pixel
/// column the lowest and the highest value of a curve with their ticks, and the worst power state.
/// A long recording thus needs no more memory, and no larger file, than a short one, and no peak is
/// lost.
class PlotReduction {
 public:
  /// @param first, last ticks at the edges of the picture
  /// @param bins number of pixel columns, at least 1
  PlotReduction(const std::vector<PlotColumn>& columns, std::uint64_t first, std::uint64_t last,
                std::size_t bins);

  /// Takes the next sample, in the order of ticks. Samples outside the edges are ignored.
  void take(const client::AxisSnapshot& sample);

  /// @return the result; no sample may follow.
  [[nodiscard]] PlotTraces finish() &&;

 private:
  struct Range {
    PlotPoint lowest{};
    PlotPoint highest{};
    PlotPoint newest{};
  };

  void begin_bin(const client::AxisSnapshot& sample);
  void end_bin();
  void take_state(const client::AxisSnapshot& sample);
  void take_fault(const client::AxisSnapshot& sample);

  PlotTraces traces_;
  std::uint64_t bins_;
  std::uint64_t bin_ = 0;
  bool has_bin_ = false;
  std::vector<Range> ranges_;  ///< of the present bin, one per column
  PlotState state_{};          ///< worst of the present bin
  std::uint16_t error_ = 0;
};

}  // namespace vdrive::tool
