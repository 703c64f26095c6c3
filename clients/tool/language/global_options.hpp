// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "values/value.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::wire {

class LocalBus;

}  // namespace vdrive::wire

namespace vdrive::tool {

/// Precedes `run --private ... FILE`: see GlobalOptions::is_one_of_several. Such a process reads
/// the text of the file from standard input, and reports its results to the process that started
/// it.
constexpr std::string_view kOneOfSeveral = "__file";

/// Options that may precede or follow the command.
struct GlobalOptions {
  std::uint32_t domain = 0;
  std::vector<std::string> interfaces;         ///< own addresses or interfaces to use
  std::vector<std::string> peers;              ///< hosts to search in addition to multicast
  std::vector<std::string> discovery_servers;  ///< such as 10.0.0.9:11811, instead of multicast
  std::string security;                        ///< directory for the closed mode; empty = open
  std::vector<std::string> network_given;      ///< names of the options above that were given
  bool json = false;
  std::shared_ptr<wire::LocalBus> bus{};  ///< connects the benches of this process, instead of a
                                          ///< network
  bool is_one_of_several = false;         ///< this process executes one file of a run
  bool ends_at_silence = false;     ///< SessionOptions::silence also ends commands that follow a
                                    ///< bench
  std::optional<Duration> timeout;  ///< wall time to find a service, drive time of motion
};

}  // namespace vdrive::tool
