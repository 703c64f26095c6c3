// SPDX-License-Identifier: Apache-2.0
#include "vdrive/client/event.hpp"

#include "vdrive/wire/event_name.hpp"
#include "vdrive_messages.h"

namespace vdrive::client {

static_assert(static_cast<std::uint32_t>(EventKind::state_changed) == msg::EVENT_STATE_CHANGED);
static_assert(static_cast<std::uint32_t>(EventKind::stopped) == wire::kEventKinds.size(),
              "the last kind of event has a name of the client library");

std::string_view to_string(EventKind kind) noexcept {
  return wire::event_name(static_cast<std::uint32_t>(kind));
}

}  // namespace vdrive::client
