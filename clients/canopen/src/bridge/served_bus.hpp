// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bridge/bench_drives.hpp"
#include "bridge/node_ids.hpp"
#include "bridge/node_store.hpp"
#include "bridge/settings.hpp"
#include "bridge/stepped_bench.hpp"
#include "bus/ascii_gateway_server.hpp"
#include "bus/bus.hpp"
#include "bus/bus_log.hpp"
#include "bus/socket_can.hpp"
#include "bus/socketcand_server.hpp"
#include "roster.hpp"
#include "worker.hpp"

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::canopen {

/// Parts shared by all buses of the program.
struct BridgeParts {
  asio::io_context& loop;
  client::Session& session;
  bridge::Reports& reports;
  bridge::Worker& closer;  ///< destroys links, which may block on benches that have gone
};

/// A bus with its connections, and the benches whose axes are its nodes. For the thread of the
/// loop.
class ServedBus final : public BusHost, private bridge::BenchHost {
 public:
  using Clock = bridge::Roster::Clock;

  /// Opens the connections.
  /// @param shared all parts outlive this object
  /// @param number from 1, for messages and CiA 309-3
  /// @throws std::runtime_error when a connection cannot be opened, with its address and the reason
  ServedBus(const BridgeParts& shared, const Settings& settings, const BusSetting& setting,
            std::uint16_t number);
  ~ServedBus() override;
  ServedBus(const ServedBus&) = delete;
  ServedBus& operator=(const ServedBus&) = delete;

  /// Adds new benches, and drops those that have gone.
  void find(const std::vector<client::BenchInfo>& present, Clock::time_point now);

  [[nodiscard]] Bus& bus() noexcept { return bus_; }

  /// @return the address of the first socketcand or CiA 309-3 server; nothing if there is none.
  [[nodiscard]] std::optional<TcpAddress> socketcand() const;
  [[nodiscard]] std::optional<TcpAddress> gateway() const;

  /// @return the nodes of a bench; nullptr if it is not served.
  [[nodiscard]] const BenchNodes* nodes(std::uint32_t bench) const;

  /// @return whether the nodes of every bench named in the settings are present.
  [[nodiscard]] bool are_all_there() const;

  /// Counts and reports values of RPDOs that a drive has refused. Refusals of other buses are
  /// ignored.
  void note_refused_set_points(const client::SetPointRefusal& refusal, std::uint64_t count);

  /// @return one line for each bench that is left out, with the reason.
  [[nodiscard]] std::vector<std::string> left_out() const;

  /// @return such as "bus 1: 3 nodes (1 to 3), socketcand 127.0.0.1:29536, no gateway". It names
  ///         absent kinds of server too, because setting up one kind switches the default one off.
  [[nodiscard]] std::string description() const;

  /// Flushes the log of the bus.
  /// @return the number of frames missing from it
  [[nodiscard]] std::uint64_t flush_log() { return log_ ? log_->flush() : 0; }

  /// @return such as "bus 1: 1234 frames, ...".
  [[nodiscard]] std::string counters() const;

 private:
  /// One of the two pointers is set.
  struct ServedBench {
    std::unique_ptr<BenchDrives> drives{};
    std::unique_ptr<SteppedBench> stepped{};

    [[nodiscard]] const BenchNodes& nodes() const {
      return drives ? drives->nodes() : stepped->nodes();
    }
  };

  void report(bridge::Severity severity, const std::string& port, const std::string& text) override;
  [[nodiscard]] std::chrono::microseconds frame_time() const override;
  [[nodiscard]] std::optional<std::string> disturb(std::uint8_t node,
                                                   std::string_view text) override;
  void open_ports();
  [[nodiscard]] std::int32_t offset_of(std::uint32_t bench) const;
  [[nodiscard]] bool continues(const client::BenchInfo& known,
                               const client::BenchInfo& found) const override;
  std::optional<std::string> add(const client::BenchInfo& info) override;
  void leave_out(const client::BenchInfo& info, const std::string& reason) override;
  void remove(std::uint32_t bench, bool is_replaced) override;
  [[nodiscard]] std::chrono::microseconds drive_time() const;
  [[nodiscard]] DriveTime fault_time() const;
  void report(bridge::Severity severity, std::uint32_t bench, const std::string& text) const;

  const BridgeParts shared_;
  const BusSetting setting_;
  const std::optional<std::chrono::microseconds> sync_steps_;
  const std::string label_;  ///< such as "bus 1"
  const std::uint16_t number_;
  Bus bus_;
  NodeStore store_;
  NodeIds ids_;
  bridge::Roster roster_;
  std::map<std::uint32_t, ServedBench> benches_;
  NodeCounters ended_;                    ///< of benches that have gone
  std::uint64_t dropped_set_points_ = 0;  ///< of benches that have gone
  std::unique_ptr<BusLog> log_;
  std::vector<std::unique_ptr<SocketcandServer>> socketcand_;
  std::vector<std::unique_ptr<AsciiGatewayServer>> gateways_;
  std::vector<std::unique_ptr<SocketCan>> interfaces_;
};

}  // namespace vdrive::canopen
