// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/service/queues.hpp"

#include <string>

namespace vdrive::service {

/// @return what happened, in words; at most 200 bytes.
[[nodiscard]] std::string words_of(const EventRecord& event);

}  // namespace vdrive::service
