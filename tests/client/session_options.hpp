// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "support/test_domain.hpp"
#include "vdrive/client/session.hpp"

#include <chrono>
#include <string>

namespace vdrive::test {

/// @return a session on the domain of this test, which waits long enough for a service on a busy
///         machine: such a machine lets a service start late, and stand still for seconds.
inline client::SessionOptions options() {
  client::SessionOptions options;
  options.domain = test_domain();
  options.find_timeout = std::chrono::seconds(60);
  options.silence = std::chrono::seconds(10);
  return options;
}

/// @return the same for a test whose service ends, with the usual time until it is called lost.
inline client::SessionOptions options_of_a_loss() {
  client::SessionOptions options = test::options();
  options.silence = client::SessionOptions().silence;
  return options;
}

/// @return the arguments of a service whose axes wait long for a silent owner: in lock-step while
///         others step, in real time on a busy machine.
inline std::string patient(const std::string& arguments) {
  return "--config " VDRIVE_SOURCE_DIR "/tests/data/patient.yaml " + arguments;
}

}  // namespace vdrive::test
