// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bus/gateway_value.hpp"
#include "vdrive/dictionary/object.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <variant>
#include <vector>

namespace vdrive::canopen {

/// Why the gateway itself refuses a command; the value is that of an answer (CiA 309-3, "Error
/// response").
enum class GatewayError : std::uint16_t {
  not_supported = 100,
  syntax = 101,
  internal_state = 102,
  time_out = 103,
  no_default_net = 104,
  no_default_node = 105,
  unsupported_net = 106,
  unsupported_node = 107,
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
};

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
///
/// Words in any letter case; numbers decimal, or hexadecimal behind 0x; `#` begins a comment.
struct GatewayCommand {
  std::uint32_t sequence = 0;
  std::optional<std::uint64_t> net{};   ///< that the command names
  std::optional<std::uint64_t> node{};  ///< that the command names
  GatewayVerb verb{};
  ObjectAddress object{};             ///< of read and write
  std::optional<GatewayType> type{};  ///< of read and write; none = bytes in hexadecimal
  std::vector<std::uint8_t> data{};   ///< to write
  std::uint64_t value = 0;            ///< that is set; of boot_up_indication 1 = enable

  friend bool operator==(const GatewayCommand&, const GatewayCommand&) = default;
};

/// A line that is no command.
struct GatewayRefusal {
  std::uint32_t sequence = 0;  ///< 0 when the line has none
  GatewayError error{};

  friend bool operator==(const GatewayRefusal&, const GatewayRefusal&) = default;
};

/// @param line without its end
/// @return nothing for a line that is empty or has a comment only.
[[nodiscard]] std::variant<std::monostate, GatewayCommand, GatewayRefusal> parse_gateway_command(
    std::string_view line);

/// @return whether the command is for a node: it may name one.
[[nodiscard]] bool is_for_node(GatewayVerb verb) noexcept;

}  // namespace vdrive::canopen
