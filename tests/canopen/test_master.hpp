// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bus/bus.hpp"
#include "node/frame.hpp"
#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/dictionary/object.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <optional>
#include <vector>

namespace vdrive::test {

/// A test master: a port that sends frames and records those it receives.
class TestMaster final : public canopen::Port {
 public:
  /// @param work lets the bridge do its pending work, or waits briefly
  TestMaster(canopen::Bus& bus, std::function<void()> work);
  ~TestMaster() override;
  TestMaster(const TestMaster&) = delete;
  TestMaster& operator=(const TestMaster&) = delete;

  void deliver(const canopen::Frame& frame) override { received_.push_back(frame); }

  // ---- frames

  void send(std::uint32_t id, const std::vector<std::uint8_t>& data);
  void send_nmt(std::uint8_t command, std::uint8_t node);

  void send_sync() { send(0x080, {}); }

  /// All frames since the last take_all(), in their order.
  [[nodiscard]] const std::vector<canopen::Frame>& received() const noexcept { return received_; }

  [[nodiscard]] std::vector<canopen::Frame> take_all();

  /// @return the latest frame with this identifier since the last take_all().
  [[nodiscard]] std::optional<canopen::Frame> newest(std::uint32_t id) const;

  [[nodiscard]] std::size_t count(std::uint32_t id) const;

  /// Calls `work` until `condition` holds.
  /// @return false after 60 s.
  [[nodiscard]] bool wait_until(const std::function<bool()>& condition);

  [[nodiscard]] bool wait_for(std::uint32_t id);

  // ---- SDO

  struct Upload {
    AbortCode abort = AbortCode::none;
    std::vector<std::uint8_t> data{};  ///< least byte first

    /// @return the data as a number with or without a sign
    [[nodiscard]] std::int64_t number(bool is_signed = false) const;
  };

  /// Expedited or segmented, as the node chooses.
  Upload upload(std::uint8_t node, ObjectAddress object);

  /// @param size bytes of the object, 1 to 4
  AbortCode download(std::uint8_t node, ObjectAddress object, std::int64_t value, std::size_t size);

 private:
  using Bytes = std::vector<std::uint8_t>;

  [[nodiscard]] std::optional<canopen::Frame> exchange(std::uint8_t node, const Bytes& request);

  canopen::Bus& bus_;
  const std::function<void()> work_;
  std::vector<canopen::Frame> received_;
};

/// @return the bytes of a number, least significant first.
[[nodiscard]] std::vector<std::uint8_t> little_endian(std::int64_t value, std::size_t size);

/// @return the number encoded in these bytes of a frame.
[[nodiscard]] std::int64_t number_in(const canopen::Frame& frame, std::size_t first,
                                     std::size_t size, bool is_signed = false);

}  // namespace vdrive::test
