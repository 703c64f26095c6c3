// SPDX-License-Identifier: Apache-2.0
//
// Any sequence of writes, reads, steps, power cycles, lost connections and restores keeps several
// axes valid, gives the same result when repeated, and leaves no state that a power cycle does not
// clear.
#include "fuzz/support/bytes.hpp"
#include "support/programs/model.hpp"
#include "vdrive/axis_bank.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <array>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <vector>

namespace {

using namespace vdrive;
using test::Bytes;
using test::demand;
using test::violated_invariant;

constexpr std::size_t kAxes = 3;
constexpr std::size_t kElasticAxis = 1;
constexpr int kMostActions = 64;
constexpr ObjectAddress kTestLoadTorque{0x5E00, 0};
constexpr ObjectAddress kTestBlockedLoad{0x5E01, 0};
constexpr ObjectAddress kTestEncoderFailure{0x5E04, 0};
constexpr ObjectAddress kStatuswordBits{0x5E20, 0x0C};
constexpr ObjectAddress kErrorHistory{0x1003, 0};
constexpr ObjectAddress kControlword{0x6040, 0};
constexpr ObjectAddress kMode{0x6060, 0};

/// A bank, and the observations of its previous tick.
class Bench {
 public:
  explicit Bench(const AxisBank& bank) : bank_(bank), saved_(bank.snapshot()) { note_inputs(); }

  AxisBank& bank() { return bank_; }

  void step() {
    bank_.step();
    for (std::size_t axis = 0; axis < kAxes; ++axis) {
      const char* const violated = violated_invariant(bank_.status(axis), bank_.power_state(axis),
                                                      bank_.read(axis, kStatuswordBits).value);
      demand(violated == nullptr, violated);
      check_rest(axis);
    }
  }

  /// Called after writes: the inputs may have changed.
  void note_inputs() {
    for (std::size_t axis = 0; axis < kAxes; ++axis) {
      seen_[axis] = {speed(axis), is_left_alone(axis)};
    }
  }

  void save() { saved_ = bank_.snapshot(); }

  void restore() { bank_.restore(saved_); }

  /// Runs the same ticks again, group by group; the result must be the same.
  void step_twice(std::size_t ticks) {
    const AxisBank::Snapshot before = bank_.snapshot();
    for (std::size_t tick = 0; tick < ticks; ++tick) bank_.step();
    const std::uint64_t hash = bank_.status_hash();
    bank_.restore(before);
    for (std::size_t tick = 0; tick < ticks; ++tick) {
      for (std::size_t group = bank_.group_count(); group > 0; --group) {
        bank_.step_groups(group - 1, group);
      }
    }
    demand(bank_.status_hash() == hash, "the same ticks give the same");
  }

 private:
  struct Seen {
    std::int64_t speed = 0;
    bool is_left_alone = false;
  };

  [[nodiscard]] std::int64_t speed(std::size_t axis) const {
    return std::abs(std::int64_t{bank_.status(axis).motor_velocity_actual_value});
  }

  [[nodiscard]] bool is_left_alone(std::size_t axis) const {
    return bank_.status(axis).motor_op_status == 0 &&
           bank_.read(axis, kTestLoadTorque).value == 0 &&
           bank_.read(axis, kTestEncoderFailure).value == 0;
  }

  /// Only friction acts on a rigid axis without power: it never gets faster.
  void check_rest(std::size_t axis) {
    Seen& seen = seen_[axis];
    const bool is_rigid = axis != kElasticAxis;  // a spring moves the elastic axis
    if (is_rigid && seen.is_left_alone && speed(axis) > seen.speed + 1) {
      demand(!is_left_alone(axis), "no motion without power");
    }
    seen.speed = speed(axis);
    seen.is_left_alone = seen.is_left_alone && bank_.status(axis).motor_op_status == 0;
  }

  AxisBank bank_;
  AxisBank::Snapshot saved_;
  std::array<Seen, kAxes> seen_;
};

std::int64_t value_for(Bytes& bytes, const ObjectDescription& object) {
  switch (bytes.below(7)) {
    case 0:
      return object.lower_limit;
    case 1:
      return object.upper_limit;
    case 2:
      return object.default_value;
    case 3:
      return bytes.take<std::int64_t>();
    case 4:
      return bytes.take<std::int8_t>();
    case 5:
      return bytes.take<std::int16_t>();
    default:
      return bytes.take<std::uint32_t>();
  }
}

void write_any(AxisBank& bank, std::size_t axis, Bytes& bytes) {
  const ObjectDescription& object =
      describe(static_cast<ObjectRow>(bytes.below(kObjectTable.size())));
  const std::int64_t value = value_for(bytes, object);
  if (bank.write(axis, object.address, value) == AbortCode::none &&
      object.address != kErrorHistory) {
    demand(bank.read(axis, object.address).value == value, "a write reads back at once");
  }
}

void write_unknown(AxisBank& bank, std::size_t axis, Bytes& bytes) {
  const ObjectAddress address{bytes.take<std::uint16_t>(), bytes.take()};
  demand(find_object(address).has_value() || bank.write(axis, address, 0) != AbortCode::none,
         "an unknown object is refused");
}

void act(Bench& bench, Bytes& bytes) {
  AxisBank& bank = bench.bank();
  const std::uint8_t action = bytes.take();
  const std::size_t axis = (action >> 4U) % kAxes;
  switch (action & 0xFU) {
    case 0:
    case 1:
    case 2:
      bank.write(axis, kControlword, bytes.take<std::uint16_t>());
      break;
    case 3:
      bank.write(axis, kMode, static_cast<std::int64_t>(bytes.below(14)) - 2);
      break;
    case 4:
    case 5:
    case 6:
    case 7:
      write_any(bank, axis, bytes);
      break;
    case 8:
      write_unknown(bank, axis, bytes);
      break;
    case 9:
      bank.power_cycle(axis);
      break;
    case 10:
      bank.report_connection_loss(axis);
      break;
    case 11:
      bench.save();
      break;
    case 12:
      bench.restore();
      break;
    case 13:
      bench.step_twice(bytes.below(16));
      break;
    default:
      for (std::size_t ticks = bytes.take(); ticks > 0; --ticks) bench.step();
      break;
  }
}

/// After any actions, with its inputs off and its load held until it rests, a rigid axis moves as
/// at the beginning: 1000 user units with the default ramps take 0.1 s. A value that is not a
/// number would have stayed in the plant.
void check_healed(Bench& bench, std::size_t axis) {
  constexpr std::int64_t kDistance = 1000;
  constexpr auto kPatience = std::chrono::milliseconds{400};
  AxisBank& bank = bench.bank();
  for (std::size_t row = 0; row < kObjectTable.size(); ++row) {
    const ObjectDescription& object = describe(static_cast<ObjectRow>(row));
    if (object.address >= kTestLoadTorque && object.address.index < 0x5F00) {
      bank.write(axis, object.address, object.default_value);  // 0 is a valid switch position
    }
  }
  bank.write(axis, kTestBlockedLoad, 1);
  bank.power_cycle(axis);
  bench.step();
  bench.step();
  bank.write(axis, kTestBlockedLoad, 0);
  const std::int64_t start = bank.read(axis, {0x6064, 0}).value;
  bank.write(axis, kMode, 1);
  bank.write(axis, kControlword, 0x000F);
  bench.step();
  demand(bank.power_state(axis) == PowerState::operation_enabled, "an axis can be enabled again");
  bank.write(axis, {0x607A, 0}, kDistance);
  bank.write(axis, kControlword, 0x005F);
  for (auto left = kPatience / bank.period(); left > 0; --left) bench.step();
  const auto moved = static_cast<std::int32_t>(
      static_cast<std::uint32_t>(bank.status(axis).load_position_actual_value - start));
  demand(std::abs(moved - kDistance) <= 1, "an axis moves again");
}

AxisBank make_bank(std::chrono::microseconds period) {
  std::array<AxisConfiguration, kAxes> axes{};
  axes[kElasticAxis].model.coupling = Coupling::two_inertia;
  axes[kElasticAxis].model.backlash = 0.01;
  axes[2].settings = {.enable_from_switch_on_disabled = false,
                      .following_error_is_fault = false,
                      .quick_stop_dwell_ms = 3};
  axes[2].initial_position = 2'147'483'000;
  return {axes, period};
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes({data, size});
  static const AxisBank kSlow = make_bank(std::chrono::microseconds{1000});
  static const AxisBank kFast = make_bank(std::chrono::microseconds{250});
  const std::uint8_t options = bytes.take();
  Bench bench((options & 1U) == 0 ? kSlow : kFast);
  for (int actions = 0; actions < kMostActions && !bytes.empty(); ++actions) {
    act(bench, bytes);
    bench.note_inputs();
  }
  if ((options & 6U) == 6U) {  // not always: it takes as long as many actions
    check_healed(bench, 0);
  }
  return 0;
}
