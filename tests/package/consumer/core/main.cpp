// SPDX-License-Identifier: Apache-2.0
// The drive alone, without a bench.
#include "loaded.hpp"

#include <vdrive/axis_bank.hpp>
#include <vdrive/dictionary/object_table.hpp>

#include <chrono>
#include <iostream>
#include <vector>

using namespace vdrive::literals;

int main() {
  vdrive::AxisBank bank(std::vector<vdrive::AxisConfiguration>(2), std::chrono::milliseconds{1});
  bank.write(1, "op_mode_cmd"_object, 1);
  bank.write(1, "position_user_target_value"_object, 100);
  bank.write(1, "ds402_controlword"_object, 0x0F);
  bank.write(1, "ds402_controlword"_object, 0x3F);
  for (int tick = 0; tick < 1000; ++tick) bank.step();
  if (bank.status(1).load_position_actual_value != 100) {
    std::cerr << "the axis is at " << bank.status(1).load_position_actual_value << ", not 100\n";
    return 1;
  }
  return has_loaded_one_of({"fastrtps", "fastcdr", "crypto", "tinyxml2", "spdlog", "yaml"}) ? 1 : 0;
}
