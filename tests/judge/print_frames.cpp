// SPDX-License-Identifier: Apache-2.0
// Prints what the decoder of the judge makes of each frame of a log, a line each: kind and node.
// The judges compare it with what a program of others makes of the same frames.
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
