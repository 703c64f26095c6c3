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

/// The layout of a status message, derived from the ros2msg text of its schema: an AxisStatus or a
/// BenchStatus of this or another version. Unknown members are skipped, missing ones are 0.
class StatusLayout {
 public:
  /// @throws RecordingError if a field has an unknown type
  explicit StatusLayout(std::string_view schema);

  /// Reads one message.
  /// @param bytes CDR with its encapsulation header
  /// @return one element per axis, without the number of the bench
  /// @throws RecordingError if the bytes do not fit the layout
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
