// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace vdrive::service {

/// Runs a wire in its own process: `vdrived --wire-process DESCRIPTOR`, started by the service
/// only. Ends with the engine, when the engine orders it, or by a fault of the DDS library.
/// @param region descriptor of the memory shared with the engine
/// @return exit code: 0 if ended by the engine; 1 if it could not start, with the reason in the
///         region
int run_wire_process(int region);

}  // namespace vdrive::service
