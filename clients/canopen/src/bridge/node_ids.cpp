// SPDX-License-Identifier: Apache-2.0
#include "bridge/node_ids.hpp"

#include "node/node.hpp"
#include "vdrive/wording.hpp"

#include <iterator>
#include <utility>

namespace vdrive::canopen {
namespace {

constexpr const char* kRemedy = "; give the bench another offset (node_offset, --node-offset)";

std::string begin_of_refusal(const client::AxisInfo& axis, std::int64_t node) {
  return "axis " + to_string(axis.id) + " would be node " + std::to_string(node);
}

}  // namespace

std::optional<std::string> NodeIds::add(std::span<const client::AxisInfo> axes,
                                        std::int32_t offset) {
  auto taken = axes_;
  for (const client::AxisInfo& axis : axes) {
    const std::int64_t node = std::int64_t{axis.id.axis} + offset;
    if (node < kLowestNodeId || node > kHighestNodeId) {
      return begin_of_refusal(axis, node) + ": node ids are " + std::to_string(kLowestNodeId) +
             " to " + std::to_string(kHighestNodeId) + kRemedy;
    }
    const auto [owner, is_free] = taken.try_emplace(static_cast<std::uint8_t>(node), axis.id);
    if (!is_free) {
      return begin_of_refusal(axis, node) + ", which is axis " + to_string(owner->second) + kRemedy;
    }
  }
  axes_ = std::move(taken);
  return std::nullopt;
}

void NodeIds::remove(std::uint32_t bench) {
  std::erase_if(axes_, [bench](const auto& entry) {
    return entry.second.bench == bench;
  });
}

std::string NodeIds::text() const {
  std::string ranges;
  for (auto first = axes_.begin(); first != axes_.end();) {
    auto last = first;
    auto next = std::next(first);
    while (next != axes_.end() && next->first == last->first + 1) last = next++;
    if (!ranges.empty()) ranges += ", ";
    ranges += std::to_string(first->first);
    if (last != first) ranges += " to " + std::to_string(last->first);
    first = next;
  }
  std::string text = counted(axes_.size(), "node", "nodes");
  if (!ranges.empty()) text += " (" + ranges + ")";
  return text;
}

std::uint8_t node_id_of(const client::AxisId& axis, std::int32_t offset) noexcept {
  return static_cast<std::uint8_t>(axis.axis + offset);
}

}  // namespace vdrive::canopen
