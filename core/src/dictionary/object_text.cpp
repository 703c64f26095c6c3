// SPDX-License-Identifier: Apache-2.0
#include "vdrive/dictionary/object_text.hpp"

#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/standard_names.hpp"
#include "vdrive/number_text.hpp"

#include <algorithm>

namespace vdrive {
namespace {

constexpr int kHex = 16;
constexpr std::size_t kDigitsOfIndex = 4;  // of the form 6081h

std::optional<std::uint16_t> parse_index(std::string_view text) noexcept {
  if (has_hex_prefix(text)) return parse_digits<std::uint16_t>(text.substr(2), kHex);
  const bool is_of_standard =
      text.size() == kDigitsOfIndex + 1 && (text.back() == 'h' || text.back() == 'H');
  if (!is_of_standard) return std::nullopt;
  return parse_digits<std::uint16_t>(text.substr(0, kDigitsOfIndex), kHex);
}

std::optional<std::uint8_t> parse_subindex(std::string_view text) noexcept {
  return has_hex_prefix(text) ? parse_digits<std::uint8_t>(text.substr(2), kHex)
                              : parse_digits<std::uint8_t>(text);
}

/// @return a text such as "607Dh has sub-indices 1 and 2".
std::string subindices_text(std::uint16_t index) {
  std::vector<std::string> numbers;
  for (const ObjectDescription& row : kObjectTable) {
    if (row.address.index == index) numbers.push_back(std::to_string(row.address.subindex));
  }
  if (numbers.empty()) return {};
  const std::string of_index = index_text(index) + " has ";
  if (numbers.size() == 1) return of_index + "only sub-index " + numbers.front();
  std::string text = of_index + "sub-indices " + numbers.front();
  for (std::size_t i = 1; i < numbers.size(); ++i) {
    text += (i + 1 == numbers.size() ? " and " : ", ") + numbers[i];
  }
  return text;
}

}  // namespace

std::optional<ObjectRow> find_named(std::string_view name) noexcept {
  if (const auto row = find_object(name)) return row;
  const auto* const standard = std::ranges::find(kStandardNames, name, &StandardName::name);
  return standard == kStandardNames.end() ? std::nullopt : find_object(standard->variable_name);
}

std::string index_text(std::uint16_t index) {
  return hex(index, 4).substr(2) + "h";
}

std::string object_text(ObjectAddress object) {
  const auto row = find_object(object);
  std::string text(row ? describe(*row).variable_name : "object");
  text.append(" (").append(index_text(object.index));
  if (object.subindex != 0) text.append(":").append(std::to_string(object.subindex));
  return text.append(")");
}

std::optional<SpelledAddress> parse_address(std::string_view text) noexcept {
  const std::size_t colon = text.find(':');
  const auto index = parse_index(text.substr(0, colon));
  if (!index) return std::nullopt;
  if (colon == std::string_view::npos) return SpelledAddress{.index = *index};
  const auto subindex = parse_subindex(text.substr(colon + 1));
  if (!subindex) return std::nullopt;
  return SpelledAddress{.index = *index, .subindex = subindex};
}

std::optional<ObjectAddress> parse_object(std::string_view text) noexcept {
  if (const auto row = find_named(text)) return describe(*row).address;
  const auto spelled = parse_address(text);
  return spelled ? std::optional(spelled->address()) : std::nullopt;
}

std::string address_suggestion(std::string_view text) {
  const std::size_t colon = std::min(text.find(':'), text.size());
  const std::string_view index = text.substr(0, colon);
  const std::string_view rest = text.substr(colon);
  const std::string meant = std::string(index).append("h").append(rest);
  const auto spelled = parse_address(meant);
  const bool exists = spelled && std::ranges::any_of(kObjectTable, [&](const auto& object) {
                        return object.address.index == spelled->index;
                      });
  if (index.size() != kDigitsOfIndex || !exists) return {};
  return " (did you mean 0x" + std::string(text) + " or " + meant + "?)";
}

std::vector<std::string> names_of_objects() {
  std::vector<std::string> names;
  names.reserve(kObjectTable.size() + kStandardNames.size());
  for (const ObjectDescription& row : kObjectTable) names.emplace_back(row.variable_name);
  for (const StandardName& standard : kStandardNames) names.emplace_back(standard.name);
  return names;
}

std::string advice_on(ObjectAddress object, AbortCode code) {
  switch (code) {
    case AbortCode::subindex_does_not_exist:
      return subindices_text(object.index);
    case AbortCode::value_range_exceeded:
    case AbortCode::value_too_high:
    case AbortCode::value_too_low:
      break;
    default:
      return {};
  }
  const auto row = find_object(object);
  if (!row) return {};
  return std::string(describe(*row).variable_name) + " accepts " + values_text(*row);
}

}  // namespace vdrive
