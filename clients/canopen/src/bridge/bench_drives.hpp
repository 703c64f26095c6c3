// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench_control.hpp"
#include "bridge/bench_nodes.hpp"
#include "bus/asio.hpp"
#include "bus/bus.hpp"
#include "reports.hpp"
#include "vdrive/client/session.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace vdrive::canopen {

/// Parts shared by the benches of a bus.
struct BusParts {
  asio::io_context& loop;
  client::Session& session;
  bridge::Reports& reports;
  Bus& bus;
  NodeStore& store;
};

/// How the nodes of a bench keep control of its axes: a CAN bus master has no way to request it.
/// @param label the name of the bench in reports
[[nodiscard]] bridge::BenchControl::Options control_options(std::string label);

/// Connects nodes to a bench whose time is advanced by others (realtime, freerun, or lock-step with
/// another stepper). When the bench falls silent or ends, its nodes leave the bus; when it returns,
/// they boot. For the thread of the bus.
class BenchDrives final : private NodeDrives {
 public:
  /// @param parts all outlive this object
  /// @param places one for each axis of `info`, in the same order
  BenchDrives(const BusParts& parts, const client::BenchInfo& info,
              std::span<const NodePlace> places, std::string label);
  ~BenchDrives() override;
  BenchDrives(const BenchDrives&) = delete;
  BenchDrives& operator=(const BenchDrives&) = delete;

  /// Takes the nodes off the bus.
  /// @return the link. Destroying it may block on the bench, so destroy it in another thread.
  [[nodiscard]] std::shared_ptr<void> close();

  [[nodiscard]] const BenchNodes& nodes() const noexcept { return nodes_; }

  /// See BenchNodes::note_refused_set_points().
  void note_refused_set_points(std::uint16_t axis, std::uint64_t count) {
    nodes_.note_refused_set_points(axis, count);
  }

  /// @return the number of set-points that did not reach the bench.
  [[nodiscard]] std::uint64_t dropped_set_points() const;

 private:
  class Link;

  void access(std::size_t place, const DriveAccess& access) override;
  void tell_connection(std::size_t place, bool is_lost) override;
  void cycle_power(std::size_t place) override;
  void note_set_points() override;
  void read(std::size_t place, std::uint32_t ticket,
            const std::vector<ObjectAddress>& objects) override;
  void take_news();

  /// @return a function that makes the loop call `action` with these drives and its own arguments.
  ///         It may be called by any thread, and does nothing once the drives have been destroyed.
  template <typename Action>
  [[nodiscard]] auto in_loop(Action action);

  const BusParts parts_;
  const std::string label_;
  const std::size_t count_;  ///< number of axes
  BenchNodes nodes_;
  /// Empty once this object is destroyed: posted functions then do nothing.
  std::shared_ptr<BenchDrives*> self_;
  std::shared_ptr<Link> link_;  ///< last: its threads post to the loop
};

}  // namespace vdrive::canopen
