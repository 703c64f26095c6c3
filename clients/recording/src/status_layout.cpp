// SPDX-License-Identifier: Apache-2.0
#include "status_layout.hpp"

#include "axis_fields.hpp"
#include "recording.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wire/cdr.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <type_traits>
#include <utility>

namespace vdrive::recording {
namespace {

/// Removes the next line from `text` and returns it without the part after a #.
std::string_view take_line(std::string_view& text) {
  const std::string_view line = text.substr(0, text.find('\n'));
  text.remove_prefix(std::min(text.size(), line.size() + 1));
  return line.substr(0, line.find('#'));
}

/// Removes the next word from `line` and returns it.
std::string_view take_word(std::string_view& line) {
  constexpr std::string_view kBlanks = " \t\r";
  line.remove_prefix(std::min(line.size(), line.find_first_not_of(kBlanks)));
  const std::string_view word = line.substr(0, line.find_first_of(kBlanks));
  line.remove_prefix(word.size());
  return word;
}

/// Reads a number of this type.
template <typename Number>
std::int64_t next(wire::CdrReader& reader) {
  return static_cast<std::int64_t>(reader.next<Number>());
}

// Fields that are not integers are only skipped.

template <typename Number>
std::int64_t skip(wire::CdrReader& reader) {
  (void)reader.next<Number>();
  return 0;
}

std::int64_t skip_text(wire::CdrReader& reader) {
  (void)reader.next_text();
  return 0;
}

std::int64_t skip_time(wire::CdrReader& reader) {
  (void)skip<std::int32_t>(reader);
  return skip<std::uint32_t>(reader);
}

/// A type of ros2msg.
struct TypeRow {
  std::string_view name;
  std::int64_t (*next)(wire::CdrReader& reader);
};

constexpr std::array kTypes{TypeRow{"bool", next<std::uint8_t>},
                            TypeRow{"uint8", next<std::uint8_t>},
                            TypeRow{"byte", next<std::uint8_t>},
                            TypeRow{"char", next<std::uint8_t>},
                            TypeRow{"int8", next<std::int8_t>},
                            TypeRow{"uint16", next<std::uint16_t>},
                            TypeRow{"int16", next<std::int16_t>},
                            TypeRow{"uint32", next<std::uint32_t>},
                            TypeRow{"int32", next<std::int32_t>},
                            TypeRow{"uint64", next<std::uint64_t>},
                            TypeRow{"int64", next<std::int64_t>},
                            TypeRow{"float32", skip<float>},
                            TypeRow{"float64", skip<double>},
                            TypeRow{"string", skip_text},
                            TypeRow{"builtin_interfaces/Time", skip_time}};

/// @throws RecordingError if a read has failed
void check(const wire::CdrReader& reader) {
  if (!reader.is_good()) {
    throw RecordingError("a message of the status is shorter than its schema");
  }
}

}  // namespace

/// @return the field in a line of a schema; nothing for a line without a field, such as a constant.
std::optional<StatusLayout::Field> StatusLayout::field_of(std::string_view line) {
  if (line.find('=') != std::string_view::npos) return std::nullopt;
  std::string_view type = take_word(line);
  Field field{.name = std::string(take_word(line))};
  if (field.name.empty()) return std::nullopt;
  field.is_array = type.ends_with("[]");
  if (field.is_array) type.remove_suffix(2);
  const auto* const known = std::ranges::find(kTypes, type, &TypeRow::name);
  if (known == kTypes.end()) {
    throw RecordingError("the schema of the status has the field " + in_quotes(field.name) +
                         " of the type " + in_quotes(type) + ", which is not known");
  }
  field.next = known->next;
  const auto take = [&](std::string_view name, auto field_of_axis) {
    if (name != field.name) return;
    field.set = [field_of_axis](client::AxisSnapshot& axis, std::int64_t value) {
      auto& number = field_of_axis(axis);
      number = static_cast<std::remove_reference_t<decltype(number)>>(value);
    };
  };
  take(
      "tick", [](auto& axis) -> auto& { return axis.tick; });
  bridge::for_each_axis_field(take);
  return field;
}

StatusLayout::StatusLayout(std::string_view schema) {
  while (!schema.empty()) {
    const std::string_view line = take_line(schema);
    if (line.starts_with("===")) break;
    if (auto field = field_of(line)) fields_.push_back(std::move(*field));
  }
}

void StatusLayout::decode_array(const Field& field, wire::CdrReader& reader,
                                std::vector<client::AxisSnapshot>& axes) {
  const std::size_t count = reader.next_length({});
  check(reader);
  if (!field.set) {
    for (std::size_t i = 0; i < count; ++i) (void)field.next(reader);
    return;
  }
  if (axes.empty()) axes.resize(count);
  if (axes.size() != count) {
    throw RecordingError("a message of the status has " + std::to_string(axes.size()) +
                         " axes and " + std::to_string(count) + " values of " +
                         in_quotes(field.name));
  }
  for (client::AxisSnapshot& axis : axes) field.set(axis, field.next(reader));
}

std::vector<client::AxisSnapshot> StatusLayout::decode(std::string_view bytes) const {
  wire::CdrReader reader(std::as_bytes(std::span(bytes)));
  if (!reader.is_native()) {
    throw RecordingError("a message of the status is not little-endian CDR");
  }
  client::AxisSnapshot common;
  std::vector<client::AxisSnapshot> axes;
  bool has_arrays = false;
  for (const Field& field : fields_) {
    has_arrays = has_arrays || (field.is_array && field.set);
    if (field.is_array) {
      decode_array(field, reader, axes);
    } else {
      const std::int64_t value = field.next(reader);
      if (field.set) field.set(common, value);
    }
  }
  check(reader);
  if (!has_arrays) return {common};
  for (client::AxisSnapshot& axis : axes) axis.tick = common.tick;
  return axes;
}

}  // namespace vdrive::recording
