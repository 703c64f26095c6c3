// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/node_object.hpp"
#include "vdrive/dictionary/object.hpp"

#include <cstdint>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

namespace vdrive::canopen {

/// An object as an electronic data sheet describes it.
struct SheetObject {
  std::uint16_t data_type = 0;          ///< number of CiA 301; 0 = not given
  std::optional<std::int64_t> value{};  ///< ParameterValue of a DCF, else DefaultValue
  bool has_node_id = false;             ///< the node id is added to the value ("$NODEID+0x180")

  /// @return the size [bytes] of a number of this type; 0 for a text, a domain and unknown types.
  [[nodiscard]] std::uint8_t size() const noexcept;

  [[nodiscard]] bool is_signed() const noexcept;
};

/// The objects of an electronic data sheet or a device configuration file.
using DataSheet = std::map<ObjectAddress, SheetObject>;

/// The text is not a data sheet: it has no section that describes an object.
class DataSheetError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Reads data sheets from electronic_data_sheet() and from other makers (CiA 306-1): sections such
/// as [6040] and [607Dsub1], with keys in upper or lower case. Skips everything that it does not
/// need.
/// @throws DataSheetError
[[nodiscard]] DataSheet read_data_sheet(std::string_view text);

}  // namespace vdrive::canopen
