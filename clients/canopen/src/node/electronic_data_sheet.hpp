// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/node_host.hpp"
#include "node/node_object.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace vdrive::canopen {

/// The contents of an electronic data sheet apart from the objects of a node. Each text is one line
/// of ASCII without ';' and '#'.
struct DataSheetSettings {
  std::string_view file_name = "vdrive.eds";
  std::string_view program_version = "0";
  std::string_view date = "11-26-2026";  ///< of creation and modification: month-day-year
  std::string_view time = "08:00AM";     ///< hours:minutes
  /// The node id, 1 to 127: makes the sheet the device configuration file of this node, with
  /// COB-IDs as plain numbers for readers that do not know "$NODEID". None = valid for every node
  /// id.
  std::optional<std::uint8_t> node_id{};
  /// Objects of the drive whose defaults differ from those of the dictionary.
  std::span<const DriveValue> values{};
};

/// The electronic data sheet of a node (CiA 306-1), which a master reads instead of the node's
/// dictionary. It lists every object of node_objects(). Equal settings give identical bytes.
/// @return ASCII text; lines end with a line feed.
[[nodiscard]] std::string electronic_data_sheet(const DataSheetSettings& settings);

/// @return the data type as CiA 301 spells it, such as "UNSIGNED16".
[[nodiscard]] std::string_view type_text(NodeDataType type) noexcept;

/// @return the AccessType of CiA 306: "ro", "wo", "const" or "rw". With PDOMapping=1, "rw" allows
///         PDOs in both directions.
[[nodiscard]] std::string_view access_text(const NodeObject& object) noexcept;

}  // namespace vdrive::canopen
