// SPDX-License-Identifier: Apache-2.0
#include "canopen/test_master.hpp"

#include "support/deadline.hpp"

#include <algorithm>
#include <chrono>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

namespace vdrive::test {
namespace {

using canopen::Frame;

constexpr std::chrono::seconds kMasterPatience{60};

std::int64_t number_of(std::span<const std::uint8_t> bytes, bool is_signed) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) value |= std::uint64_t{bytes[i]} << (8 * i);
  const bool is_negative = is_signed && !bytes.empty() && (bytes.back() & 0x80U) != 0;
  const auto range = std::int64_t{1} << (8 * bytes.size());
  return static_cast<std::int64_t>(value) - (is_negative ? range : 0);
}

Frame frame_of(std::uint32_t id, const std::vector<std::uint8_t>& data) {
  Frame frame{.id = id, .size = static_cast<std::uint8_t>(data.size())};
  std::ranges::copy(data, frame.data.begin());
  return frame;
}

}  // namespace

TestMaster::TestMaster(canopen::Bus& bus, std::function<void()> work)
    : bus_(bus), work_(std::move(work)) {
  bus_.attach(*this);
}

TestMaster::~TestMaster() {
  bus_.detach(*this);
}

void TestMaster::send(std::uint32_t id, const std::vector<std::uint8_t>& data) {
  bus_.send(frame_of(id, data), this);
}

void TestMaster::send_nmt(std::uint8_t command, std::uint8_t node) {
  send(0x000, {command, node});
}

std::vector<Frame> TestMaster::take_all() {
  return std::exchange(received_, {});
}

std::optional<Frame> TestMaster::newest(std::uint32_t id) const {
  const auto found = std::find_if(received_.rbegin(), received_.rend(), [id](const Frame& frame) {
    return frame.id == id;
  });
  if (found == received_.rend()) return std::nullopt;
  return *found;
}

std::size_t TestMaster::count(std::uint32_t id) const {
  return static_cast<std::size_t>(std::ranges::count(received_, id, &Frame::id));
}

bool TestMaster::wait_until(const std::function<bool()>& condition) {
  const auto deadline = std::chrono::steady_clock::now() + kMasterPatience;
  while (!condition()) {
    if (std::chrono::steady_clock::now() >= deadline) {
      report_missed_deadline("frames of nodes", kMasterPatience);
      return false;
    }
    work_();
  }
  return true;
}

bool TestMaster::wait_for(std::uint32_t id) {
  return wait_until([this, id] {
    return newest(id).has_value();
  });
}

// ---- SDO (CiA 301, 7.2.4.3) ------------------------------------------------------------------

std::optional<Frame> TestMaster::exchange(std::uint8_t node, const Bytes& request) {
  const std::uint32_t answer = 0x580U + node;
  std::erase_if(received_, [answer](const Frame& frame) {
    return frame.id == answer;
  });
  send(0x600U + node, request);
  if (!wait_for(answer)) return std::nullopt;
  return newest(answer);
}

TestMaster::Upload TestMaster::upload(std::uint8_t node, ObjectAddress object) {
  const Bytes index = little_endian(object.index, 2);
  auto answer = exchange(node, {0x40, index[0], index[1], object.subindex, 0, 0, 0, 0});
  if (!answer) throw std::runtime_error("node " + std::to_string(node) + " does not answer");
  if (answer->data[0] == 0x80) return {.abort = static_cast<AbortCode>(number_in(*answer, 4, 4))};
  if ((answer->data[0] & 0x02U) != 0) {  // expedited; n = number of unused bytes
    const std::size_t size = 4 - ((answer->data[0] >> 2U) & 0x03U);
    return {.data = {answer->data.begin() + 4,
                     answer->data.begin() + 4 + static_cast<std::ptrdiff_t>(size)}};
  }
  Upload upload;
  for (bool toggle = false;; toggle = !toggle) {
    const std::uint8_t command = toggle ? 0x70 : 0x60;
    answer = exchange(node, {command, 0, 0, 0, 0, 0, 0, 0});
    if (!answer) throw std::runtime_error("node " + std::to_string(node) + " does not answer");
    if (answer->data[0] == 0x80) return {.abort = static_cast<AbortCode>(number_in(*answer, 4, 4))};
    const std::size_t size = 7 - ((answer->data[0] >> 1U) & 0x07U);
    upload.data.insert(upload.data.end(), answer->data.begin() + 1,
                       answer->data.begin() + 1 + static_cast<std::ptrdiff_t>(size));
    if ((answer->data[0] & 0x01U) != 0) return upload;
  }
}

AbortCode TestMaster::download(std::uint8_t node, ObjectAddress object, std::int64_t value,
                               std::size_t size) {
  const Bytes index = little_endian(object.index, 2);
  const auto command = static_cast<std::uint8_t>(0x23U | ((4 - size) << 2U));
  Bytes request{command, index[0], index[1], object.subindex};
  const Bytes data = little_endian(value, size);
  request.insert(request.end(), data.begin(), data.end());
  request.resize(canopen::kMostData);
  const auto answer = exchange(node, request);
  if (!answer) throw std::runtime_error("node " + std::to_string(node) + " does not answer");
  if (answer->data[0] == 0x60) return AbortCode::none;
  return static_cast<AbortCode>(number_in(*answer, 4, 4));
}

std::int64_t TestMaster::Upload::number(bool is_signed) const {
  return number_of(data, is_signed);
}

std::vector<std::uint8_t> little_endian(std::int64_t value, std::size_t size) {
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i < size; ++i) {
    bytes.push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> (8 * i)));
  }
  return bytes;
}

std::int64_t number_in(const Frame& frame, std::size_t first, std::size_t size, bool is_signed) {
  return number_of(std::span(frame.data).subspan(first, size), is_signed);
}

}  // namespace vdrive::test
