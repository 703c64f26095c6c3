// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/command.hpp"
#include "vdrive/client/session.hpp"

#include <cstdint>
#include <optional>
#include <string_view>

namespace vdrive::tool {

struct StepCommand {
  std::uint64_t ticks = 0;
  std::optional<std::uint32_t> bench{};  ///< none = the only one
  std::uint32_t steppers = 0;            ///< steppers that the clock waits for; 0 = this program
                                         ///< steps alone

  void declare(Arguments& arguments);
  client::Outcome run(CommandContext& context) const;

 private:
  client::Result<std::uint64_t> step(client::Session& session, std::uint32_t number) const;
};

struct RateCommand {
  std::optional<double> rate{};          ///< drive time over wall time; none = show all rates
  std::optional<std::uint32_t> bench{};  ///< none = the only one

  void declare(Arguments& arguments);
  client::Outcome run(CommandContext& context) const;
};

struct SnapshotCommand {
  enum class Action : std::uint8_t { take, restore, drop, list };

  Action action = Action::take;
  std::uint64_t snapshot = 0;            ///< restore, drop: number of the snapshot
  std::optional<std::uint32_t> bench{};  ///< none = the only one; list: all

  void declare(Arguments& arguments);
  client::Outcome run(CommandContext& context) const;
};

/// @return "take", "restore", "drop" or "list".
[[nodiscard]] std::string_view to_string(SnapshotCommand::Action action) noexcept;

}  // namespace vdrive::tool
