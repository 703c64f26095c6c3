// SPDX-License-Identifier: Apache-2.0
#include "language/arguments.hpp"
#include "language/command.hpp"
#include "terminal/terminal.hpp"
#include "vdrive/assert.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::tool {
namespace {

constexpr std::string_view kBash = R"(# bash completion for vdrive, made by: vdrive completion bash
_vdrive() {
  local IFS=$'\n'
  local choices
  choices=$("${COMP_WORDS[0]}" __complete "${COMP_WORDS[@]:1:COMP_CWORD}" 2>/dev/null)
  COMPREPLY=($(compgen -W "$choices" -- "${COMP_WORDS[COMP_CWORD]}"))
}
complete -o default -F _vdrive vdrive
)";

constexpr std::string_view kZsh = R"(#compdef vdrive
# zsh completion for vdrive, made by: vdrive completion zsh
_vdrive() {
  local -a choices
  choices=("${(@f)$("${words[1]}" __complete "${(@)words[2,CURRENT]}" 2>/dev/null)}")
  choices=("${(@)choices:#}")
  if (( $#choices )); then
    compadd -- "${choices[@]}"
  else
    _files
  fi
}
if [[ "$funcstack[1]" == _vdrive ]]; then
  _vdrive "$@"
else
  compdef _vdrive vdrive
fi
)";

constexpr std::string_view kFish = R"(# fish completion for vdrive, made by: vdrive completion fish
function __vdrive_complete
  set -l words (commandline -opc)
  set -l current (commandline -ct)
  set -l choices ($words[1] __complete $words[2..-1] "$current" 2>/dev/null)
  if test (count $choices) -gt 0
    printf '%s\n' $choices
  else
    __fish_complete_path "$current"
  end
end
complete -c vdrive -f -a '(__vdrive_complete)'
)";

struct ShellRow {
  std::string_view name;
  std::string_view script;
};

constexpr std::array kShells{ShellRow{"bash", kBash}, ShellRow{"zsh", kZsh},
                             ShellRow{"fish", kFish}};

std::vector<std::string> completed_shells() {
  std::vector<std::string> names;
  names.reserve(kShells.size());
  for (const ShellRow& row : kShells) names.emplace_back(row.name);
  return names;
}

/// Prints a shell script that completes command lines by calling this program.
struct CompletionCommand {
  std::string shell{};

  void declare(Arguments& arguments) {
    arguments.positional("SHELL", shell, "bash, zsh or fish").required().one_of(completed_shells());
  }

  ExitCode start(const Program& program) const {
    const auto* const row = std::ranges::find(kShells, shell, &ShellRow::name);
    ensure(row != kShells.end(), "the reader takes the shells of the table only");
    std::string_view script = row->script;
    while (script.ends_with('\n')) script.remove_suffix(1);
    program.terminal.print(script);
    return ExitCode::ok;
  }
};

}  // namespace

extern const CommandRow kCompletion = row_of<CompletionCommand>(
    {.name = "completion",
     .group = CommandGroup::machine,
     .summary = "Print a script that completes command lines",
     .example = "completion bash > ~/.local/share/bash-completion/completions/vdrive",
     .deepest = Place::command_line,
     .needs_domain = false});

}  // namespace vdrive::tool
