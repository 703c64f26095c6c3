// SPDX-License-Identifier: Apache-2.0
#include "language/grammar.hpp"

#include "base/usage_error.hpp"
#include "language/completion.hpp"
#include "language/help.hpp"
#include "network_options.hpp"
#include "private_domain.hpp"
#include "values/condition.hpp"
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
#include <span>
#include <sstream>
#include <stdexcept>
#include <thread>
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
  for (const Action known : {Action::take, Action::list, Action::restore, Action::drop}) {
    if (action != to_string(known)) continue;
    const bool takes_number = known == Action::restore || known == Action::drop;
    if (number.empty() == takes_number) {
      throw UsageError("'snapshot " + action + "' takes " +
                       (number.empty() ? "the number of a snapshot" : "no number"));
    }
    return {known, number.empty() ? 0 : parse_number(number, "snapshot number", kHighest64), bench};
  }
  throw UsageError(in_quotes(action) + " is not an action: write take, list, restore or drop");
}

/// @return what is wrong with ADDRESS:PORT, or nothing; part of one of CLI11's texts.
std::string check_server(const std::string& text) {
  return wire::parse_server_address(text)
             ? ""
             : "'" + text + "' is not ADDRESS:PORT, such as 10.0.0.9:11811";
}

/// @return a speed or a ramp of a move, if it was given.
std::optional<Quantity> limit(const std::string& text, Dimension dimension) {
  if (text.empty()) return std::nullopt;
  return parse_quantity(text, dimension, DataType::unsigned32);
}

/// @return the value of an object where it was typed with a unit, or with an exponent.
std::optional<Quantity> quantity_of(const std::string& text, const ObjectName& object) {
  const auto row = object.row();
  const auto dimension = row ? dimension_of(*row) : std::nullopt;
  const bool is_plain = text.find_first_not_of("-0123456789") == std::string::npos;
  if (!dimension || is_plain || text.starts_with("0x") || text.starts_with("0X")) {
    return std::nullopt;
  }
  return parse_quantity(text, *dimension, describe(*row).data_type);
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

/// @return what is wrong with arguments that no option and no place of a command takes, the first
///         option of them or else the first: CLI11 lists them from the last to the first.
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

/// The commands of the tool, for CLI11. Each takes text and makes a Command of it when the line is
/// complete.
class Grammar {
 public:
  Grammar() {
    app_.name("vdrive");
    app_.description(std::string(kSummary));
    app_.footer(std::string(kExamples));
    app_.require_subcommand(1);
    app_.fallthrough();
    app_.get_formatter()->column_width(28);
    app_.get_formatter()->label("SUBCOMMAND", "COMMAND");
    add_global_timeout();
    add_list();
    add_axis_actions();
    add_stop();
    add_status();
    add_move();
    add_home();
    add_velocity();
    add_torque();
    add_read();
    add_write();
    add_disturb();
    add_dictionary();
    add_step();
    add_snapshot();
    add_rate();
    add_expect();
    add_wait();
  }

  /// Commands and options of the command line only.
  void add_command_line() {
    bridge::add_domain_option(app_, domain_, "; default: VDRIVE_DOMAIN, else 0");
    add_network_option(
        "--interface", options_.interfaces,
        "Use this network in addition to loopback: IPv4 address of this machine in it", "ADDRESS")
        ->check(CLI::ValidIPV4);
    add_network_option("--peer", options_.peers,
                       "Search for benches on this host, too: its IPv4 address", "ADDRESS")
        ->check(CLI::ValidIPV4);
    add_network_option("--discovery-server", options_.discovery_servers,
                       "Use a discovery server instead of multicast", "ADDRESS:PORT")
        ->check(check_server);
    app_.add_option("--security", options_.security,
                    "Closed mode: directory with certificate, key and permissions")
        ->envname("VDRIVE_SECURITY")
        ->type_name("DIR");
    app_.set_version_flag("--version", "vdrive " VDRIVE_VERSION);
    add_shell_commands();
    add_jog(false);
    add_convert();
    add_test();
    add_shell();
    add_doctor();
    add_bench();
    add_completion();
    // After the commands: those that follow would take it over.
    app_.set_help_all_flag("--help-all", "Print the help of every command and exit");
  }

  /// What a shell has beside what a scenario has, too.
  void add_shell_commands() {
    app_.add_flag("--json", options_.json, "One JSON object per line on standard output");
    add_watch(false);
    add_events();
    add_record();
    add_run();
  }

  /// What a line of a shell may be.
  void add_shell_line() {
    add_shell_commands();
    add_jog(true);
  }

  /// Commands of scenarios only.
  void add_scenario() {
    app_.set_help_flag();
    for (CLI::App* command : app_.get_subcommands({})) command->set_help_flag();
    add_watch(true);
    add_jog(true);
  }

  /// @throws CLI::ParseError, UsageError
  void parse(std::vector<std::string> arguments) {
    check_command(arguments);
    std::ranges::reverse(arguments);  // CLI11 takes them from the back
    app_.parse(std::move(arguments));
    refuse_empty_values(app_);
    for (const CLI::App* const command : app_.get_subcommands()) refuse_empty_values(*command);
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
  struct Arguments {
    std::string axis, object, value, kind, duration, mask, tolerance, within, throughout;
    std::string velocity, acceleration, deceleration, method, offset, search, creep, slope, count,
        lost_after, bench, format = "table", language = "en";
    std::string file, to, junit, configuration, service, jobs;
    std::vector<std::string> axes, objects, rate, values, files, settings;
    bool relative = false, queue = false, wait = false, no_wait = false, live = false;
    bool take_over = false, stop_on_interrupt = false, follow = false, all = false, quick = false;
  };

  /// CLI11 reports an unknown command as a missing one, and takes the value of an unknown option
  /// for the command. The first argument that is neither an option nor the value of an option is
  /// the command.
  void check_command(const std::vector<std::string>& arguments) const {
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
    for (const CLI::App* const command : app_.get_subcommands({}))
      names.push_back(command->get_name());
    return names;
  }

  /// @param name of an option that stands before the command
  [[nodiscard]] std::string unknown_option(const std::string& name) const {
    for (const CLI::App* const command : app_.get_subcommands({})) {
      if (command->get_option_no_throw(name) == nullptr) continue;
      return in_quotes(name) + " belongs after its command, such as 'vdrive " +
             command->get_name() + " ... " + name + "'";
    }
    return in_quotes(name) + " is not an option" + suggestion(name, names_of_options(app_));
  }

  /// May appear several times, with one value each: the next argument may be the command.
  CLI::Option* add_network_option(const char* name, std::vector<std::string>& values,
                                  const char* help, const char* type) {
    return app_.add_option(name, values, help)->allow_extra_args(false)->type_name(type);
  }

  CLI::App* add_command(std::string_view name, std::string_view summary, std::string_view example) {
    CLI::App* command = app_.add_subcommand(std::string(name), std::string(summary));
    command->footer("Example:\n  vdrive " + std::string(example));
    return command;
  }

  void add_axis(CLI::App* command) {
    command->add_option("AXIS", arguments_.axis, "bench.axis such as 1.1, or a name")
        ->required()
        ->type_name("");
  }

  /// @param without what happens when none is named
  void add_axes(CLI::App* command, const std::string& without) {
    command
        ->add_option("AXIS", arguments_.axes,
                     "Axes: 7.1, 7.lift or a name; '7.*' is every axis of bench 7; " + without)
        ->type_name("");
  }

  /// The axes of a command that takes --all.
  [[nodiscard]] std::vector<std::string> axes_or_all() const {
    if (arguments_.all && !arguments_.axes.empty())
      throw UsageError("--all cannot be combined with AXIS");
    if (!arguments_.all && arguments_.axes.empty()) {
      throw UsageError("AXIS is required, or --all for every axis of every bench");
    }
    return arguments_.all ? std::vector<std::string>{"*"} : arguments_.axes;
  }

  void add_take_over(CLI::App* command) {
    command->add_flag("--take-over", arguments_.take_over,
                      "Take control of the axis first, also from another session");
  }

  static CLI::Option* add_positional(CLI::App* command, const char* name, std::string& text,
                                     const char* help) {
    return command->add_option(name, text, help)->required()->type_name("");
  }

  void add_global_timeout() {
    app_.add_option("--timeout", timeout_,
                    "Limit [s]: wall time to find a service (default 2, in the closed mode 5), "
                    "drive time of a motion (default 60)")
        ->type_name("S");
  }

  void add_list() {
    CLI::App* command = add_command("list", "List all benches and axes", "list --json");
    command->callback([this] {
      command_ = ListCommand{};
    });
  }

  void add_status() {
    CLI::App* command = add_command(
        "status", "Show one axis with its statusword decoded, or several axes, one per line",
        "status 1.1\n  vdrive status         # every axis");
    add_axes(command, "default: every axis of every bench");
    command->callback([this] {
      command_ = StatusCommand{arguments_.axes};
    });
  }

  void add_watch(bool needs_count) {
    CLI::App* command =
        add_command("watch", "Show axes live until interrupted",
                    "watch 1.1 1.2 --count 20\n  vdrive watch          # every axis");
    add_axes(command, "default: every axis of every bench");
    CLI::Option* count =
        command->add_option("--count", arguments_.count, "Stop after N samples of each axis");
    count->type_name("N");
    if (needs_count) count->required();
    command->callback([this] {
      const std::uint64_t samples =
          arguments_.count.empty() ? 0 : parse_number(arguments_.count, "count", kHighest32);
      command_ = WatchCommand{arguments_.axes, samples};
    });
  }

  void add_record() {
    CLI::App* command = add_command("record", "Record the status stream of axes to a file",
                                    "record move.csv 1.1 1.2 --for 5s");
    add_positional(
        command, "FILE", arguments_.file,
        "CSV, JSON lines or MCAP by its ending: .csv, .jsonl, .mcap; - is standard output");
    add_axes(command, "default: every axis of the only bench");
    command->add_option("--for", arguments_.duration, "Stop after this drive time")->type_name("T");
    command->add_option("--count", arguments_.count, "Stop after N samples")->type_name("N");
    command
        ->add_option("--lost-after", arguments_.lost_after,
                     "End when a bench has sent nothing for this wall time; default: 1min")
        ->type_name("T");
    command->callback([this] {
      command_ = make_record();
    });
  }

  [[nodiscard]] RecordCommand make_record() const {
    RecordCommand record;
    record.file = arguments_.file;
    record.axes = arguments_.axes;
    if (arguments_.file != "-") {
      record.format = format_of(arguments_.file);
    } else if (options_.json) {
      record.format = recording::Format::json_lines;
    }
    if (!arguments_.duration.empty()) record.duration = parse_duration(arguments_.duration);
    if (!arguments_.count.empty())
      record.count = parse_number(arguments_.count, "count", kHighest32);
    if (!arguments_.lost_after.empty()) record.lost_after = parse_duration(arguments_.lost_after);
    return record;
  }

  /// @throws UsageError
  static recording::Format format_of(const std::string& file) {
    const auto format = recording::format_of(file);
    if (format) return *format;
    throw UsageError(in_quotes(file) + " does not end in .csv, .jsonl or .mcap");
  }

  void add_convert() {
    CLI::App* command = add_command("convert", "Write the status of a recording in another format",
                                    "convert run.mcap run.csv");
    add_positional(command, "FROM", arguments_.file, "The recording: .csv, .jsonl or .mcap");
    add_positional(command, "TO", arguments_.to,
                   "The new file: .csv, .jsonl or .mcap by its ending");
    command
        ->add_option("--period", arguments_.duration,
                     "Drive time of a tick, where FROM has no such time; default: 1ms")
        ->type_name("T");
    command->callback([this] {
      command_ = make_convert();
    });
  }

  [[nodiscard]] ConvertCommand make_convert() const {
    ConvertCommand convert{.from = arguments_.file, .to = arguments_.to, .period = {}};
    if (format_of(convert.from) == format_of(convert.to)) {
      throw UsageError(in_quotes(convert.from) + " and " + in_quotes(convert.to) +
                       " have the same format");
    }
    if (arguments_.duration.empty()) return convert;
    if (format_of(convert.from) == recording::Format::mcap) {
      throw UsageError("--period is for recordings of text; a recording in MCAP has this time");
    }
    convert.period = parse_duration(arguments_.duration);
    if (convert.period->count() <= 0) throw UsageError("--period has to be above 0");
    return convert;
  }

  void add_axis_actions() {
    for (const ActionRow& row : kActions) {
      const std::string name(to_string(row.action));
      CLI::App* command = add_command(name, row.summary, name + " 1.1");
      add_axes(command, "required unless --all is given");
      command->add_flag("--all", arguments_.all, "Every axis of every bench");
      if (row.may_wait)
        command->add_flag("--wait", arguments_.wait, "Wait for standstill or target");
      if (row.may_return_early) {
        command->add_flag("--no-wait", arguments_.no_wait, "Return when the command is in force");
      }
      add_take_over(command);
      command->callback([this, row] {
        const bool early = row.may_wait ? !arguments_.wait : arguments_.no_wait;
        command_ = ActionCommand{row.action, axes_or_all(),
                                 early ? client::Until::in_force : client::Until::done,
                                 arguments_.take_over};
      });
    }
  }

  void add_stop() {
    CLI::App* command = add_command(
        "stop", "Quick stop of every axis of a bench, also of other sessions", "stop 1");
    command->add_option("BENCH", arguments_.bench, "Default: the only bench")->type_name("");
    command->add_flag("--no-wait", arguments_.no_wait, "Return when the command is in force");
    command->callback([this] {
      command_ =
          StopCommand{bench(), arguments_.no_wait ? client::Until::in_force : client::Until::done};
    });
  }

  void add_move() {
    CLI::App* command = add_command("move", "Move to a position and wait until it is reached",
                                    "move 1.1 10000 --velocity 1000 --acceleration 6000");
    add_axis(command);
    add_positional(command, "POSITION", arguments_.value,
                   "Target, or distance with --relative [UU, or with a unit: 90deg, 12.5mm]");
    command->add_flag("--relative", arguments_.relative, "POSITION is a distance (bit 6)");
    command
        ->add_option("--velocity", arguments_.velocity, "6081h [UU/s, or 180deg/s] for this move")
        ->type_name("V");
    command
        ->add_option("--acceleration", arguments_.acceleration,
                     "6083h [UU/s2, or 900deg/s2] for this move")
        ->type_name("A");
    command
        ->add_option("--deceleration", arguments_.deceleration,
                     "6084h [UU/s2, or 900deg/s2] for this move")
        ->type_name("D");
    command->add_flag("--queue", arguments_.queue,
                      "Start after the present move, not at once (bit 5 = 0)");
    command->add_flag("--no-wait", arguments_.no_wait,
                      "Return when the drive has accepted the set-point");
    command->add_flag("--stop-on-interrupt", arguments_.stop_on_interrupt,
                      "Halt the axis when Ctrl-C ends the wait; it continues otherwise");
    add_take_over(command);
    command->callback([this] {
      MoveCommand move{
          .axis = arguments_.axis,
          .position = parse_quantity(arguments_.value, Dimension::position, DataType::integer32),
          .relative = arguments_.relative,
          .velocity = limit(arguments_.velocity, Dimension::velocity),
          .acceleration = limit(arguments_.acceleration, Dimension::acceleration),
          .deceleration = limit(arguments_.deceleration, Dimension::acceleration),
          .queue = arguments_.queue,
          .until = arguments_.no_wait ? client::Until::in_force : client::Until::done,
          .take_over = arguments_.take_over,
          .stop_on_interrupt = arguments_.stop_on_interrupt};
      command_ = std::move(move);
    });
  }

  static client::Until until_of(bool no_wait) {
    return no_wait ? client::Until::in_force : client::Until::done;
  }

  void add_no_wait(CLI::App* command) {
    command->add_flag("--no-wait", arguments_.no_wait, "Return when the command is in force");
  }

  void add_home() {
    CLI::App* command =
        add_command("home", "Home the axis (mode 6) and wait until home is attained",
                    "home 1.1 --method 37 --offset 0deg");
    add_axis(command);
    command
        ->add_option(
            "--method", arguments_.method,
            "6098h: 17, 18 to a limit switch; 1, 2 to a limit switch, then to the index pulse; "
            "33, 34 to the index pulse; 35, 37 where the axis is")
        ->type_name("M");
    command->add_option("--offset", arguments_.offset, "607Ch: the position of home [UU, or 90deg]")
        ->type_name("P");
    command
        ->add_option("--speed", arguments_.search, "6099h:1 towards the switch [UU/s, or 90deg/s]")
        ->type_name("V");
    command->add_option("--creep", arguments_.creep, "6099h:2 towards home [UU/s, or 9deg/s]")
        ->type_name("V");
    command->add_option("--acceleration", arguments_.acceleration, "609Ah [UU/s2, or 900deg/s2]")
        ->type_name("A");
    add_no_wait(command);
    add_take_over(command);
    command->callback([this] {
      HomeCommand home;
      home.axis = arguments_.axis;
      if (!arguments_.method.empty()) {
        home.method = static_cast<std::int8_t>(parse_value(arguments_.method, DataType::integer8));
      }
      if (!arguments_.offset.empty()) {
        home.offset = parse_quantity(arguments_.offset, Dimension::position, DataType::integer32);
      }
      home.search_speed = limit(arguments_.search, Dimension::velocity);
      home.creep_speed = limit(arguments_.creep, Dimension::velocity);
      home.acceleration = limit(arguments_.acceleration, Dimension::acceleration);
      home.until = until_of(arguments_.no_wait);
      home.take_over = arguments_.take_over;
      command_ = std::move(home);
    });
  }

  /// The arguments of a command that runs at a velocity.
  void add_run_arguments(CLI::App* command) {
    add_axis(command);
    add_positional(command, "VELOCITY", arguments_.velocity, "60FFh [UU/s, or 180deg/s]");
    command
        ->add_option("--acceleration", arguments_.acceleration,
                     "6083h [UU/s2, or 900deg/s2]; keeps this value")
        ->type_name("A");
    command
        ->add_option("--deceleration", arguments_.deceleration,
                     "6084h [UU/s2, or 900deg/s2]; keeps this value")
        ->type_name("D");
    add_take_over(command);
  }

  [[nodiscard]] Quantity run_velocity() const {
    return parse_quantity(arguments_.velocity, Dimension::velocity, DataType::integer32);
  }

  [[nodiscard]] RunRamps run_ramps() const {
    return {.acceleration = limit(arguments_.acceleration, Dimension::acceleration),
            .deceleration = limit(arguments_.deceleration, Dimension::acceleration)};
  }

  void add_velocity() {
    CLI::App* command =
        add_command("velocity", "Run at a velocity (mode 3) until another command; 0 stops",
                    "velocity 1.1 180deg/s");
    add_run_arguments(command);
    add_no_wait(command);
    command->callback([this] {
      command_ = VelocityCommand{arguments_.axis, run_velocity(), run_ramps(),
                                 until_of(arguments_.no_wait), arguments_.take_over};
    });
  }

  void add_torque() {
    CLI::App* command =
        add_command("torque", "Apply a torque (mode 4) until another command; 0 ends it",
                    "torque 1.1 10% --slope 500");
    add_axis(command);
    add_positional(command, "TORQUE", arguments_.value,
                   "6071h [per mille of rated torque, or 10%]");
    command
        ->add_option("--slope", arguments_.slope,
                     "6087h [per mille of rated torque a second]; keeps this value")
        ->type_name("S");
    add_no_wait(command);
    add_take_over(command);
    command->callback([this] {
      TorqueCommand torque{.axis = arguments_.axis,
                           .torque = parse_torque(arguments_.value),
                           .slope = std::nullopt,
                           .until = until_of(arguments_.no_wait),
                           .take_over = arguments_.take_over};
      if (!arguments_.slope.empty()) {
        torque.slope =
            static_cast<std::uint32_t>(parse_value(arguments_.slope, DataType::unsigned32));
      }
      command_ = std::move(torque);
    });
  }

  void add_jog(bool needs_duration) {
    CLI::App* command = add_command("jog", "Run at a velocity until Enter or Ctrl-C, then stop",
                                    "jog 1.1 90deg/s --for 2s");
    add_run_arguments(command);
    CLI::Option* duration =
        command->add_option("--for", arguments_.duration, "Run for this drive time instead");
    duration->type_name("T");
    if (needs_duration) duration->required();
    command->callback([this] {
      JogCommand jog{.axis = arguments_.axis,
                     .velocity = run_velocity(),
                     .ramps = run_ramps(),
                     .duration = std::nullopt,
                     .take_over = arguments_.take_over};
      if (!arguments_.duration.empty()) jog.duration = parse_duration(arguments_.duration);
      command_ = std::move(jog);
    });
  }

  void add_read() {
    CLI::App* command =
        add_command("read", "Read objects", "read 1.1 0x6041 position_demand_value");
    add_axis(command);
    command->add_option("OBJECT", arguments_.objects, "0x6041, 0x607D:1 or a variable_name")
        ->required()
        ->type_name("");
    command->callback([this] {
      ReadCommand read{arguments_.axis, {}};
      for (const std::string& text : arguments_.objects) read.objects.push_back(parse_object(text));
      command_ = std::move(read);
    });
  }

  void add_write() {
    CLI::App* command = add_command("write", "Write an object", "write 1.1 0x607A 0xFFFFD8F0");
    add_axis(command);
    add_positional(command, "OBJECT", arguments_.object, "0x6040, 0x607D:1 or a variable_name");
    add_positional(
        command, "VALUE", arguments_.value,
        "Decimal, or hex as the type's two's complement; positions, speeds and ramps also "
        "with a unit");
    add_take_over(command);
    command->callback([this] {
      WriteCommand write{.axis = arguments_.axis,
                         .object = parse_object(arguments_.object),
                         .take_over = arguments_.take_over};
      write.quantity = quantity_of(arguments_.value, write.object);
      if (!write.quantity) write.value = parse_value(arguments_.value, write.object);
      command_ = std::move(write);
    });
  }

  void add_disturb() {
    CLI::App* command = add_command("disturb", "Set a test-bench input: a load, a fault, a switch",
                                    "disturb 1.1 load_torque 1500 --for 200ms");
    add_axis(command);
    add_positional(command, "KIND", arguments_.kind, kDisturbanceHelp.data());
    command->add_option("VALUE", arguments_.value, "Default 1; 0 clears")->type_name("");
    command->add_option("--for", arguments_.duration, "Clear after this drive time")
        ->type_name("T");
    command->callback([this] {
      DisturbCommand disturb{arguments_.axis, arguments_.kind, {}, std::nullopt};
      disturb.inputs =
          inputs_of(arguments_.kind, arguments_.value.empty() ? "1" : arguments_.value);
      if (!arguments_.duration.empty()) disturb.duration = parse_duration(arguments_.duration);
      command_ = std::move(disturb);
    });
  }

  void add_dictionary() {
    CLI::App* command = add_command("dictionary", "Show the object dictionary; needs no service",
                                    "dictionary 0x607D --language zh");
    command
        ->add_option("OBJECT", arguments_.objects,
                     "Show these only; an index shows all sub-indices")
        ->type_name("");
    command->add_option("--format", arguments_.format, "table, json or csv")
        ->check(CLI::IsMember({"table", "json", "csv"}))
        ->type_name("F");
    command->add_option("--language", arguments_.language, "en or zh")
        ->check(CLI::IsMember({"en", "zh"}))
        ->type_name("L");
    command->callback([this] {
      DictionaryCommand dictionary;
      if (arguments_.format == "json") dictionary.format = TableFormat::json;
      if (arguments_.format == "csv") dictionary.format = TableFormat::csv;
      if (arguments_.language == "zh") dictionary.language = Language::zh;
      for (const std::string& text : arguments_.objects) {
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
    CLI::App* command =
        add_command("step", "Step a lock-step bench by N ticks", "step 1000 --bench 2");
    add_positional(command, "N", arguments_.value, "Ticks");
    command->add_option("--bench", arguments_.bench, "Default: the only bench")->type_name("B");
    command->callback([this] {
      command_ =
          StepCommand{parse_number(arguments_.value, "number of ticks", 1'000'000'000), bench()};
    });
  }

  void add_snapshot() {
    CLI::App* command =
        add_command("snapshot", "Take, list, restore or drop saved states of all axes of a bench",
                    "snapshot take\n  vdrive snapshot restore 1");
    add_positional(command, "ACTION", arguments_.kind, "take, list, restore or drop");
    command->add_option("N", arguments_.value, "Number of the snapshot, as take and list print it")
        ->type_name("");
    command->add_option("--bench", arguments_.bench, "Default: the only bench")->type_name("B");
    command->callback([this] {
      command_ = snapshot_of(arguments_.kind, arguments_.value, bench());
    });
  }

  [[nodiscard]] std::optional<std::uint32_t> bench() const {
    if (arguments_.bench.empty()) return std::nullopt;
    return static_cast<std::uint32_t>(parse_number(arguments_.bench, "bench number", kHighest32));
  }

  void add_rate() {
    CLI::App* command =
        add_command("rate", "Set or show how fast a realtime bench runs; 0 pauses it",
                    "rate 0.5\n  vdrive rate 2 0       # bench 2");
    command
        ->add_option("VALUE", arguments_.rate,
                     "[BENCH] VALUE: drive time divided by wall time, 0 or from 0.1 to 100; BENCH "
                     "defaults to the only bench. Without a value the rates of all benches are "
                     "shown")
        ->type_name("");
    command->callback([this] {
      if (arguments_.rate.size() > 2) throw UsageError("rate takes at most a bench and a value");
      if (arguments_.rate.empty()) {
        command_ = RateCommand{};
        return;
      }
      RateCommand rate{parse_real(arguments_.rate.back(), "rate"), std::nullopt};
      if (arguments_.rate.size() == 2) {
        rate.bench = static_cast<std::uint32_t>(
            parse_number(arguments_.rate.front(), "bench number", kHighest32));
      }
      command_ = rate;
    });
  }

  void add_run() {
    CLI::App* command =
        add_command("run", "Execute scenario files", "run forward.scn --junit out.xml");
    command->footer(std::string(kScenarioHelp));
    add_files(command, "Scenario, - for standard input; several run one after the other");
    command->add_flag("--live", arguments_.live,
                      "Show the axes while time passes, also when piped");
    command->callback([this] {
      command_ =
          RunCommand{arguments_.files, arguments_.settings, arguments_.junit, arguments_.live};
    });
  }

  /// What `run` and `test` have in common.
  void add_files(CLI::App* command, const char* help) {
    command->add_option("FILE", arguments_.files, help)->required()->type_name("");
    command
        ->add_option("--set", arguments_.settings, "Value of the variable ${NAME}; may be repeated")
        ->allow_extra_args(false)
        ->type_name("NAME=VALUE");
    command->add_option("--junit", arguments_.junit, "Write a JUnit report")->type_name("OUT.xml");
  }

  void add_test() {
    CLI::App* command =
        add_command("test", "Run scenario files in parallel, each on a separate bench",
                    "test tests/*.scn --config bench.yaml --junit out.xml");
    add_files(command, "Scenario");
    command
        ->add_option("--config", arguments_.configuration,
                     "Configuration of the benches; default: the demo bench")
        ->type_name("FILE");
    command
        ->add_option("--jobs", arguments_.jobs,
                     "How many files run at the same time; default: one per processor")
        ->type_name("N");
    add_service(command);
    command->callback([this] {
      command_ = make_test();
    });
  }

  void add_service(CLI::App* command) {
    command
        ->add_option("--service", arguments_.service,
                     "The program vdrived; default: beside this program, else in PATH")
        ->type_name("FILE");
  }

  [[nodiscard]] TestCommand make_test() const {
    TestCommand test{.files = arguments_.files,
                     .settings = arguments_.settings,
                     .junit = arguments_.junit,
                     .configuration = arguments_.configuration,
                     .service = arguments_.service,
                     .jobs = std::max(std::thread::hardware_concurrency(), 1U)};
    constexpr std::uint64_t kMostJobs = process::PrivateDomain::kMostOfOneUser;
    if (!arguments_.jobs.empty())
      test.jobs = parse_number(arguments_.jobs, "number of jobs", kMostJobs);
    if (test.jobs == 0) throw UsageError("--jobs: at least one file must run");
    return test;
  }

  void add_events() {
    CLI::App* command =
        add_command("events", "Show events: state changes, faults, refusals, changes of control",
                    "events 1.1 --follow");
    command
        ->add_option("WHAT", arguments_.axis, "A bench's number or an axis; default: all benches")
        ->type_name("");
    command->add_flag("--follow", arguments_.follow, "Then print new events until interrupted");
    command->callback([this] {
      command_ = EventsCommand{arguments_.axis, arguments_.follow};
    });
  }

  void add_shell() {
    CLI::App* command =
        add_command("shell", "Execute commands line by line, in one session", "shell");
    command->footer(std::string(kShellHelp));
    command->callback([this] {
      command_ = ShellCommand{};
    });
  }

  void add_doctor() {
    CLI::App* command =
        add_command("doctor", "Check this machine and its network, and show what to change",
                    "doctor --interface 10.0.0.1");
    command->callback([this] {
      command_ = DoctorCommand{};
    });
  }

  void add_bench() {
    CLI::App* command = add_command(
        "bench", "Measure in a minute how many axes this machine holds, and how late its ticks are",
        "bench --json");
    add_service(command);
    command->add_flag("--quick", arguments_.quick,
                      "A few seconds, at most 1,024 axes: a first estimate");
    command->callback([this] {
      command_ = BenchCommand{arguments_.service, arguments_.quick};
    });
  }

  void add_completion() {
    CLI::App* command =
        add_command("completion", "Print a script that completes command lines",
                    "completion bash > ~/.local/share/bash-completion/completions/vdrive");
    command->add_option("SHELL", arguments_.file, "bash, zsh or fish")
        ->required()
        ->check(CLI::IsMember(completed_shells()))
        ->type_name("");
    command->callback([this] {
      text_ = shell_completion(arguments_.file);
    });
  }

  void add_expect() {
    CLI::App* command =
        add_command("expect", "Compare an object; exit code 1 when it is another value",
                    "expect 1.1 position 1000 --tolerance 1\n"
                    "  vdrive expect 1.1 torque '<' 500 --throughout 2s");
    add_axis(command);
    add_positional(command, "OBJECT", arguments_.object, "0x6064, 0x607D:1 or a variable_name");
    command
        ->add_option("VALUE", arguments_.values,
                     "[COMPARISON] VALUE: the comparison is ==, !=, <, <=, > or >=; default: ==")
        ->required()
        ->type_name("");
    CLI::Option* mask =
        command->add_option("--mask", arguments_.mask, "Compare these bits only")->type_name("M");
    command->add_option("--tolerance", arguments_.tolerance, "A difference of at most T is equal")
        ->excludes(mask)
        ->type_name("T");
    CLI::Option* within =
        command->add_option("--within", arguments_.within, "Wait at most this drive time for it")
            ->type_name("D");
    command
        ->add_option("--throughout", arguments_.throughout, "Check every tick of this drive time")
        ->excludes(within)
        ->type_name("D");
    command->callback([this] {
      command_ = make_expect();
    });
  }

  [[nodiscard]] ExpectCommand make_expect() const {
    ExpectCommand expect = expectation_of(arguments_.axis, arguments_.object, arguments_.values);
    const bool is_ordered =
        expect.comparison != Comparison::equal && expect.comparison != Comparison::not_equal;
    if (is_ordered && (!arguments_.mask.empty() || !arguments_.tolerance.empty())) {
      throw UsageError("--mask and --tolerance go with == and !=, not with " +
                       std::string(to_string(expect.comparison)));
    }
    if (!arguments_.mask.empty()) {
      expect.mask = static_cast<std::uint64_t>(parse_value(arguments_.mask, expect.object));
    }
    if (!arguments_.tolerance.empty()) {
      expect.quantity_of_tolerance = quantity_of(arguments_.tolerance, expect.object);
      if (expect.quantity_of_tolerance) expect.quantity_of_tolerance->type = DataType::unsigned32;
      expect.tolerance = expect.quantity_of_tolerance
                             ? 0
                             : parse_number(arguments_.tolerance, "tolerance", kHighest32);
    }
    if (!arguments_.within.empty()) expect.within = parse_duration(arguments_.within);
    if (!arguments_.throughout.empty()) expect.throughout = parse_duration(arguments_.throughout);
    return expect;
  }

  /// @param values [COMPARISON] VALUE
  static ExpectCommand expectation_of(const std::string& axis, const std::string& object,
                                      std::span<const std::string> values) {
    ExpectCommand expect;
    expect.axis = axis;
    expect.object = parse_object(object);
    if (values.size() > 2) {
      throw UsageError(in_quotes(values[2]) + " is one argument too many: write OBJECT [==] VALUE");
    }
    if (values.size() == 2) {
      const auto comparison = comparison_named(values.front());
      if (!comparison) {
        throw UsageError(in_quotes(values.front()) +
                         " is not a comparison: write ==, !=, <, <=, > or >=");
      }
      expect.comparison = *comparison;
    }
    expect.quantity = quantity_of(values.back(), expect.object);
    if (!expect.quantity) expect.value = parse_value(values.back(), expect.object);
    return expect;
  }

  void add_wait() {
    CLI::App* command =
        add_command("wait", "Wait for a state or a value of an axis; exit code 4 after --timeout",
                    "wait 1.1 target_reached --timeout 5s\n"
                    "  vdrive wait 1.1 position '>' 1000\n"
                    "  vdrive wait 500ms");
    std::string help =
        "AXIS CONDITION, AXIS OBJECT [COMPARISON] VALUE, or DURATION of drive time. CONDITION is a "
        "state or a bit of the statusword:";
    std::string_view separator = " ";
    for (const std::string& name : condition_names()) {
      help.append(separator).append(name);
      separator = ", ";
    }
    command->add_option("WHAT", arguments_.values, help)->required()->type_name("");
    command->callback([this] {
      command_ = make_wait();
    });
  }

  [[nodiscard]] Command make_wait() const {
    const std::vector<std::string>& what = arguments_.values;
    if (what.size() == 1) return WaitCommand{parse_duration(what.front())};
    if (what.size() > 2) {
      return AwaitCommand{what[0], "",
                          expectation_of(what[0], what[1], std::span(what).subspan(2))};
    }
    const std::vector<std::string>& names = condition_names();
    if (std::ranges::find(names, what[1]) == names.end()) {
      throw UsageError(in_quotes(what[1]) + " is not a condition" + suggestion(what[1], names) +
                       "; 'vdrive wait --help' lists all conditions");
    }
    return AwaitCommand{what[0], what[1], std::nullopt};
  }

  CLI::App app_;
  GlobalOptions options_;
  std::optional<std::uint32_t> domain_;
  std::string timeout_;
  Arguments arguments_;
  std::optional<Command> command_;
  std::string text_;
};

/// @return the help of the tool, then that of each command.
std::string help_of_all_commands(const CLI::App& app) {
  std::string text = app.help();
  for (const CLI::App* const command : app.get_subcommands({})) {
    text += "\n" + command->get_name() + ": " + command->help(app.get_name());
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

namespace {

/// What a command line, or a line of a shell, requests.
Invocation invocation_of(Grammar& grammar, std::vector<std::string> arguments) {
  Invocation invocation;
  try {
    grammar.parse(std::move(arguments));
    invocation.options = grammar.options();
    invocation.command = std::move(grammar.command());
    invocation.text = grammar.text();
  } catch (const CLI::CallForHelp&) {
    invocation.text = grammar.app().help();
  } catch (const CLI::CallForAllHelp&) {
    invocation.text = help_of_all_commands(grammar.app());
  } catch (const CLI::CallForVersion& version) {
    invocation.text = std::string(version.what()) + "\n";
  } catch (const CLI::ExtrasError&) {
    throw UsageError(unexpected_text(grammar.app()));
  } catch (const CLI::ParseError& error) {
    throw UsageError(one_line(error.what()));
  }
  return invocation;
}

}  // namespace

Invocation parse_command_line(std::vector<std::string> arguments) {
  if (arguments.empty()) throw UsageError("no command given; 'vdrive --help' lists all commands");
  Grammar grammar;
  grammar.add_command_line();
  Invocation invocation = invocation_of(grammar, std::move(arguments));
  if (invocation.command) invocation.options.domain = grammar.domain();
  return invocation;
}

Invocation parse_shell_command(std::vector<std::string> words) {
  Grammar grammar;
  grammar.add_shell_line();
  return invocation_of(grammar, std::move(words));
}

std::vector<std::string> complete_words(const std::vector<std::string>& words,
                                        const BenchNames& names) {
  Grammar grammar;
  grammar.add_command_line();
  return candidates(grammar.app(), words, names);
}

std::vector<std::string> complete_line(const std::string& line, const BenchNames& names) {
  std::vector<std::string> words;
  std::istringstream stream(line);
  for (std::string word; stream >> word;) words.push_back(word);
  if (line.empty() || line.ends_with(' ') || line.ends_with('\t')) words.emplace_back();
  Grammar grammar;
  grammar.add_shell_line();
  return candidates(grammar.app(), words, names);
}

ScenarioCommand parse_scenario_command(std::vector<std::string> words) {
  if (!words.empty() && words.front() == "refused") {
    if (words.size() < 3) throw UsageError("refused needs a code and a command");
    const auto code = static_cast<std::uint32_t>(parse_number(words[1], "code", kHighest32));
    if (words[2] == "refused") {
      throw UsageError("refused stands in refused: a line has at most one of them");
    }
    ScenarioCommand inner = parse_scenario_command({words.begin() + 2, words.end()});
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
    ScenarioCommand result{std::move(grammar.command()).value(), grammar.options().timeout};
    return result;
  } catch (const CLI::ExtrasError&) {
    throw UsageError(unexpected_text(grammar.app()));
  } catch (const CLI::ParseError& error) {
    throw UsageError(one_line(error.what()));
  }
}

}  // namespace vdrive::tool
