// SPDX-License-Identifier: Apache-2.0
#include "drops.hpp"

#include <cstddef>
#include <optional>
#include <string_view>

namespace vdrive::ros2 {
namespace {

using bridge::Severity;

// A flood of datagrams is reported once per second.
constexpr std::chrono::seconds kPeriod{1};

/// @return the text between the first pair of quotes after `begin`, which is moved past it.
std::optional<std::string_view> next_quoted(std::string_view words, std::size_t& begin) {
  const std::size_t first = words.find('\'', begin);
  if (first == std::string_view::npos) return std::nullopt;
  const std::size_t end = words.find('\'', first + 1);
  if (end == std::string_view::npos) return std::nullopt;
  begin = end + 1;
  return words.substr(first + 1, end - first - 1);
}

std::string words_of(wire::Refusal refusal) {
  const std::string words(wire::describe(refusal));
  return refusal == wire::Refusal::fragment ? words + ", or of a message above 16 MB" : words;
}

}  // namespace

void Drops::report(const wire::GuardCounts& counts, Clock::time_point now) {
  if (now < due_) return;
  due_ = now + kPeriod;
  for (std::size_t i = 0; i < counts.refused.size(); ++i) {
    const std::uint64_t more = counts.refused[i] - reported_.refused[i];
    if (more == 0) continue;
    reports_.report(Severity::warning, "network",
                    std::to_string(more) + " datagrams were dropped, with " +
                        words_of(static_cast<wire::Refusal>(i)));
  }
  reported_ = counts;
}

std::string dropped_message(const std::string& words) {
  // The library reports this only in these words; other words are kept unchanged.
  constexpr std::string_view kTooLarge = "Change payload size of";
  std::size_t place = 0;
  if (!words.starts_with(kTooLarge)) return words;
  const auto size = next_quoted(words, place);
  const auto limit = next_quoted(words, place);
  if (!size || !limit) return words;
  return "a message of " + std::string(*size) + " bytes was dropped: at most " +
         std::string(*limit) + " are read";
}

}  // namespace vdrive::ros2
