// SPDX-License-Identifier: Apache-2.0
// `store` and `restore`: the stored parameters of an axis. A service without a state directory
// refuses both.
#include "execution/axis_action.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <string>

namespace vdrive::tool {
namespace {

/// The service stores the parameters in a file of this name (docs/guides/configuration.md). Only
/// the service knows the directory of the file.
Field file_field(const client::Axis& axis, const std::string& end) {
  const std::string bench = std::to_string(axis.id().bench);
  const std::string file = "bench-" + bench + ".parameters";
  return {"file", file,
          "in " + file + " in the state directory of the service of bench " + bench + end};
}

/// Storing does not wait for drive time to pass.
client::Outcome store_parameters(client::Axis& axis) {
  return axis.store();
}

client::Outcome restore_parameters(client::Axis& axis) {
  return axis.restore_defaults();
}

Record stored(const client::Axis& axis) {
  return {{"objects", kStoredRows.size(),
           "stored " + std::to_string(kStoredRows.size()) + " parameters"},
          {"group", "1010h:01", "(1010h:01)"},
          file_field(axis, "")};
}

Record restored(const client::Axis& axis) {
  return {{"group", "1011h:01", "no stored parameters (1011h:01) are left"},
          file_field(axis, "; the configured values are in force after the next power cycle")};
}

constexpr AxisAction kStoreAction{
    .name = "store", .each = store_parameters, .result_record = stored};
constexpr AxisAction kRestoreAction{
    .name = "restore", .each = restore_parameters, .result_record = restored};

}  // namespace

extern const CommandRow kStore = action_row<kStoreAction>(
    CommandGroup::parameters, "Store the parameters for every later power-up", "store 1.1");
extern const CommandRow kRestore = action_row<kRestoreAction>(
    CommandGroup::parameters,
    "Remove stored parameters; defaults are in force after the next power cycle", "restore 1.1");

}  // namespace vdrive::tool
