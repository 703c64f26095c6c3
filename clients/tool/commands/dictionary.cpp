// SPDX-License-Identifier: Apache-2.0
#include "commands/dictionary.hpp"

#include "base/usage_error.hpp"
#include "csv_field.hpp"
#include "execution/command_context.hpp"
#include "language/arguments.hpp"
#include "node/electronic_data_sheet.hpp"
#include "node/node_object.hpp"
#include "node/node_settings.hpp"
#include "terminal/columns.hpp"
#include "vdrive/bench/bench.hpp"
#include "vdrive/cia402/homing_method.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/clock_mode.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <array>
#include <sstream>

namespace vdrive::tool {
namespace {

struct FormatName {
  std::string_view name;
  TableFormat format = TableFormat::table;
};

constexpr std::array kFormatNames{
    FormatName{"table", TableFormat::table}, FormatName{"json", TableFormat::json},
    FormatName{"csv", TableFormat::csv}, FormatName{"eds", TableFormat::eds},
    FormatName{"node-json", TableFormat::node_json}};

/// @return whether the full dictionary of a CANopen node is shown, rather than the core's table.
bool is_of_node(TableFormat format) {
  return format == TableFormat::eds || format == TableFormat::node_json;
}

std::string_view name_in(const ObjectDescription& row, Language language) {
  return language == Language::zh ? row.name_zh : row.name;
}

std::string units_in(const ObjectDescription& row, Language language) {
  return language == Language::zh ? std::string(row.units) : english_units(row);
}

Json dictionary_json(const ObjectDescription& row, Language language) {
  return {{"index", hex(row.address.index, 4)},
          {"subindex", row.address.subindex},
          {"name", row.variable_name},
          {"title", name_in(row, language)},
          {"category", row.category},
          {"type", to_string(row.data_type)},
          {"access", to_string(row.access)},
          {"stored", row.storage == Storage::flash},
          {"effective", to_string(row.effective)},
          {"lower_limit", row.lower_limit},
          {"upper_limit", row.upper_limit},
          {"default", row.default_value},
          {"units", units_in(row, language)},
          {"origin", row.origin == Origin::manual ? "manual" : "companion"}};
}

std::string csv_value(const Json& value) {
  return value.is_string() ? recording::csv_field(value.get<std::string>()) : value.dump();
}

/// One line of CSV: the fields' names, or their values.
std::string csv_line(const Json& row, bool is_header) {
  std::string line;
  for (const auto& [key, value] : row.items()) {
    if (!line.empty()) line += ',';
    line += is_header ? key : csv_value(value);
  }
  return line;
}

std::vector<std::string> table_row(const ObjectDescription& row, Language language) {
  return {address_text(row.address),
          std::string(row.variable_name),
          std::string(name_in(row, language)),
          std::string(to_string(row.data_type)),
          std::string(to_string(row.access)),
          row.storage == Storage::flash ? "yes" : "",
          std::to_string(row.default_value),
          std::to_string(row.lower_limit) + " .. " + std::to_string(row.upper_limit),
          row.units == "-" ? std::string() : units_in(row, language)};
}

bool is_listed(const ObjectDescription& row, const DictionaryCommand& command) {
  return command.objects.empty() ||
         std::ranges::any_of(command.objects, [&row](const ObjectName& object) {
           return object.covers(row.address);
         });
}

std::string line_of_value(std::int64_t value, std::string_view meaning) {
  return "  " + padded(std::to_string(value), 4) + std::string(meaning);
}

void add_modes(const std::string& title, std::vector<std::string>& lines) {
  lines.push_back(title);
  for (const OperatingModeRow& row : kOperatingModes) {
    lines.push_back(line_of_value(static_cast<std::int64_t>(row.mode), row.name));
  }
}

void add_homing_methods(std::vector<std::string>& lines) {
  lines.emplace_back("homing_method (6098h) takes");
  lines.push_back(line_of_value(0, "no method: a homing run ends with a homing error"));
  for (const HomingMethodRow& row : kHomingMethods) {
    lines.push_back(line_of_value(row.number, row.what));
  }
}

/// Adds the meanings of values, for the objects that the user named.
void add_meanings(const DictionaryCommand& command, std::vector<std::string>& lines) {
  using namespace vdrive::literals;
  const auto is_asked = [&command](ObjectRow row) {
    return !command.objects.empty() && is_listed(describe(row), command);
  };
  if (is_asked("op_mode_cmd"_object)) add_modes("op_mode_cmd (6060h) takes", lines);
  if (is_asked("op_mode_actual"_object)) add_modes("op_mode_actual (6061h) shows", lines);
  if (is_asked("homing_method"_object)) add_homing_methods(lines);
}

std::string_view object_type_of(canopen::ObjectCode code) {
  switch (code) {
    case canopen::ObjectCode::variable:
      return "variable";
    case canopen::ObjectCode::array:
      return "array";
    case canopen::ObjectCode::record:
      return "record";
  }
  return "";
}

std::string_view pdo_mapping_of(canopen::PdoMapping mapping) {
  switch (mapping) {
    case canopen::PdoMapping::none:
      return "none";
    case canopen::PdoMapping::transmit:
      return "transmit";
    case canopen::PdoMapping::receive:
      return "receive";
    case canopen::PdoMapping::both:
      return "both";
  }
  return "";
}

Json node_object_json(const canopen::NodeObject& object) {
  Json json{{"index", hex(object.address.index, 4)},
            {"subindex", object.address.subindex},
            {"name", object.name},
            {"index_name", object.index_name},
            {"object_type", object_type_of(object.code)},
            {"type", canopen::type_text(object.data_type)},
            {"access", canopen::access_text(object)},
            {"owner", object.owner == canopen::ObjectOwner::drive ? "drive" : "node"},
            {"pdo_mapping", pdo_mapping_of(object.mapping)},
            {"lower_limit", object.lower_limit},
            {"upper_limit", object.upper_limit},
            {"default", object.default_value},
            {"adds_node_id", object.has_node_id}};
  if (object.data_type == canopen::NodeDataType::visible_string) {
    json["lower_limit"] = nullptr;
    json["upper_limit"] = nullptr;
    json["default"] = object.default_text;
  }
  return json;
}

std::vector<std::string> node_lines() {
  std::vector<std::string> lines;
  for (const canopen::NodeObject& object : canopen::node_objects()) {
    lines.push_back(to_line(node_object_json(object)));
  }
  return lines;
}

/// The values of an axis after power-up, from a temporary bench.
/// @param number of the axis
std::vector<canopen::DriveValue> values_of_axis(const DictionaryCommand& command,
                                                std::uint64_t number) {
  bench::BenchOptions options{.configuration_file = command.configuration,
                              .preset = command.preset,
                              .clock = ClockMode::lockstep};
  if (command.configuration.empty()) options.axes = number;
  const bench::Bench bench(options);
  client::Session session = bench.session();
  const std::string name = std::to_string(bench.number()) + "." + std::to_string(number);
  const auto axis = session.axis(name);
  if (!axis) throw UsageError("--axis: " + axis.outcome().message());
  std::vector<canopen::DriveValue> values;
  for (const canopen::NodeObject& object : canopen::node_objects()) {
    if (object.owner != canopen::ObjectOwner::drive) continue;
    if (const auto value = axis->read(object.address)) values.push_back({object.address, *value});
  }
  return values;
}

std::string data_sheet_of_node(const DictionaryCommand& command, std::uint64_t node) {
  try {
    const auto values = values_of_axis(command, command.axis_number.value_or(node));
    return canopen::electronic_data_sheet({.file_name = "vdrive.dcf",
                                           .program_version = VDRIVE_VERSION,
                                           .node_id = static_cast<std::uint8_t>(node),
                                           .values = values});
  } catch (const bench::BenchError& error) {
    throw UsageError(error.what());
  }
}

std::vector<std::string> data_sheet_lines(const DictionaryCommand& command) {
  std::istringstream text(
      command.node ? data_sheet_of_node(command, *command.node)
                   : canopen::electronic_data_sheet({.program_version = VDRIVE_VERSION}));
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  return lines;
}

std::vector<std::string> object_table(const DictionaryCommand& command) {
  std::vector<std::vector<std::string>> rows{
      {"object", "variable_name", "name", "type", "access", "stored", "default", "range", "units"}};
  for (const ObjectDescription& row : kObjectTable) {
    if (is_listed(row, command)) rows.push_back(table_row(row, command.language));
  }
  std::vector<std::string> lines = table_lines(rows);
  add_meanings(command, lines);
  return lines;
}

ObjectName parse_listed(const std::string& text) {
  ObjectName object = parse_object(text);
  const bool exists = std::ranges::any_of(kObjectTable, [&](const ObjectDescription& row) {
    return object.covers(row.address);
  });
  if (exists) return object;
  const std::string advice =
      object.address ? advice_on(*object.address, check_address(*object.address)) : "";
  throw UsageError("the dictionary has no object " + in_quotes(text) + object_suggestion(text) +
                   (advice.empty() ? "" : ": " + advice));
}

std::vector<std::string> format_names() {
  std::vector<std::string> names;
  names.reserve(kFormatNames.size());
  for (const FormatName& row : kFormatNames) names.emplace_back(row.name);
  return names;
}

TableFormat parse_table_format(const std::string& text) {
  const auto* const row =
      std::ranges::find(kFormatNames, std::string_view(text), &FormatName::name);
  return row == kFormatNames.end() ? TableFormat::table : row->format;
}

/// Refuses the options for the data sheet of one node in any other format than eds.
void check_node(const DictionaryCommand& command) {
  if (command.node && command.format != TableFormat::eds) {
    throw UsageError("--node applies to a data sheet only: add --format eds");
  }
  if (command.node == 0U) throw UsageError("--node 0 means all nodes; a node-ID is 1 to 127");
  const bool has_axis =
      command.axis_number || !command.preset.empty() || !command.configuration.empty();
  if (has_axis && !command.node) {
    throw UsageError(
        "--axis, --preset and --config say which axis a node is: add --node with its node-ID");
  }
  if (!command.preset.empty() && !command.configuration.empty()) {
    throw UsageError("--preset and --config cannot be used together");
  }
}

/// @param is_json whether the line has --json
void check_node_format(const DictionaryCommand& command, bool is_json) {
  if (!is_of_node(command.format)) return;
  const auto* const row = std::ranges::find(kFormatNames, command.format, &FormatName::format);
  const std::string option = "--format " + std::string(row->name);
  if (!command.objects.empty()) {
    throw UsageError("'" + option + "' has all objects of a node, so it takes no OBJECT; leave " +
                     in_quotes(command.objects.front().text) + " out");
  }
  if (command.language != Language::en) {
    throw UsageError("'" + option + "' is in English, so it takes no --language");
  }
  if (is_json && command.format == TableFormat::eds) {
    throw UsageError("'" + option +
                     "' is not available as JSON: use 'vdrive dictionary --format node-json'");
  }
}

void print_dictionary(DictionaryCommand command, bool is_json, Terminal& terminal) {
  if (is_json && !is_of_node(command.format)) command.format = TableFormat::json;
  for (const std::string& line : dictionary_lines(command)) {
    if (!terminal.is_open()) return;
    terminal.print(line);
  }
}

}  // namespace

std::vector<std::string> dictionary_lines(const DictionaryCommand& command) {
  if (command.format == TableFormat::table) return object_table(command);
  if (command.format == TableFormat::eds) return data_sheet_lines(command);
  if (command.format == TableFormat::node_json) return node_lines();
  std::vector<std::string> lines;
  for (const ObjectDescription& row : kObjectTable) {
    if (!is_listed(row, command)) continue;
    const Json json = dictionary_json(row, command.language);
    if (command.format == TableFormat::json) {
      lines.push_back(to_line(json));
      continue;
    }
    if (lines.empty()) lines.push_back(csv_line(json, true));
    lines.push_back(csv_line(json, false));
  }
  return lines;
}

void DictionaryCommand::declare(Arguments& arguments) {
  arguments
      .positionals("OBJECT", objects, "Show these only; an index shows all sub-indices",
                   [](const std::vector<std::string>& texts) {
                     std::vector<ObjectName> listed;
                     listed.reserve(texts.size());
                     for (const std::string& text : texts) listed.push_back(parse_listed(text));
                     return listed;
                   })
      .completed_by(complete_object);
  arguments
      .option(
          "--format", "F", format,
          "Of an axis: table, json or csv. Of an axis as a CANopen node, with its communication "
          "objects: eds (electronic data sheet) or node-json",
          parse_table_format)
      .one_of(format_names());
  arguments
      .option("--language", "L", language, "en or zh",
              [](const std::string& text) {
                return text == "zh" ? Language::zh : Language::en;
              })
      .one_of({"en", "zh"});
  arguments.option(
      "--node", "ID", node,
      "With --format eds: for this node, 1 to 127, with numeric COB-IDs and the values that its "
      "axis has after power-up",
      [](const std::string& text) {
        return parse_number(text, "node-ID", canopen::kHighestNodeId);
      });
  arguments.option("--axis", "N", axis_number,
                   "With --node: number of the axis on its bench; default: the node-ID",
                   [](const std::string& text) {
                     return parse_number(text, "number of an axis", bench::kMostAxes);
                   });
  arguments.option("--preset", "NAME", preset, "With --node: the machine that the axis belongs to");
  arguments.option("--config", "FILE", configuration,
                   "With --node: configuration file of the bench, as for vdrived");
  arguments.then([this, &is_json = arguments.is_json()] {
    check_node(*this);
    check_node_format(*this, is_json);
  });
}

client::Outcome DictionaryCommand::run(CommandContext& context) const {
  print_dictionary(*this, context.output.is_json, context.output.terminal);
  return {};
}

ExitCode DictionaryCommand::start(const Program& program) const {
  print_dictionary(*this, program.options.json, program.terminal);
  return ExitCode::ok;
}

extern const CommandRow kDictionary =
    row_of<DictionaryCommand>({.name = "dictionary",
                               .group = CommandGroup::parameters,
                               .summary = "Show the object dictionary; needs no service",
                               .example = "dictionary 0x607D --language zh"});

}  // namespace vdrive::tool
