// SPDX-License-Identifier: Apache-2.0
// State goes into snapshots as it lies in memory. Compiling this file is the test: a padding byte
// in the state, which has no value, is an error. core_axis_bank_test compares the bytes of
// snapshots.
#include "vdrive/axis_configuration.hpp"
#include "vdrive/axis_status.hpp"  // status_digest.cpp checks the image
#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/dictionary/object_table.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

// Only from here on: the headers above describe configurations, which no snapshot contains.
#pragma GCC diagnostic error "-Wpadded"

#include "bank/parameter_memory.hpp"
#include "drive/state.hpp"
#include "plant/effects.hpp"
#include "plant/load_noise.hpp"
