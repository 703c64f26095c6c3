// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/session.hpp"

#include <memory>
#include <string>

namespace vdrive::test {

/// For tests that run unchanged over either wire: over the local bus of their process, or over DDS
/// if VDRIVE_TEST_WIRE=dds is in the environment (vdrive_run_over_dds in tests/CMakeLists.txt).

/// @return whether this process runs its tests over DDS.
/// @throws std::runtime_error if the wire is neither local nor dds
[[nodiscard]] bool runs_over_dds();

/// @return the bus of all benches of this process; nothing over DDS.
[[nodiscard]] std::shared_ptr<wire::LocalBus> local_bus();

/// @return options of a session that finds the benches of this test.
[[nodiscard]] client::SessionOptions options_on_wire();

/// A bench on the chosen wire, either in this process or as a service of this build. It is ready
/// when the constructor returns and is stopped by the destructor.
class BenchOnWire {
 public:
  /// @param words arguments of vdrived without network options: "--clock lockstep --axes 3"
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
