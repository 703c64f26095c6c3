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

/// Where a command is written. Every command of a scenario is allowed in a shell, and every command
/// of a shell on the command line.
enum class Place : std::uint8_t { command_line, shell, scenario };

/// A command with its arguments: the content of a line. Created only by the command-line parser.
struct Command {
  const CommandRow* row = nullptr;
  std::any arguments;                    ///< struct defined in the command's source file
  std::vector<std::string> axes;         ///< named in the command: addresses such as 7.1, names,
                                         ///< 7.*, *
  std::optional<std::uint32_t> bench;    ///< named in the command
  std::optional<std::uint32_t> refusal;  ///< `refused`: passes if it is refused with this code
  bool limits_itself = false;    ///< --timeout limits the command, not the search for its axes
  bool bridges_silence = false;  ///< continues after a gap of up to SessionOptions::patience
};

/// The invocation of the tool, for commands that open their own session or none.
struct Program {
  const GlobalOptions& options;
  CommandTable commands;
  Terminal& terminal;
};

/// The heading under which the help lists a command; headings are in the order of their first
/// command.
enum class CommandGroup : std::uint8_t {
  none,  ///< not used by any command
  observation,
  power,
  motion,
  parameters,
  bench,
  scenarios,
  recordings,
  machine,
};

/// The name and help of a command.
struct CommandInfo {
  std::string_view name;
  CommandGroup group = CommandGroup::none;
  std::string_view summary;
  std::string_view example;         ///< after "vdrive "
  std::string_view help = {};       ///< end of its help, instead of the example
  Place deepest = Place::scenario;  ///< allowed here and in the places before it
  bool needs_domain = true;         ///< false: also works with an invalid VDRIVE_DOMAIN
};

/// Creates the command from the arguments read.
using CommandMaker = std::function<Command()>;

/// The interface of a command to the rest of the tool; `row_of` derives it from the struct of its
/// arguments.
struct CommandRow {
  CommandInfo info;

  /// Declares the arguments.
  CommandMaker (*declare)(Arguments& arguments) = nullptr;

  /// Checks that need no bench; a scenario makes them when it is read.
  /// @throws UsageError
  void (*check_objects)(const std::any& arguments) = nullptr;

  /// Checks the values once the axis is known, before anything moves.
  /// @throws UsageError for a unit that the axis does not have, and for a value that is out of
  ///         range after conversion from its unit.
  void (*check_units)(const std::any& arguments, const CommandContext& context,
                      const client::Axis& axis) = nullptr;

  /// Executes the command in a session.
  client::Outcome (*run)(const std::any& arguments, CommandContext& context) = nullptr;

  /// Executes a command of the command line that needs no session or opens its own.
  ExitCode (*start)(const std::any& arguments, const Program& program) = nullptr;
};

/// @return the axes named in the arguments.
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

/// @return the command with these arguments.
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
///         both, and with `check_objects` and `check_units` if there is something to check
/// @tparam make returns the arguments with their initial values
template <typename Given, Given (*make)() = &no_arguments<Given>>
[[nodiscard]] consteval CommandRow row_of(const CommandInfo& info) {
  constexpr bool kRuns = requires(const Given& given, CommandContext& context) {
    given.run(context);
  };
  constexpr bool kStarts = requires(const Given& given, const Program& program) {
    given.start(program);
  };
  static_assert(kRuns || kStarts, "a command does something");
  if (info.group == CommandGroup::none) throw "the help lists each command in a group";
  if (!kRuns && info.deepest != Place::command_line) throw "a shell has one session for all";
  CommandRow row{.info = info};
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
