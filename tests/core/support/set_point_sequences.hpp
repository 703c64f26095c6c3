// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/support/set_point_model.hpp"

#include <rapidcheck.h>

#include <cstdint>
#include <vector>

namespace vdrive::test {

/// Controlwords: enabling, set-points of each kind, halts, all commands that leave Operation
/// enabled, resets.
inline rc::Gen<std::int64_t> any_controlword() {
  return rc::gen::elementOf(std::vector<std::int64_t>{
      0x0F,  0x1F,  0x3F, 0x5F,  0x7F, 0x0F,  0x1F, 0x3F, 0x10F, 0x11F, 0x13F,
      0x15F, 0x17F, 0x2F, 0x21F, 0x0F, 0x1F,  0x3F, 0x06, 0x07,  0x00,  0x16,
      0x80,  0x86,  0x8F, 0x02,  0x12, 0x102, 0x8F, 0x0F, 0x3F,  0x05});
}

inline rc::Gen<Command> any_command() {
  using Values = std::vector<std::int64_t>;
  const auto value_of = [](const char* object, rc::Gen<std::int64_t> values) {
    return rc::gen::map(values, [object](std::int64_t value) {
      return Command{object, value};
    });
  };
  const auto ramp = rc::gen::elementOf(Values{100'000, 400'000, 1'000'000});
  const auto cause = rc::gen::elementOf(Values{0, 0, 0, 1});
  return rc::gen::weightedOneOf<Command>({
      {20, value_of("ds402_controlword", any_controlword())},
      {8, value_of("position_user_target_value", rc::gen::inRange<std::int64_t>(-20'000, 20'000))},
      {4, value_of("profile_velocity", rc::gen::elementOf(Values{0, 5'000, 50'000, 4294967295}))},
      {2, value_of("profile_acc", ramp)},
      {2, value_of("profile_dec", ramp)},
      {2, value_of("positioning_option_code", rc::gen::inRange<std::int64_t>(0, 3))},
      // Modes 0 and 1, and modes that are refused: 6060h then keeps its value.
      {6, value_of("op_mode_cmd", rc::gen::elementOf(Values{0, 0, 1, 1, 1, 11, 5, -1, 127}))},
      {2, value_of("position_target_reached_window",
                   rc::gen::elementOf(Values{0, 5, 100, 4294967295}))},
      {1, value_of("test_over_temperature", cause)},
      {1, value_of("test_over_current", cause)},
      {1, value_of("test_encoder_failure", cause)},
      {1, value_of("test_dc_link_loss", cause)},
  });
}

inline rc::Gen<Step> any_step() {
  return rc::gen::build<Step>(
      rc::gen::set(&Step::writes,
                   rc::gen::resize(4, rc::gen::container<std::vector<Command>>(any_command()))),
      rc::gen::set(&Step::ticks, rc::gen::weightedOneOf<std::uint32_t>(
                                     {{3, rc::gen::just(1U)},
                                      {2, rc::gen::inRange<std::uint32_t>(1, 30)},
                                      {1, rc::gen::inRange<std::uint32_t>(30, 900)}})));
}

/// Steps that begin with an enabled axis.
inline std::vector<Step> from_enabled(std::vector<Step> steps) {
  steps.insert(steps.begin(), Step{{{"op_mode_cmd", 1}, {"ds402_controlword", 0x0F}}, 1});
  return steps;
}

inline rc::Gen<std::vector<Step>> any_sequence() {
  return rc::gen::map(rc::gen::container<std::vector<Step>>(any_step()), from_enabled);
}

/// @return the sequence of `count` steps that belongs to `seed`.
inline std::vector<Step> fixed_sequence(std::uint64_t seed, std::size_t count) {
  const auto steps = rc::gen::container<std::vector<Step>>(count, any_step());
  return from_enabled(steps(rc::Random(seed), 40).value());
}

}  // namespace vdrive::test
