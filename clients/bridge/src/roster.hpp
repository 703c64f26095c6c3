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

/// A bench as the bridge last found it.
struct BenchRecord {
  using Clock = std::chrono::steady_clock;

  client::BenchInfo info;
  bool is_alive = true;             ///< its samples arrive
  bool is_offline = false;          ///< it announced its end
  Clock::time_point newest_sample;  ///< when its newest sample arrived
  bool is_served = false;
  std::string left_out{};  ///< why it is not served; empty = it is, or it is not there now
};

/// How a bridge handles benches that appear and disappear. Called by Roster::take().
class BenchHost {
 public:
  virtual ~BenchHost() = default;

  /// Must not call the roster.
  /// @return whether a bench that was found continues the known one; otherwise the known one is
  ///         removed and the found one added.
  [[nodiscard]] virtual bool continues(const client::BenchInfo& known,
                                       const client::BenchInfo& found) const = 0;

  /// Starts serving a bench.
  /// @return nothing, or why the bench cannot be served. It is then left out, and added again at
  ///         each take() while it is there, because another bench may have freed what it needs.
  virtual std::optional<std::string> add(const client::BenchInfo& bench) = 0;

  /// The bench is left out; called once per reason.
  virtual void leave_out(const client::BenchInfo& /*bench*/, const std::string& /*reason*/) {}

  /// A bench being served continues as another run.
  virtual void renew(const client::BenchInfo& /*bench*/) {}

  /// A bench that was served has gone.
  /// @param is_replaced another one with its number follows
  virtual void remove(std::uint32_t bench, bool is_replaced) = 0;
};

/// The benches that a bridge serves, and those that it leaves out. Time is passed as an argument.
/// Thread-safe, except that take() is for one thread.
class Roster {
 public:
  using Clock = BenchRecord::Clock;

  /// A bench that is silent for longer is removed.
  static constexpr std::chrono::minutes kPatience{1};

  /// @param host must outlive this
  /// @param wanted numbers of benches; empty = every bench
  explicit Roster(BenchHost& host, std::vector<std::uint32_t> wanted = {})
      : host_(host), wanted_(std::move(wanted)) {}

  /// Compares the benches found with the known ones and passes the differences to the host: first
  /// the renewed benches, then those that have gone, then the new ones. A bench without axes does
  /// not count.
  /// @return whether a bench was added, removed or renewed.
  bool take(std::vector<client::BenchInfo> found, Clock::time_point now);

  /// Updates the information about known benches, without adding or removing any.
  void refresh(std::vector<client::BenchInfo> found, Clock::time_point now);

  /// Records that a bench started or stopped sending. One that announced its end is removed by the
  /// next take().
  void note(const client::ServiceChange& change, Clock::time_point now);

  /// @return the record of a bench; nothing if it has gone.
  [[nodiscard]] std::optional<BenchRecord> find(std::uint32_t bench) const;

  /// @return all records, by number.
  [[nodiscard]] std::vector<BenchRecord> all() const;

  /// @return why present benches are left out, by number.
  [[nodiscard]] std::map<std::uint32_t, std::string> left_out() const;

 private:
  /// The changes to pass to the host.
  struct Changes {
    std::vector<std::pair<std::uint32_t, bool>> ended;  ///< and whether another one follows
    std::vector<client::BenchInfo> renewed;
    std::vector<client::BenchInfo> unserved;  ///< present benches
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
