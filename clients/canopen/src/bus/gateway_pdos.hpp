// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bus/gateway_command.hpp"
#include "node/frame.hpp"
#include "vdrive/dictionary/abort_code.hpp"

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace vdrive::canopen {

/// Why a command for a PDO is refused; monostate = accepted.
using PdoRefusal = std::variant<std::monostate, GatewayError, AbortCode>;

/// The PDOs that a session of the gateway has configured (CiA 309-3, "PDO access"): it receives
/// RPDOs, which are TPDOs of nodes, and sends TPDOs. A mapped object has the size that it has in
/// the dictionary of our nodes; 0002h to 0007h have the size of the data type with the same index.
class GatewayPdos final {
 public:
  /// Carries out "set rpdo" or "set tpdo"; a PDO with the same number is replaced.
  [[nodiscard]] PdoRefusal set(const GatewayCommand& command);

  /// @return the latest values of the RPDO with this number, such as "2 0x237 0x3E8"; nothing if it
  ///         is not configured or has received nothing.
  [[nodiscard]] std::optional<std::string> read(std::uint64_t number) const;

  /// @param frame receives the values of "write pdo" for its TPDO
  [[nodiscard]] PdoRefusal write(const GatewayCommand& command, Frame& frame) const;

  /// @return whether this frame belongs to an RPDO.
  [[nodiscard]] bool awaits(const Frame& frame) const;

  /// @return the reports for this frame: number and values of each RPDO that it belongs to, such as
  ///         "1 2 0x237 0x3E8".
  [[nodiscard]] std::vector<std::string> receive(const Frame& frame);

 private:
  struct Pdo {
    std::uint32_t can_id = 0;
    std::vector<std::uint8_t> sizes{};  ///< of the mapped objects [bytes]
    std::size_t size = 0;               ///< sum of `sizes`
    std::optional<Frame> newest{};      ///< latest received
  };

  [[nodiscard]] static std::string values_of(const Pdo& pdo);
  [[nodiscard]] static bool is_of(const Pdo& pdo, const Frame& frame);

  std::map<std::uint64_t, Pdo> received_;  ///< RPDOs, by number
  std::map<std::uint64_t, Pdo> sent_;      ///< TPDOs, by number
};

}  // namespace vdrive::canopen
