// SPDX-License-Identifier: Apache-2.0
#pragma once

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

/// What a recording lacks, by tick numbers: the first gaps each, the others as a count.
class GapLog {
 public:
  /// How many gaps are kept.
  static constexpr std::size_t kKept = 1000;

  /// The next sample of a bench was recorded.
  /// @param missed samples between it and the one before
  void note_sample(std::uint32_t bench, std::uint64_t tick, std::uint64_t missed);

  /// Samples behind the last one were received and not recorded.
  void note_lost_end(std::uint32_t bench, std::uint64_t missed);

  [[nodiscard]] const std::vector<Gap>& gaps() const noexcept { return gaps_; }

  /// @return samples that are missing in all.
  [[nodiscard]] std::uint64_t missed() const noexcept { return missed_; }

  /// @return gaps beyond those that are kept.
  [[nodiscard]] std::uint64_t left_out() const noexcept { return left_out_; }

  /// @return such as "between the ticks 12 and 15 of bench 1 (2), and 3 further gaps"; empty when
  ///         nothing is missing.
  /// @param most gaps that are named
  [[nodiscard]] std::string text(std::size_t most) const;

 private:
  void add(const Gap& gap);

  std::map<std::uint32_t, std::uint64_t> last_ticks_;
  std::vector<Gap> gaps_;
  std::uint64_t missed_ = 0;
  std::uint64_t left_out_ = 0;
};

}  // namespace vdrive::recording
