// SPDX-License-Identifier: Apache-2.0
// Prints a template of the package with the tables of the drive filled in: each line "# rows: NAME"
// is replaced by one line per row of that table, with the same indentation. Run by the build.
#include "vdrive/axis_status.hpp"
#include "vdrive/cia402/bit_names.hpp"
#include "vdrive/cia402/error_code.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/cia402/power_state.hpp"
#include "vdrive/client/disturbance.hpp"
#include "vdrive/client/outcome.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/number_text.hpp"

#include <bit>
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <fstream>
#include <iostream>
#include <map>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::python {
namespace {

using Lines = std::vector<std::string>;

constexpr std::size_t kDigits = 4;           // of a word of the drive
constexpr std::size_t kAbortCodeDigits = 8;  // CiA 301

/// @return such as "SET_POINT_ACKNOWLEDGE" for "set-point acknowledge".
std::string identifier_of(std::string_view words) {
  std::string name;
  for (const char letter : words) {
    const auto code = static_cast<unsigned char>(letter);
    name += std::isalnum(code) != 0 ? static_cast<char>(std::toupper(code)) : '_';
  }
  return name;
}

std::string member(std::string_view words, const std::string& number) {
  return identifier_of(words) + " = " + number;
}

Lines power_states() {
  Lines lines;
  for (auto number = std::uint8_t{0}; number <= static_cast<std::uint8_t>(PowerState::fault);
       ++number) {
    lines.push_back(member(to_string(static_cast<PowerState>(number)), std::to_string(number)));
  }
  return lines;
}

Lines operating_modes() {
  Lines lines;
  for (const OperatingModeRow& row : kOperatingModes) {
    lines.push_back(member(row.name, std::to_string(static_cast<std::int8_t>(row.mode))));
  }
  return lines;
}

/// A bit with different meanings in different modes has a name for each of them.
Lines statusword_bits() {
  constexpr unsigned kBits = 16;
  constexpr std::string_view kNameless = "bit ";  // of a bit that is named by modes only
  Lines lines;
  for (unsigned place = 0; place < kBits; ++place) {
    const auto bit = static_cast<std::uint16_t>(1U << place);
    const std::string number = hex(bit, kDigits);
    const std::string_view common = statusword_bit_name(bit, OperatingMode::none);
    if (!common.empty() && !common.starts_with(kNameless)) lines.push_back(member(common, number));
    std::set<std::string_view> added;  // modes may share a name
    for (const OperatingModeRow& row : kOperatingModes) {
      for (const BitName& name : row.status_bits) {
        if (name.bit == bit && added.insert(name.name).second) {
          lines.push_back(member(name.name, number));
        }
      }
    }
  }
  return lines;
}

Lines errors_of_drive() {
  Lines lines{member(describe(ErrorCode::none), "0")};
  for (const ErrorCode code : error_codes()) {
    lines.push_back(member(describe(code), hex(static_cast<std::uint16_t>(code), kDigits)));
  }
  return lines;
}

Lines reasons_of_refusals() {
  Lines lines;
  for (const client::RefusalCode& row : client::refusal_codes()) {
    const bool is_abort_code = row.code > client::kNotPermitted;
    lines.push_back(member(
        row.name, is_abort_code ? hex(row.code, kAbortCodeDigits) : std::to_string(row.code)));
  }
  return lines;
}

std::string text_of(const StatusMember& member) {
  if (member.address.index == 0) return "Counted by the drive since power-up.";
  const auto row = find_object(member.address);
  const std::string units = row ? english_units(describe(*row)) : "";
  return object_text(member.address) + (units.empty() ? "." : ", in " + units + ".");
}

/// @return the character for the type in Python's struct module.
char format_of(DataType type) {
  const std::string_view letters = range_of(type).lowest < 0 ? "bhiq" : "BHIQ";
  return letters.at(static_cast<std::size_t>(std::countr_zero(size_of(type))));
}

/// The table is in the order of the members, which have no gaps.
Lines properties_of_status() {
  Lines lines;
  std::size_t offset = 0;
  for (const StatusMember& row : status_members()) {
    if (row.is_published) {
      lines.insert(lines.end(),
                   {"@property", "def " + std::string(row.name) + "(self) -> int:",
                    R"(    """)" + text_of(row) + R"(""")",
                    std::string(R"(    return unpack_from("<)") + format_of(row.data_type) +
                        R"(", self._state[7], )" + std::to_string(offset) + ")[0]",
                    ""});
    }
    offset += size_of(row.data_type);
  }
  lines.pop_back();
  return lines;
}

Lines disturbances() {
  Lines lines;
  for (const client::DisturbanceRow& row : client::kDisturbances) {
    lines.push_back('"' + std::string(row.name) + "\",");
  }
  return lines;
}

/// @throws std::invalid_argument for an unknown name
Lines rows_of(const std::string& name) {
  static const std::map<std::string, Lines (*)()> tables{
      {"bits of the statusword", &statusword_bits},
      {"disturbances", &disturbances},
      {"error codes", &errors_of_drive},
      {"members of the status", &properties_of_status},
      {"operating modes", &operating_modes},
      {"power states", &power_states},
      {"reasons of refusals", &reasons_of_refusals}};
  const auto table = tables.find(name);
  if (table == tables.end()) throw std::invalid_argument("there is no table '" + name + "'");
  return table->second();
}

/// @throws std::invalid_argument if the file does not exist or names an unknown table
void print_filled(const std::string& path) {
  constexpr std::string_view kMark = "# rows: ";
  std::ifstream file(path);
  if (!file) throw std::invalid_argument("it cannot be read");
  for (std::string line; std::getline(file, line);) {
    const std::size_t mark = line.find(kMark);
    if (mark == std::string::npos) {
      std::cout << line << '\n';
      continue;
    }
    for (const std::string& row : rows_of(line.substr(mark + kMark.size()))) {
      std::cout << (row.empty() ? "" : line.substr(0, mark)) << row << '\n';
    }
  }
}

}  // namespace
}  // namespace vdrive::python

int main(int argument_count, char** arguments) {
  const std::span all(arguments, static_cast<std::size_t>(argument_count));
  try {
    for (const char* const path : all.subspan(1)) vdrive::python::print_filled(path);
  } catch (const std::exception& error) {
    std::cerr << all.back() << ": " << error.what() << '\n';
    return 1;
  }
  return 0;
}
