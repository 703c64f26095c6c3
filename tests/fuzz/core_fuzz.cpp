// SPDX-License-Identifier: Apache-2.0
//
// Any sequence of writes, reads, steps, power cycles and restores keeps an axis in order.
#include "vdrive/axis_bank.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <array>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <span>

namespace {

using namespace vdrive;

/// Takes numbers from the fuzzer's bytes; past the end they are 0.
class Bytes {
 public:
  explicit Bytes(std::span<const std::uint8_t> data) : data_(data) {}

  [[nodiscard]] bool empty() const { return data_.empty(); }

  std::uint64_t take(std::size_t count) {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < count && !data_.empty(); ++i) {
      value = value << 8U | data_.front();
      data_ = data_.subspan(1);
    }
    return value;
  }

 private:
  std::span<const std::uint8_t> data_;
};

void demand(bool holds, const char* what) {
  if (!holds) {
    std::cerr << "violated: " << what << '\n';
    std::abort();
  }
}

bool may_be_powered(PowerState state) {
  return state == PowerState::operation_enabled || state == PowerState::quick_stop_active ||
         state == PowerState::fault_reaction_active;
}

void check(const AxisBank& bank) {
  for (std::size_t axis = 0; axis < bank.size(); ++axis) {
    const AxisStatus& status = bank.status(axis);
    const PowerState state = decode_power_state(status.ds402_statusword);
    demand(state == bank.power_state(axis), "6041h shows the state");
    demand(status.motor_op_status == 0 || may_be_powered(state), "no power outside its states");
    demand(status.motor_op_status == 1 || status.torque_actual_value == 0,
           "no torque without power");
    demand(status.motor_op_status == 1 || status.velocity_demand_value == 0,
           "606Bh is 0 without power");
    demand((status.error_code != 0) ==
               (state == PowerState::fault || state == PowerState::fault_reaction_active),
           "603Fh is set in a fault only");
    demand((status.ds402_statusword & 0xC100U) == 0, "reserved bits are 0");
  }
}

std::int64_t value_for(Bytes& bytes, const ObjectDescription& object) {
  switch (bytes.take(1) % 6) {
    case 0:
      return object.lower_limit;
    case 1:
      return object.upper_limit;
    case 2:
      return object.default_value;
    case 3:
      return static_cast<std::int64_t>(bytes.take(8));
    case 4:
      return static_cast<std::int8_t>(bytes.take(1));
    default:
      return static_cast<std::int64_t>(bytes.take(4));
  }
}

void act(AxisBank& bank, AxisBank::Snapshot& saved, Bytes& bytes) {
  const std::uint64_t action = bytes.take(1);
  const std::size_t axis = action >> 7U;
  const auto row = static_cast<ObjectRow>(bytes.take(1) % kObjectCount);
  const ObjectDescription& object = describe(row);
  switch (action % 16) {
    case 0:
    case 1:
    case 2:
    case 3:
      bank.write(axis, {0x6040, 0}, static_cast<std::int64_t>(bytes.take(2)));
      break;
    case 4:
    case 5:
    case 6:
    case 7: {
      const std::int64_t value = value_for(bytes, object);
      if (bank.write(axis, object.address, value) == AbortCode::none &&
          object.address.index != 0x1003) {
        demand(bank.read(axis, object.address).value == value, "a write reads back at once");
      }
      break;
    }
    case 8: {
      const ObjectAddress address{static_cast<std::uint16_t>(bytes.take(2)),
                                  static_cast<std::uint8_t>(bytes.take(1))};
      demand(find_object(address).has_value() || bank.write(axis, address, 0) != AbortCode::none,
             "an unknown object is refused");
      break;
    }
    case 9:
      bank.power_cycle(axis);
      break;
    case 10:
      bank.report_connection_loss(axis);
      break;
    case 11:
      saved = bank.snapshot();
      break;
    case 12:
      bank.restore(saved);
      break;
    default:
      for (std::uint64_t ticks = bytes.take(1); ticks > 0; --ticks) {
        bank.step();
        check(bank);
      }
      break;
  }
}

AxisBank make_bank(std::chrono::microseconds period) {
  std::array<AxisConfiguration, 2> axes{};
  axes[1].model.coupling = Coupling::two_inertia;
  axes[1].model.backlash = 0.01;
  return {axes, period};
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes({data, size});
  static const AxisBank kSlow = make_bank(std::chrono::microseconds{1000});
  static const AxisBank kFast = make_bank(std::chrono::microseconds{250});
  AxisBank bank = bytes.take(1) % 2 == 0 ? kSlow : kFast;
  AxisBank::Snapshot saved = bank.snapshot();
  for (int actions = 0; actions < 64 && !bytes.empty(); ++actions) {
    act(bank, saved, bytes);
  }
  return 0;
}
