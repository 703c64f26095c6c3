// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bridge/bench_link.hpp"
#include "bridge/bench_nodes.hpp"
#include "bus/asio.hpp"
#include "bus/bus.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace vdrive::canopen {

/// What the benches of a bus have in common.
struct BusParts {
  asio::io_context& loop;
  client::Session& session;
  bridge::Reports& reports;
  Bus& bus;
  NodeStore& store;
};

/// A bench whose time others advance (realtime, freerun, or lock-step with another stepper), behind
/// its nodes. When it is silent or ends its nodes leave the bus; when it is there again they boot.
/// For the thread of the bus.
class BenchDrives final {
 public:
  /// @param parts all outlive this
  /// @param places one for each axis of `info`, in their order
  BenchDrives(const BusParts& parts, const client::BenchInfo& info,
              std::span<const NodePlace> places, std::string label);
  ~BenchDrives();
  BenchDrives(const BenchDrives&) = delete;
  BenchDrives& operator=(const BenchDrives&) = delete;

  /// The nodes leave the bus.
  /// @return the link, to be destroyed where it may wait for the bench
  [[nodiscard]] std::unique_ptr<BenchLink> close();

  [[nodiscard]] const BenchNodes& nodes() const noexcept { return nodes_; }

  /// As BenchNodes::note_refused_set_points().
  void note_refused_set_points(std::uint16_t axis, std::uint64_t count) {
    nodes_.note_refused_set_points(axis, count);
  }

  /// @return set-points that did not reach the bench.
  [[nodiscard]] std::uint64_t dropped_set_points() const;

 private:
  [[nodiscard]] BenchNodes::Calls calls_of_nodes();
  void take_news();
  void read(std::size_t place, std::uint32_t ticket, const std::vector<ObjectAddress>& objects);
  void report(bridge::Severity severity, const std::string& text) const;

  const BusParts parts_;
  const std::string label_;
  const std::size_t count_;  ///< of axes
  BenchNodes nodes_;
  /// What is posted to the loop does nothing once this has ended.
  std::shared_ptr<BenchDrives*> self_;
  std::unique_ptr<BenchLink> link_;  ///< last: its threads post to the loop
};

}  // namespace vdrive::canopen
