// SPDX-License-Identifier: Apache-2.0
#include "bridge/command_line.hpp"
#include "standard_streams.hpp"

#include <cstdlib>

int main(int argument_count, char** arguments) {
  vdrive::bridge::open_standard_streams();
  // Everything has been released. Skips static destructors: one in the DDS library sleeps 100 ms.
  std::quick_exit(vdrive::canopen::run_command_line(argument_count, arguments));
}
