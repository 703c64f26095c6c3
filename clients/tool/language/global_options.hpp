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

/// In front of `run --private ... FILE`: GlobalOptions::is_one_of_several. Such a process reads the
/// text of the file from standard input, and tells the one that has started it what it finds.
constexpr std::string_view kOneOfSeveral = "__file";

/// Options that stand before or after the command.
struct GlobalOptions {
  std::uint32_t domain = 0;
  std::vector<std::string> interfaces;         ///< own addresses or interfaces to use
  std::vector<std::string> peers;              ///< hosts searched beside multicast
  std::vector<std::string> discovery_servers;  ///< such as 10.0.0.9:11811, instead of multicast
  std::string security;                        ///< directory of the closed mode; empty = open
  std::vector<std::string> network_given;      ///< names of those above in the command line
  bool json = false;
  std::shared_ptr<wire::LocalBus> bus{};  ///< of the benches of this process, instead of a network
  bool is_one_of_several = false;         ///< this process carries out one file of a run
  bool ends_at_silence = false;     ///< SessionOptions::silence ends what follows a bench, too
  std::optional<Duration> timeout;  ///< wall time to find a service, drive time of motion
};

}  // namespace vdrive::tool
