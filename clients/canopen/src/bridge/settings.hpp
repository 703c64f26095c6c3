// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bus/bus_faults.hpp"
#include "bus/tcp_address.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/clock_mode.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::canopen {

/// Limits of the offset added to the number of an axis. The sum must be a node id, 1 to 127.
inline constexpr std::int64_t kLowestNodeOffset = -65'534;
inline constexpr std::int64_t kHighestNodeOffset = 126;

/// Limits of the drive time that one SYNC advances.
inline constexpr std::chrono::microseconds kShortestSyncStep{125};
inline constexpr std::chrono::microseconds kLongestSyncStep{10'000'000};

/// The most axes of a bench that can all be nodes.
inline constexpr std::size_t kMostNodes = 127;

/// A bench whose axes are nodes of a bus.
struct BenchSetting {
  std::uint32_t number = 1;
  std::int32_t node_offset = 0;           ///< node id = number of the axis + offset
  std::optional<std::size_t> axes{};      ///< private: number of default axes, 1 to kMostNodes
  std::string preset{};                   ///< private: machine preset of these axes; empty =
                                          ///< default axes
  std::filesystem::path configuration{};  ///< private: configuration file, as for vdrived
};

/// A bus and its connections.
struct BusSetting {
  std::string name = "can0";              ///< in messages, and prefix of the files of its nodes
  std::vector<TcpAddress> socketcand{};   ///< servers of the socketcand protocol
  std::vector<TcpAddress> gateways{};     ///< servers of CiA 309-3
  std::vector<std::string> interfaces{};  ///< network interfaces (SocketCAN)
  std::vector<BenchSetting> benches{};    ///< empty = every bench, with `node_offset`
  std::int32_t node_offset = 0;           ///< of benches that are not listed
  std::filesystem::path log{};            ///< log file of its frames; empty = none
  std::vector<BusFault> faults{};         ///< active from the start
};

/// The settings of vdrive-canopen.
struct Settings {
  client::SessionOptions session{};
  bool is_private = false;           ///< benches run in this process, without a network
  std::optional<ClockMode> clock{};  ///< of the private benches
  /// Drive time that each SYNC advances on a lock-step bench; nothing = others advance time.
  std::optional<std::chrono::microseconds> sync_steps{};
  std::filesystem::path state{};    ///< directory for parameters saved by 1010h; empty = kept in
                                    ///< memory
  std::filesystem::path journal{};  ///< file of the private bench; empty = none
  std::vector<BusSetting> buses{};
};

/// Reads a YAML document; its values replace those in `settings`.
/// @throws settings::ConfigurationError with file, line, key, value and limit
void read_settings(const std::string& text, const std::string& file, Settings& settings);

/// Fills in everything not set: a bus, its port, the private bench and its clock. Then checks the
/// settings for contradictions.
/// @throws settings::ConfigurationError
void complete_settings(Settings& settings);

}  // namespace vdrive::canopen
