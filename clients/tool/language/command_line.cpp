// SPDX-License-Identifier: Apache-2.0
#include "language/command_line.hpp"

#include "base/usage_error.hpp"
#include "language/arguments.hpp"
#include "language/bench_names.hpp"
#include "language/help.hpp"
#include "network_options.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wire/address.hpp"
#include "vdrive/wire/ports.hpp"
#include "vdrive/wire/program_version.hpp"
#include "vdrive/wording.hpp"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdlib>
#include <deque>
#include <limits>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace vdrive::tool {
namespace {

/// @return whether an argument looks like an option; a negative number does not.
bool is_option(const std::string& argument) {
  return argument.size() > 1 && argument[0] == '-' && (argument[1] < '0' || argument[1] > '9');
}

using Words = std::vector<std::string>;

/// Adds the long names of the options, such as "--json"; short ones are not worth completing.
void add_options(const CLI::App& app, Words& words) {
  for (const CLI::Option* const option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) words.push_back("--" + name);
  }
}

/// @return the option if it takes a value, otherwise nullptr.
const CLI::Option* option_with_value(const CLI::App& app, const std::string& name) {
  const CLI::Option* const found = app.get_option_no_throw(name);
  return found != nullptr && found->get_items_expected_max() > 0 ? found : nullptr;
}

/// A command line split into its parts.
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

  /// @param current the word to complete
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

  /// @return the option of this name if the next word is its value; options of the command take
  ///         precedence.
  [[nodiscard]] const CLI::Option* awaiting(const std::string& name) const {
    const CLI::Option* own = command_ == nullptr ? nullptr : option_with_value(*command_, name);
    return own != nullptr ? own : option_with_value(app_, name);
  }

  /// @return the positional argument that is next, such as AXIS, or nullptr.
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
  const CLI::Option* awaited_ = nullptr;  ///< the next word is its value
  Words arguments_;
};

/// @param app the commands
/// @param completers of their arguments
/// @param words of the command line without the program; the last one is completed
/// @return the possible words, none where a file name is expected.
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

/// @return what is wrong with ADDRESS:PORT, or nothing; becomes part of a text of CLI11.
std::string check_server(const std::string& text) {
  return wire::parse_server_address(text)
             ? ""
             : "'" + text + "' is not HOST:PORT, such as 10.0.0.9:11811";
}

/// @return what is wrong with an own interface, or nothing.
std::string check_interface(const std::string& text) {
  return wire::is_interface(text)
             ? ""
             : "'" + text + "' is not an IPv4 address or an interface, such as 10.0.0.1 or eth0";
}

/// @return what is wrong with a host, or nothing.
std::string check_host_name(const std::string& text) {
  return wire::is_host(text)
             ? ""
             : "'" + text + "' is not an IPv4 address or the name of a host, such as 10.0.0.1";
}

/// CLI11 treats an empty value as a missing option, and an empty environment variable as unset.
void refuse_empty_values(const CLI::App& app) {
  for (const CLI::Option* const option : app.get_options()) {
    if (std::ranges::find(option->results(), "") != option->results().end()) {
      throw UsageError(option->get_name() + ": the value is empty");
    }
    const std::string variable = option->get_envname();
    const char* const text = variable.empty()
                                 ? nullptr
                                 : std::getenv(variable.c_str());  // NOLINT(concurrency-mt-unsafe)
    if (option->count() == 0 && text != nullptr && *text == '\0') {
      throw UsageError(variable +
                       " in the environment is set, but empty: unset it or give a value");
    }
  }
}

std::vector<std::string> names_of_options(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* const option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

std::vector<std::string> names_of_commands(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* const command : app.get_subcommands({}))
    names.push_back(command->get_name());
  return names;
}

/// @return what is wrong with arguments that nothing takes: names the first option among them, or
///         else the first one. The message of CLI11 lists them in reverse order.
std::string unexpected_text(const CLI::App& app) {
  const std::vector<std::string> extras = app.remaining(true);
  const auto chosen = app.get_subcommands();
  const CLI::App& command = chosen.empty() ? app : *chosen.front();
  const std::string called = "'vdrive " + command.get_name() + "'";
  auto extra = std::ranges::find_if(extras, is_option);
  if (extra == extras.end()) {
    return in_quotes(extras.front()) + " is one argument too many for " + called;
  }
  const std::string name = extra->substr(0, extra->find('='));
  std::vector<std::string> known = names_of_options(command);
  for (std::string& global : names_of_options(app)) known.push_back(std::move(global));
  return in_quotes(name) + " is not an option of " + called + suggestion(name, known);
}

/// @param name of an option before the command
std::string unknown_option(const CLI::App& app, const std::string& name) {
  for (const CLI::App* const command : app.get_subcommands({})) {
    if (command->get_option_no_throw(name) == nullptr) continue;
    return in_quotes(name) + " belongs after its command, such as 'vdrive " + command->get_name() +
           " ... " + name + "'";
  }
  return in_quotes(name) + " is not an option" + suggestion(name, names_of_options(app));
}

/// @param how_to_list tells the user how to list the commands, if none has a similar name
void check_command_name(const CLI::App& app, const std::string& name,
                        std::string_view how_to_list) {
  const std::vector<std::string> commands = names_of_commands(app);
  if (std::ranges::find(commands, name) != commands.end()) return;
  const std::string nearest = suggestion(name, commands);
  throw UsageError(in_quotes(name) + " is not a command" +
                   (nearest.empty() ? std::string(how_to_list) : nearest));
}

/// CLI11 reports an unknown command as a missing one, and takes the value of an unknown option for
/// the command. So this checks the first argument that is neither an option nor the value of one.
void check_command(const CLI::App& app, const std::vector<std::string>& arguments,
                   std::string_view how_to_list) {
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& argument = arguments[i];
    if (!argument.starts_with('-')) {
      check_command_name(app, argument, how_to_list);
      return;
    }
    const std::string name = argument.substr(0, argument.find('='));
    const CLI::Option* const option = app.get_option_no_throw(name);
    if (option == nullptr) throw UsageError(unknown_option(app, name));
    const bool has_value = option->get_items_expected_max() > 0;
    if (has_value && name == argument) ++i;
  }
}

/// @throws UsageError
std::uint32_t default_domain() {
  try {
    return wire::default_domain();
  } catch (const std::runtime_error& error) {
    throw UsageError(error.what());
  }
}

/// A line as read by CLI11: the options of the tool, and the commands allowed in this place.
class CommandLine {
 public:
  CommandLine(CommandTable commands, Place place) : place_(place) {
    app_.name("vdrive");
    const bool is_shell = place == Place::shell;
    app_.description(std::string(is_shell ? kSummaryOfShell : kSummary) + std::string(kSpelling));
    if (!is_shell) app_.footer(std::string(kExamples));
    app_.require_subcommand(1);
    app_.fallthrough();
    app_.get_formatter()->column_width(28);
    app_.get_formatter()->label("SUBCOMMAND", "COMMAND");
    if (place == Place::scenario) app_.set_help_flag();
    add_options(place);
    for (const CommandRow* const row : commands) {
      if (row->info.deepest >= place) add_command(*row, place);
    }
    // Added after the commands, which would otherwise inherit it.
    if (place == Place::command_line) {
      app_.set_help_all_flag("--help-all", "Print the help of every command and exit");
    }
  }

  /// @throws CLI::ParseError, UsageError
  void parse(std::vector<std::string> arguments) {
    check_command(app_, arguments,
                  place_ == Place::shell ? "; 'help' lists all commands"
                                         : "; 'vdrive --help' lists all commands");
    std::ranges::reverse(arguments);  // CLI11 takes them from the back
    app_.parse(std::move(arguments));
    refuse_empty_values(app_);
    for (const CLI::App* const command : app_.get_subcommands()) refuse_empty_values(*command);
  }

  [[nodiscard]] const CLI::App& app() const { return app_; }

  [[nodiscard]] const Completers& completers() const { return completers_; }

  [[nodiscard]] std::optional<Command>& command() { return command_; }

  /// @throws UsageError
  [[nodiscard]] GlobalOptions options() const {
    GlobalOptions options = options_;
    if (!timeout_.empty()) options.timeout = parse_duration(timeout_);
    options.network_given = network_given();
    return options;
  }

  /// --domain. @throws UsageError for a wrong default.
  [[nodiscard]] std::uint32_t domain() const { return domain_ ? *domain_ : default_domain(); }

 private:
  void add_options(Place place) {
    app_.add_option("--timeout", timeout_,
                    "Limit such as 500ms or 5 (seconds): wall time to find a service (default 2, "
                    "in the closed mode 5), "
                    "drive time of a motion (default 60)")
        ->type_name("T");
    if (place == Place::command_line) add_network();
    if (place != Place::scenario) {
      app_.add_flag("--json", options_.json, "One JSON object per line on standard output");
    }
  }

  void add_network() {
    network_.push_back(
        bridge::add_domain_option(app_, domain_, "; default: VDRIVE_DOMAIN, else 0"));
    add_addresses("--interface", options_.interfaces,
                  "Use this network in addition to loopback: IPv4 address or interface (eth0) of "
                  "this machine in it",
                  "ADDRESS")
        ->check(check_interface);
    add_addresses("--peer", options_.peers,
                  "Search for benches on this host, too: its IPv4 address or name", "HOST")
        ->check(check_host_name);
    add_addresses("--discovery-server", options_.discovery_servers,
                  "Use a discovery server instead of multicast", "HOST:PORT")
        ->check(check_server);
    network_.push_back(
        app_.add_option("--security", options_.security,
                        "Closed mode: directory with certificate, key and permissions")
            ->envname("VDRIVE_SECURITY")
            ->type_name("DIR"));
    app_.set_version_flag("--version", wire::program_version("vdrive"));
  }

  /// The option may be repeated, but takes one value each time: the next argument may be the
  /// command.
  CLI::Option* add_addresses(const char* name, std::vector<std::string>& values, const char* help,
                             const char* type) {
    network_.push_back(
        app_.add_option(name, values, help)->allow_extra_args(false)->type_name(type));
    return network_.back();
  }

  /// Excludes values from the environment.
  [[nodiscard]] std::vector<std::string> network_given() const {
    std::vector<std::string> names;
    for (const CLI::Option* const option : app_.parse_order()) {
      if (std::ranges::count(network_, option) != 0) names.push_back(option->get_name());
    }
    return names;
  }

  void add_command(const CommandRow& row, Place place) {
    const CommandInfo& info = row.info;
    CLI::App* const command =
        app_.add_subcommand(std::string(info.name), std::string(info.summary));
    command->group(std::string(title_of(info.group)));
    command->footer(info.help.empty() ? "Example:\n  vdrive " + std::string(info.example)
                                      : std::string(info.help));
    Arguments& arguments = arguments_.emplace_back(*command, place, options_.json, completers_);
    command->callback([this, &row, &arguments, make = row.declare(arguments)] {
      arguments.finish();
      command_ = make();
      command_->row = &row;
    });
  }

  const Place place_;
  CLI::App app_;
  GlobalOptions options_;
  std::vector<CLI::Option*> network_;  ///< the options about the network
  std::optional<std::uint32_t> domain_;
  std::string timeout_;
  Completers completers_;
  std::deque<Arguments> arguments_;  ///< of each command; referenced by the callbacks
  std::optional<Command> command_;
};

/// @return the help of the tool, then that of each command.
std::string help_of_all_commands(const CLI::App& app) {
  std::string text = app.help();
  for (const CLI::App* const command : app.get_subcommands({})) {
    text += "\n" + command->get_name() + ": " + command->help(app.get_name());
  }
  return text;
}

/// Texts of CLI11 end with its own hints and with line breaks, and contain the user's input
/// unescaped.
std::string one_line(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  std::ranges::replace(text, '\n', ' ');
  return escaped(text, kShownOfMessage);
}

/// The request of a command line, or of a line of a shell.
Invocation invocation_of(CommandLine& line, std::vector<std::string> arguments) {
  Invocation invocation;
  try {
    line.parse(std::move(arguments));
    invocation.options = line.options();
    invocation.command = std::move(line.command());
  } catch (const CLI::CallForHelp&) {
    invocation.text = line.app().help();
  } catch (const CLI::CallForAllHelp&) {
    invocation.text = help_of_all_commands(line.app());
  } catch (const CLI::CallForVersion& version) {
    invocation.text = std::string(version.what()) + "\n";
  } catch (const CLI::ExtrasError&) {
    throw UsageError(unexpected_text(line.app()));
  } catch (const CLI::ParseError& error) {
    throw UsageError(one_line(error.what()));
  }
  return invocation;
}

constexpr std::string_view kHelp = "help";

/// @param words of a shell line that begins with `help`
/// @return the words of the equivalent command line.
std::vector<std::string> words_of_help(std::vector<std::string> words) {
  if (words.size() > 2) {
    throw UsageError(in_quotes(words[2]) + " is one argument too many for 'help'");
  }
  words.erase(words.begin());
  words.emplace_back("--help");
  return words;
}

/// refused CODE COMMAND...: parses the inner command.
ScenarioCommand parse_refused(CommandTable commands, const std::vector<std::string>& words) {
  constexpr std::uint64_t kHighestCode = std::numeric_limits<std::uint32_t>::max();
  if (words.size() < 3) throw UsageError("refused needs a code and a command");
  const auto code = static_cast<std::uint32_t>(parse_number(words[1], "code", kHighestCode));
  if (words[2] == "refused") {
    throw UsageError("'refused' cannot be nested: a line has at most one");
  }
  ScenarioCommand inner = parse_scenario_command(commands, {words.begin() + 2, words.end()});
  inner.command.refusal = code;
  return inner;
}

}  // namespace

Invocation parse_command_line(CommandTable commands, std::vector<std::string> arguments) {
  if (arguments.empty()) throw UsageError("no command given; 'vdrive --help' lists all commands");
  CommandLine line(commands, Place::command_line);
  Invocation invocation = invocation_of(line, std::move(arguments));
  const bool needs_domain = invocation.command && invocation.command->row->info.needs_domain;
  if (needs_domain) invocation.options.domain = line.domain();
  return invocation;
}

Invocation parse_shell_command(CommandTable commands, std::vector<std::string> words) {
  CommandLine line(commands, Place::shell);
  const bool is_help = !words.empty() && words.front() == kHelp;
  return invocation_of(line, is_help ? words_of_help(std::move(words)) : std::move(words));
}

ScenarioCommand parse_scenario_command(CommandTable commands, std::vector<std::string> words) {
  if (!words.empty() && words.front() == "refused") return parse_refused(commands, words);
  const bool asks_for_help = std::ranges::any_of(words, [](const std::string& word) {
    return word == "--help" || word == "-h";
  });
  if (asks_for_help) throw UsageError("help cannot be used in a scenario");
  CommandLine line(commands, Place::scenario);
  try {
    line.parse(std::move(words));
    ensure(line.command().has_value(), "a line without a mistake has a command");
    return {*std::move(line.command()), line.options().timeout};
  } catch (const CLI::ExtrasError&) {
    throw UsageError(unexpected_text(line.app()));
  } catch (const CLI::ParseError& error) {
    throw UsageError(one_line(error.what()));
  }
}

std::vector<std::string> complete_words(CommandTable commands,
                                        const std::vector<std::string>& words,
                                        const BenchNames& names) {
  const CommandLine line(commands, Place::command_line);
  return candidates(line.app(), line.completers(), words, names);
}

std::vector<std::string> complete_line(CommandTable commands, const std::string& line,
                                       const BenchNames& names) {
  std::vector<std::string> words;
  std::istringstream stream(line);
  for (std::string word; stream >> word;) words.push_back(word);
  if (line.empty() || line.ends_with(' ') || line.ends_with('\t')) words.emplace_back();
  const CommandLine shell(commands, Place::shell);
  const bool is_help = words.size() == 2 && words.front() == kHelp;
  if (is_help) words.erase(words.begin());
  std::vector<std::string> found = candidates(shell.app(), shell.completers(), words, names);
  const bool is_first = words.size() == 1 && !is_help;
  if (is_first) {
    // Commands of the shell itself.
    for (const std::string_view own : {kHelp, std::string_view("exit"), std::string_view("quit")}) {
      if (own.starts_with(words.front())) found.emplace_back(own);
    }
    std::ranges::sort(found);
  }
  return found;
}

}  // namespace vdrive::tool
