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

/// @return a message as a sample of its axis.
[[nodiscard]] AxisSnapshot sample_of(const msg::AxisStatus& message);

/// Fills a sample, which may have been one before, with an axis of a frame or of a reply.
void fill_sample(const wire::ReceivedStatus& received, AxisSnapshot& sample);

/// The numbers of some axes.
struct AxisRange {
  std::uint16_t lowest = 0;
  std::uint16_t highest = 0;
};

/// @param frame has an axis
[[nodiscard]] AxisRange range_of(const wire::StatusFrameView& frame) noexcept;

/// Puts the status frames of a bench together into samples that show all wanted axes after one
/// tick, and counts the ticks that went missing and, apart from them, those that the number jumped
/// over: they were never run. Each frame carries the count, so that a lost one hides no jump. Not
/// thread-safe.
class StatusFeed {
 public:
  /// @param axes none of them twice; samples have this order
  /// @param first_tick frames of earlier ticks are left out
  StatusFeed(BenchKey key, std::vector<std::uint16_t> axes, std::uint32_t status_every_ticks,
             std::uint64_t first_tick = 0);

  /// @return whether a frame with these axes may have one that is wanted: a bench of 10,000 axes
  ///         sends 40 frames a tick, and each is looked through once for each feed that wants it.
  [[nodiscard]] bool wants(const AxisRange& range) const noexcept {
    return count_ == 0 || (range.lowest <= wanted_.highest && wanted_.lowest <= range.highest);
  }

  /// Takes one frame; others' benches are ignored.
  /// @return whether it completed a sample.
  bool on_frame(const wire::StatusFrameView& frame);

  /// @return whether take() has one.
  [[nodiscard]] bool has_sample() const noexcept { return !samples_.empty(); }

  /// Gives `sample` the oldest sample that was not taken yet and keeps its memory for a later one.
  /// @return whether there was one; `sample` is as it was when there was none.
  bool take(Observation& sample);

  /// @return the oldest sample that was not taken yet, or nothing.
  [[nodiscard]] std::optional<Observation> take();

 private:
  void start(std::uint64_t tick);
  void keep(std::vector<AxisSnapshot> axes);
  void count_gap(Observation& sample, const RunTime& time);

  BenchKey key_;
  std::size_t count_;
  AxisRange wanted_;
  std::vector<std::size_t> places_;  ///< in a sample, by number of the axis; count_ = not wanted
  std::uint32_t status_every_ticks_;

  /// A sample and what its frames say about the time.
  struct Sample {
    Observation observation;
    std::uint32_t skipped_ticks = 0;
  };

  Observation growing_;
  std::vector<bool> seen_;
  std::size_t seen_count_ = 0;
  std::deque<Sample> samples_;
  std::vector<std::vector<AxisSnapshot>> spares_;  ///< memory of samples that were taken
  std::optional<RunTime> last_;                    ///< of the sample taken last
  std::uint64_t skipped_ = 0;                      ///< since the first one
};

}  // namespace vdrive::client
