// SPDX-License-Identifier: Apache-2.0
//
// Joins the clock of a lock-step bench, prints its session and then does nothing until it is
// terminated:
//
//   idle_stepper DOMAIN BENCH
#include "vdrive/client/session.hpp"
#include "vdrive/client/step_clock.hpp"

#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <iostream>
#include <string>

int main(int count, char** arguments) {
  if (count != 3) return 2;
  vdrive::client::SessionOptions options;
  options.domain = static_cast<std::uint32_t>(std::stoul(arguments[1]));
  options.find_timeout = std::chrono::seconds(10);
  vdrive::client::Session session(options);
  const std::array bench{static_cast<std::uint32_t>(std::stoul(arguments[2]))};
  const auto clock = vdrive::client::StepClock::join(session, bench);
  if (!clock) {
    std::cout << clock.outcome().message() << std::endl;
    return 1;
  }
  std::printf("0x%016llx\n", static_cast<unsigned long long>(session.id()));
  std::fflush(stdout);
  pause();
  return 0;
}
