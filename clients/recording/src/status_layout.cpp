// SPDX-License-Identifier: Apache-2.0
#include "status_layout.hpp"

#include "recording.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

namespace vdrive::recording {
namespace {

/// Bits of a number of `size` bytes as those of a signed one.
std::uint64_t with_sign(std::uint64_t bits, std::size_t size) {
  constexpr std::size_t kBits = 8;
  if (size >= sizeof(bits)) return bits;
  const std::uint64_t sign = std::uint64_t{1} << (size * kBits - 1);
  return (bits ^ sign) - sign;
}

/// The next line, without what follows a #; off `text`.
std::string_view take_line(std::string_view& text) {
  const std::string_view line = text.substr(0, text.find('\n'));
  text.remove_prefix(std::min(text.size(), line.size() + 1));
  return line.substr(0, line.find('#'));
}

/// The next word; off `line`.
std::string_view take_word(std::string_view& line) {
  constexpr std::string_view kBlanks = " \t\r";
  line.remove_prefix(std::min(line.size(), line.find_first_not_of(kBlanks)));
  const std::string_view word = line.substr(0, line.find_first_of(kBlanks));
  line.remove_prefix(word.size());
  return word;
}

}  // namespace

/// Reads CDR.
class StatusLayout::Cursor {
 public:
  explicit Cursor(std::string_view bytes) : all_(bytes) {
    constexpr std::string_view kLittleEndianCdr{"\0\1", 2};
    if (bytes.size() < kHeader || bytes.substr(0, 2) != kLittleEndianCdr) {
      throw RecordingError("a message of the status is not little-endian CDR");
    }
    all_.remove_prefix(kHeader);
  }

  /// @return the number's bits, with the sign of a signed type; 0 for a field that is not a number.
  std::uint64_t number(Type type) {
    const auto row = static_cast<std::size_t>(type);
    if (type == Type::text) return skip(bits(sizeof(std::uint32_t)));
    if (type == Type::time) {
      (void)bits(sizeof(std::uint32_t));
      (void)bits(sizeof(std::uint32_t));
      return 0;
    }
    constexpr std::array<std::size_t, 11> kSizes{1, 1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
    const std::uint64_t value = bits(kSizes.at(row));
    if (type == Type::f32 || type == Type::f64) return 0;
    const bool is_signed =
        type == Type::i8 || type == Type::i16 || type == Type::i32 || type == Type::i64;
    return is_signed ? with_sign(value, kSizes.at(row)) : value;
  }

  /// The number of elements of an array, each of at least one byte.
  std::size_t count() {
    const std::uint64_t count = bits(sizeof(std::uint32_t));
    if (count > all_.size() - place_) fail();
    return count;
  }

 private:
  static constexpr std::size_t kHeader = 4;

  [[noreturn]] static void fail() {
    throw RecordingError("a message of the status is shorter than its schema");
  }

  std::uint64_t bits(std::size_t size) {
    place_ += (size - place_ % size) % size;
    if (place_ > all_.size() || size > all_.size() - place_) fail();
    std::uint64_t value = 0;
    std::memcpy(&value, all_.data() + place_, size);
    place_ += size;
    return value;
  }

  std::uint64_t skip(std::uint64_t size) {
    if (size > all_.size() - place_) fail();
    place_ += size;
    return 0;
  }

  std::string_view all_;
  std::size_t place_ = 0;
};

std::optional<StatusLayout::Type> StatusLayout::type_named(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, Type>, 15> kTypes{
      {{"bool", Type::boolean},
       {"uint8", Type::u8},
       {"byte", Type::u8},
       {"char", Type::u8},
       {"int8", Type::i8},
       {"uint16", Type::u16},
       {"int16", Type::i16},
       {"uint32", Type::u32},
       {"int32", Type::i32},
       {"uint64", Type::u64},
       {"int64", Type::i64},
       {"float32", Type::f32},
       {"float64", Type::f64},
       {"string", Type::text},
       {"builtin_interfaces/Time", Type::time}}};
  for (const auto& [text, type] : kTypes) {
    if (text == name) return type;
  }
  return std::nullopt;
}

/// @return the field of a line of a schema; nothing for a line without one, such as a constant.
std::optional<StatusLayout::Field> StatusLayout::field_of(std::string_view line) {
  constexpr std::array<std::pair<std::string_view, Meaning>, 5> kMeanings{
      {{"tick", Meaning::tick},
       {"axis", Meaning::axis},
       {"owner_session", Meaning::owner_session},
       {"owner_epoch", Meaning::owner_epoch},
       {"last_sequence", Meaning::last_sequence}}};
  if (line.find('=') != std::string_view::npos) return std::nullopt;
  std::string_view type = take_word(line);
  Field field{.name = std::string(take_word(line))};
  if (field.name.empty()) return std::nullopt;
  field.is_array = type.ends_with("[]");
  if (field.is_array) type.remove_suffix(2);
  const auto known = type_named(type);
  if (!known) {
    throw RecordingError("the schema of the status has the field " + in_quotes(field.name) +
                         " of the type " + in_quotes(type) + ", which is not known");
  }
  field.type = *known;
  const auto members = status_members();
  const auto member = std::ranges::find(members, field.name, &StatusMember::name);
  if (member != members.end()) {
    field.meaning = Meaning::member;
    field.member = &*member;
  }
  for (const auto& [name, meaning] : kMeanings) {
    if (name == field.name) field.meaning = meaning;
  }
  return field;
}

StatusLayout::StatusLayout(std::string_view schema) {
  while (!schema.empty()) {
    const std::string_view line = take_line(schema);
    if (line.starts_with("===")) break;
    if (auto field = field_of(line)) fields_.push_back(std::move(*field));
  }
}

void StatusLayout::set(client::AxisSnapshot& axis, const Field& field, std::uint64_t value) {
  switch (field.meaning) {
    case Meaning::tick:
      axis.tick = value;
      break;
    case Meaning::axis:
      axis.id.axis = static_cast<std::uint16_t>(value);
      break;
    case Meaning::member:
      field.member->set(axis.status, static_cast<std::int64_t>(value));
      break;
    case Meaning::owner_session:
      axis.owner_session = value;
      break;
    case Meaning::owner_epoch:
      axis.owner_epoch = static_cast<std::uint32_t>(value);
      break;
    case Meaning::last_sequence:
      axis.last_sequence = value;
      break;
    case Meaning::none:
      break;
  }
}

void StatusLayout::decode_array(const Field& field, Cursor& cursor,
                                std::vector<client::AxisSnapshot>& axes) {
  const std::size_t count = cursor.count();
  if (field.meaning == Meaning::none) {
    for (std::size_t i = 0; i < count; ++i) (void)cursor.number(field.type);
    return;
  }
  if (axes.empty()) axes.resize(count);
  if (axes.size() != count) {
    throw RecordingError("a message of the status has " + std::to_string(axes.size()) +
                         " axes and " + std::to_string(count) + " values of " +
                         in_quotes(field.name));
  }
  for (client::AxisSnapshot& axis : axes) set(axis, field, cursor.number(field.type));
}

std::vector<client::AxisSnapshot> StatusLayout::decode(std::string_view bytes) const {
  Cursor cursor(bytes);
  client::AxisSnapshot common;
  std::vector<client::AxisSnapshot> axes;
  bool has_arrays = false;
  for (const Field& field : fields_) {
    has_arrays = has_arrays || (field.is_array && field.meaning != Meaning::none);
    if (field.is_array) {
      decode_array(field, cursor, axes);
    } else {
      set(common, field, cursor.number(field.type));
    }
  }
  if (!has_arrays) return {common};
  for (client::AxisSnapshot& axis : axes) axis.tick = common.tick;
  return axes;
}

}  // namespace vdrive::recording
