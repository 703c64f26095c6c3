// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "support/test_domain.hpp"
#include "vdrive/client/session.hpp"

#include <chrono>
#include <string>

namespace vdrive::test {

/// @return options of a session on the domain of this test. It waits long enough for a busy
///         machine, where services start late and may stall for seconds.
inline client::SessionOptions options() {
  client::SessionOptions options;
  options.domain = test_domain();
  options.find_timeout = std::chrono::seconds(60);
  options.silence = std::chrono::seconds(10);
  return options;
}

/// @return the same for a test whose service ends, with the usual time before a loss is reported.
inline client::SessionOptions options_of_a_loss() {
  client::SessionOptions options = test::options();
  options.silence = client::SessionOptions().silence;
  return options;
}

/// @return the arguments of a service that tolerates a long silence of an owner: in lock-step while
///         others step, in real time on a busy machine.
inline std::string patient(const std::string& arguments) {
  return "--config " VDRIVE_SOURCE_DIR "/tests/data/patient.yaml " + arguments;
}

}  // namespace vdrive::test
