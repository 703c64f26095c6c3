// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/session.hpp"

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <vector>

namespace vdrive::bridge {

/// A bench as a bridge found it last.
struct BenchRecord {
  using Clock = std::chrono::steady_clock;

  client::BenchInfo info;
  bool is_alive = true;             ///< its samples arrive
  bool is_offline = false;          ///< it announced its end
  Clock::time_point newest_sample;  ///< when its newest sample came
};

/// What became of a bench.
struct PresenceChange {
  enum class Kind : std::uint8_t {
    came,
    renewed,   ///< another run of it, which takes the place of the one before
    replaced,  ///< it went, because another one comes in its place
    went,
  };

  Kind kind = Kind::came;
  std::uint32_t bench = 0;
};

/// Which benches a bridge serves. Time is an argument. Thread-safe.
class Presence {
 public:
  using Clock = BenchRecord::Clock;

  struct Rules {
    /// Whether a bench that was found takes the place of the known one; else the known one goes,
    /// and the found one comes.
    std::function<bool(const client::BenchInfo& known, const client::BenchInfo& found)> continues;
    std::vector<std::uint32_t> wanted{};       ///< numbers of benches; empty = every bench
    Clock::duration patience{kUsualPatience};  ///< a bench that is silent for longer goes
  };

  static constexpr std::chrono::minutes kUsualPatience{1};

  explicit Presence(Rules rules) : rules_(std::move(rules)) {}

  /// Compares the benches that are there with those that are known. One without axes counts as
  /// none.
  /// @return what changed, in this order: a bench that is replaced goes before it comes.
  std::vector<PresenceChange> take(std::vector<client::BenchInfo> found, Clock::time_point now);

  /// Takes what was found of the known benches, and changes none.
  void refresh(std::vector<client::BenchInfo> found, Clock::time_point now);

  /// A bench started or stopped sending. One that announced its end goes with the next take().
  void note(const client::ServiceChange& change, Clock::time_point now);

  /// @return what is known of a bench; none of one that is not served.
  [[nodiscard]] std::optional<BenchRecord> find(std::uint32_t bench) const;

  /// @return all of them, by number.
  [[nodiscard]] std::vector<BenchRecord> all() const;

 private:
  using Changes = std::vector<PresenceChange>;

  void take_one(client::BenchInfo&& found, Clock::time_point now, Changes& changes);
  void remove_ended(Clock::time_point now, Changes& changes);

  const Rules rules_;
  mutable std::mutex mutex_;
  std::map<std::uint32_t, BenchRecord> benches_;
};

}  // namespace vdrive::bridge
