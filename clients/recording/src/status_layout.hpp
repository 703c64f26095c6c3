// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/axis_snapshot.hpp"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::wire {
class CdrReader;
}  // namespace vdrive::wire

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
  struct Field {
    std::string name;
    bool is_array = false;
    std::int64_t (*next)(wire::CdrReader& reader) = nullptr;
    /// Empty: the field is skipped.
    std::function<void(client::AxisSnapshot& axis, std::int64_t value)> set{};
  };

  static std::optional<Field> field_of(std::string_view line);
  static void decode_array(const Field& field, wire::CdrReader& reader,
                           std::vector<client::AxisSnapshot>& axes);

  std::vector<Field> fields_;
};

}  // namespace vdrive::recording
