// SPDX-License-Identifier: Apache-2.0
#include "tool.hpp"

#include <cstdlib>

int main(int argc, char** argv) {
  const auto code = vdrive::tool::run_tool({argv + 1, argv + argc});
  // Everything is released and flushed. A static destructor of the DDS library would sleep 100 ms,
  // three quarters of the time that a call takes.
  std::quick_exit(static_cast<int>(code));
}
