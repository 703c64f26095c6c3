// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bus/gateway_value.hpp"
#include "vdrive/dictionary/object.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace vdrive::canopen {

/// Errors of the gateway itself, with their codes in an answer (CiA 309-3, "Error response").
enum class GatewayError : std::uint16_t {
  not_supported = 100,
  syntax = 101,
  internal_state = 102,
  time_out = 103,
  no_default_net = 104,
  no_default_node = 105,
  unsupported_net = 106,
  unsupported_node = 107,
  pdo_length_exceeded = 401,
};

/// @return the standard's wording, such as "syntax error".
[[nodiscard]] std::string_view describe(GatewayError error) noexcept;

enum class GatewayVerb : std::uint8_t {
  read,
  write,
  start,
  stop,
  preoperational,
  reset_node,
  reset_communication,
  set_network,
  set_node,
  set_sdo_timeout,
  boot_up_indication,
  info_version,
  set_receive_pdo,
  set_transmit_pdo,
  read_pdo,
  write_pdo,
  sync,
  disturb,
};

/// A session of the gateway numbers its PDOs 1 to kHighestPdo.
inline constexpr std::uint64_t kHighestPdo = 512;

/// The most SYNCs of one command.
inline constexpr std::uint64_t kMostSyncs = 100'000;

/// A command of CiA 309-3:
///
///     "[" sequence "]" [[net] node] r[ead] index subindex [type]
///     "[" sequence "]" [[net] node] w[rite] index subindex type value
///     "[" sequence "]" [[net] node] start | stop | preop[erational] | reset node
///                                   | reset comm[unication]
///     "[" sequence "]" [net] set node NODE | set sdo_timeout MILLISECONDS
///     "[" sequence "]" [net] boot_up_indication Enable | Disable
///     "[" sequence "]" [net] info version
///     "[" sequence "]" set network NET
///     "[" sequence "]" [net] set rpdo NR CAN-ID event | sync0 to sync240 COUNT [index subindex]...
///     "[" sequence "]" [net] set tpdo NR CAN-ID event COUNT [index subindex]...
///     "[" sequence "]" [net] r[ead] p[do] NR
///     "[" sequence "]" [net] w[rite] p[do] NR COUNT [value]...
///
/// and two extensions, whose words begin with _ as the standard requires:
///
///     "[" sequence "]" [net] _sync [COUNT]
///     "[" sequence "]" [[net] node] _disturb none | FAULT      see parse_bus_fault()
///
/// Words are case-insensitive; numbers are decimal, or hexadecimal after 0x; `#` begins a comment.
struct GatewayCommand {
  std::uint32_t sequence = 0;
  std::optional<std::uint64_t> net{};   ///< named in the command
  std::optional<std::uint64_t> node{};  ///< named in the command
  GatewayVerb verb{};
  ObjectAddress object{};             ///< read and write
  std::optional<GatewayType> type{};  ///< read and write; none = bytes in hexadecimal
  std::vector<std::uint8_t> data{};   ///< to write
  std::uint64_t value = 0;   ///< to set; boot_up_indication: 1 = enable; number of a PDO; number of
                             ///< SYNCs
  std::uint64_t cob_id = 0;  ///< of the PDO to set: 11 bits
  std::vector<ObjectAddress> mapped{};  ///< of the PDO to set
  std::vector<std::uint64_t> values{};  ///< "write pdo"
  std::string fault{};                  ///< _disturb, in lower case

  friend bool operator==(const GatewayCommand&, const GatewayCommand&) = default;
};

/// A line that is not a command.
struct GatewayRefusal {
  std::uint32_t sequence = 0;  ///< 0 if the line has none
  GatewayError error{};

  friend bool operator==(const GatewayRefusal&, const GatewayRefusal&) = default;
};

/// @param line without its end
/// @return nothing for a line that is empty or only a comment.
[[nodiscard]] std::variant<std::monostate, GatewayCommand, GatewayRefusal> parse_gateway_command(
    std::string_view line);

/// @return whether the command addresses a node, and so may name one.
[[nodiscard]] bool is_for_node(GatewayVerb verb) noexcept;

}  // namespace vdrive::canopen
