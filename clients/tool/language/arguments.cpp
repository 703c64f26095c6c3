// SPDX-License-Identifier: Apache-2.0
#include "language/arguments.hpp"

#include "base/usage_error.hpp"
#include "values/value.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/wording.hpp"

#include <CLI/CLI.hpp>

#include <limits>
#include <utility>

namespace vdrive::tool {
namespace {

constexpr std::uint64_t kHighest32 = std::numeric_limits<std::uint32_t>::max();

}  // namespace

Argument& Argument::required() {
  option_.required();
  return *this;
}

Argument& Argument::excludes(const Argument& other) {
  option_.excludes(&other.option_);
  return *this;
}

Argument& Argument::one_of(std::vector<std::string> words) {
  option_.check(CLI::Validator(
      [words](const std::string& text) {
        return refusal_of_choice(text, words);
      },
      choice_of(words)));
  return completed_by(complete_one_of(std::move(words)));
}

Argument& Argument::completed_by(Completer completer) {
  completers_[&option_] = std::move(completer);
  return *this;
}

Argument Arguments::positional(const std::string& name, std::string& text,
                               const std::string& help) {
  return {*command_.add_option(name, text, help)->type_name(""), completers_};
}

Argument Arguments::positional(const std::string& name, std::vector<std::string>& texts,
                               const std::string& help) {
  return {*command_.add_option(name, texts, help)->type_name(""), completers_};
}

Argument Arguments::option(const std::string& name, const std::string& type, std::string& text,
                           const std::string& help) {
  return {*command_.add_option(name, text, help)->type_name(type), completers_};
}

Argument Arguments::option(const std::string& name, const std::string& type,
                           std::vector<std::string>& texts, const std::string& help) {
  // The next argument may be a positional one.
  return {*command_.add_option(name, texts, help)->allow_extra_args(false)->type_name(type),
          completers_};
}

void Arguments::flag(const std::string& name, bool& is_given, const std::string& help) {
  command_.add_flag(name, is_given, help);
}

void Arguments::axis(std::string& axis) {
  positional("AXIS", axis, "bench.axis such as 1.1, or a name")
      .required()
      .completed_by(complete_axis);
}

void Arguments::axes(std::vector<std::string>& axes, const std::string& without) {
  positional("AXIS", axes,
             "Axes: 7.1, 7.lift or a name; '7.*' is every axis of bench 7; " + without)
      .completed_by(complete_axis);
}

void Arguments::axes_or_all(std::vector<std::string>& axes) {
  bool& is_for_all = flags_.emplace_back();
  this->axes(axes, "required unless --all is given");
  flag("--all", is_for_all, "Every axis of every bench");
  then([&axes, &is_for_all] {
    if (is_for_all && !axes.empty()) throw UsageError("--all cannot be combined with AXIS");
    if (!is_for_all && axes.empty()) {
      throw UsageError("AXIS is required, or --all for every axis of every bench");
    }
    if (is_for_all) axes = {"*"};
  });
}

void Arguments::bench(std::optional<std::uint32_t>& bench) {
  option("--bench", "B", bench, "Default: the only bench", parse_bench)
      .completed_by(complete_bench);
}

void Arguments::service(std::string& file) {
  option("--service", "FILE", file,
         "The program vdrived; default: next to this program, otherwise from PATH");
}

void Arguments::take_over(bool& is_given) {
  flag("--take-over", is_given, "Take control of the axis first, also from another session");
}

void Arguments::no_wait(client::Until& until, const std::string& help) {
  bool& is_given = flags_.emplace_back();
  flag("--no-wait", is_given, help);
  then([&until, &is_given] {
    if (is_given) until = client::Until::in_force;
  });
}

void Arguments::finish() const {
  for (const auto& step : steps_) step();
}

std::uint64_t parse_count(std::string_view text) {
  return parse_number(text, "count", kHighest32);
}

std::uint32_t parse_bench(std::string_view text) {
  return static_cast<std::uint32_t>(parse_number(text, "bench number", kHighest32));
}

Completer complete_one_of(std::vector<std::string> words) {
  return [words = std::move(words)](std::span<const std::string>, const BenchNames&) {
    return words;
  };
}

std::vector<std::string> complete_axis(std::span<const std::string> /*before*/,
                                       const BenchNames& names) {
  return names.axes();
}

std::vector<std::string> complete_bench(std::span<const std::string> /*before*/,
                                        const BenchNames& names) {
  return names.benches();
}

std::vector<std::string> complete_object(std::span<const std::string> /*before*/,
                                         const BenchNames& /*names*/) {
  std::vector<std::string> names;
  names.reserve(kObjectTable.size());
  for (const ObjectDescription& row : kObjectTable) names.emplace_back(row.variable_name);
  return names;
}

}  // namespace vdrive::tool
