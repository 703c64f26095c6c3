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

/// @param before the arguments in front of the word that is completed
/// @return the words that may stand in its place.
using Completer = std::function<std::vector<std::string>(std::span<const std::string> before,
                                                         const BenchNames& names)>;

/// What completes which argument.
using Completers = std::map<const CLI::Option*, Completer>;

/// One argument that was declared: what else holds for it.
class Argument {
 public:
  Argument(CLI::Option& option, Completers& completers)
      : option_(option), completers_(completers) {}

  Argument& required();

  /// The two cannot be given together.
  Argument& excludes(const Argument& other);

  /// It is one of these words; the completion offers them.
  Argument& one_of(std::vector<std::string> words);

  Argument& completed_by(Completer completer);

 private:
  CLI::Option& option_;
  Completers& completers_;
};

/// The arguments of one command, declared by its file. What is declared writes into the fields that
/// it is given, which have to stay as long as this: text while the line is read, everything else
/// in finish(), in the order in which it was declared.
class Arguments {
 public:
  /// @param is_json whether the line has --json, known in finish()
  Arguments(CLI::App& command, Place place, const bool& is_json, Completers& completers)
      : command_(command), place_(place), is_json_(is_json), completers_(completers) {}

  /// Where the command is written.
  [[nodiscard]] Place place() const noexcept { return place_; }

  [[nodiscard]] const bool& is_json() const noexcept { return is_json_; }

  /// An argument by its place, such as POSITION.
  Argument positional(const std::string& name, std::string& text, const std::string& help);
  Argument positional(const std::string& name, std::vector<std::string>& texts,
                      const std::string& help);

  /// It is required. @param read makes the field of the text
  template <typename Field, typename Read>
  Argument positional(const std::string& name, Field& field, const std::string& help, Read read) {
    std::string& text = texts_.emplace_back();
    then([&field, &text, read] {
      field = read(text);
    });
    return positional(name, text, help).required();
  }

  /// Without it the field stays as it is.
  template <typename Field, typename Read>
  Argument optional_positional(const std::string& name, Field& field, const std::string& help,
                               Read read) {
    std::string& text = texts_.emplace_back();
    then([&field, &text, read] {
      if (!text.empty()) field = read(text);
    });
    return positional(name, text, help);
  }

  /// Any number of arguments from a place on. @param read makes the field of all their texts
  template <typename Field, typename Read>
  Argument positionals(const std::string& name, Field& field, const std::string& help, Read read) {
    std::vector<std::string>& texts = lists_.emplace_back();
    then([&field, &texts, read] {
      field = read(texts);
    });
    return positional(name, texts, help);
  }

  /// An option with a value. @param type what its help has for the value, such as N
  Argument option(const std::string& name, const std::string& type, std::string& text,
                  const std::string& help);

  /// It may be given several times, with one value each.
  Argument option(const std::string& name, const std::string& type, std::vector<std::string>& texts,
                  const std::string& help);

  /// @param read makes the field of the text; without the option the field stays as it is
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

  /// AXIS: any number. @param without what happens when none is named
  void axes(std::vector<std::string>& axes, const std::string& without);

  /// AXIS: any number but none, or --all, which is "*": every axis of every bench.
  void axes_or_all(std::vector<std::string>& axes);

  /// --bench. None = the only one there is.
  void bench(std::optional<std::uint32_t>& bench);

  /// --service: the program of the benches. Empty = found beside the tool or in PATH.
  void service(std::string& file);

  void take_over(bool& is_given);

  /// --no-wait. @param help what is in force when it returns
  void no_wait(client::Until& until,
               const std::string& help = "Return when the command is in force");

  /// @return room for the text of an argument that is read in then().
  [[nodiscard]] std::string& text() { return texts_.emplace_back(); }

  /// What makes fields of several texts, and checks how they go together.
  void then(std::function<void()> step) { steps_.push_back(std::move(step)); }

  /// Once the whole line is read. @throws UsageError
  void finish() const;

 private:
  CLI::App& command_;
  const Place place_;
  const bool& is_json_;
  Completers& completers_;
  std::deque<std::string> texts_;  ///< of arguments that are no text
  std::deque<std::vector<std::string>> lists_;
  std::deque<bool> flags_;
  std::vector<std::function<void()>> steps_;
};

/// The readers of arguments that several commands have.
[[nodiscard]] std::uint64_t parse_count(std::string_view text);
[[nodiscard]] std::uint32_t parse_bench(std::string_view text);

/// @return a completer with these words.
[[nodiscard]] Completer complete_one_of(std::vector<std::string> words);

/// The completers of arguments that several commands have.
[[nodiscard]] std::vector<std::string> complete_axis(std::span<const std::string> before,
                                                     const BenchNames& names);
[[nodiscard]] std::vector<std::string> complete_bench(std::span<const std::string> before,
                                                      const BenchNames& names);
[[nodiscard]] std::vector<std::string> complete_object(std::span<const std::string> before,
                                                       const BenchNames& names);

}  // namespace vdrive::tool
