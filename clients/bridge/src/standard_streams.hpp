// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace vdrive::bridge {

/// Opens each closed standard stream, first thing in a program: else a socket or a file gets its
/// number, and is read or written to as if it were the stream. Standard input is then at its end;
/// what is written to the others fails.
void open_standard_streams() noexcept;

}  // namespace vdrive::bridge
