// SPDX-License-Identifier: Apache-2.0
#include "presence/service_watch.hpp"

#include <set>
#include <string>
#include <utility>

namespace vdrive::client {
namespace {

using std::chrono::milliseconds;

// Samples of a bench that publishes its ticks arrive every few milliseconds. With this limit,
// silence is reported within 100 ms even if the check itself runs late.
constexpr milliseconds kSilenceOfAStream{80};
// A bench that stands still publishes its state 20 times a second: a few lost samples are not a
// silence.
constexpr milliseconds kSilenceOfAState{250};

milliseconds age(const SeenRun& run) {
  return std::chrono::duration_cast<milliseconds>(run.age);
}

bool is_there(const SeenRun& run) {
  return !run.is_offline && run.age < (run.is_streaming ? kSilenceOfAStream : kSilenceOfAState);
}

std::string text_of(ServiceNews news, const SeenRun& run) {
  std::string bench = "bench " + std::to_string(run.key.number);
  switch (news) {
    case ServiceNews::found:
      return bench + " was found";
    case ServiceNews::fell_silent:
      return bench + " stopped sending " + std::to_string(age(run).count()) + " ms ago";
    case ServiceNews::sends_again:
      return bench + " sends again";
    case ServiceNews::restarted:
      return bench + " restarted: this session has lost control of its axes";
    case ServiceNews::went_offline:
      return bench + " went offline";
  }
  return bench;
}

}  // namespace

std::string_view to_string(ServiceNews news) noexcept {
  switch (news) {
    case ServiceNews::found:
      return "found";
    case ServiceNews::fell_silent:
      return "fell_silent";
    case ServiceNews::sends_again:
      return "sends_again";
    case ServiceNews::restarted:
      return "restarted";
    case ServiceNews::went_offline:
      return "went_offline";
  }
  return "unknown";
}

std::optional<ServiceNews> ServiceWatch::note(Known& known, const SeenRun& run) {
  const bool is_ours = known.incarnation == run.key.incarnation;
  if (!is_there(run)) {
    if (!known.is_there || !is_ours) return std::nullopt;
    known.is_there = false;
    return run.is_offline ? ServiceNews::went_offline : ServiceNews::fell_silent;
  }
  const Known before = std::exchange(known, {.incarnation = run.key.incarnation, .is_there = true});
  if (before.incarnation == 0) return ServiceNews::found;
  if (!is_ours) return ServiceNews::restarted;
  return before.is_there ? std::nullopt : std::optional(ServiceNews::sends_again);
}

std::vector<ServiceChange> ServiceWatch::changes(const Directory& directory,
                                                 Directory::Clock::time_point now) {
  std::vector<ServiceChange> changes;
  const std::vector<SeenRun> runs = directory.seen_runs(now);
  forget_the_unknown(runs);
  std::set<std::uint32_t> seen;
  for (const SeenRun& run : runs) {
    const std::uint32_t bench = run.key.number;
    // Of two runs present at the same time, the earlier one keeps the number.
    if (is_there(run) && !seen.insert(bench).second) continue;
    const auto news = note(known_[bench], run);
    if (!news) continue;
    changes.push_back(
        {.bench = bench, .news = *news, .silence = age(run), .text = text_of(*news, run)});
  }
  return changes;
}

void ServiceWatch::forget_the_unknown(const std::vector<SeenRun>& runs) {
  if (known_.size() <= kMostRuns) return;
  std::set<std::uint32_t> named;
  for (const SeenRun& run : runs) named.insert(run.key.number);
  std::erase_if(known_, [&named](const auto& item) {
    return !named.contains(item.first);
  });
}

}  // namespace vdrive::client
