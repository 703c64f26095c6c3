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

/// Reads the configurations of the private benches, and makes none.
/// @throws settings::ConfigurationError where a bench cannot be made of its options
void check_private_benches(const Settings& settings);

/// The whole bridge: one session for all benches, one thread for all buses, that of loop().
class CanopenBridge final {
 public:
  /// Makes the private benches and opens all connections; nobody boots before start().
  /// @throws std::runtime_error when DDS cannot be set up or a connection cannot be opened,
  ///         bench::BenchError when a private bench cannot be made
  explicit CanopenBridge(const Settings& settings);

  /// The nodes leave their buses without a frame, and the axes are given back as they are.
  ~CanopenBridge();
  CanopenBridge(const CanopenBridge&) = delete;
  CanopenBridge& operator=(const CanopenBridge&) = delete;

  /// Runs everything from start() on, until stop().
  [[nodiscard]] asio::io_context& loop() noexcept { return loop_; }

  /// Looks for benches from now on. Runs the loop until the nodes of the private benches are there,
  /// or the loop is stopped.
  /// @throws settings::ConfigurationError when the axes of a private bench cannot be nodes
  void start();

  /// Ends loop(), and all calls that wait for a bench, in it and elsewhere. Any thread.
  void stop();

  /// @return the number of its session, which an axis shows as its owner.
  [[nodiscard]] std::uint64_t session() const noexcept { return session_.id(); }

  [[nodiscard]] std::size_t count() const noexcept { return buses_.size(); }

  /// @param place from 0, in the order of the settings
  [[nodiscard]] ServedBus& bus(std::size_t place) { return *buses_.at(place); }

  /// @return a line for each bus, without the name of the program.
  [[nodiscard]] std::vector<std::string> first_lines() const;
  [[nodiscard]] std::vector<std::string> counter_lines() const;

  /// Writes what waits for the logs of the buses.
  /// @return false when frames are missing there
  [[nodiscard]] bool flush_logs();

  /// Reports what the log of the DDS library says. Any thread but those that receive.
  void report_library(const std::string& words);

 private:
  void find();
  void find_later();
  void count_refusals();
  [[nodiscard]] bool are_all_there() const;

  asio::io_context loop_{1};  // first: what is posted may outlive who has posted it
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
