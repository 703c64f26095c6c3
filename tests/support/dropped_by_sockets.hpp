// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::test {

/// @return the datagrams dropped so far in this network namespace because a UDP socket's buffer was
///         full.
inline std::uint64_t dropped_by_sockets() {
  std::ifstream file("/proc/net/snmp");
  std::string line;
  std::vector<std::string> names;  // a line of names, followed by a line of their values
  while (std::getline(file, line)) {
    if (!line.starts_with("Udp:")) continue;
    std::istringstream words(line);
    std::vector<std::string> values{std::istream_iterator<std::string>(words), {}};
    const auto name = std::find(names.begin(), names.end(), "RcvbufErrors");
    if (name != names.end()) {
      return std::stoull(values.at(static_cast<std::size_t>(name - names.begin())));
    }
    names = std::move(values);
  }
  return 0;
}

}  // namespace vdrive::test
