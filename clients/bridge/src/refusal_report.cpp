// SPDX-License-Identifier: Apache-2.0
#include "refusal_report.hpp"

#include "vdrive/dictionary/abort_code.hpp"

namespace vdrive::bridge {

std::optional<std::string> refusal_report(const client::Event& event, std::uint64_t own) {
  constexpr std::uint32_t kControlled = wire_code(AbortCode::refused_local_control);
  if (event.kind != client::EventKind::refused || event.session != own) return std::nullopt;
  if (event.code == kControlled) return std::nullopt;
  // Without what differs from command to command.
  const std::string text = event.text.substr(0, event.text.rfind(" (session "));
  return "a command was refused: " + text.substr(0, text.find(", late by "));
}

}  // namespace vdrive::bridge
