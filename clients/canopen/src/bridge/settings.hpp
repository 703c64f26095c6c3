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

/// What may be added to the number of an axis. The sum has to be a node id, 1 to 127.
inline constexpr std::int64_t kLowestNodeOffset = -65'534;
inline constexpr std::int64_t kHighestNodeOffset = 126;

/// Drive time that a SYNC lets pass.
inline constexpr std::chrono::microseconds kShortestSyncStep{125};
inline constexpr std::chrono::microseconds kLongestSyncStep{10'000'000};

/// Axes of a bench that may all be nodes.
inline constexpr std::size_t kMostNodes = 127;

/// A bench whose axes are nodes of a bus.
struct BenchSetting {
  std::uint32_t number = 1;
  std::int32_t node_offset = 0;           ///< node id = number of the axis + offset
  std::optional<std::size_t> axes{};      ///< private: default axes, 1 to kMostNodes
  std::string preset{};                   ///< private: machine of these axes; empty = default axes
  std::filesystem::path configuration{};  ///< private: file as that of vdrived
};

/// A bus and its connections.
struct BusSetting {
  std::string name = "can0";              ///< in messages, and of the files of its nodes
  std::vector<TcpAddress> socketcand{};   ///< servers of the socketcand protocol
  std::vector<TcpAddress> gateways{};     ///< servers of CiA 309-3
  std::vector<std::string> interfaces{};  ///< of the kernel (SocketCAN)
  std::vector<BenchSetting> benches{};    ///< empty = every bench, with `node_offset`
  std::int32_t node_offset = 0;           ///< of benches that are not named
  std::filesystem::path log{};            ///< of its frames; empty = none
  std::vector<BusFault> faults{};         ///< from the beginning on
};

/// The settings of vdrive-canopen.
struct Settings {
  client::SessionOptions session{};
  bool is_private = false;           ///< benches are made in this process, and no network is used
  std::optional<ClockMode> clock{};  ///< of the private benches
  /// Each SYNC lets so much drive time pass on a lock-step bench; nothing = others advance time.
  std::optional<std::chrono::microseconds> sync_steps{};
  std::filesystem::path state{};    ///< directory of what 1010h stores; empty = kept in memory
  std::filesystem::path journal{};  ///< of the private bench; empty = none is written
  std::vector<BusSetting> buses{};
};

/// Reads a YAML document over what `settings` has.
/// @throws settings::ConfigurationError with file, line, key, value and limit
void read_settings(const std::string& text, const std::string& file, Settings& settings);

/// Fills in what is left to the program: a bus, its port, the private bench and its clock. Then
/// checks what several settings say together.
/// @throws settings::ConfigurationError
void complete_settings(Settings& settings);

}  // namespace vdrive::canopen
