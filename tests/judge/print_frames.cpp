// SPDX-License-Identifier: Apache-2.0
// Prints a line for each frame of a log: the kind and the node that the judge's decoder finds. The
// tests compare this with the output of a third-party program for the same frames.
#include "log/bus_log.hpp"

#include <fstream>
#include <iostream>

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: print_frames LOG\n";
    return 2;
  }
  std::ifstream log(argv[1], std::ios::binary);
  const auto result = vdrive::judge::judge_bus_log(
      log, {}, [](std::uint64_t /*line*/, const vdrive::judge::DecodedFrame& frame) {
        std::cout << to_string(frame.kind) << ' ' << int{frame.node} << '\n';
      });
  return result.is_readable() ? 0 : 1;
}
