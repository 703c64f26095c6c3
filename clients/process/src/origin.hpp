// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/origin.hpp"

namespace vdrive::process {

/// What a forked process may not touch, for clients that name no wire.
using wire::made_here;
using wire::Origin;

}  // namespace vdrive::process
