// SPDX-License-Identifier: Apache-2.0
#include "standard_streams.hpp"
#include "tool.hpp"

#include <cstdlib>

int main(int argc, char** argv) {
  vdrive::bridge::open_standard_streams();
  const auto code = vdrive::tool::run_tool({argv + 1, argv + argc});
  // Everything is released and flushed, so static destructors can be skipped: one of them, in the
  // DDS library, sleeps for 100 ms, three quarters of the run time of a command.
  std::quick_exit(static_cast<int>(code));
}
