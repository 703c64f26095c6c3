// SPDX-License-Identifier: Apache-2.0
#include "grammar.hpp"

#include "completion.hpp"
#include "help.hpp"
#include "usage_error.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wire/address.hpp"
#include "vdrive/wording.hpp"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <limits>
#include <map>
#include <memory>
#include <stdexcept>
#include <utility>

namespace vdrive::tool {
namespace {

constexpr std::uint64_t kHighest32 = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint64_t kHighest64 = std::numeric_limits<std::uint64_t>::max();

struct ActionRow {
  AxisAction action;
  bool may_return_early;  ///< takes --no-wait
  bool may_wait;          ///< returns early unless --wait
  std::string_view summary;
};

constexpr std::array kActions{
    ActionRow{AxisAction::enable, false, false, "Go through the power states to Operation enabled"},
    ActionRow{AxisAction::disable, false, false, "Shut down (0x06): to Ready to switch on"},
    ActionRow{AxisAction::halt, false, true, "Brake to standstill, keep the set-point (0x010F)"},
    ActionRow{AxisAction::resume, false, true, "End a halt and continue the set-point (0x0F)"},
    ActionRow{AxisAction::quick_stop, true, false, "Quick stop (0x02), wait for standstill"},
    ActionRow{AxisAction::reset, false, false, "Reset a fault (rising edge of bit 7)"},
    ActionRow{AxisAction::power_cycle, false, false, "Switch the axis off and on again"},
    ActionRow{AxisAction::store, false, false, "Store the parameters for every later power-up"},
    ActionRow{AxisAction::restore, false, false,
              "Remove stored parameters; defaults are in force after the next power cycle"},
};

std::vector<std::string> names_of_disturbances() {
  std::vector<std::string> names{"none"};
  for (const client::DisturbanceRow& row : client::kDisturbances) names.emplace_back(row.name);
  return names;
}

std::vector<Disturbance> inputs_of(const std::string& kind, const std::string& value) {
  std::vector<Disturbance> inputs;
  for (const client::DisturbanceRow& row : client::kDisturbances) {
    if (kind != row.name && kind != "none") continue;
    const ObjectName object = parse_object(row.variable_name);
    inputs.push_back({object, kind == "none" ? 0 : parse_value(value, object)});
  }
  if (!inputs.empty()) return inputs;
  std::string message = in_quotes(kind) + " is not a disturbance: write";
  for (const client::DisturbanceRow& row : client::kDisturbances) {
    message += " " + std::string(row.name) + ",";
  }
  throw UsageError(message + " or none" + suggestion(kind, names_of_disturbances()));
}

SnapshotCommand snapshot_of(const std::string& action, const std::string& number,
                            std::optional<std::uint32_t> bench) {
  using Action = SnapshotCommand::Action;
  for (const Action known : {Action::take, Action::restore, Action::drop}) {
    if (action != to_string(known)) continue;
    if (number.empty() != (known == Action::take)) {
      throw UsageError("'snapshot " + action + "' takes " +
                       (number.empty() ? "the number of a snapshot" : "no number"));
    }
    return {known, number.empty() ? 0 : parse_number(number, "snapshot number", kHighest64), bench};
  }
  throw UsageError(in_quotes(action) + " is not an action: write take, restore or drop");
}

/// @return what is wrong with ADDRESS:PORT, or nothing; part of one of CLI11's texts.
std::string check_server(const std::string& text) {
  return wire::parse_server_address(text)
             ? ""
             : "'" + text + "' is not ADDRESS:PORT, such as 10.0.0.9:11811";
}

std::optional<std::uint32_t> parse_unsigned32(const std::string& text) {
  if (text.empty()) return std::nullopt;
  return static_cast<std::uint32_t>(parse_value(text, DataType::unsigned32));
}

/// CLI11 takes an empty value for one that was not given, and an empty variable for none.
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

/// @return whether an argument is meant as an option: no negative number.
bool is_option(const std::string& argument) {
  return argument.size() > 1 && argument[0] == '-' && (argument[1] < '0' || argument[1] > '9');
}

/// @return what is wrong with arguments that no option and no place of a command takes, the first
///         option of them or else the first: CLI11 lists them from the last to the first.
std::string unexpected_text(const CLI::App& app) {
  const std::vector<std::string> extras = app.remaining(true);
  const auto chosen = app.get_subcommands();
  const CLI::App& word = chosen.empty() ? app : *chosen.front();
  const std::string command = "'vdrive " + word.get_name() + "'";
  auto extra = std::ranges::find_if(extras, is_option);
  if (extra == extras.end()) {
    return in_quotes(extras.front()) + " is one argument too many for " + command;
  }
  const std::string name = extra->substr(0, extra->find('='));
  std::vector<std::string> known = names_of_options(word);
  for (std::string& global : names_of_options(app)) known.push_back(std::move(global));
  return in_quotes(name) + " is not an option of " + command + suggestion(name, known);
}

/// The words of the tool as CLI11 knows them. Every word takes text and makes a command of it when
/// the line is whole.
class Grammar {
 public:
  Grammar() {
    app_.name("vdrive");
    app_.description(std::string(kSummary));
    app_.footer(std::string(kExamples));
    app_.require_subcommand(1);
    app_.fallthrough();
    app_.get_formatter()->column_width(28);
    add_global_timeout();
    add_list();
    add_axis_words();
    add_stop();
    add_status();
    add_move();
    add_read();
    add_write();
    add_disturb();
    add_dictionary();
    add_step();
    add_snapshot();
    add_rate();
  }

  /// Words and options of the command line only.
  void add_command_line() {
    app_.add_option("--domain", domain_, "DDS domain, 0 to 232; default: VDRIVE_DOMAIN, else 0")
        ->check(CLI::Range(0, 232))
        ->type_name("N");
    add_network_option(
        "--interface", options_.interfaces,
        "Use this network in addition to loopback: IPv4 address of this machine in it", "ADDRESS")
        ->check(CLI::ValidIPV4);
    add_network_option("--peer", options_.peers,
                       "Look for benches on this host, too: its IPv4 address", "ADDRESS")
        ->check(CLI::ValidIPV4);
    add_network_option("--discovery-server", options_.discovery_servers,
                       "Use a discovery server instead of multicast", "ADDRESS:PORT")
        ->check(check_server);
    app_.add_option("--security", options_.security,
                    "Closed mode: directory with certificate, key and permissions")
        ->envname("VDRIVE_SECURITY")
        ->type_name("DIR");
    app_.add_flag("--json", options_.json, "One JSON object a line on standard output");
    app_.set_version_flag("--version", "vdrive " VDRIVE_VERSION);
    add_watch(false);
    add_record();
    add_run();
    add_doctor();
    add_completion();
    // After the words: those that follow would take it over.
    app_.set_help_all_flag("--help-all", "Print the help of every command and exit");
  }

  /// Words of scenarios only.
  void add_scenario() {
    app_.set_help_flag();
    for (CLI::App* word : app_.get_subcommands({})) word->set_help_flag();
    add_watch(true);
    add_expect();
    add_wait();
  }

  /// @throws CLI::ParseError, UsageError
  void parse(std::vector<std::string> arguments) {
    check_word(arguments);
    std::ranges::reverse(arguments);  // CLI11 takes them from the back
    app_.parse(std::move(arguments));
    refuse_empty_values(app_);
    for (const CLI::App* const word : app_.get_subcommands()) refuse_empty_values(*word);
  }

  [[nodiscard]] const CLI::App& app() const { return app_; }

  [[nodiscard]] std::optional<Command>& command() { return command_; }

  /// What a command prints without a service.
  [[nodiscard]] const std::string& text() const { return text_; }

  /// @throws UsageError
  [[nodiscard]] std::uint32_t domain() const {
    if (domain_) return *domain_;
    try {
      return client::default_domain();
    } catch (const std::runtime_error& error) {
      throw UsageError(error.what());
    }
  }

  [[nodiscard]] GlobalOptions options() const {
    GlobalOptions options = options_;
    if (!timeout_.empty()) options.timeout = parse_seconds(timeout_);
    return options;
  }

 private:
  /// The arguments of all commands, as text; a command line uses one command.
  struct Words {
    std::string axis, object, value, kind, duration, mask, tolerance, within, throughout;
    std::string velocity, acceleration, deceleration, count, bench, format = "table",
                                                                    language = "en";
    std::string file, junit;
    std::vector<std::string> axes, objects, rate;
    bool relative = false, queue = false, wait = false, no_wait = false, live = false;
    bool take_over = false, stop_on_interrupt = false;
  };

  /// CLI11 reports an unknown command as a missing one, and takes the value of an unknown option
  /// for the command. The first argument that is neither an option nor the value of an option is
  /// the command.
  void check_word(const std::vector<std::string>& arguments) const {
    for (std::size_t i = 0; i < arguments.size(); ++i) {
      const std::string& argument = arguments[i];
      if (!argument.starts_with('-')) {
        check_command(argument);
        return;
      }
      const std::string name = argument.substr(0, argument.find('='));
      const CLI::Option* const option = app_.get_option_no_throw(name);
      if (option == nullptr) throw UsageError(unknown_option(name));
      const bool has_value = option->get_items_expected_max() > 0;
      if (has_value && name == argument) ++i;
    }
  }

  void check_command(const std::string& name) const {
    const std::vector<std::string> commands = names_of_commands();
    if (std::ranges::find(commands, name) != commands.end()) return;
    const std::string nearest = suggestion(name, commands);
    throw UsageError(in_quotes(name) + " is not a command" +
                     (nearest.empty() ? "; 'vdrive --help' lists all commands" : nearest));
  }

  [[nodiscard]] std::vector<std::string> names_of_commands() const {
    std::vector<std::string> names;
    for (const CLI::App* const word : app_.get_subcommands({})) names.push_back(word->get_name());
    return names;
  }

  /// @param name of an option that stands before the command
  [[nodiscard]] std::string unknown_option(const std::string& name) const {
    for (const CLI::App* const word : app_.get_subcommands({})) {
      if (word->get_option_no_throw(name) == nullptr) continue;
      return in_quotes(name) + " belongs behind its command, such as 'vdrive " + word->get_name() +
             " ... " + name + "'";
    }
    return in_quotes(name) + " is not an option" + suggestion(name, names_of_options(app_));
  }

  /// May appear several times, with one value each: the next argument may be the command.
  CLI::Option* add_network_option(const char* name, std::vector<std::string>& values,
                                  const char* help, const char* type) {
    return app_.add_option(name, values, help)->allow_extra_args(false)->type_name(type);
  }

  CLI::App* add_word(std::string_view name, std::string_view summary, std::string_view example) {
    CLI::App* word = app_.add_subcommand(std::string(name), std::string(summary));
    word->footer("Example:\n  vdrive " + std::string(example));
    return word;
  }

  void add_axis(CLI::App* word) {
    word->add_option("AXIS", words_.axis, "bench.axis such as 1.1, or a name")
        ->required()
        ->type_name("");
  }

  void add_take_over(CLI::App* word) {
    word->add_flag("--take-over", words_.take_over,
                   "Take control of the axis first, also from another session");
  }

  static CLI::Option* add_positional(CLI::App* word, const char* name, std::string& text,
                                     const char* help) {
    return word->add_option(name, text, help)->required()->type_name("");
  }

  void add_global_timeout() {
    app_.add_option("--timeout", timeout_,
                    "Limit [s]: wall time to find a service (default 2, in the closed mode 5), "
                    "drive time of a motion (default 60)")
        ->type_name("S");
  }

  void add_list() {
    CLI::App* word = add_word("list", "List all benches and axes", "list --json");
    word->callback([this] {
      command_ = ListCommand{};
    });
  }

  void add_status() {
    CLI::App* word = add_word("status", "Show an axis once, its statusword decoded", "status 1.1");
    add_axis(word);
    word->callback([this] {
      command_ = StatusCommand{words_.axis};
    });
  }

  void add_watch(bool needs_count) {
    CLI::App* word =
        add_word("watch", "Show axes live until interrupted", "watch 1.1 1.2 --count 20");
    word->add_option("AXIS", words_.axes, "bench.axis such as 1.1, or a name")
        ->required()
        ->type_name("");
    CLI::Option* count =
        word->add_option("--count", words_.count, "Stop after N samples of each axis");
    count->type_name("N");
    if (needs_count) count->required();
    word->callback([this] {
      const std::uint64_t samples =
          words_.count.empty() ? 0 : parse_number(words_.count, "count", kHighest32);
      command_ = WatchCommand{words_.axes, samples};
    });
  }

  void add_record() {
    CLI::App* word = add_word("record", "Record the status stream of axes to a file",
                              "record move.csv 1.1 1.2 --for 5s");
    add_positional(word, "FILE", words_.file,
                   "CSV or JSON lines by its ending: .csv, .jsonl; - is standard output");
    word->add_option("AXIS", words_.axes, "Default: all axes of the only bench")->type_name("");
    word->add_option("--for", words_.duration, "Stop after this drive time")->type_name("T");
    word->add_option("--count", words_.count, "Stop after N samples")->type_name("N");
    word->callback([this] {
      command_ = make_record();
    });
  }

  [[nodiscard]] RecordCommand make_record() const {
    RecordCommand record;
    record.file = words_.file;
    record.axes = words_.axes;
    const bool is_lines = words_.file.ends_with(".jsonl") || words_.file.ends_with(".json");
    if (!is_lines && words_.file != "-" && !words_.file.ends_with(".csv")) {
      throw UsageError(in_quotes(words_.file) + " ends neither in .csv nor in .jsonl");
    }
    if (is_lines || (words_.file == "-" && options_.json)) record.format = RecordFormat::json_lines;
    if (!words_.duration.empty()) record.duration = parse_duration(words_.duration);
    if (!words_.count.empty()) record.count = parse_number(words_.count, "count", kHighest32);
    return record;
  }

  void add_axis_words() {
    for (const ActionRow& row : kActions) {
      const std::string name(to_string(row.action));
      CLI::App* word = add_word(name, row.summary, name + " 1.1");
      add_axis(word);
      if (row.may_wait) word->add_flag("--wait", words_.wait, "Wait for standstill or target");
      if (row.may_return_early) {
        word->add_flag("--no-wait", words_.no_wait, "Return when the command is in force");
      }
      add_take_over(word);
      word->callback([this, row] {
        const bool early = row.may_wait ? !words_.wait : words_.no_wait;
        command_ =
            ActionCommand{row.action, words_.axis,
                          early ? client::Until::in_force : client::Until::done, words_.take_over};
      });
    }
  }

  void add_stop() {
    CLI::App* word =
        add_word("stop", "Quick stop of every axis of a bench, whoever controls it", "stop 1");
    word->add_option("BENCH", words_.bench, "Default: the only bench")->type_name("");
    word->add_flag("--no-wait", words_.no_wait, "Return when the command is in force");
    word->callback([this] {
      command_ =
          StopCommand{bench(), words_.no_wait ? client::Until::in_force : client::Until::done};
    });
  }

  void add_move() {
    CLI::App* word = add_word("move", "Move to a position and wait until it is reached",
                              "move 1.1 10000 --velocity 1000 --acceleration 6000");
    add_axis(word);
    add_positional(word, "POSITION", words_.value, "Target, or distance with --relative [UU]");
    word->add_flag("--relative", words_.relative, "POSITION is a distance (bit 6)");
    word->add_option("--velocity", words_.velocity, "6081h [UU/s] for this move")->type_name("V");
    word->add_option("--acceleration", words_.acceleration, "6083h [UU/s2] for this move")
        ->type_name("A");
    word->add_option("--deceleration", words_.deceleration, "6084h [UU/s2] for this move")
        ->type_name("D");
    word->add_flag("--queue", words_.queue,
                   "Start after the present move, not at once (bit 5 = 0)");
    word->add_flag("--no-wait", words_.no_wait, "Return when the drive has accepted the set-point");
    word->add_flag("--stop-on-interrupt", words_.stop_on_interrupt,
                   "Halt the axis when Ctrl-C ends the wait; it goes on otherwise");
    add_take_over(word);
    word->callback([this] {
      MoveCommand move{
          .axis = words_.axis,
          .position = static_cast<std::int32_t>(parse_value(words_.value, DataType::integer32)),
          .relative = words_.relative,
          .options = {},
          .take_over = words_.take_over,
          .stop_on_interrupt = words_.stop_on_interrupt};
      move.options.velocity = parse_unsigned32(words_.velocity);
      move.options.acceleration = parse_unsigned32(words_.acceleration);
      move.options.deceleration = parse_unsigned32(words_.deceleration);
      move.options.queue = words_.queue;
      move.options.call.until = words_.no_wait ? client::Until::in_force : client::Until::done;
      command_ = std::move(move);
    });
  }

  void add_read() {
    CLI::App* word = add_word("read", "Read objects", "read 1.1 0x6041 position_demand_value");
    add_axis(word);
    word->add_option("OBJECT", words_.objects, "0x6041, 0x607D:1 or a variable_name")
        ->required()
        ->type_name("");
    word->callback([this] {
      ReadCommand read{words_.axis, {}};
      for (const std::string& text : words_.objects) read.objects.push_back(parse_object(text));
      command_ = std::move(read);
    });
  }

  void add_write() {
    CLI::App* word = add_word("write", "Write an object", "write 1.1 0x607A 0xFFFFD8F0");
    add_axis(word);
    add_positional(word, "OBJECT", words_.object, "0x6040, 0x607D:1 or a variable_name");
    add_positional(word, "VALUE", words_.value, "Decimal, or hex as the type's two's complement");
    add_take_over(word);
    word->callback([this] {
      WriteCommand write{words_.axis, parse_object(words_.object), 0, words_.take_over};
      write.value = parse_value(words_.value, write.object);
      command_ = std::move(write);
    });
  }

  void add_disturb() {
    CLI::App* word = add_word("disturb", "Set a test-bench input: a load, a fault, a switch",
                              "disturb 1.1 load_torque 1500 --for 200ms");
    add_axis(word);
    add_positional(word, "KIND", words_.kind, kDisturbanceHelp.data());
    word->add_option("VALUE", words_.value, "Default 1; 0 clears")->type_name("");
    word->add_option("--for", words_.duration, "Clear after this drive time")->type_name("T");
    word->callback([this] {
      DisturbCommand disturb{words_.axis, words_.kind, {}, std::nullopt};
      disturb.inputs = inputs_of(words_.kind, words_.value.empty() ? "1" : words_.value);
      if (!words_.duration.empty()) disturb.duration = parse_duration(words_.duration);
      command_ = std::move(disturb);
    });
  }

  void add_dictionary() {
    CLI::App* word = add_word("dictionary", "Show the object dictionary; needs no service",
                              "dictionary 0x607D --language zh");
    word->add_option("OBJECT", words_.objects, "Show these only; an index shows all sub-indices")
        ->type_name("");
    word->add_option("--format", words_.format, "table, json or csv")
        ->check(CLI::IsMember({"table", "json", "csv"}))
        ->type_name("F");
    word->add_option("--language", words_.language, "en or zh")
        ->check(CLI::IsMember({"en", "zh"}))
        ->type_name("L");
    word->callback([this] {
      DictionaryCommand dictionary;
      if (words_.format == "json") dictionary.format = TableFormat::json;
      if (words_.format == "csv") dictionary.format = TableFormat::csv;
      if (words_.language == "zh") dictionary.language = Language::zh;
      for (const std::string& text : words_.objects) {
        const ObjectName& object = dictionary.objects.emplace_back(parse_object(text));
        const bool exists = std::ranges::any_of(kObjectTable, [&](const ObjectDescription& row) {
          return object.covers(row.address);
        });
        if (!exists) {
          throw UsageError("the dictionary has no object " + in_quotes(text) +
                           object_suggestion(text));
        }
      }
      command_ = std::move(dictionary);
    });
  }

  void add_step() {
    CLI::App* word = add_word("step", "Step a lock-step bench by N ticks", "step 1000 --bench 2");
    add_positional(word, "N", words_.value, "Ticks");
    word->add_option("--bench", words_.bench, "Default: the only bench")->type_name("B");
    word->callback([this] {
      command_ = StepCommand{parse_number(words_.value, "number of ticks", 1'000'000'000), bench()};
    });
  }

  void add_snapshot() {
    CLI::App* word = add_word("snapshot", "Keep, restore or drop the state of all axes of a bench",
                              "snapshot take; vdrive snapshot restore 1");
    add_positional(word, "ACTION", words_.kind, "take, restore or drop");
    word->add_option("N", words_.value, "Number that take printed")->type_name("");
    word->add_option("--bench", words_.bench, "Default: the only bench")->type_name("B");
    word->callback([this] {
      command_ = snapshot_of(words_.kind, words_.value, bench());
    });
  }

  [[nodiscard]] std::optional<std::uint32_t> bench() const {
    if (words_.bench.empty()) return std::nullopt;
    return static_cast<std::uint32_t>(parse_number(words_.bench, "bench number", kHighest32));
  }

  void add_rate() {
    CLI::App* word = add_word("rate", "Set or show how fast a realtime bench runs; 0 pauses it",
                              "rate 0.5\n  vdrive rate 2 0    (bench 2)");
    word->add_option("VALUE", words_.rate,
                     "[BENCH] VALUE: drive time divided by wall time, 0 or from 0.1 to 100; BENCH "
                     "defaults to the only bench. Without a value the rates of all benches are "
                     "shown")
        ->type_name("");
    word->callback([this] {
      if (words_.rate.size() > 2) throw UsageError("rate takes at most a bench and a value");
      if (words_.rate.empty()) {
        command_ = RateCommand{};
        return;
      }
      RateCommand rate{parse_real(words_.rate.back(), "rate"), std::nullopt};
      if (words_.rate.size() == 2) {
        rate.bench = static_cast<std::uint32_t>(
            parse_number(words_.rate.front(), "bench number", kHighest32));
      }
      command_ = rate;
    });
  }

  void add_run() {
    CLI::App* word = add_word("run", "Execute a scenario file", "run forward.scn --junit out.xml");
    word->footer(std::string(kScenarioHelp));
    add_positional(word, "FILE", words_.file, "Scenario, - for standard input");
    word->add_option("--junit", words_.junit, "Write a JUnit report")->type_name("OUT.xml");
    word->add_flag("--live", words_.live, "Show the axes while time passes, also when piped");
    word->callback([this] {
      command_ = RunCommand{words_.file, words_.junit, words_.live};
    });
  }

  void add_doctor() {
    CLI::App* word =
        add_word("doctor", "Check this machine and its network, and show what to change",
                 "doctor --interface 10.0.0.1");
    word->callback([this] {
      command_ = DoctorCommand{};
    });
  }

  void add_completion() {
    CLI::App* word =
        add_word("completion", "Print a script that completes command lines",
                 "completion bash > ~/.local/share/bash-completion/completions/vdrive");
    word->add_option("SHELL", words_.file, "bash")
        ->required()
        ->check(CLI::IsMember({"bash"}))
        ->type_name("");
    word->callback([this] {
      text_ = bash_completion(app_);
    });
  }

  void add_expect() {
    CLI::App* word = add_word("expect", "Compare an object", "");
    add_axis(word);
    add_positional(word, "OBJECT", words_.object, "");
    add_positional(word, "VALUE", words_.value, "");
    CLI::Option* mask = word->add_option("--mask", words_.mask);
    word->add_option("--tolerance", words_.tolerance)->excludes(mask);
    CLI::Option* within = word->add_option("--within", words_.within);
    word->add_option("--throughout", words_.throughout)->excludes(within);
    word->callback([this] {
      command_ = make_expect();
    });
  }

  [[nodiscard]] ExpectCommand make_expect() const {
    ExpectCommand expect;
    expect.axis = words_.axis;
    expect.object = parse_object(words_.object);
    expect.value = parse_value(words_.value, expect.object);
    if (!words_.mask.empty()) {
      expect.mask = static_cast<std::uint64_t>(parse_value(words_.mask, expect.object));
    }
    if (!words_.tolerance.empty()) {
      expect.tolerance = parse_number(words_.tolerance, "tolerance", kHighest32);
    }
    if (!words_.within.empty()) expect.within = parse_duration(words_.within);
    if (!words_.throughout.empty()) expect.throughout = parse_duration(words_.throughout);
    return expect;
  }

  void add_wait() {
    CLI::App* word = add_word("wait", "Let drive time pass", "");
    add_positional(word, "DURATION", words_.duration, "");
    word->callback([this] {
      command_ = WaitCommand{parse_duration(words_.duration)};
    });
  }

  CLI::App app_;
  GlobalOptions options_;
  std::optional<std::uint32_t> domain_;
  std::string timeout_;
  Words words_;
  std::optional<Command> command_;
  std::string text_;
};

/// @return the help of the tool, then that of each word.
std::string help_of_all_words(const CLI::App& app) {
  std::string text = app.help();
  for (const CLI::App* const word : app.get_subcommands({})) {
    text += "\n" + word->get_name() + ": " + word->help(app.get_name());
  }
  return text;
}

/// CLI11's texts end with hints of their own and with line breaks, and hold what was given as it
/// is.
std::string one_line(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  std::ranges::replace(text, '\n', ' ');
  return escaped(text, kShownOfMessage);
}

}  // namespace

Invocation parse_command_line(std::vector<std::string> arguments) {
  if (arguments.empty()) {
    throw UsageError("no command given; 'vdrive --help' lists all commands");
  }
  Grammar grammar;
  grammar.add_command_line();
  Invocation invocation;
  try {
    grammar.parse(std::move(arguments));
    invocation.options = grammar.options();
    invocation.options.domain = grammar.domain();
    invocation.command = std::move(grammar.command());
    invocation.text = grammar.text();
  } catch (const CLI::CallForHelp&) {
    invocation.text = grammar.app().help();
  } catch (const CLI::CallForAllHelp&) {
    invocation.text = help_of_all_words(grammar.app());
  } catch (const CLI::CallForVersion& version) {
    invocation.text = std::string(version.what()) + "\n";
  } catch (const CLI::ExtrasError&) {
    throw UsageError(unexpected_text(grammar.app()));
  } catch (const CLI::ParseError& error) {
    throw UsageError(one_line(error.what()));
  }
  return invocation;
}

ScenarioWords parse_scenario_words(std::vector<std::string> words) {
  if (!words.empty() && words.front() == "refused") {
    if (words.size() < 3) throw UsageError("refused needs a code and a command");
    const auto code = static_cast<std::uint32_t>(parse_number(words[1], "code", kHighest32));
    ScenarioWords inner = parse_scenario_words({words.begin() + 2, words.end()});
    inner.command =
        std::make_shared<const RefusedCommand>(RefusedCommand{code, std::move(inner.command)});
    return inner;
  }
  if (std::ranges::any_of(words, [](const std::string& w) {
        return w == "--help" || w == "-h";
      })) {
    throw UsageError("help cannot be used in a scenario");
  }
  Grammar grammar;
  grammar.add_scenario();
  try {
    grammar.parse(std::move(words));
    ScenarioWords result{std::move(grammar.command()).value(), grammar.options().timeout};
    return result;
  } catch (const CLI::ExtrasError&) {
    throw UsageError(unexpected_text(grammar.app()));
  } catch (const CLI::ParseError& error) {
    throw UsageError(one_line(error.what()));
  }
}

}  // namespace vdrive::tool
