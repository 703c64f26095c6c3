// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace vdrive {

/// True when the program checks its own invariants: in every Debug build and in every build with
/// tests or fuzzers (VDRIVE_ASSERTS in CMake), but not in a release built without tests.
#ifdef VDRIVE_ASSERTS
inline constexpr bool kChecksInvariants = true;
#else
inline constexpr bool kChecksInvariants = false;
#endif

/// Prints `invariant` and its location to standard error and aborts the program.
[[noreturn]] void abort_broken_invariant(const char* invariant, const char* file,
                                         unsigned line) noexcept;

/// Checks an invariant of our own code whose violation would do harm. Bad input from outside is not
/// a bug and is reported as an error.
/// @param invariant the condition that holds, as a sentence: "the index is inside the table"
constexpr void ensure(bool holds, const char* invariant, const char* file = __builtin_FILE(),
                      unsigned line = __builtin_LINE()) noexcept {
  if (kChecksInvariants && !holds) abort_broken_invariant(invariant, file, line);
}

}  // namespace vdrive
