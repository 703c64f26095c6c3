// SPDX-License-Identifier: Apache-2.0
#pragma once

// The complete client library: sessions, axes, groups, clocks, outcomes.

#include "vdrive/client/axis.hpp"
#include "vdrive/client/axis_group.hpp"
#include "vdrive/client/axis_snapshot.hpp"
#include "vdrive/client/bench.hpp"
#include "vdrive/client/command_words.hpp"
#include "vdrive/client/disturbance.hpp"
#include "vdrive/client/event.hpp"
#include "vdrive/client/outcome.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/client/session_name.hpp"
#include "vdrive/client/step_clock.hpp"
