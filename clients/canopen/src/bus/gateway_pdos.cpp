// SPDX-License-Identifier: Apache-2.0
#include "bus/gateway_pdos.hpp"

#include "node/frame.hpp"
#include "node/pdo_mapping.hpp"
#include "vdrive/number_text.hpp"

#include <algorithm>
#include <span>
#include <utility>

namespace vdrive::canopen {
namespace {

/// @return 0 for an object that cannot be mapped.
std::uint8_t mapped_size(ObjectAddress object) {
  if (object.index >= kFirstDummy && object.index <= kLastDummy) {
    return size_of(static_cast<NodeDataType>(object.index));
  }
  const NodeObject* const found = find_node_object(object);
  if (found == nullptr || found->mapping == PdoMapping::none) return 0;
  return size_of(found->data_type);
}

}  // namespace

PdoRefusal GatewayPdos::set(const GatewayCommand& command) {
  Pdo pdo{.can_id = static_cast<std::uint32_t>(command.cob_id)};
  for (const ObjectAddress& object : command.mapped) {
    pdo.sizes.push_back(mapped_size(object));
    if (pdo.sizes.back() == 0) {
      const AbortCode abort = check_node_address(object);
      return abort == AbortCode::none ? AbortCode::cannot_be_mapped_to_pdo : abort;
    }
    pdo.size += pdo.sizes.back();
  }
  if (pdo.size > kMostData) return GatewayError::pdo_length_exceeded;
  auto& pdos = command.verb == GatewayVerb::set_receive_pdo ? received_ : sent_;
  pdos.insert_or_assign(command.value, std::move(pdo));
  return {};
}

std::optional<std::string> GatewayPdos::read(std::uint64_t number) const {
  const auto found = received_.find(number);
  if (found == received_.end() || !found->second.newest) return std::nullopt;
  return values_of(found->second);
}

PdoRefusal GatewayPdos::write(const GatewayCommand& command, Frame& frame) const {
  const auto found = sent_.find(command.value);
  if (found == sent_.end()) return GatewayError::internal_state;
  const Pdo& pdo = found->second;
  if (command.values.size() != pdo.sizes.size()) return GatewayError::syntax;
  frame = {.id = pdo.can_id, .size = static_cast<std::uint8_t>(pdo.size)};
  std::span<std::uint8_t> rest(frame.data);
  for (std::size_t i = 0; i < pdo.sizes.size(); ++i) {
    const std::uint64_t value = command.values[i];
    const std::size_t size = pdo.sizes[i];
    if (value >> (8U * size) != 0) return GatewayError::syntax;
    put_little_endian(value, rest.first(size));
    rest = rest.subspan(size);
  }
  return {};
}

bool GatewayPdos::is_of(const Pdo& pdo, const Frame& frame) {
  return frame.id == pdo.can_id && !frame.is_extended && !frame.is_remote && frame.size >= pdo.size;
}

bool GatewayPdos::awaits(const Frame& frame) const {
  return std::ranges::any_of(received_, [&frame](const auto& entry) {
    return is_of(entry.second, frame);
  });
}

std::vector<std::string> GatewayPdos::receive(const Frame& frame) {
  std::vector<std::string> reports;
  for (auto& [number, pdo] : received_) {
    if (!is_of(pdo, frame)) continue;
    pdo.newest = frame;
    reports.push_back(std::to_string(number) + " " + values_of(pdo));
  }
  return reports;
}

std::string GatewayPdos::values_of(const Pdo& pdo) {
  std::string text = std::to_string(pdo.sizes.size());
  std::span<const std::uint8_t> rest(pdo.newest->data);
  for (const std::uint8_t size : pdo.sizes) {
    text += " " + hex(little_endian_number(rest.first(size)), 1);
    rest = rest.subspan(size);
  }
  return text;
}

}  // namespace vdrive::canopen
