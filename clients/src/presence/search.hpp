// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace vdrive::client {

using SearchClock = std::chrono::steady_clock;

/// What a search for benches sees at one time.
struct Sight {
  std::size_t present = 0;       ///< benches that have described themselves and live
  std::size_t participants = 0;  ///< others of any kind; clients do not see each other
  /// Participants of services that this session can meet: known some 100 ms before their benches.
  std::size_t services = 0;
  std::size_t undescribed = 0;  ///< of these, those that have not shown their bench
  std::size_t unreachable = 0;  ///< services of the other mode: closed for an open session
  bool is_complete = false;     ///< nobody else is there, for certain
};

/// @param delay see SearchTime
/// @return words such as "seen: 3 other participants, 1 service that has not described its bench".
[[nodiscard]] std::string text_of(const Sight& sight, SearchClock::duration delay);

/// Until when a search goes on. A participant that announced itself as a service is worth waiting
/// for. A machine that lets this thread run late lets every thread run late that a description
/// passes, here and in the service.
class SearchTime {
 public:
  SearchTime(SearchClock::time_point begin, std::chrono::milliseconds timeout);

  /// The search was to go on at `planned`, and does at `now`.
  void note_wait(SearchClock::time_point planned, SearchClock::time_point now);

  /// @param is_expecting a service has announced itself, and nothing has been found
  [[nodiscard]] SearchClock::time_point end(bool is_expecting) const;

  /// @return how late this machine has let the search run, in all.
  [[nodiscard]] SearchClock::duration delay() const { return delay_; }

 private:
  SearchClock::time_point begin_;
  SearchClock::duration timeout_;
  SearchClock::duration delay_{};
};

/// When a search that has found something has found everything: each service has shown its bench,
/// and for a while no further service or no further bench has come.
class Settling {
 public:
  explicit Settling(SearchClock::time_point begin) : services_(begin), benches_(begin) {}

  bool has_ended(const Sight& sight, SearchClock::time_point now);

  /// @return when the search is to look again though nothing has changed: the next end of a while
  ///         without a further service or bench; the last time that there is for none.
  [[nodiscard]] SearchClock::time_point next_end(SearchClock::time_point now) const;

 private:
  /// A number that changes while more are found.
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
