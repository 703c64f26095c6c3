// SPDX-License-Identifier: Apache-2.0
#include "execution/parameter_memory.hpp"

namespace vdrive::tool {
namespace {

/// The service names it so (docs/guides/configuration.md); only the service knows its directory.
std::string file_of(const client::Axis& axis) {
  return "bench-" + std::to_string(axis.id().bench) + ".parameters";
}

}  // namespace

std::string memory_text(const client::Axis& axis) {
  return file_of(axis) + " in the state directory of the service of bench " +
         std::to_string(axis.id().bench);
}

Json memory_json(const client::Axis& axis, std::string_view group) {
  return {{"group", group}, {"file", file_of(axis)}};
}

}  // namespace vdrive::tool
