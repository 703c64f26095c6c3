// SPDX-License-Identifier: Apache-2.0
#include "language/completion.hpp"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <span>

namespace vdrive::tool {
namespace {

using Words = std::vector<std::string>;

/// @return the names of its options, such as "--json"; short ones are not worth completing.
void add_options(const CLI::App& app, Words& words) {
  for (const CLI::Option* const option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) words.push_back("--" + name);
  }
}

/// @return the option where it has a value, else none.
const CLI::Option* option_with_value(const CLI::App& app, const std::string& name) {
  const CLI::Option* const found = app.get_option_no_throw(name);
  return found != nullptr && found->get_items_expected_max() > 0 ? found : nullptr;
}

/// One command line, taken apart.
class Line {
 public:
  Line(const CLI::App& app, std::span<const std::string> before) : app_(app) {
    for (std::size_t i = 0; i < before.size() && !is_unknown_; ++i) {
      const std::string& word = before[i];
      if (is_option(word)) {
        const CLI::Option* const option = awaiting(word);
        if (option != nullptr && ++i == before.size()) awaited_ = option;
      } else if (command_ == nullptr) {
        command_ = command_named(word);
        is_unknown_ = command_ == nullptr;
      } else {
        arguments_.push_back(word);
      }
    }
  }

  /// @param current the word that is completed
  [[nodiscard]] Words candidates(const std::string& current, const Completers& completers,
                                 const BenchNames& names) const {
    Words words;
    if (is_unknown_) return words;
    if (awaited_ != nullptr) return values_of(awaited_, completers, names);
    if (is_option(current) || current == "-" || current == "--") {
      add_options(app_, words);
      if (command_ != nullptr) add_options(*command_, words);
      return words;
    }
    if (command_ != nullptr) return values_of(place(), completers, names);
    for (const CLI::App* const each : app_.get_subcommands({})) words.push_back(each->get_name());
    return words;
  }

 private:
  [[nodiscard]] const CLI::App* command_named(const std::string& name) const {
    const auto commands = app_.get_subcommands({});
    const auto found = std::ranges::find(commands, name, &CLI::App::get_name);
    return found == commands.end() ? nullptr : *found;
  }

  /// @return the option of this name, of the command first, where the next word is its value.
  [[nodiscard]] const CLI::Option* awaiting(const std::string& name) const {
    const CLI::Option* own = command_ == nullptr ? nullptr : option_with_value(*command_, name);
    return own != nullptr ? own : option_with_value(app_, name);
  }

  /// @return the place that the next argument has, such as AXIS, or none.
  [[nodiscard]] const CLI::Option* place() const {
    std::size_t left = arguments_.size();
    for (const CLI::Option* const option : command_->get_options()) {
      if (!option->get_positional()) continue;
      const auto most = static_cast<std::size_t>(std::max(option->get_items_expected_max(), 1));
      if (left < most) return option;
      left -= most;
    }
    return nullptr;
  }

  [[nodiscard]] Words values_of(const CLI::Option* option, const Completers& completers,
                                const BenchNames& names) const {
    const auto found = completers.find(option);
    return found == completers.end() ? Words() : found->second(arguments_, names);
  }

  const CLI::App& app_;
  const CLI::App* command_ = nullptr;
  bool is_unknown_ = false;
  const CLI::Option* awaited_ = nullptr;  ///< whose value comes next
  Words arguments_;
};

}  // namespace

bool is_option(const std::string& argument) {
  return argument.size() > 1 && argument[0] == '-' && (argument[1] < '0' || argument[1] > '9');
}

Words candidates(const CLI::App& app, const Completers& completers, const Words& words,
                 const BenchNames& names) {
  if (words.empty()) return {};
  const std::string& current = words.back();
  const Line line(app, std::span(words).first(words.size() - 1));
  Words found = line.candidates(current, completers, names);
  std::erase_if(found, [&current](const std::string& word) {
    return !word.starts_with(current);
  });
  std::ranges::sort(found);
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

}  // namespace vdrive::tool
