// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/bench_names.hpp"
#include "language/command.hpp"

#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace CLI {  // NOLINT(readability-identifier-naming): CLI11's own
class App;
class Option;
}  // namespace CLI

namespace vdrive::tool {

/// @param before the arguments before the word to complete
/// @return the possible words.
using Completer = std::function<std::vector<std::string>(std::span<const std::string> before,
                                                         const BenchNames& names)>;

/// The completer of each argument.
using Completers = std::map<const CLI::Option*, Completer>;

/// A declared argument, to which further rules can be added.
class Argument {
 public:
  Argument(CLI::Option& option, Completers& completers)
      : option_(option), completers_(completers) {}

  Argument& required();

  /// The two cannot be given together.
  Argument& excludes(const Argument& other);

  /// Must be one of these words; the completion offers them.
  Argument& one_of(std::vector<std::string> words);

  Argument& completed_by(Completer completer);

 private:
  CLI::Option& option_;
  Completers& completers_;
};

/// The arguments of one command, declared by its source file. The fields passed to the declarations
/// must outlive this object. Text fields are written while the line is read, all others by
/// finish(), in the order of declaration.
class Arguments {
 public:
  /// @param is_json whether the line has --json; valid in finish()
  Arguments(CLI::App& command, Place place, const bool& is_json, Completers& completers)
      : command_(command), place_(place), is_json_(is_json), completers_(completers) {}

  /// Where the command was written.
  [[nodiscard]] Place place() const noexcept { return place_; }

  [[nodiscard]] const bool& is_json() const noexcept { return is_json_; }

  /// A positional argument, such as POSITION.
  Argument positional(const std::string& name, std::string& text, const std::string& help);
  Argument positional(const std::string& name, std::vector<std::string>& texts,
                      const std::string& help);

  /// A required positional argument. @param read converts the text into the field's value
  template <typename Field, typename Read>
  Argument positional(const std::string& name, Field& field, const std::string& help, Read read) {
    std::string& text = texts_.emplace_back();
    then([&field, &text, read] {
      field = read(text);
    });
    return positional(name, text, help).required();
  }

  /// An optional positional argument: without it, the field keeps its value.
  template <typename Field, typename Read>
  Argument optional_positional(const std::string& name, Field& field, const std::string& help,
                               Read read) {
    std::string& text = texts_.emplace_back();
    then([&field, &text, read] {
      if (!text.empty()) field = read(text);
    });
    return positional(name, text, help);
  }

  /// Any number of arguments from here on. @param read converts their texts into the field's value
  template <typename Field, typename Read>
  Argument positionals(const std::string& name, Field& field, const std::string& help, Read read) {
    std::vector<std::string>& texts = lists_.emplace_back();
    then([&field, &texts, read] {
      field = read(texts);
    });
    return positional(name, texts, help);
  }

  /// An option with a value. @param type placeholder of the value in the help, such as N
  Argument option(const std::string& name, const std::string& type, std::string& text,
                  const std::string& help);

  /// An option that may be given several times, with one value each.
  Argument option(const std::string& name, const std::string& type, std::vector<std::string>& texts,
                  const std::string& help);

  /// @param read converts the text into the field's value; without the option the field keeps its
  ///        value
  template <typename Field, typename Read>
  Argument option(const std::string& name, const std::string& type, Field& field,
                  const std::string& help, Read read) {
    std::string& text = texts_.emplace_back();
    then([&field, &text, read] {
      if (!text.empty()) field = read(text);
    });
    return option(name, type, text, help);
  }

  void flag(const std::string& name, bool& is_given, const std::string& help);

  /// AXIS: exactly one.
  void axis(std::string& axis);

  /// AXIS: any number. @param without what happens if none is named
  void axes(std::vector<std::string>& axes, const std::string& without);

  /// AXIS: at least one, or --all, which is "*": every axis of every bench.
  void axes_or_all(std::vector<std::string>& axes);

  /// --bench. None = the only one.
  void bench(std::optional<std::uint32_t>& bench);

  /// --service: the program of the benches. Empty = found next to the tool or in PATH.
  void service(std::string& file);

  void take_over(bool& is_given);

  /// --no-wait. @param help what is in force when it returns
  void no_wait(client::Until& until,
               const std::string& help = "Return when the command is in force");

  /// @return storage for the text of an argument that a then() step reads.
  [[nodiscard]] std::string& text() { return texts_.emplace_back(); }

  /// Adds a step that converts several texts, or checks their combination.
  void then(std::function<void()> step) { steps_.push_back(std::move(step)); }

  /// Called once the complete line has been read. @throws UsageError
  void finish() const;

 private:
  CLI::App& command_;
  const Place place_;
  const bool& is_json_;
  Completers& completers_;
  std::deque<std::string> texts_;  ///< texts of arguments that are converted
  std::deque<std::vector<std::string>> lists_;
  std::deque<bool> flags_;
  std::vector<std::function<void()>> steps_;
};

/// Readers of arguments that several commands share.
[[nodiscard]] std::uint64_t parse_count(std::string_view text);
[[nodiscard]] std::uint32_t parse_bench(std::string_view text);

/// @return a completer with these words.
[[nodiscard]] Completer complete_one_of(std::vector<std::string> words);

/// Completers of arguments that several commands share.
[[nodiscard]] std::vector<std::string> complete_axis(std::span<const std::string> before,
                                                     const BenchNames& names);
[[nodiscard]] std::vector<std::string> complete_bench(std::span<const std::string> before,
                                                      const BenchNames& names);
[[nodiscard]] std::vector<std::string> complete_object(std::span<const std::string> before,
                                                       const BenchNames& names);

}  // namespace vdrive::tool
