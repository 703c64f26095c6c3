// SPDX-License-Identifier: Apache-2.0
// Numbers and names of the tables of the core, for the enumerations of vdrive/_enums.py.
#include "python.hpp"
#include "vdrive/cia402/bit_names.hpp"
#include "vdrive/cia402/error_code.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/cia402/power_state.hpp"
#include "vdrive/client/outcome.hpp"

#include <cctype>
#include <cstdint>
#include <set>
#include <string>
#include <string_view>

namespace vdrive::python {
namespace {

/// @return such as "SET_POINT_ACKNOWLEDGE" for "set-point acknowledge".
std::string identifier_of(std::string_view words) {
  std::string name;
  for (const char letter : words) {
    const auto code = static_cast<unsigned char>(letter);
    name += std::isalnum(code) != 0 ? static_cast<char>(std::toupper(code)) : '_';
  }
  return name;
}

void add_member(py::list& members, std::string_view words, std::int64_t number) {
  members.append(py::make_tuple(identifier_of(words), number));
}

py::list power_states() {
  py::list members;
  for (auto number = std::uint8_t{0}; number <= static_cast<std::uint8_t>(PowerState::fault);
       ++number) {
    add_member(members, to_string(static_cast<PowerState>(number)), number);
  }
  return members;
}

py::list operating_modes() {
  py::list members;
  for (const OperatingModeRow& row : kOperatingModes) {
    add_member(members, row.name, static_cast<std::int8_t>(row.mode));
  }
  return members;
}

/// A bit that modes read in different ways has a name for each of them.
py::list statusword_bits() {
  constexpr unsigned kBits = 16;
  constexpr std::string_view kNameless = "bit ";  // of a bit that only modes name
  py::list members;
  for (unsigned place = 0; place < kBits; ++place) {
    const auto bit = static_cast<std::uint16_t>(1U << place);
    const std::string_view common = statusword_bit_name(bit, OperatingMode::none);
    if (!common.empty() && !common.starts_with(kNameless)) add_member(members, common, bit);
    std::set<std::string_view> added;  // modes may share a name
    for (const OperatingModeRow& row : kOperatingModes) {
      for (const BitName& name : row.status_bits) {
        if (name.bit == bit && added.insert(name.name).second) add_member(members, name.name, bit);
      }
    }
  }
  return members;
}

py::list errors_of_drive() {
  py::list members;
  add_member(members, describe(ErrorCode::none), 0);
  for (const ErrorCode code : error_codes()) {
    add_member(members, describe(code), static_cast<std::uint16_t>(code));
  }
  return members;
}

py::list reasons_of_refusals() {
  py::list members;
  for (const client::RefusalCode& row : client::refusal_codes()) {
    add_member(members, row.name, row.code);
  }
  return members;
}

py::dict enum_tables() {
  py::dict tables;
  tables["PowerState"] = power_states();
  tables["OperatingMode"] = operating_modes();
  tables["Statusword"] = statusword_bits();
  tables["ErrorCode"] = errors_of_drive();
  tables["Reason"] = reasons_of_refusals();
  return tables;
}

}  // namespace

void add_enums(py::module_& module) {
  module.def("enum_tables", &enum_tables,
             "The names and numbers of each enumeration of the module, as the drive has them.");
}

}  // namespace vdrive::python
