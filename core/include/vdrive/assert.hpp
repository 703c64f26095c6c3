// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace vdrive {

/// Whether the invariants of our own code are checked: in every build with tests or fuzzers and in
/// every Debug build (VDRIVE_ASSERTS of CMake); not in a release without tests.
#ifdef VDRIVE_ASSERTS
inline constexpr bool kChecksInvariants = true;
#else
inline constexpr bool kChecksInvariants = false;
#endif

/// Writes `invariant` with its place to standard error and ends the program.
[[noreturn]] void abort_broken_invariant(const char* invariant, const char* file,
                                         unsigned line) noexcept;

/// Our own bug is an assert: what a caller within the program has to hold, and what would do harm
/// if it did not. Bad input is no bug and has its own errors.
/// @param invariant what holds, as a sentence: "the index is inside the table"
constexpr void ensure(bool holds, const char* invariant, const char* file = __builtin_FILE(),
                      unsigned line = __builtin_LINE()) noexcept {
  if (kChecksInvariants && !holds) abort_broken_invariant(invariant, file, line);
}

}  // namespace vdrive
