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

/// What the benches of a bus have in common.
struct BusParts {
  asio::io_context& loop;
  client::Session& session;
  bridge::Reports& reports;
  Bus& bus;
  NodeStore& store;
};

/// How the nodes of a bench keep control of its axes: a master of a bus cannot ask for it.
/// @param label what reports call the bench
[[nodiscard]] bridge::BenchControl::Options control_options(std::string label);

/// A bench whose time others advance (realtime, freerun, or lock-step with another stepper), behind
/// its nodes. When it is silent or ends its nodes leave the bus; when it is there again they boot.
/// For the thread of the bus.
class BenchDrives final : private NodeDrives {
 public:
  /// @param parts all outlive this
  /// @param places one for each axis of `info`, in their order
  BenchDrives(const BusParts& parts, const client::BenchInfo& info,
              std::span<const NodePlace> places, std::string label);
  ~BenchDrives() override;
  BenchDrives(const BenchDrives&) = delete;
  BenchDrives& operator=(const BenchDrives&) = delete;

  /// The nodes leave the bus.
  /// @return the link, to be destroyed where it may wait for the bench
  [[nodiscard]] std::shared_ptr<void> close();

  [[nodiscard]] const BenchNodes& nodes() const noexcept { return nodes_; }

  /// As BenchNodes::note_refused_set_points().
  void note_refused_set_points(std::uint16_t axis, std::uint64_t count) {
    nodes_.note_refused_set_points(axis, count);
  }

  /// @return set-points that did not reach the bench.
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

  /// @return what has the loop call `action` with these drives and its own arguments, from any
  ///         thread; unless they have ended.
  template <typename Action>
  [[nodiscard]] auto in_loop(Action action);

  const BusParts parts_;
  const std::string label_;
  const std::size_t count_;  ///< of axes
  BenchNodes nodes_;
  /// What is posted to the loop does nothing once this has ended.
  std::shared_ptr<BenchDrives*> self_;
  std::shared_ptr<Link> link_;  ///< last: its threads post to the loop
};

}  // namespace vdrive::canopen
