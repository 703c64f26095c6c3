// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/finding.hpp"
#include "judge/record.hpp"
#include "judge/rule.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::judge {

/// The properties of a source.
struct SourceFacts {
  bool has_time = true;              ///< the times of its records are meaningful
  bool shows_reads = false;          ///< it contains the reads of the master
  bool shows_sessions = false;       ///< it contains the author of each write
  bool speed_is_per_second = false;  ///< 607Fh is in the units of 6064h per second
};

/// Rules that could not be judged on some axes because the source lacks a fact.
struct Unjudged {
  std::uint32_t fact = 0;  ///< one bit of Fact
  std::vector<Rule> rules;
  std::vector<std::uint32_t> axes;
};

/// A finding covered by an exception, with the reason of the exception.
struct Excepted {
  Finding finding;
  std::string reason;
};

/// The result of the judge.
struct Verdict {
  std::vector<Finding> findings;   ///< worst first
  std::vector<Excepted> excepted;  ///< covered by an exception
  std::vector<Unjudged> unjudged;
  std::vector<std::uint32_t> axes;  ///< numbers of the axes seen
  std::uint64_t records = 0;
  Time first{};  ///< of the first record
  Time last{};
};

/// @param fail_on nothing = never
/// @return whether a finding is of severity `fail_on` or worse.
[[nodiscard]] bool fails(const Verdict& verdict, std::optional<Severity> fail_on);

/// Judges masters by their writes and by the state that their drives showed. Depends only on its
/// records: it has no clock, no thread and no file. Its memory per axis is bounded.
class Judge {
 public:
  explicit Judge(const SourceFacts& facts);
  ~Judge();
  Judge(const Judge&) = delete;
  Judge& operator=(const Judge&) = delete;
  Judge(Judge&&) noexcept;
  Judge& operator=(Judge&&) noexcept;

  /// The records of an axis must be in order of time; those of different axes need not be.
  void take(const Record& record);

  /// @return the verdict so far; more records may follow.
  [[nodiscard]] Verdict verdict() const;

  /// @param is_over the source has shown the end of the run; otherwise it may be cut off anywhere
  [[nodiscard]] Verdict end(bool is_over = false);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vdrive::judge
