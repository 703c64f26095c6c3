// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/session.hpp"

#include <memory>
#include <string>

namespace vdrive::test {

/// Tests that are the same over both wires. They run over the local bus of their process; with
/// VDRIVE_TEST_WIRE=dds in the environment they run over DDS (vdrive_run_over_dds in
/// tests/CMakeLists.txt).

/// @return whether this process runs its tests over DDS.
/// @throws std::runtime_error for another wire than local and dds
[[nodiscard]] bool runs_over_dds();

/// @return the bus of all benches of this process; over DDS nothing.
[[nodiscard]] std::shared_ptr<wire::LocalBus> local_bus();

/// @return a session that finds the benches of this test.
[[nodiscard]] client::SessionOptions options_on_wire();

/// A bench on that wire, available after construction: in this process, or a service of this build.
/// It ends when it is destroyed.
class BenchOnWire {
 public:
  /// @param words a command line of vdrived without options of a network, such as
  ///        "--clock lockstep --axes 3"
  /// @throws std::runtime_error
  explicit BenchOnWire(const std::string& words);
  ~BenchOnWire();
  BenchOnWire(const BenchOnWire&) = delete;
  BenchOnWire& operator=(const BenchOnWire&) = delete;

 private:
  class Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace vdrive::test
