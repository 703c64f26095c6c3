// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/exit_code.hpp"
#include "language/global_options.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/outcome.hpp"

#include <any>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::tool {

class Arguments;
class Terminal;
struct CommandContext;
struct CommandRow;

/// The commands of the tool, in the order of its help.
using CommandTable = std::span<const CommandRow* const>;

/// Where a command is written. What a scenario may have a shell may have too, and what a shell may
/// have the command line.
enum class Place : std::uint8_t { command_line, shell, scenario };

/// A command with its arguments: what a line requests. Made by the reader of command lines only.
struct Command {
  const CommandRow* row = nullptr;
  std::any arguments;                    ///< the struct that the file of the command has for them
  std::vector<std::string> axes;         ///< that it names: addresses such as 7.1, names, 7.*, *
  std::optional<std::uint32_t> bench;    ///< that it names
  std::optional<std::uint32_t> refusal;  ///< `refused`: it passes if it is refused with this code
  bool limits_itself = false;    ///< --timeout is the limit of the command, not of the search
  bool bridges_silence = false;  ///< it continues after a gap, up to SessionOptions::patience
};

/// The tool as it was called: what a command works with that opens its own session, or none.
struct Program {
  const GlobalOptions& options;
  CommandTable commands;
  Terminal& terminal;
};

/// Under which title the help lists a command; the titles are in the order of their first command.
enum class CommandGroup : std::uint8_t {
  none,  ///< no command has it
  observation,
  power,
  motion,
  parameters,
  bench,
  scenarios,
  recordings,
  machine,
};

/// What a command is called, and its help.
struct CommandFace {
  std::string_view name;
  CommandGroup group = CommandGroup::none;
  std::string_view summary;
  std::string_view example;         ///< behind "vdrive "
  std::string_view help = {};       ///< at the end of its help in place of the example
  Place deepest = Place::scenario;  ///< where it may stand, and everywhere before
  bool needs_domain = true;         ///< false: it works also where VDRIVE_DOMAIN is wrong
};

/// Makes the command of the arguments that have been read.
using CommandMaker = std::function<Command()>;

/// What a command is to the rest of the tool: `row_of` makes it of the struct with its arguments.
struct CommandRow {
  CommandFace face;

  /// Declares the arguments.
  CommandMaker (*declare)(Arguments& arguments) = nullptr;

  /// Checks what can be checked before a bench is there; a scenario does it when it is read.
  /// @throws UsageError
  void (*check_objects)(const std::any& arguments) = nullptr;

  /// Checks the values once the axis is known, before anything moves.
  /// @throws UsageError for a unit that the axis has not, and for what is out of range with it.
  void (*check_units)(const std::any& arguments, const CommandContext& context,
                      const client::Axis& axis) = nullptr;

  /// Carries the command out in a session.
  client::Outcome (*run)(const std::any& arguments, CommandContext& context) = nullptr;

  /// Carries it out on the command line where that takes no session, or one of its own.
  ExitCode (*start)(const std::any& arguments, const Program& program) = nullptr;
};

/// @return the axes that the arguments name.
template <typename Given>
[[nodiscard]] std::vector<std::string> axes_of(const Given& given) {
  if constexpr (requires { given.axes; }) {
    return given.axes;
  } else if constexpr (requires { given.axis; }) {
    return given.axis.empty() ? std::vector<std::string>{} : std::vector<std::string>{given.axis};
  } else {
    return {};
  }
}

/// @return the command that these arguments are for.
template <typename Given>
[[nodiscard]] Command command_of(const Given& given) {
  Command command{.row = nullptr,
                  .arguments = given,
                  .axes = axes_of(given),
                  .bench = {},
                  .refusal = {},
                  .limits_itself = false,
                  .bridges_silence = requires {Given::kBridgesSilence;
}
};  // namespace vdrive::tool

if constexpr (requires { given.bench; }) command.bench = given.bench;
if constexpr (requires { given.limits_itself(); }) command.limits_itself = given.limits_itself();
return command;
}

template <typename Given>
[[nodiscard]] Given no_arguments() {
  return {};
}

/// @tparam Given the arguments of the command, with `declare(Arguments&)`, with `run` or `start` or
///         both, and where it has something to check `check_objects` and `check_units`
/// @tparam make the arguments before anything was read
template <typename Given, Given (*make)() = &no_arguments<Given>>
[[nodiscard]] consteval CommandRow row_of(const CommandFace& face) {
  constexpr bool kRuns = requires(const Given& given, CommandContext& context) {
    given.run(context);
  };
  constexpr bool kStarts = requires(const Given& given, const Program& program) {
    given.start(program);
  };
  static_assert(kRuns || kStarts, "a command does something");
  if (face.group == CommandGroup::none) throw "the help lists each command in a group";
  if (!kRuns && face.deepest != Place::command_line) throw "a shell has one session for all";
  CommandRow row{.face = face};
  row.declare = [](Arguments& arguments) -> CommandMaker {
    auto given = std::make_shared<Given>(make());
    given->declare(arguments);
    return [given] {
      return command_of(*given);
    };
  };
  if constexpr (requires(const Given& given) { given.check_objects(); }) {
    row.check_objects = [](const std::any& arguments) {
      std::any_cast<const Given&>(arguments).check_objects();
    };
  }
  if constexpr (requires(const Given& given, const CommandContext& context,
                         const client::Axis& axis) { given.check_units(context, axis); }) {
    row.check_units = [](const std::any& arguments, const CommandContext& context,
                         const client::Axis& axis) {
      std::any_cast<const Given&>(arguments).check_units(context, axis);
    };
  }
  if constexpr (kRuns) {
    row.run = [](const std::any& arguments, CommandContext& context) {
      return std::any_cast<const Given&>(arguments).run(context);
    };
  }
  if constexpr (kStarts) {
    row.start = [](const std::any& arguments, const Program& program) {
      return std::any_cast<const Given&>(arguments).start(program);
    };
  }
  return row;
}

}  // namespace vdrive::tool
