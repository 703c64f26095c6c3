// SPDX-License-Identifier: Apache-2.0
// The units of a command's values: what the axis that it names makes of them.
#include "execution/executor.hpp"

#include <memory>
#include <utility>
#include <variant>

namespace vdrive::tool {

std::int64_t Executor::user_units(const client::Axis& axis, const Quantity& quantity) const {
  return user_units_of(quantity, axis.unit(), label_of(axis.id()));
}

std::optional<std::uint32_t> Executor::limit(const client::Axis& axis,
                                             const std::optional<Quantity>& quantity) const {
  if (!quantity) return std::nullopt;
  return static_cast<std::uint32_t>(user_units(axis, *quantity));
}

ExpectCommand Executor::in_user_units(const client::Axis& axis, ExpectCommand command) const {
  if (command.quantity) command.value = user_units(axis, *std::exchange(command.quantity, {}));
  if (command.quantity_of_tolerance) {
    const Quantity tolerance = *std::exchange(command.quantity_of_tolerance, {});
    command.tolerance = static_cast<std::uint64_t>(user_units(axis, tolerance));
  }
  return command;
}

client::Outcome Executor::check(const Command& command) {
  if (const auto* refused = std::get_if<std::shared_ptr<const RefusedCommand>>(&command)) {
    return check((*refused)->command);
  }
  return std::visit(
      [this](const auto& word) -> client::Outcome {
        if constexpr (requires { word.axis; }) {
          const auto axis = this->axis(word.axis);
          if (!axis) return axis.outcome();
          check_values(*axis, word);
        }
        return {};
      },
      command);
}

void Executor::check_values(const client::Axis& axis, const MoveCommand& move) const {
  static_cast<void>(user_units(axis, move.position));
  static_cast<void>(limit(axis, move.velocity));
  static_cast<void>(limit(axis, move.acceleration));
  static_cast<void>(limit(axis, move.deceleration));
}

void Executor::check_values(const client::Axis& axis, const WriteCommand& write) const {
  if (write.quantity) static_cast<void>(user_units(axis, *write.quantity));
}

void Executor::check_values(const client::Axis& axis, const ExpectCommand& expect) const {
  static_cast<void>(in_user_units(axis, expect));
}

void Executor::check_values(const client::Axis& axis, const AwaitCommand& await) const {
  if (await.expectation) check_values(axis, *await.expectation);
}

}  // namespace vdrive::tool
