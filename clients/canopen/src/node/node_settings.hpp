// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/axis_status.hpp"

#include <cstdint>
#include <optional>
#include <string_view>

namespace vdrive::canopen {

inline constexpr std::uint8_t kLowestNodeId = 1;
inline constexpr std::uint8_t kHighestNodeId = 127;

/// NMT states (CiA 301, 7.3.2.2) with their numbers in a heartbeat.
enum class NmtState : std::uint8_t {
  boot_up = 0x00,
  stopped = 0x04,
  operational = 0x05,
  pre_operational = 0x7F,
};

/// Commands of the NMT master (CiA 301, 7.2.8.3.1) with their numbers in a frame.
enum class NmtService : std::uint8_t {
  start = 0x01,
  stop = 0x02,
  enter_pre_operational = 0x80,
  reset_node = 0x81,
  reset_communication = 0x82,
};

/// The settings of a node.
struct NodeSettings {
  std::uint8_t node_id = 1;                 ///< 1 to 127
  std::string_view device_name = "vdrive";  ///< 1008h
  std::string_view hardware_version = "1";  ///< 1009h
  std::string_view software_version = "0";  ///< 100Ah
  /// With stepped SYNC: the period that 1006h accepts besides 0 [us]; none = any.
  std::optional<std::uint32_t> sync_period{};
};

/// The drive after a tick, as its node sees it.
struct DriveView {
  AxisStatus status;
  bool is_owned = true;  ///< the bridge controls the axis. Otherwise bit 9 (remote) of 6041h reads
                         ///< 0, and RPDOs are ignored and counted.
};

}  // namespace vdrive::canopen
