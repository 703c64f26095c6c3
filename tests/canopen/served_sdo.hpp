// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "canopen/fake_host.hpp"
#include "node/sdo_server.hpp"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::canopen {

/// The SDO server of node 1 and a client of it.
template <typename Objects>
struct ServedSdo {
  static constexpr std::uint8_t kNode = 1;

  FakeHost host;
  Objects objects;
  SdoServer server{kNode, host, objects};
  DriveTime now{};

  /// @param data such as "40 00 20 02", padded with zeros
  std::vector<std::string> request(std::string_view data) {
    std::string text = "601#";
    std::ranges::copy_if(data, std::back_inserter(text), [](char c) {
      return c != ' ';
    });
    text.resize(std::string_view("601#0000000000000000").size(), '0');
    server.receive(frame_of(text), now);
    return host.take();
  }

  std::vector<std::string> finish(const SdoAnswer& answer) {
    server.finish(answer, now);
    return host.take();
  }

  std::vector<std::string> advance(DriveTime time) {
    now = time;
    server.advance(now);
    return host.take();
  }
};

}  // namespace vdrive::canopen
