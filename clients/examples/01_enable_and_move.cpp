// SPDX-License-Identifier: Apache-2.0
//
// Finds an axis, enables it, moves it, and reads its position.
//
//   vdrived &                        a bench with the axes 1.1 and 1.2
//   01_enable_and_move [domain]
#include <vdrive/client.hpp>

#include <iostream>
#include <string>

using namespace vdrive::client;

int main(int argc, char** argv) {
  SessionOptions options;
  if (argc > 1) options.domain = static_cast<std::uint32_t>(std::stoul(argv[1]));
  Session session(options);

  // A call returns a value, or an outcome whose message says why there is none.
  auto axis = session.axis("1.1");
  if (!axis) {
    std::cerr << axis.outcome().message() << '\n';
    return 1;
  }

  if (const Outcome enabled = axis->enable(); !enabled) {
    std::cerr << enabled.message() << '\n';
    return 1;
  }

  MoveOptions slow;
  slow.velocity = 20'000;  // 6081h [UU/s]; 4096 UU are one revolution
  for (const std::int32_t target : {10'000, -5'000, 2'048}) {
    if (const Outcome moved = axis->move_to(target, slow); !moved) {
      std::cerr << moved.message() << '\n';
      return 1;
    }
    const auto status = axis->status();
    if (!status) {
      std::cerr << status.outcome().message() << '\n';
      return 1;
    }
    std::cout << "asked for " << target << ", is at " << status->status.load_position_actual_value
              << '\n';
  }

  const Outcome disabled = axis->disable();
  if (!disabled) std::cerr << disabled.message() << '\n';
  return disabled ? 0 : 1;
}
