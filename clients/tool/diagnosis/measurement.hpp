// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/exit_code.hpp"
#include "output/report.hpp"
#include "terminal/interrupt.hpp"
#include "terminal/terminal.hpp"

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace vdrive::tool {

/// A histogram of lateness, with the bins of BenchState.lateness_histogram: bin i counts events
/// less than 2^i us late.
struct Lateness {
  std::array<std::uint64_t, 32> bins{};

  void add(std::chrono::nanoseconds late) noexcept;

  [[nodiscard]] std::uint64_t count() const noexcept;

  /// @param share from 0 to 1
  /// @return the lateness that this share does not exceed, interpolated linearly within a bin [us];
  ///         0 if empty.
  [[nodiscard]] double quantile(double share) const noexcept;

  /// @return the upper limit of the last non-empty bin [us].
  [[nodiscard]] double most() const noexcept;
};

/// One-tick steps of a lock-step bench, each waiting for its reply.
struct RoundTrips {
  double median = 0.0;  ///< [us]
  double p99 = 0.0;     ///< [us]
  double per_second = 0.0;
};

/// A client that follows all axes of a realtime bench at 1 kHz.
struct StatusStreamFigures {
  std::size_t axes = 0;
  std::uint64_t samples = 0;
  std::uint64_t missed = 0;
  double overrun_share = 0.0;  ///< of all ticks

  /// @return whether every tick arrived, and at most 0.1 % of the ticks were late.
  [[nodiscard]] bool is_whole() const noexcept;
};

/// The measurements of `vdrive bench`, in order.
struct Measurement {
  Lateness bare;  ///< a thread that wakes every millisecond
  Lateness ticks;
  RoundTrips steps;
  double tick_of_an_axis = 0.0;  ///< time of one core for a tick of an axis and for sending its
                                 ///< status, while all axes move [ns]
  std::vector<StatusStreamFigures> streams;

  /// @return the number of axes that one core can step at 1 kHz, including sending their status.
  [[nodiscard]] std::size_t axes_of_a_core() const noexcept;

  /// @return the highest number of axes without a lost tick; 0 = none.
  [[nodiscard]] std::size_t axes_with_status() const noexcept;
};

/// As one JSON object, see docs/reference/json.md.
[[nodiscard]] Json measurement_json(const Measurement& measurement);

/// As a table.
[[nodiscard]] std::vector<std::string> measurement_lines(const Measurement& measurement);

/// @return the number with three significant digits.
[[nodiscard]] std::string rounded(double value);

struct MeasurementOptions {
  std::string service;    ///< the program vdrived
  bool is_quick = false;  ///< short measurements, at most 1,024 axes
  bool is_json = false;
};

/// `vdrive bench`: measures this machine on private benches, which end when it returns.
ExitCode run_measurement(const MeasurementOptions& options, Interrupt& interrupt,
                         Terminal& terminal);

}  // namespace vdrive::tool
