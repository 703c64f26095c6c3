// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/session.hpp"

#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::bridge {

/// A bench as a bridge found it last.
struct BenchRecord {
  using Clock = std::chrono::steady_clock;

  client::BenchInfo info;
  bool is_alive = true;             ///< its samples arrive
  bool is_offline = false;          ///< it announced its end
  Clock::time_point newest_sample;  ///< when its newest sample came
  bool is_served = false;
  std::string left_out{};  ///< why it is not served; empty = it is, or it is not there now
};

/// What a bridge does with the benches that come and go. Called by Roster::take().
class BenchHost {
 public:
  virtual ~BenchHost() = default;

  /// May not call the roster.
  /// @return whether a bench that was found takes the place of the known one; else the known one
  ///         goes, and the found one comes.
  [[nodiscard]] virtual bool continues(const client::BenchInfo& known,
                                       const client::BenchInfo& found) const = 0;

  /// Serves a bench from now on.
  /// @return why it cannot; then the bench is left out, and offered again as long as it is there:
  ///         another one may have left what it needs.
  virtual std::optional<std::string> add(const client::BenchInfo& bench) = 0;

  /// The bench is left out; called once for each reason.
  virtual void leave_out(const client::BenchInfo& /*bench*/, const std::string& /*reason*/) {}

  /// A bench that is served continues as another run.
  virtual void renew(const client::BenchInfo& /*bench*/) {}

  /// A bench that was served goes.
  /// @param is_replaced another one with its number comes
  virtual void remove(std::uint32_t bench, bool is_replaced) = 0;
};

/// Which benches a bridge serves, and which it leaves out. Time is an argument. Thread-safe, but
/// take() is for one thread.
class Roster {
 public:
  using Clock = BenchRecord::Clock;

  /// A bench that is silent for longer goes.
  static constexpr std::chrono::minutes kPatience{1};

  /// @param host outlives this
  /// @param wanted numbers of benches; empty = every bench
  explicit Roster(BenchHost& host, std::vector<std::uint32_t> wanted = {})
      : host_(host), wanted_(std::move(wanted)) {}

  /// Compares the benches that are there with those that are known, and tells the host what
  /// changed: first what is renewed, then what goes, then what comes. A bench without axes counts
  /// as none.
  /// @return whether a bench came, went or was renewed.
  bool take(std::vector<client::BenchInfo> found, Clock::time_point now);

  /// Takes what was found of the known benches, and changes none.
  void refresh(std::vector<client::BenchInfo> found, Clock::time_point now);

  /// A bench started or stopped sending. One that announced its end goes with the next take().
  void note(const client::ServiceChange& change, Clock::time_point now);

  /// @return what is known of a bench; nothing of one that has gone.
  [[nodiscard]] std::optional<BenchRecord> find(std::uint32_t bench) const;

  /// @return all of them, by number.
  [[nodiscard]] std::vector<BenchRecord> all() const;

  /// @return why benches that are there are left out, by number.
  [[nodiscard]] std::map<std::uint32_t, std::string> left_out() const;

 private:
  /// What the host is to be told.
  struct Changes {
    std::vector<std::pair<std::uint32_t, bool>> ended;  ///< and whether another one comes
    std::vector<client::BenchInfo> renewed;
    std::vector<client::BenchInfo> unserved;  ///< they are there
  };

  [[nodiscard]] bool is_wanted(const client::BenchInfo& found) const;
  [[nodiscard]] Changes compare(std::vector<client::BenchInfo>&& found, Clock::time_point now);
  void compare_one(client::BenchInfo&& found, Clock::time_point now, Changes& changes);
  void remove_ended(Clock::time_point now, Changes& changes);
  [[nodiscard]] bool offer(const client::BenchInfo& bench);

  BenchHost& host_;
  const std::vector<std::uint32_t> wanted_;
  mutable std::mutex mutex_;
  std::map<std::uint32_t, BenchRecord> benches_;
};

}  // namespace vdrive::bridge
