// SPDX-License-Identifier: Apache-2.0
// Random writes to the objects of the PDOs, checked against a second formulation of the rules of
// CiA 301: the configuration in force is always permitted and reads back as accepted.
#include "canopen/pdo_support.hpp"
#include "node/pdos.hpp"
#include "support/random_cases.hpp"

#include <gtest/gtest.h>

#include <rapidcheck.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <vector>

namespace vdrive::canopen {
namespace {

using namespace std::chrono_literals;

struct MappableObject {
  std::uint32_t entry = 0;
  bool is_receive = false;
  bool is_transmit = false;
};

constexpr std::array kMappable{
    MappableObject{kMapControlword, true, true},
    MappableObject{kMapMode, true, true},
    MappableObject{kMapTargetPosition, true, true},
    MappableObject{kMapTargetVelocity, true, true},
    MappableObject{map_entry(5, 0, 8), true, false},
    MappableObject{map_entry(7, 0, 32), true, false},
    MappableObject{kMapStatusword, false, true},
    MappableObject{kMapModeDisplay, false, true},
    MappableObject{kMapPosition, false, true},
    MappableObject{kMapVelocity, false, true},
};

constexpr std::array kWrittenObjects{
    ObjectAddress{0x1400, 1}, ObjectAddress{0x1400, 1}, ObjectAddress{0x1400, 2},
    ObjectAddress{0x1400, 5}, ObjectAddress{0x1600, 0}, ObjectAddress{0x1600, 0},
    ObjectAddress{0x1600, 1}, ObjectAddress{0x1600, 2}, ObjectAddress{0x1600, 3},
    ObjectAddress{0x1800, 1}, ObjectAddress{0x1800, 1}, ObjectAddress{0x1800, 2},
    ObjectAddress{0x1800, 3}, ObjectAddress{0x1800, 5}, ObjectAddress{0x1800, 6},
    ObjectAddress{0x1A00, 0}, ObjectAddress{0x1A00, 0}, ObjectAddress{0x1A00, 1},
    ObjectAddress{0x1A00, 2}, ObjectAddress{0x1A00, 3}, ObjectAddress{0x1005, 0},
    ObjectAddress{0x1006, 0}, ObjectAddress{0x1007, 0}, ObjectAddress{0x1019, 0},
};

constexpr std::array kCobIdValues{0x80U,       0x100U,      0x185U,      0x205U,      0x206U,
                                  0x286U,      0x000U,      0x581U,      0x7FFU,      0x40000185U,
                                  0x40000080U, 0x20000185U, 0x80000000U, 0x80000185U, 0x80000205U,
                                  0x80000206U, 0xC0000186U, 0xA0000185U};

constexpr std::array kEntryValues{kMapControlword,
                                  kMapMode,
                                  kMapTargetPosition,
                                  kMapTargetVelocity,
                                  kMapStatusword,
                                  kMapModeDisplay,
                                  kMapPosition,
                                  kMapVelocity,
                                  map_entry(5, 0, 8),
                                  map_entry(7, 0, 32),
                                  map_entry(0x6040, 0, 8),
                                  map_entry(0x2000, 0, 8),
                                  0U};

constexpr std::array kNumberValues{0U,   1U,   2U,   3U,   4U,   8U,   9U,   64U,     65U,     240U,
                                   241U, 251U, 252U, 253U, 254U, 255U, 256U, 0xFFFFU, 0x10000U};

/// @return whether the object belongs to 1600h.. or 1A00h..
bool is_in_mapping(ObjectAddress object) {
  return object.index >= 0x1400 && (object.index & 0x0200U) != 0;
}

std::span<const std::uint32_t> interesting_values(ObjectAddress object) {
  if (is_in_mapping(object) && object.subindex != 0) return kEntryValues;
  const bool is_cob_id = object.subindex == 1 || object.index == 0x1005;
  if (is_cob_id) return kCobIdValues;
  return kNumberValues;
}

using Registers = std::map<ObjectAddress, std::uint32_t>;

Registers registers_of(const Pdos& pdos) {
  Registers registers;
  for (const ObjectAddress object : kWrittenObjects) registers[object] = pdos.read(object);
  return registers;
}

bool is_valid_pdo(const Registers& registers, std::uint16_t parameters) {
  return (registers.at({parameters, 1}) & 0x80000000U) == 0;
}

/// Checks a PDO and its mapping against CiA 301.
/// @return the violation; empty if there is none.
std::string wrong_in_pdo(const Registers& registers, std::uint16_t parameters) {
  const bool is_receive = parameters == 0x1400;
  const auto mapping = static_cast<std::uint16_t>(parameters + 0x200);
  const std::uint32_t count = registers.at({mapping, 0});
  if (count > 3) return "a count over entries that are never written";
  std::uint32_t bits = 0;
  for (std::uint8_t subindex = 1; subindex <= count; ++subindex) {
    const std::uint32_t entry = registers.at({mapping, subindex});
    const bool is_mappable = std::ranges::any_of(kMappable, [&](const MappableObject& object) {
      return object.entry == entry && (is_receive ? object.is_receive : object.is_transmit);
    });
    if (!is_mappable) return "an object that cannot be mapped";
    bits += entry & 0xFFU;
  }
  if (bits > 64) return "more than 8 bytes";
  const std::uint32_t cob_id = registers.at({parameters, 1});
  if ((cob_id & 0x3FFFF800U) != 0) return "an extended CAN-ID";
  if (is_valid_pdo(registers, parameters)) {
    const std::uint32_t can_id = cob_id & 0x7FFU;
    const bool is_free = (can_id >= 0x080 && can_id <= 0x100) ||
                         (can_id >= 0x181 && can_id <= 0x580) || can_id == 0x600 ||
                         (can_id >= 0x680 && can_id <= 0x6DF) || can_id == 0x700;
    if (!is_free) return "a restricted CAN-ID";
    if (count == 0) return "a valid PDO without objects";
  }
  const std::uint32_t type = registers.at({parameters, 2});
  const bool is_type = type <= 240 || (type >= (is_receive ? 254U : 252U) && type <= 255);
  if (!is_type) return "a reserved transmission type";
  if (registers.at({parameters, 5}) > 0xFFFF) return "a long event timer";
  if (!is_receive && registers.at({parameters, 6}) > 240) return "a SYNC start value";
  return {};
}

std::string wrong_in(const Registers& registers) {
  std::string wrong = wrong_in_pdo(registers, 0x1400);
  if (wrong.empty()) wrong = wrong_in_pdo(registers, 0x1800);
  if (!wrong.empty()) return wrong;
  if ((registers.at({0x1005, 0}) & 0x7FFFF800U) != 0) return "a flag in 1005h";
  const std::uint32_t overflow = registers.at({0x1019, 0});
  if (overflow == 1 || overflow > 240) return "an overflow value";
  return {};
}

/// Checks whether CiA 301 permits an accepted write in the previous state.
/// @return the violation; empty if there is none.
std::string wrong_write(const Registers& before, ObjectAddress object, std::uint32_t value) {
  const bool is_changed = before.at(object) != value;
  if (object.index == 0x1019 && is_changed && before.at({0x1006, 0}) != 0) return "1019h at 1006h";
  if (object.index < 0x1400) return {};
  const bool is_mapping = is_in_mapping(object);
  const auto parameters =
      static_cast<std::uint16_t>(is_mapping ? object.index - 0x200 : object.index);
  const bool was_valid = is_valid_pdo(before, parameters);
  if (is_mapping && was_valid) return "a mapping of a valid PDO";
  if (is_mapping && object.subindex != 0 && before.at({object.index, 0}) != 0) {
    return "an entry under a count";
  }
  const bool is_fixed = object.subindex == 3 || object.subindex == 6;
  if (!is_mapping && is_fixed && was_valid && is_changed) return "a parameter of a valid PDO";
  const bool stays_valid = was_valid && (value & 0x80000000U) == 0;
  const bool is_other_id = ((value ^ before.at({parameters, 1})) & 0x3FFFFFFFU) != 0;
  if (!is_mapping && object.subindex == 1 && stays_valid && is_other_id) return "another CAN-ID";
  return {};
}

/// Index of the object, choice of an interesting value or the raw value, raw value.
using RandomWrite = std::tuple<std::size_t, std::size_t, std::uint32_t>;

rc::Gen<std::vector<RandomWrite>> any_writes() {
  const auto any_write =
      rc::gen::tuple(rc::gen::inRange<std::size_t>(0, kWrittenObjects.size()),
                     rc::gen::inRange<std::size_t>(0, 1'000), rc::gen::arbitrary<std::uint32_t>());
  return rc::gen::resize(200, rc::gen::container<std::vector<RandomWrite>>(any_write));
}

/// Writes a value and checks the outcome against the rules.
/// @return whether the write was accepted.
bool write_and_check(Pdos& pdos, Registers& registers, const RandomWrite& write) {
  const auto& [position, choice, raw] = write;
  const ObjectAddress object = kWrittenObjects.at(position);
  const std::span<const std::uint32_t> values = interesting_values(object);
  const std::size_t chosen = choice % (values.size() + 1);
  const std::uint32_t value = chosen < values.size() ? values[chosen] : raw;
  const bool is_accepted = pdos.write(object, value) == AbortCode::none;
  std::string wrong = is_accepted ? wrong_write(registers, object, value) : "";
  if (is_accepted) registers[object] = value;
  if (registers != registers_of(pdos)) wrong = "another value than the accepted one";
  if (wrong.empty()) wrong = wrong_in(registers);
  if (!wrong.empty()) {
    RC_FAIL(wrong + " after " + std::to_string(object.index) + ":" +
            std::to_string(object.subindex) + " = " + std::to_string(value));
  }
  return is_accepted;
}

TEST(AnyPdos, StayWithinTheStandardOverAnySequenceOfWrites) {
  const std::uint64_t cases = vdrive::test::case_count(1'000, 50'000);
  const std::string parameters = "seed=20240613 max_success=" + std::to_string(cases);
  setenv("RC_PARAMS", parameters.c_str(), 0);  // a value from the environment takes precedence
  std::map<ObjectAddress, int> accepted;
  const bool holds = rc::check("records stay permitted, and read as accepted", [&accepted] {
    RecordingPdoHost host;
    Pdos pdos(kPdoNode, host, std::nullopt);
    pdos.start({}, 0ms);
    Registers registers = registers_of(pdos);
    DriveTime now{};
    for (const RandomWrite& write : *any_writes()) {
      const ObjectAddress object = kWrittenObjects.at(std::get<0>(write));
      if (write_and_check(pdos, registers, write)) ++accepted[object];
      now += 700us;
      pdos.receive(pdo_frame(0x80), now);
      pdos.receive(pdo_frame(registers.at({0x1400, 1}) & 0x7FFU, {1, 2, 3, 4, 5, 6, 7, 8}), now);
      for (const ObjectAddress asked : pdos.read_objects()) pdos.set_value({asked, now.count()});
      pdos.update(pdo_status(static_cast<std::uint16_t>(now.count() / 700)), now);
      pdos.advance(now);
    }
    for (const Frame& frame : host.frames) RC_ASSERT(frame.size >= 1 && frame.size <= 8);
    for (const auto& command : host.commands) RC_ASSERT(!command.empty());
  });
  ASSERT_TRUE(holds);
  for (const ObjectAddress object : kWrittenObjects) {
    EXPECT_GE(accepted[object], 1) << object.index << ":" << int{object.subindex};
  }
}

}  // namespace
}  // namespace vdrive::canopen
