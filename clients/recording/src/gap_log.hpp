// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/axis_snapshot.hpp"

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace vdrive::recording {

/// Samples of a bench that a recording lacks.
struct Gap {
  std::uint32_t bench = 0;
  std::uint64_t after = 0;   ///< tick of the sample before, 0 = the recording lacks its beginning
  std::uint64_t before = 0;  ///< tick of the sample behind, 0 = the recording lacks its end
  std::uint64_t missed = 0;  ///< samples
};

/// A jump of the tick number of a bench: the ticks between were not run, so that nothing is lost.
struct Jump {
  std::uint32_t bench = 0;
  std::uint64_t after = 0;    ///< tick of the sample before
  std::uint64_t before = 0;   ///< tick of the sample behind
  std::uint64_t skipped = 0;  ///< ticks
};

/// What a recording lacks, and what it cannot have, by tick numbers: the first gaps and jumps each,
/// the others as a count.
class GapLog {
 public:
  /// How many gaps are kept.
  static constexpr std::size_t kKept = 1000;

  /// The next sample of a bench was recorded, with `missed` and `skipped` since the one before that
  /// was recorded.
  void note_sample(const client::Observation& sample);

  /// Samples behind the last one were received and not recorded.
  void note_lost_end(std::uint32_t bench, std::uint64_t missed);

  [[nodiscard]] const std::vector<Gap>& gaps() const noexcept { return gaps_; }

  /// @return samples that are missing in all.
  [[nodiscard]] std::uint64_t missed() const noexcept { return missed_; }

  /// @return gaps beyond those that are kept.
  [[nodiscard]] std::uint64_t left_out() const noexcept { return left_out_; }

  [[nodiscard]] const std::vector<Jump>& jumps() const noexcept { return jumps_; }

  /// @return ticks that were jumped over in all.
  [[nodiscard]] std::uint64_t skipped() const noexcept { return skipped_; }

  /// @return jumps beyond those that are kept.
  [[nodiscard]] std::uint64_t jumps_left_out() const noexcept { return jumps_left_out_; }

  /// @return such as "between the ticks 12 and 15 of bench 1 (2), and 3 further gaps"; empty when
  ///         nothing is missing.
  /// @param most gaps that are named
  [[nodiscard]] std::string text(std::size_t most) const;

  /// @return the same of the jumps.
  [[nodiscard]] std::string jumps_text(std::size_t most) const;

 private:
  void add(const Gap& gap);
  void add(const Jump& jump);

  std::map<std::uint32_t, std::uint64_t> last_ticks_;
  std::vector<Gap> gaps_;
  std::uint64_t missed_ = 0;
  std::uint64_t left_out_ = 0;
  std::vector<Jump> jumps_;
  std::uint64_t skipped_ = 0;
  std::uint64_t jumps_left_out_ = 0;
};

}  // namespace vdrive::recording
