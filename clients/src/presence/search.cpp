// SPDX-License-Identifier: Apache-2.0
#include "presence/search.hpp"

#include "vdrive/wording.hpp"

#include <algorithm>

namespace vdrive::client {
namespace {

using std::chrono::milliseconds;

// If no further bench appears for this time, all present benches have been found. If the first sign
// of a bench took long, on a busy machine or a slow network, the wait is kSettleTimes times as long
// as that took.
constexpr milliseconds kSettle{150};
constexpr int kSettleTimes = 4;

/// How many times as long a search may take if a service has announced itself.
constexpr int kTimesForAnnounced = 3;

/// Threads that a message passes through in sequence, each as late as this one: in the service's
/// library, in the service, in the library here, in the search.
constexpr int kThreadsOfMessage = 4;

/// The delay of the machine lengthens a search by at most this many times its time-out.
constexpr int kMostTimesForDelay = 3;

/// A message mentions the delay of the machine from this value on: smaller delays are usual and
/// explain nothing.
constexpr milliseconds kShownDelay{10};

}  // namespace

std::string text_of(const SearchFindings& findings, SearchClock::duration delay) {
  std::string text = "seen: ";
  text += findings.participants == 0
              ? "no other participant"
              : counted(findings.participants, "other participant", "other participants");
  if (findings.undescribed != 0) {
    text += ", " + counted(findings.undescribed, "service that has not described its bench",
                           "services that have not described their benches");
  }
  if (findings.unreachable != 0) {
    text += ", " + counted(findings.unreachable, "service", "services") +
            " in the other security mode (open or closed)";
  }
  if (delay >= kShownDelay) {
    text += ", the search was delayed by " +
            std::to_string(std::chrono::floor<milliseconds>(delay).count()) + " ms on this machine";
  }
  return text;
}

SearchTime::SearchTime(SearchClock::time_point begin, milliseconds timeout)
    : begin_(begin), timeout_(timeout) {}

void SearchTime::note_wait(SearchClock::time_point planned, SearchClock::time_point now) {
  delay_ += std::max(now - planned, SearchClock::duration::zero());
}

SearchClock::time_point SearchTime::end(bool is_expecting) const {
  return begin_ + (is_expecting ? kTimesForAnnounced : 1) * timeout_ +
         std::min(kThreadsOfMessage * delay_, kMostTimesForDelay * timeout_);
}

bool SearchCompletion::has_ended(const SearchFindings& findings, SearchClock::time_point now) {
  services_.note(findings.services, now);
  benches_.note(findings.present, now);
  if (findings.is_complete) return true;
  return findings.present != 0 && findings.undescribed == 0 &&
         (benches_.has_ended(now) || services_.has_ended(now));
}

SearchClock::time_point SearchCompletion::next_end(SearchClock::time_point now) const {
  auto next = SearchClock::time_point::max();
  for (const auto end : {services_.end(), benches_.end()}) {
    if (end > now) next = std::min(next, end);
  }
  return next;
}

void SearchCompletion::Count::note(std::size_t count, SearchClock::time_point now) {
  if (count == count_) return;
  if (count_ == 0) {
    settle_ = std::max<SearchClock::duration>(kSettle, kSettleTimes * (now - begin_));
  }
  count_ = count;
  end_ = now + settle_;
}

bool SearchCompletion::Count::has_ended(SearchClock::time_point now) const {
  return count_ != 0 && now >= end_;
}

}  // namespace vdrive::client
