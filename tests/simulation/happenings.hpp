// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "support/programs/model.hpp"

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>
#include <utility>

namespace vdrive::simulation {

/// The invariants as texts: those of an axis, and those of a service and its masters.
struct Invariant : test::Invariant {
  static constexpr std::string_view kProbe = "touch probes show what they can have seen";
  static constexpr std::string_view kRepeat = "a restored snapshot runs the same ticks again";
  static constexpr std::string_view kOwner = "one owner an axis, of the current epoch";
  static constexpr std::string_view kRevoked = "no command of a revoked epoch is executed";
  static constexpr std::string_view kCommanded = "what is in force was commanded";
  static constexpr std::string_view kAnswered = "every numbered command is answered for once";
  static constexpr std::string_view kWatchdog = "a silent master is lost in time, others never";
  static constexpr std::string_view kStored = "what was stored is there in full, and nothing else";
};

struct Violation {
  std::string invariant;
  std::uint64_t tick = 0;  ///< ticks since the beginning of the seed
  std::uint16_t axis = 0;  ///< 0 = none
  std::string expected;
  std::string seen;
};

/// Everything that happens in a seed, as one hash and, on request, as a trace. Keeps the first
/// violation.
class Happenings {
 public:
  explicit Happenings(std::ostream* trace) : trace_(trace) {}

  void add(std::uint64_t number) {
    hash_ = (hash_ ^ number) * 0x9E3779B97F4A7C15ULL;
    hash_ ^= hash_ >> 29U;
  }

  void record(std::string_view what, std::initializer_list<std::uint64_t> numbers) {
    for (const std::uint64_t number : numbers) add(number);
    if (trace_ != nullptr) {
      *trace_ << "tick " << tick_ << ": " << what;
      for (const std::uint64_t number : numbers) *trace_ << ' ' << number;
      *trace_ << '\n';
    }
  }

  void fail(std::string_view invariant, std::size_t axis, std::string expected, std::string seen) {
    if (!violation_) {
      violation_ = {.invariant = std::string(invariant),
                    .tick = tick_,
                    .axis = static_cast<std::uint16_t>(axis),
                    .expected = std::move(expected),
                    .seen = std::move(seen)};
    }
  }

  void next_tick() { ++tick_; }

  [[nodiscard]] std::uint64_t tick() const { return tick_; }

  [[nodiscard]] std::uint64_t hash() const { return hash_; }

  [[nodiscard]] const std::optional<Violation>& violation() const { return violation_; }

 private:
  std::ostream* trace_;
  std::uint64_t hash_ = 0;
  std::uint64_t tick_ = 0;
  std::optional<Violation> violation_;
};

}  // namespace vdrive::simulation
