// SPDX-License-Identifier: Apache-2.0
#include "vdrive/client/session_name.hpp"

#include "vdrive/number_text.hpp"

namespace vdrive::client {

std::string to_string(const SessionName& name) {
  std::string where;
  if (name.process != 0) where = "process " + std::to_string(name.process);
  if (!name.host.empty()) where += (where.empty() ? "on " : " on ") + name.host;
  const std::string program = name.program.empty() ? "an unknown program" : name.program;
  return where.empty() ? program : program + " (" + where + ")";
}

std::string owner_text(std::uint64_t session, const std::optional<SessionName>& name) {
  return to_string(name.value_or(SessionName{})) + ", session " + session_text(session);
}

std::string to_string(const AxisOwner& owner) {
  const std::string axis = owner.axis.axis == 0 ? "it" : "axis " + to_string(owner.axis);
  return axis + " is controlled by " + owner_text(owner.session, owner.name);
}

}  // namespace vdrive::client
