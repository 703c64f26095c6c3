// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "support/test_domain.hpp"
#include "vdrive/client/session.hpp"

#include <chrono>
#include <string>

namespace vdrive::test {

/// @return a session on the domain of this test, which waits long enough for a service on a busy
///         machine.
inline client::SessionOptions options() {
  client::SessionOptions options;
  options.domain = test_domain();
  options.find_timeout = std::chrono::seconds(20);
  return options;
}

/// @return the arguments of a service whose axes wait long for a silent owner: in lock-step while
///         others step, in real time on a busy machine.
inline std::string patient(const std::string& arguments) {
  return "--config " VDRIVE_SOURCE_DIR "/tests/data/patient.yaml " + arguments;
}

}  // namespace vdrive::test
