// SPDX-License-Identifier: Apache-2.0
#include "store/parameter_file.hpp"

#include "base/content_check.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"

#include <nlohmann/json.hpp>

#include <array>
#include <cstdio>
#include <limits>
#include <optional>
#include <string_view>

namespace vdrive::service {
namespace {

using Json = nlohmann::json;

constexpr std::string_view kFirstWords = "vdrive parameters, version ";

template <typename... Numbers>
std::string formatted(const char* format, Numbers... numbers) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), format, numbers...);  // NOLINT(*-vararg)
  return text.data();
}

std::string key_of(ObjectAddress address) {
  return hex(address.index, 4) + ":" + std::to_string(address.subindex);
}

std::string head_of(std::string_view content) {
  return std::string(kFirstWords) + std::to_string(kParameterFileVersion) + ", " +
         std::to_string(content.size()) + " bytes, check " +
         formatted("%016llx\n", static_cast<unsigned long long>(  // NOLINT(*-runtime-int)
                                    check_of(std::as_bytes(std::span(content)))));
}

[[noreturn]] void fail_damaged(const std::string& what) {
  throw ParameterFileError(ParameterProblem::damaged, 0, what);
}

/// @throws ParameterFileError if the first line does not match the rest
std::string_view content_of(std::string_view file) {
  const std::size_t end = file.find('\n');
  if (end == std::string_view::npos || !file.starts_with(kFirstWords)) {
    fail_damaged("this is not a parameter file");
  }
  const std::string_view head = file.substr(0, end + 1);
  const std::string_view content = file.substr(end + 1);
  if (head == head_of(content)) return content;
  const std::string_view rest = head.substr(kFirstWords.size());
  const auto version = parse_integer(rest.substr(0, rest.find(',')));
  if (version && *version >= 0 && *version != kParameterFileVersion) {
    throw ParameterFileError(ParameterProblem::unknown_version,
                             static_cast<std::uint64_t>(*version),
                             "its format has another version");
  }
  fail_damaged("its content does not match its first line");
}

template <typename Number>
Number number_of(std::string_view text) {
  const auto number = parse_integer(text);
  if (!number || *number < 0 || *number > std::numeric_limits<Number>::max()) {
    fail_damaged(in_quotes(text) + " is not a valid number here");
  }
  return static_cast<Number>(*number);
}

ObjectAddress address_of(std::string_view text) {
  const auto spelled = parse_address(text);
  if (!spelled) fail_damaged(in_quotes(text) + " is not the address of an object");
  return spelled->address();
}

}  // namespace

std::string encode(const ParameterTable& table) {
  Json axes = Json::object();
  for (const auto& [number, values] : table) {
    Json& axis = axes[std::to_string(number)] = Json::object();
    for (const InitialValue& stored : values) axis[key_of(stored.address)] = stored.value;
  }
  const std::string content = Json{{"axes", std::move(axes)}}.dump(1) + "\n";
  return head_of(content) + content;
}

ParameterTable decode(std::span<const std::byte> file) {
  if (file.empty()) throw ParameterFileError(ParameterProblem::empty, 0, "it is empty");
  const std::string_view content = content_of(
      {reinterpret_cast<const char*>(file.data()), file.size()});  // NOLINT(*-reinterpret-cast)
  ParameterTable table;
  try {
    const Json json = Json::parse(content);
    for (const auto& [number, axis] : json.at("axes").items()) {
      auto& values = table[number_of<std::uint16_t>(number)];
      for (const auto& [object, value] : axis.items()) {
        // The library would convert a value such as 1e400 without checking the range of the
        // integer.
        if (!value.is_number_integer()) {
          fail_damaged("the value of " + in_quotes(object) + " is not a whole number");
        }
        values.push_back({address_of(object), value.get<std::int64_t>()});
      }
    }
  } catch (const Json::exception& error) {
    fail_damaged(escaped(error.what(), kShownOfMessage));
  }
  // A correct check does not prove that vdrived wrote the content: it may have a number that wraps
  // around, or an object that appears twice.
  if (content_of(encode(table)) != content) {
    fail_damaged("its content is not in the form that vdrived writes");
  }
  return table;
}

}  // namespace vdrive::service
