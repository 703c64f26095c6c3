// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace vdrive::service {

/// A wire as a process of its own: `vdrived --wire-process DESCRIPTOR`, started by the service
/// only. Ends with the engine, at its order, or with a fault of the DDS library.
/// @param region descriptor of the memory that it shares with the engine
/// @return exit code: 0 at the engine's order, 1 when it could not start; the region has the reason
int run_wire_process(int region);

}  // namespace vdrive::service
