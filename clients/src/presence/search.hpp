// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace vdrive::client {

using SearchClock = std::chrono::steady_clock;

/// A snapshot of what a search for benches has found so far.
struct SearchFindings {
  std::size_t present = 0;       ///< benches that are described and alive
  std::size_t participants = 0;  ///< other participants of any kind; clients do not see each other
  /// Participants of services that this session can meet: known some 100 ms before their benches.
  std::size_t services = 0;
  std::size_t undescribed = 0;  ///< of these, those that have not described their bench
  std::size_t unreachable = 0;  ///< services in the other security mode (open or closed)
  bool is_complete = false;     ///< it is certain that no further bench is present
};

/// @param delay see SearchTime
/// @return a text such as "seen: 3 other participants, 1 service that has not described its bench".
[[nodiscard]] std::string text_of(const SearchFindings& findings, SearchClock::duration delay);

/// Decides when an unsuccessful search ends. It waits longer for a participant that has announced
/// itself as a service. It also waits longer on a machine that runs this thread late, because such
/// a machine delays every thread that a description passes through, here and in the service.
class SearchTime {
 public:
  SearchTime(SearchClock::time_point begin, std::chrono::milliseconds timeout);

  /// Records that a wait planned to end at `planned` ended at `now`.
  void note_wait(SearchClock::time_point planned, SearchClock::time_point now);

  /// @param is_expecting a service has announced itself, and nothing has been found
  [[nodiscard]] SearchClock::time_point end(bool is_expecting) const;

  /// @return the total delay of the search caused by this machine.
  [[nodiscard]] SearchClock::duration delay() const { return delay_; }

 private:
  SearchClock::time_point begin_;
  SearchClock::duration timeout_;
  SearchClock::duration delay_{};
};

/// Decides when a search that has found something has found everything: each service has described
/// its bench, and for a while no further service or bench has appeared.
class SearchCompletion {
 public:
  explicit SearchCompletion(SearchClock::time_point begin) : services_(begin), benches_(begin) {}

  bool has_ended(const SearchFindings& findings, SearchClock::time_point now);

  /// @return when the search must look again even if nothing changes: the next time at which one of
  ///         the counts ends; time_point::max() if there is none.
  [[nodiscard]] SearchClock::time_point next_end(SearchClock::time_point now) const;

 private:
  /// The number of services or benches found. It has ended once it has not changed for a while.
  class Count {
   public:
    explicit Count(SearchClock::time_point begin) : begin_(begin) {}

    void note(std::size_t count, SearchClock::time_point now);

    [[nodiscard]] bool has_ended(SearchClock::time_point now) const;

    [[nodiscard]] SearchClock::time_point end() const { return end_; }

   private:
    SearchClock::time_point begin_;
    SearchClock::duration settle_{};
    std::size_t count_ = 0;
    SearchClock::time_point end_ = SearchClock::time_point::max();
  };

  Count services_;
  Count benches_;
};

}  // namespace vdrive::client
