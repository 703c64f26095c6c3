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

/// What a source says of itself.
struct SourceFacts {
  bool has_time = true;              ///< the times of its records mean something
  bool shows_reads = false;          ///< what the master reads
  bool shows_sessions = false;       ///< who has written
  bool speed_is_per_second = false;  ///< 607Fh is in the units of 6064h a second
};

/// Rules that could not be judged on some axes, because the source lacks a fact.
struct Unjudged {
  std::uint32_t fact = 0;  ///< one bit of Fact
  std::vector<Rule> rules;
  std::vector<std::uint32_t> axes;
};

/// A finding that an exception covers, with its reason.
struct Excepted {
  Finding finding;
  std::string reason;
};

/// What the judge says in the end.
struct Verdict {
  std::vector<Finding> findings;   ///< worst first
  std::vector<Excepted> excepted;  ///< left out by an exception
  std::vector<Unjudged> unjudged;
  std::vector<std::uint32_t> axes;  ///< that were seen, by their number
  std::uint64_t records = 0;
  Time first{};  ///< of the first record
  Time last{};
};

/// @param fail_on nothing = never
/// @return whether a finding is at or above `fail_on`.
[[nodiscard]] bool fails(const Verdict& verdict, std::optional<Severity> fail_on);

/// Judges masters by what they wrote and what their drives showed. A function of its records: it
/// has no clock, no thread and no file. It keeps a bounded number of bytes for each axis.
class Judge {
 public:
  explicit Judge(const SourceFacts& facts);
  ~Judge();
  Judge(const Judge&) = delete;
  Judge& operator=(const Judge&) = delete;
  Judge(Judge&&) noexcept;
  Judge& operator=(Judge&&) noexcept;

  /// The records of an axis come in the order of their times; those of different axes need not.
  void take(const Record& record);

  /// @return what it would say now; more may come.
  [[nodiscard]] Verdict verdict() const;

  /// @param is_over the source has shown the end of the run; else it may be cut anywhere
  [[nodiscard]] Verdict end(bool is_over = false);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vdrive::judge
