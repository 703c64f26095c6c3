// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/dictionary/object.hpp"
#include "vdrive/number_text.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

namespace vdrive::test {

/// A controlword, mode, set-point, setting or disturbance: a value for an object of an axis.
struct Write {
  ObjectAddress object;
  std::int64_t value;
};

/// @return the equivalent call in Python: "write((0x6060, 0), 1)".
[[nodiscard]] inline std::string to_string(const Write& write) {
  return "write((" + hex(write.object.index, 4) + ", " + std::to_string(write.object.subindex) +
         "), " + std::to_string(write.value) + ")";
}

/// An action of a master on an axis, as a call of the client library.
struct Intent {
  enum class Kind : std::uint8_t {
    enable,
    disable,
    halt,
    resume,
    quick_stop,
    reset_fault,
    home,          ///< with method `value`
    move_to,       ///< [UU]
    move_by,       ///< [UU]
    run_at,        ///< [UU/s]
    apply_torque,  ///< [‰ of rated torque]
  };
  Kind kind;
  std::int32_t value = 0;
};

/// @return the equivalent call in Python: "move_to(120)".
[[nodiscard]] inline std::string to_string(const Intent& intent) {
  using enum Intent::Kind;
  constexpr std::array kNames{"enable",     "disable",     "halt",        "resume",
                              "quick_stop", "reset_fault", "home",        "move_to",
                              "move_by",    "run_at",      "apply_torque"};
  std::string text = kNames.at(static_cast<std::size_t>(intent.kind));
  if (intent.kind == resume) return text + "(until=\"in_force\")";  // a motion may never end
  if (intent.kind < home) return text + "()";
  return text + (intent.kind == home ? "(method=" : "(") + std::to_string(intent.value) + ")";
}

}  // namespace vdrive::test
