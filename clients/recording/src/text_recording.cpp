// SPDX-License-Identifier: Apache-2.0
#include "text_recording.hpp"

#include "csv_field.hpp"
#include "sample_order.hpp"
#include "status_json.hpp"
#include "topic_names.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <set>
#include <utility>

namespace vdrive::recording {
namespace {

/// The fields of a row other than the members of the status, in CSV order.
constexpr std::array<std::string_view, 4> kBeforeMembers{"axis", "name", "tick", "missed"};
constexpr std::array<std::string_view, 2> kAfterMembers{"owner", "owner_epoch"};

/// At the end of a row; missing in recordings of older versions.
constexpr std::string_view kUnit = "unit";
constexpr std::string_view kUnitSize = "unit_size";  // [UU] per unit, or per revolution
constexpr std::string_view kPositionInUnit = "position_in_unit";
constexpr std::string_view kVelocityInUnit = "velocity_in_unit";
constexpr std::array kOfUnit{kUnit, kUnitSize, kPositionInUnit, kVelocityInUnit};

/// Derived from other fields; state and flags in JSON only.
constexpr std::array<std::string_view, 4> kDerived{"state", "flags", kPositionInUnit,
                                                   kVelocityInUnit};

/// The names of the fields that a row has in every version.
const std::vector<std::string>& columns() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all(kBeforeMembers.begin(), kBeforeMembers.end());
    for (const StatusMember& member : recorded_members()) all.emplace_back(member.name);
    all.insert(all.end(), kAfterMembers.begin(), kAfterMembers.end());
    return all;
  }();
  return names;
}

}  // namespace

std::string csv_header() {
  std::string header;
  for (const std::string& name : columns()) {
    if (!header.empty()) header += ',';
    header += name;
  }
  for (const std::string_view name : kOfUnit) header.append(",").append(name);
  return header;
}

// ---- writing -----------------------------------------------------------------------------------

TextRecording::TextRecording(std::unique_ptr<Output> output, Format format)
    : output_(std::move(output)), format_(format) {}

void TextRecording::put(std::string_view line) {
  constexpr std::size_t kMost = std::size_t{64} * 1024;
  lines_.append(line).push_back('\n');
  if (lines_.size() >= kMost) write();
}

void TextRecording::write() {
  if (!lines_.empty()) output_->write(lines_);
  lines_.clear();
}

void TextRecording::begin(const std::vector<RecordedBench>& benches) {
  for (const RecordedBench& bench : benches) {
    for (const RecordedAxis& axis : bench.axes) axes_[axis.id] = axis;
  }
  if (format_ == Format::csv) put(csv_header());
  write();
}

void TextRecording::status(const client::Observation& sample) {
  for (const client::AxisSnapshot& axis : sample.axes) {
    put(format_ == Format::csv ? csv_row(axis, sample.missed) : json_row(axis, sample.missed));
  }
}

void TextRecording::event(const client::Event& /*event*/) {}

void TextRecording::parameters(const bridge::ParameterImage& /*image*/) {}

void TextRecording::flush(Clock::time_point /*now*/) {
  write();
}

void TextRecording::finish(const Summary& /*summary*/) {
  write();
}

std::string TextRecording::csv_row(const client::AxisSnapshot& axis, std::uint64_t missed) const {
  const RecordedAxis& recorded = axes_.at(axis.id);
  std::string row = to_string(axis.id) + "," + csv_field(recorded.name) + "," +
                    std::to_string(axis.tick) + "," + std::to_string(missed);
  for (const StatusMember& member : recorded_members()) {
    row.append(",").append(std::to_string(member.value(axis.status)));
  }
  row.append(",");
  if (axis.owner_session != 0) row.append(session_text(axis.owner_session));
  row.append(",").append(std::to_string(axis.owner_epoch));
  if (!recorded.unit) return row.append(kOfUnit.size(), ',');
  const auto in_unit = [&recorded](std::int32_t user_units) {
    return to_text(client::from_user_units(user_units, *recorded.unit));
  };
  row.append(",").append(csv_field(recorded.unit->name));
  row.append(",").append(to_text(recorded.unit->size));
  row.append(",").append(in_unit(axis.status.load_position_actual_value));
  return row.append(",").append(in_unit(axis.status.load_velocity_actual_value));
}

std::string TextRecording::json_row(const client::AxisSnapshot& axis, std::uint64_t missed) const {
  const RecordedAxis& recorded = axes_.at(axis.id);
  Json json = status_json(axis, recorded.name, recorded.unit);
  json["missed"] = missed;
  return to_line(json);
}

// ---- reading -----------------------------------------------------------------------------------

namespace {

/// One row as read.
struct Row {
  client::AxisSnapshot axis;
  std::string name;
  std::uint64_t missed = 0;
  std::string unit{};
  std::string unit_size{};
};

[[noreturn]] void refuse(std::string_view column, std::string_view text, const std::string& what) {
  throw RecordingError(std::string(column) + " is " + in_quotes(text) + ": " + what);
}

template <typename Number>
Number number_of(std::string_view column, std::string_view text) {
  const auto number = parse_digits<Number>(text);
  if (number) return *number;
  refuse(column, text,
         "a whole number from 0 to " + std::to_string(std::numeric_limits<Number>::max()) +
             " is expected");
}

std::uint64_t session_of(std::string_view column, std::string_view text) {
  constexpr std::string_view kHex = "0x";
  constexpr int kBase = 16;
  if (text.empty()) return 0;
  const auto session = text.starts_with(kHex)
                           ? parse_digits<std::uint64_t>(text.substr(kHex.size()), kBase)
                           : std::nullopt;
  if (!session) refuse(column, text, "a session such as 0x0123456789abcdef is expected");
  return *session;
}

void set_member(const StatusMember& member, AxisStatus& status, std::string_view text) {
  const TypeRange range = range_of(member.data_type);
  const auto value = parse_digits<std::int64_t>(text);
  if (!value || *value < range.lowest || *value > range.highest) {
    refuse(member.name, text,
           "a whole number from " + std::to_string(range.lowest) + " to " +
               std::to_string(range.highest) + " is expected");
  }
  member.set(status, *value);
}

/// Sets the value of a field.
/// @return false if no field has this name
bool set_field(Row& row, const std::string& column, const std::string& text) {
  const auto member = std::ranges::find(recorded_members(), column, &StatusMember::name);
  if (member != recorded_members().end()) {
    set_member(*member, row.axis.status, text);
  } else if (column == "axis") {
    const auto id = client::parse_axis_id(text);
    if (!id || id->axis == 0) refuse(column, text, "an address such as 1.2 is expected");
    row.axis.id = *id;
  } else if (column == "name") {
    row.name = text;
  } else if (column == "tick") {
    row.axis.tick = number_of<std::uint64_t>(column, text);
  } else if (column == "missed") {
    row.missed = number_of<std::uint64_t>(column, text);
  } else if (column == "owner") {
    row.axis.owner_session = session_of(column, text);
  } else if (column == "owner_epoch") {
    row.axis.owner_epoch = number_of<std::uint32_t>(column, text);
  } else if (column == kUnit) {
    row.unit = text;
  } else if (column == kUnitSize) {
    row.unit_size = text;
  } else {
    return std::ranges::find(kDerived, column) != kDerived.end();
  }
  return true;
}

[[noreturn]] void refuse_columns(const std::string& what, const std::string& column) {
  throw RecordingError(what + " " + in_quotes(column));
}

/// @throws RecordingError if one is missing, unknown or duplicated
void check_columns(const std::vector<std::string>& present) {
  std::set<std::string> seen;
  for (const std::string& column : present) {
    if (std::ranges::find(columns(), column) == columns().end() &&
        std::ranges::find(kOfUnit, column) == kOfUnit.end()) {
      refuse_columns("there is no column", column);
    }
    if (!seen.insert(column).second) refuse_columns("there are two columns", column);
  }
  for (const std::string& column : columns()) {
    if (!seen.contains(column)) refuse_columns("it lacks the column", column);
  }
}

std::string text_of(const Json& value) {
  if (value.is_null()) return {};
  return value.is_string() ? value.get<std::string>() : value.dump();
}

/// Reads a text recording line by line.
class TextReader {
 public:
  TextReader(std::istream& file, Format format, const SampleHandler& handler)
      : file_(file), format_(format), handler_(handler) {}

  Contents read() {
    try {
      for (std::string line; std::getline(file_, line);) {
        ++number_;
        if (file_.eof()) throw RecordingError("the last line has no line break: it is incomplete");
        if (line.ends_with('\r')) line.pop_back();
        take(line);
      }
      if (number_ == 0) throw RecordingError("the file is empty");
      const std::string shortage = order_.shortage(sample_);
      if (!shortage.empty()) throw RecordingError(shortage + ": it is incomplete");
    } catch (const RecordingError& error) {
      throw RecordingError("line " + std::to_string(number_) + ": " + error.what());
    }
    end_sample();
    contents_.benches.reserve(benches_.size());
    for (auto& [number, bench] : benches_) contents_.benches.push_back(finished(bench));
    return std::move(contents_);
  }

 private:
  void take(const std::string& line) {
    if (format_ == Format::json_lines) {
      add(json_row(line));
    } else if (number_ == 1) {
      header_ = csv_fields(line);
      check_columns(header_);
    } else {
      add(csv_row(line));
    }
  }

  [[nodiscard]] Row csv_row(const std::string& line) const {
    const std::vector<std::string> fields = csv_fields(line);
    if (fields.size() != header_.size()) {
      throw RecordingError("it has " + std::to_string(fields.size()) + " fields, the header has " +
                           std::to_string(header_.size()));
    }
    Row row;
    for (std::size_t i = 0; i < fields.size(); ++i) (void)set_field(row, header_[i], fields[i]);
    return row;
  }

  [[nodiscard]] static Row json_row(const std::string& line) {
    const Json json = Json::parse(line, nullptr, false);
    if (!json.is_object()) throw RecordingError("it is not a JSON object: " + in_quotes(line));
    Row row;
    std::set<std::string> seen;
    for (const auto& [key, value] : json.items()) {
      seen.insert(key);
      if (!set_field(row, key, text_of(value))) refuse_columns("there is no field", key);
    }
    for (const std::string& column : columns()) {
      if (!seen.contains(column)) refuse_columns("it lacks the field", column);
    }
    return row;
  }

  void add(const Row& row) {
    if (!sample_.axes.empty()) {
      const client::AxisSnapshot& first = sample_.axes.front();
      if (row.axis.tick != sample_.tick || row.axis.id.bench != first.id.bench) end_sample();
    }
    order_.note(row.axis.id, row.axis.tick);
    if (sample_.axes.empty()) {
      sample_.tick = row.axis.tick;
      sample_.missed = row.missed;
    } else if (sample_.missed != row.missed) {
      throw RecordingError("missed is " + std::to_string(row.missed) + ", but " +
                           std::to_string(sample_.missed) +
                           " in the previous row of the same tick");
    }
    sample_.axes.push_back(row.axis);
    note_axis(row);
  }

  void note_axis(const Row& row) {
    const auto [name, is_new] = names_.try_emplace(row.axis.id, row.name);
    if (!is_new && name->second != row.name) {
      throw RecordingError("the name of the axis " + to_string(row.axis.id) + " changes from " +
                           in_quotes(name->second) + " to " + in_quotes(row.name));
    }
    if (!is_new) return;
    RecordedBench& bench = benches_[row.axis.id.bench];
    bench.number = row.axis.id.bench;
    bench.axes.push_back(
        {.id = row.axis.id, .name = row.name, .unit = unit_from(row.unit, row.unit_size)});
  }

  void end_sample() {
    if (sample_.axes.empty()) return;
    ++contents_.samples;
    contents_.rows += sample_.axes.size();
    handler_(sample_);
    sample_ = {};
  }

  static RecordedBench finished(RecordedBench& bench) {
    std::ranges::sort(bench.axes, {}, &RecordedAxis::id);
    return std::move(bench);
  }

  std::istream& file_;
  const Format format_;
  const SampleHandler& handler_;
  std::uint64_t number_ = 0;  ///< of the line
  std::vector<std::string> header_;
  Contents contents_;
  client::Observation sample_;
  SampleOrder order_;
  std::map<client::AxisId, std::string> names_;
  std::map<std::uint32_t, RecordedBench> benches_;
};

}  // namespace

Contents read_text(std::istream& file, Format format, const SampleHandler& handler) {
  return TextReader(file, format, handler).read();
}

}  // namespace vdrive::recording
