// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bus/bus.hpp"

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

namespace boost::asio {
class io_context;
}

namespace vdrive::canopen {

struct BusLogSettings {
  std::filesystem::path file{};
  std::string interface = "can0";                      ///< in each line
  std::uint64_t most_bytes = std::uint64_t{4} << 30U;  ///< some 100 million frames
};

/// Appends a frame in the format of the log files of can-utils ("candump -l"), such as
/// "(0000000012.345000) can0 181#3702\n", or "181#R2" for a remote frame of 2 bytes.
void append_log_line(std::string& out, const std::string& interface, const Frame& frame,
                     std::chrono::microseconds time);

/// Writes every frame of a bus to a file, replacing an existing one. At the end of a turn of the
/// loop, the file has all frames of that turn. When the file cannot be written or is full, that is
/// reported once, and further frames are only counted. For the thread of its context.
class BusLog final {
 public:
  /// Attaches the log to the bus.
  /// @param context, bus, host outlive the log
  /// @throws std::runtime_error when the file cannot be opened, with its name and the reason
  BusLog(boost::asio::io_context& context, Bus& bus, BusHost& host, BusLogSettings settings);
  ~BusLog();
  BusLog(const BusLog&) = delete;
  BusLog& operator=(const BusLog&) = delete;

  /// Flushes the log.
  /// @return the number of frames of the bus that are not in the file
  std::uint64_t flush();

 private:
  struct State;
  std::shared_ptr<State> state_;  ///< shared: pending operations of the context keep it alive
};

}  // namespace vdrive::canopen
