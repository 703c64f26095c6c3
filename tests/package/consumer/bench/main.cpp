// SPDX-License-Identifier: Apache-2.0
// Sessions, axes and groups on a bench in this process.
#include "loaded.hpp"

#include <vdrive/bench/bench.hpp>
#include <vdrive/client.hpp>

#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

using vdrive::client::Outcome;

namespace {

Outcome move_two_axes(vdrive::client::Session& session) {
  const std::vector<std::string> axes{"1.1", "1.2"};
  auto group = vdrive::client::AxisGroup::create(session, axes);
  if (!group) return group.outcome();
  if (const Outcome enabled = group->enable_all(); !enabled) return enabled;
  return group->move_together((Eigen::VectorXd(2) << 1000, -500).finished());
}

/// A program without DDS must report what it needs for it.
bool is_refused_without_dds() {
  try {
    const vdrive::client::Session session;
  } catch (const std::runtime_error& error) {
    std::cout << error.what() << '\n';
    return std::string(error.what()).find("link vdrive::client") != std::string::npos;
  }
  std::cerr << "a session over DDS was made\n";
  return false;
}

}  // namespace

int main() {
  const vdrive::bench::Bench bench({.axes = 2});
  vdrive::client::Session session = bench.session();
  if (const Outcome moved = move_two_axes(session); !moved) {
    std::cerr << moved.message() << '\n';
    return 1;
  }
  if (!is_refused_without_dds()) return 1;
  return has_loaded_one_of({"fastrtps", "crypto", "ssl", "tinyxml2"}) ? 1 : 0;
}
