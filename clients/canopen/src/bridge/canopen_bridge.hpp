// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bridge/refused_set_points.hpp"
#include "bridge/served_bus.hpp"
#include "bridge/settings.hpp"
#include "bus/asio.hpp"
#include "reports.hpp"
#include "vdrive/bench/bench.hpp"
#include "vdrive/client/session.hpp"
#include "worker.hpp"

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace vdrive::canopen {

/// Reads the configurations of the private benches without creating them.
/// @throws settings::ConfigurationError if a bench cannot be created from its options
void check_private_benches(const Settings& settings);

/// The bridge: one session for all benches, one thread for all buses, which runs loop().
class CanopenBridge final {
 public:
  /// Creates the private benches and opens all connections; no node boots before start().
  /// @throws std::runtime_error when DDS cannot be set up or a connection cannot be opened,
  ///         bench::BenchError when a private bench cannot be created
  explicit CanopenBridge(const Settings& settings);

  /// The nodes leave their buses without sending a frame, and the axes are released in their
  /// present state.
  ~CanopenBridge();
  CanopenBridge(const CanopenBridge&) = delete;
  CanopenBridge& operator=(const CanopenBridge&) = delete;

  /// Runs everything from start() to stop().
  [[nodiscard]] asio::io_context& loop() noexcept { return loop_; }

  /// Begins to search for benches. Runs the loop until the nodes of the private benches are present
  /// or the loop is stopped.
  /// @throws settings::ConfigurationError when the axes of a private bench cannot be nodes
  void start();

  /// Ends loop(), and every call that waits for a bench, in any thread. Thread-safe.
  void stop();

  /// @return the id of the session, which axes show as their owner.
  [[nodiscard]] std::uint64_t session() const noexcept { return session_.id(); }

  [[nodiscard]] std::size_t count() const noexcept { return buses_.size(); }

  /// @param place from 0, in the order of the settings
  [[nodiscard]] ServedBus& bus(std::size_t place) { return *buses_.at(place); }

  /// @return one line for each bus, without the program's name.
  [[nodiscard]] std::vector<std::string> first_lines() const;
  [[nodiscard]] std::vector<std::string> counter_lines() const;

  /// Flushes the logs of the buses.
  /// @return false if frames are missing from a log
  [[nodiscard]] bool flush_logs();

  /// Reports a log message of the DDS library. For any thread except the receiving ones of DDS.
  void report_library(const std::string& words);

 private:
  void find();
  void find_later();
  void count_refusals();
  [[nodiscard]] bool are_all_there() const;

  asio::io_context loop_{1};  // first: posted functions may outlive the object that posted them
  const bool is_private_;
  std::vector<bench::Bench> benches_;
  bridge::Reports reports_;
  RefusedSetPoints refused_;
  client::Session session_;
  bridge::Worker closer_;
  std::vector<std::unique_ptr<ServedBus>> buses_;
  asio::steady_timer find_timer_;
};

}  // namespace vdrive::canopen
