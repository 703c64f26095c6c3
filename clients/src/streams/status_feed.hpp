// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "presence/directory.hpp"
#include "vdrive/client/axis_snapshot.hpp"
#include "vdrive/wire/status_frame.hpp"
#include "vdrive_messages.hpp"

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

namespace vdrive::client {

[[nodiscard]] AxisSnapshot sample_of(const msg::AxisStatus& message);

/// Fills a snapshot, possibly a reused one, from an axis of a frame or of a reply.
void fill_sample(const wire::ReceivedStatus& received, AxisSnapshot& sample);

/// A range of axis numbers.
struct AxisRange {
  std::uint16_t lowest = 0;
  std::uint16_t highest = 0;
};

/// @param frame must contain an axis
[[nodiscard]] AxisRange range_of(const wire::StatusFrameView& frame) noexcept;

/// Assembles the status frames of a bench into samples that show all wanted axes after one tick.
/// Counts lost ticks and, separately, ticks that the tick number jumped over and that were never
/// run. Each frame carries the number of ticks jumped over, so that a lost frame hides no jump. Not
/// thread-safe.
class StatusFeed {
 public:
  /// @param axes each once; samples have this order
  /// @param first_tick frames of earlier ticks are ignored
  StatusFeed(BenchKey key, std::vector<std::uint16_t> axes, std::uint32_t status_every_ticks,
             std::uint64_t first_tick = 0);

  /// @return whether a frame with axes in this range may contain a wanted one. Other frames need
  ///         not be searched: a bench of 10,000 axes sends 40 frames per tick.
  [[nodiscard]] bool wants(const AxisRange& range) const noexcept {
    return count_ == 0 || (range.lowest <= wanted_.highest && wanted_.lowest <= range.highest);
  }

  /// Takes one frame; those of other benches are ignored.
  /// @return whether it completed a sample.
  bool on_frame(const wire::StatusFrameView& frame);

  /// @return whether take() would return a sample.
  [[nodiscard]] bool has_sample() const noexcept { return !samples_.empty(); }

  /// Moves the oldest sample not yet taken to `sample` and keeps the memory of `sample` for a later
  /// one.
  /// @return whether there was one; if not, `sample` is unchanged.
  bool take(Observation& sample);

  /// @return the oldest sample not yet taken, or nothing.
  [[nodiscard]] std::optional<Observation> take();

 private:
  void start(std::uint64_t tick);
  void keep(std::vector<AxisSnapshot> axes);
  void count_gap(Observation& sample, const RunTime& time);

  BenchKey key_;
  std::size_t count_;
  AxisRange wanted_;
  std::vector<std::size_t> places_;  ///< in a sample, by axis number; count_ = not wanted
  std::uint32_t status_every_ticks_;

  /// A sample, and the skipped ticks up to it as its frames report them.
  struct Sample {
    Observation observation;
    std::uint32_t skipped_ticks = 0;
  };

  Observation growing_;
  std::vector<bool> seen_;
  std::size_t seen_count_ = 0;
  std::deque<Sample> samples_;
  std::vector<std::vector<AxisSnapshot>> spares_;  ///< memory of samples already taken
  std::optional<RunTime> last_;                    ///< of the last sample taken
  std::uint64_t skipped_ = 0;                      ///< ticks skipped since the first sample
};

}  // namespace vdrive::client
