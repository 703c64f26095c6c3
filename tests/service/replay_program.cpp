// SPDX-License-Identifier: Apache-2.0
// Replays a journal; built for instruction sets other than the service's.
#include "journal/replay.hpp"

#include <exception>
#include <iostream>
#include <optional>

int main(int argc, char** argv) {
  try {
    const auto result = vdrive::service::replay(argc > 1 ? argv[1] : "");
    std::cout << result.text << '\n';
    return result.agrees && result.is_complete ? 0 : 1;
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 2;
  }
}
