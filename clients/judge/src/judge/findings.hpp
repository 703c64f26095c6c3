// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/finding.hpp"

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <utility>
#include <vector>

namespace vdrive::judge {

/// The last changes of one axis; also collects what follows a finding. Its size is bounded.
class History {
 public:
  static constexpr std::size_t kLinesBefore = 16;
  static constexpr std::size_t kLinesAfter = 8;
  static constexpr std::size_t kSamplesBefore = 160;
  static constexpr std::size_t kSamplesAfter = 80;

  void put(const Line& line);
  void put(const Sample& sample);

  /// Gives the finding the preceding lines and samples, and later the following ones.
  /// @param finding must keep its address
  void open(Finding& finding);

  /// Ends the collection for all findings.
  void close() { windows_.clear(); }

 private:
  struct Window {
    Finding* finding;
    std::size_t lines;    ///< still to be added
    std::size_t samples;  ///< still to be added
  };

  std::deque<Line> lines_;
  std::vector<Sample> samples_;    ///< the last ones, in a ring buffer
  std::size_t oldest_sample_ = 0;  ///< used once the ring is full
  std::vector<Window> windows_;
};

/// The findings, one per rule and axis.
class Findings {
 public:
  /// @param text called for the first occurrence only, or each time if the rule has figures
  template <typename Text>
  void report(Rule rule, std::uint32_t axis, const Place& place, History& history,
              const Text& text) {
    auto [entry, is_new] = findings_.try_emplace({rule, axis});
    Finding& finding = entry->second;
    ++finding.count;
    finding.last = place;
    if (is_new) {
      finding.rule = rule;
      finding.axis = axis;
      finding.first = place;
      history.open(finding);
    }
    if (is_new || row_of(rule).is_figure) finding.happened = text();
  }

  /// @return all findings, worst first, then by rule and axis.
  [[nodiscard]] std::vector<Finding> all() const;

  void clear() { findings_.clear(); }

 private:
  std::map<std::pair<Rule, std::uint32_t>, Finding> findings_;
};

/// The view that a rule has of an axis at one record.
struct Context {
  const AxisTrack& track;
  Findings& findings;
  History& history;
  std::uint32_t axis = 0;
  Place place;
  bool has_time = true;  ///< durations are meaningful

  [[nodiscard]] Time now() const noexcept { return place.time; }

  template <typename Text>
  void report(Rule rule, const Text& text) const {
    if (!has_time && (row_of(rule).needs & Fact::kTime) != 0) return;
    findings.report(rule, axis, place, history, text);
  }
};

}  // namespace vdrive::judge
