// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/cob_id.hpp"
#include "node/frame.hpp"
#include "node/node_host.hpp"
#include "node/pdo_parameters.hpp"
#include "node/pdos.hpp"
#include "vdrive/axis_status.hpp"
#include "vdrive/dictionary/abort_code.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace vdrive::canopen {

/// Node id in the PDO tests.
inline constexpr std::uint8_t kPdoNode = 5;

/// A host that records the actions of the PDOs.
class RecordingPdoHost final : public PdoHost {
 public:
  void send(const Frame& frame) override {
    frames.push_back(frame);
    commands_before_last_frame = commands.size();
  }

  void command(std::span<const DriveValue> values, std::uint8_t /*pdos*/) override {
    commands.emplace_back(values.begin(), values.end());
  }

  void raise(std::uint16_t error_code) override { errors.push_back(error_code); }

  std::vector<Frame> frames;
  std::vector<std::vector<DriveValue>> commands;
  std::vector<std::uint16_t> errors;
  std::size_t commands_before_last_frame = 0;
};

inline PdoPlace pdo_place(std::uint8_t number) {
  return {.number = number, .node_id = kPdoNode};
}

inline Frame pdo_frame(std::uint32_t id, const std::vector<std::uint8_t>& bytes = {}) {
  Frame frame{.id = id, .size = static_cast<std::uint8_t>(bytes.size())};
  std::ranges::copy(bytes, frame.data.begin());
  return frame;
}

inline Frame pdo_request(std::uint32_t id) {
  return {.id = id, .is_remote = true, .size = 2};
}

/// @return the data of the frame; empty if there is none.
inline std::vector<std::uint8_t> pdo_bytes(const std::optional<Frame>& frame) {
  if (!frame) return {};
  return {frame->bytes().begin(), frame->bytes().end()};
}

inline DriveValue drive_value(std::uint16_t index, std::int64_t value) {
  return {.object = {.index = index, .subindex = 0}, .value = value};
}

/// @return the mapping entry of an object of this length [bits].
constexpr std::uint32_t map_entry(std::uint32_t index, std::uint32_t subindex, std::uint32_t bits) {
  return (index << 16U) | (subindex << 8U) | bits;
}

inline constexpr std::uint32_t kMapControlword = map_entry(0x6040, 0, 16);
inline constexpr std::uint32_t kMapMode = map_entry(0x6060, 0, 8);
inline constexpr std::uint32_t kMapTargetTorque = map_entry(0x6071, 0, 16);
inline constexpr std::uint32_t kMapTargetPosition = map_entry(0x607A, 0, 32);
inline constexpr std::uint32_t kMapProfileVelocity = map_entry(0x6081, 0, 32);
inline constexpr std::uint32_t kMapTargetVelocity = map_entry(0x60FF, 0, 32);
inline constexpr std::uint32_t kMapStatusword = map_entry(0x6041, 0, 16);
inline constexpr std::uint32_t kMapModeDisplay = map_entry(0x6061, 0, 8);
inline constexpr std::uint32_t kMapPosition = map_entry(0x6064, 0, 32);
inline constexpr std::uint32_t kMapVelocity = map_entry(0x606C, 0, 32);
inline constexpr std::uint32_t kMapDigitalInputs = map_entry(0x60FD, 0, 32);

/// @return a status with this statusword (6041h) and position (6064h).
inline AxisStatus pdo_status(std::uint16_t statusword, std::int32_t position = 0) {
  AxisStatus status;
  status.ds402_statusword = statusword;
  status.load_position_actual_value = position;
  return status;
}

/// Follows CiA 301, 7.5.2.36: PDO not valid, count 0, entries, count, PDO valid.
/// @param parameters index of the communication parameter
template <typename Target>
void remap_pdo(Target& target, std::uint16_t parameters,
               const std::vector<std::uint32_t>& entries) {
  const auto mapping = static_cast<std::uint16_t>(parameters + 0x200);
  const std::uint32_t cob_id = target.read({parameters, 1}) & ~kCobIdNotValid;
  ASSERT_EQ(target.write({parameters, 1}, cob_id | kCobIdNotValid), AbortCode::none);
  ASSERT_EQ(target.write({mapping, 0}, 0), AbortCode::none);
  std::uint8_t subindex = 0;
  for (const std::uint32_t entry : entries) {
    ++subindex;
    ASSERT_EQ(target.write({mapping, subindex}, entry), AbortCode::none);
  }
  ASSERT_EQ(target.write({mapping, 0}, subindex), AbortCode::none);
  ASSERT_EQ(target.write({parameters, 1}, cob_id), AbortCode::none);
}

}  // namespace vdrive::canopen
