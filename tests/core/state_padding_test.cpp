// SPDX-License-Identifier: Apache-2.0
// State goes into snapshots as it lies in memory. This file is compiled, and that is the test: a
// byte of the state without a value is an error. core_axis_bank_test compares the bytes of
// snapshots.
#include "vdrive/axis_configuration.hpp"
#include "vdrive/axis_status.hpp"  // status_digest.cpp checks the image
#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/dictionary/object_table.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

// The headers above describe configurations and members, which no snapshot has.
#pragma GCC diagnostic error "-Wpadded"

#include "bank/parameter_memory.hpp"
#include "drive/state.hpp"
#include "plant/effects.hpp"
#include "plant/load_noise.hpp"
