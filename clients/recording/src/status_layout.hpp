// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/axis_status.hpp"
#include "vdrive/client/axis_snapshot.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::recording {

/// How the fields of a status message lie in its bytes, by the ros2msg text of its schema: an
/// AxisStatus or a BenchStatus of this or another version. Unknown members are skipped,
/// missing ones are 0.
class StatusLayout {
 public:
  /// @throws RecordingError when a field has a type that is not known
  explicit StatusLayout(std::string_view schema);

  /// Reads one message.
  /// @param bytes CDR with its encapsulation header
  /// @return an element an axis, without the number of the bench
  /// @throws RecordingError when the bytes do not fit the layout
  [[nodiscard]] std::vector<client::AxisSnapshot> decode(std::string_view bytes) const;

 private:
  enum class Type : std::uint8_t {
    boolean,
    u8,
    i8,
    u16,
    i16,
    u32,
    i32,
    u64,
    i64,
    f32,
    f64,
    text,
    time
  };

  enum class Meaning : std::uint8_t {
    none,
    tick,
    axis,
    member,
    owner_session,
    owner_epoch,
    last_sequence
  };

  struct Field {
    std::string name;
    Type type = Type::u8;
    bool is_array = false;
    Meaning meaning = Meaning::none;
    const StatusMember* member = nullptr;
  };

  class Cursor;

  static std::optional<Type> type_named(std::string_view name);
  static std::optional<Field> field_of(std::string_view line);
  static void set(client::AxisSnapshot& axis, const Field& field, std::uint64_t value);
  static void decode_array(const Field& field, Cursor& cursor,
                           std::vector<client::AxisSnapshot>& axes);

  std::vector<Field> fields_;
};

}  // namespace vdrive::recording
