// SPDX-License-Identifier: Apache-2.0
#include "language/completion.hpp"

#include "values/condition.hpp"
#include "values/value.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/client/disturbance.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <span>

namespace vdrive::tool {
namespace {

using Words = std::vector<std::string>;

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

/// @return the names of its options, such as "--json"; short ones are not worth completing.
void add_options(const CLI::App& app, Words& words) {
  for (const CLI::Option* const option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) words.push_back("--" + name);
  }
}

bool takes_value(const CLI::App& app, const std::string& option) {
  const CLI::Option* const found = app.get_option_no_throw(option);
  return found != nullptr && found->get_items_expected_max() > 0;
}

Words object_names() {
  Words names;
  names.reserve(kObjectTable.size());
  for (const ObjectDescription& row : kObjectTable) names.emplace_back(row.variable_name);
  return names;
}

Words disturbance_names() {
  Words names{"none"};
  for (const client::DisturbanceRow& row : client::kDisturbances) names.emplace_back(row.name);
  return names;
}

/// The values of an object that has few of them.
Words values_of(const std::string& object) {
  constexpr std::int64_t kFew = 16;
  const auto row = parse_object(object).row();
  Words values;
  if (!row) return values;
  const ObjectDescription& description = describe(*row);
  const bool is_mode = description.variable_name == "op_mode_cmd";
  if (!is_mode && (description.access == Access::read_only ||
                   description.upper_limit - description.lower_limit > kFew)) {
    return values;
  }
  for (std::int64_t value = description.lower_limit; value <= description.upper_limit; ++value) {
    if (!is_mode || is_operating_mode(value)) values.push_back(std::to_string(value));
  }
  return values;
}

/// One command line, taken apart.
class Line {
 public:
  Line(const CLI::App& app, std::span<const std::string> before) : app_(app) {
    for (std::size_t i = 0; i < before.size() && !is_unknown_; ++i) {
      const std::string& word = before[i];
      if (is_option(word)) {
        const bool needs_value =
            takes_value(app_, word) || (word_ != nullptr && takes_value(*word_, word));
        if (!needs_value) continue;
        if (++i == before.size()) awaited_option_ = word;
      } else if (word_ == nullptr) {
        word_ = command_named(word);
        is_unknown_ = word_ == nullptr;
      } else {
        arguments_.push_back(word);
      }
    }
  }

  /// @param current the word that is completed
  [[nodiscard]] Words candidates(const std::string& current, const BenchNames& names) const {
    Words words;
    if (is_unknown_) return words;
    if (!awaited_option_.empty()) return values_of_option(names);
    if (is_option(current) || current == "-" || current == "--") {
      add_options(app_, words);
      if (word_ != nullptr) add_options(*word_, words);
      return words;
    }
    if (word_ != nullptr) return arguments(names);
    for (const CLI::App* const word : app_.get_subcommands({})) words.push_back(word->get_name());
    return words;
  }

 private:
  [[nodiscard]] const CLI::App* command_named(const std::string& name) const {
    const auto commands = app_.get_subcommands({});
    const auto found = std::ranges::find(commands, name, &CLI::App::get_name);
    return found == commands.end() ? nullptr : *found;
  }

  [[nodiscard]] Words values_of_option(const BenchNames& names) const {
    if (awaited_option_ == "--format") return {"table", "json", "csv"};
    if (awaited_option_ == "--language") return {"en", "zh"};
    if (awaited_option_ == "--bench") return names.benches();
    return {};
  }

  /// @return the name of the place that the next argument has, such as AXIS.
  [[nodiscard]] std::string place() const {
    std::size_t left = arguments_.size();
    std::string name;
    for (const CLI::Option* const option : word_->get_options()) {
      if (!option->get_positional()) continue;
      name = option->get_name(true);
      const auto most = static_cast<std::size_t>(std::max(option->get_items_expected_max(), 1));
      if (left < most) return name;
      left -= most;
    }
    return {};
  }

  [[nodiscard]] Words arguments(const BenchNames& names) const {
    const std::string name = place();
    if (name == "AXIS") return names.axes();
    if (name == "BENCH") return names.benches();
    if (name == "OBJECT") return object_names();
    if (name == "KIND") return disturbance_names();
    if (name == "ACTION") return {"take", "list", "restore", "drop"};
    if (name == "SHELL") return completed_shells();
    if (name == "WHAT") return what(names);
    if (name == "VALUE") return values(names);
    return {};
  }

  [[nodiscard]] Words what(const BenchNames& names) const {
    if (arguments_.empty()) {
      Words words = names.axes();
      if (word_->get_name() == "events") {
        for (std::string& bench : names.benches()) words.push_back(std::move(bench));
      }
      return words;
    }
    if (arguments_.size() > 1 || word_->get_name() != "wait") return {};
    Words words = condition_names();
    for (std::string& object : object_names()) words.push_back(std::move(object));
    return words;
  }

  [[nodiscard]] Words values(const BenchNames& /*names*/) const {
    const std::string& command = word_->get_name();
    if (command == "disturb") return {"0", "1"};
    if (command == "write" && arguments_.size() == 2) return values_of(arguments_[1]);
    if (command == "expect" && arguments_.size() == 2) return {"==", "!=", "<", "<=", ">", ">="};
    return {};
  }

  const CLI::App& app_;
  const CLI::App* word_ = nullptr;
  bool is_unknown_ = false;
  std::string awaited_option_;
  Words arguments_;
};

}  // namespace

bool is_option(const std::string& argument) {
  return argument.size() > 1 && argument[0] == '-' && (argument[1] < '0' || argument[1] > '9');
}

Words candidates(const CLI::App& app, const Words& words, const BenchNames& names) {
  if (words.empty()) return {};
  const std::string& current = words.back();
  const Line line(app, std::span(words).first(words.size() - 1));
  Words found = line.candidates(current, names);
  std::erase_if(found, [&current](const std::string& word) {
    return !word.starts_with(current);
  });
  std::ranges::sort(found);
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

Words completed_shells() {
  Words names;
  for (const ShellRow& row : kShells) names.emplace_back(row.name);
  return names;
}

std::string shell_completion(std::string_view shell) {
  const auto* const row = std::ranges::find(kShells, shell, &ShellRow::name);
  return std::string(row == kShells.end() ? std::string_view() : row->script);
}

}  // namespace vdrive::tool
