// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/frame.hpp"
#include "node/node.hpp"
#include "node/node_host.hpp"
#include "vdrive/axis.hpp"

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <initializer_list>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace vdrive::judge {

/// A CANopen node with the drive of the core, its master, and the log of their bus in the format of
/// `candump -L`. A frame takes 100 us.
class LoggedNode final : private canopen::NodeHost {
 public:
  static constexpr std::uint8_t kNode = 5;

  LoggedNode();

  // ---- actions of a master
  void nmt(std::uint8_t command, std::uint8_t node = kNode);
  void sync();
  void put_on_bus(std::uint32_t id, std::initializer_list<std::uint8_t> bytes);
  void put_on_bus(const canopen::Frame& frame);

  /// Writes an object by expedited SDO. @return the abort code
  std::uint32_t write(ObjectAddress object, std::int64_t value, std::size_t size);
  /// Reads a number by expedited SDO.
  std::int64_t read(ObjectAddress object);
  /// Sends an RPDO with these numbers, each given with its size [bytes].
  void pdo(std::uint16_t number,
           std::initializer_list<std::pair<std::int64_t, std::size_t>> values);

  /// Sends RPDO 1 with its default mapping.
  void word(std::uint16_t word) { pdo(1, {{word, 2}}); }

  /// Remaps RPDO `number`; entries are index, sub-index and bits as in 1600h.
  void map(std::uint16_t number, std::initializer_list<std::uint32_t> entries,
           std::uint8_t type = 255);

  // ---- time, and what the master sees
  void step(std::uint64_t ticks = 1);
  bool step_until(const std::function<bool()>& done, std::uint64_t deadline = 20'000);
  bool step_until_state(PowerState state);
  bool step_until_bits(std::uint16_t mask, std::uint16_t value);

  /// The statusword of the last TPDO with 6041h.
  [[nodiscard]] std::uint16_t statusword() const noexcept { return statusword_; }

  /// NMT start, mode, and the words up to Operation enabled, by RPDOs 1 and 2; waits after each
  /// step.
  void enable(std::int8_t mode);
  /// A move in profile position with its complete handshake, by RPDOs 1 and 3.
  void move(std::int32_t target);
  void disable();

  [[nodiscard]] const AxisStatus& drive() const { return axis_.status(); }

  [[nodiscard]] const std::vector<canopen::Frame>& frames() const noexcept { return frames_; }

  /// One line per frame.
  [[nodiscard]] const std::string& log() const noexcept { return log_; }

 private:
  void answer();
  void put(const canopen::Frame& frame);
  [[nodiscard]] canopen::DriveView view() const;

  // NodeHost
  void send(const canopen::Frame& frame) override;

  void begin_access(const canopen::DriveAccess& access) override { access_ = access; }

  void command(std::span<const canopen::DriveValue> values) override;
  void set_connection_lost(bool is_lost) override;

  void power_cycle() override { axis_.power_cycle(); }

  bool store(const std::map<ObjectAddress, std::uint32_t>& /*parameters*/) override { return true; }

  Axis axis_;
  std::optional<canopen::Node> node_;
  std::chrono::microseconds now_{1'000'000};  ///< of the drive
  std::chrono::microseconds frame_time_{1'000'000};
  std::optional<canopen::DriveAccess> access_;
  std::optional<canopen::Frame> sdo_answer_;
  std::uint16_t statusword_ = 0;
  std::vector<canopen::Frame> frames_;
  std::string log_;
};

}  // namespace vdrive::judge
