// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wording.hpp"

#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace vdrive {
namespace {

/// No user mistypes a name this long, and the cost grows with the square of the length.
constexpr std::size_t kLongestWord = 64;

}  // namespace

std::string counted(std::uint64_t count, std::string_view one, std::string_view many) {
  return std::to_string(count).append(" ").append(count == 1 ? one : many);
}

std::size_t edit_distance(std::string_view a, std::string_view b) {
  // Rows of the Wagner-Fischer table, for the prefixes of `a` of length i, i - 1 and i - 2.
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0U);
  std::vector<std::size_t> last;
  std::vector<std::size_t> one_before(b.size() + 1);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    last = std::exchange(one_before, row);
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = one_before[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      row[j] = std::min({one_before[j] + 1, row[j - 1] + 1, replaced});
      const bool is_exchanged = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (is_exchanged) row[j] = std::min(row[j], last[j - 2] + 1);
    }
  }
  return row.back();
}

std::string suggestion(std::string_view text, const std::vector<std::string>& candidates) {
  if (text.size() > kLongestWord) return {};
  const std::string* nearest = nullptr;
  // Ignore the dashes of an option: they are right in any case.
  const std::size_t typed = text.size() - std::min(text.find_first_not_of('-'), text.size());
  std::size_t least = std::max<std::size_t>(typed / 3, 1) + 1;
  for (const std::string& candidate : candidates) {
    const std::size_t distance = edit_distance(text, candidate);
    if (distance >= least || distance >= candidate.size()) continue;
    least = distance;
    nearest = &candidate;
  }
  return nearest == nullptr ? std::string() : " (did you mean " + in_quotes(*nearest) + "?)";
}

std::string prefixed_lines(std::string_view prefix, std::string_view text) {
  std::string lines(prefix);
  for (const char c : text) {
    lines += c;
    if (c == '\n') lines += prefix;
  }
  return lines;
}

std::string choice_of(const std::vector<std::string>& words) {
  std::string choice;
  for (const std::string& word : words) choice += (choice.empty() ? "{" : ",") + word;
  return choice + "}";
}

std::string refusal_of_choice(std::string_view text, const std::vector<std::string>& words) {
  if (std::ranges::find(words, text) != words.end()) return {};
  std::string list;
  for (const std::string& word : words) list += (list.empty() ? "" : ", ") + word;
  std::string refusal(1, '\'');
  refusal.append(text).append("' must be one of ").append(list).append(suggestion(text, words));
  return refusal;
}

std::string take_integer(std::string& text, std::int64_t lowest, std::int64_t highest) {
  const auto number = parse_integer(text);
  if (!number || *number < lowest || *number > highest) {
    return "'" + text + "' must be a whole number from " + std::to_string(lowest) + " to " +
           std::to_string(highest);
  }
  text = std::to_string(*number);
  return {};
}

}  // namespace vdrive
