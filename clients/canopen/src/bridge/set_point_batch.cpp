// SPDX-License-Identifier: Apache-2.0
#include "bridge/set_point_batch.hpp"

#include "vdrive/dictionary/object_table.hpp"

#include <algorithm>
#include <optional>
#include <utility>

namespace vdrive::canopen {
namespace {

using namespace literals;

constexpr ObjectAddress kControlwordOfPdo = kObjectRows["ds402_controlword"_object].address;

auto find_value(std::vector<client::ObjectValue>& values, ObjectAddress object) {
  return std::ranges::find(values, object, &client::ObjectValue::object);
}

}  // namespace

void SetPointBatch::add(std::uint16_t axis, std::span<const DriveValue> values) {
  std::optional<std::uint16_t> word;
  for (const DriveValue& value : values) {
    if (value.object == kControlwordOfPdo) {
      word = static_cast<std::uint16_t>(value.value);
    } else {
      put(axis, {.object = value.object, .value = value.value});
    }
  }
  if (word) put_controlword(axis, *word);
}

std::vector<client::SetPointFrame> SetPointBatch::take() {
  newest_.clear();
  return std::exchange(frames_, {});
}

client::SetPoint* SetPointBatch::newest_of(std::uint16_t axis) {
  const auto place = newest_.find(axis);
  if (place == newest_.end()) return nullptr;
  return &frames_[place->second.frame].axes[place->second.set_point];
}

/// Adds a set-point of the axis: to the frame that follows its newest set-point, or to the first
/// frame if it has none.
client::SetPoint& SetPointBatch::next_of(std::uint16_t axis) {
  const auto place = newest_.find(axis);
  const std::size_t frame = place == newest_.end() ? 0 : place->second.frame + 1;
  if (frame == frames_.size()) frames_.emplace_back();
  std::vector<client::SetPoint>& axes = frames_[frame].axes;
  newest_[axis] = {.frame = frame, .set_point = axes.size()};
  return axes.emplace_back(client::SetPoint{.axis = axis});
}

bool SetPointBatch::is_full_for(std::uint16_t axis) const {
  const auto place = newest_.find(axis);
  return place != newest_.end() && place->second.frame + 1 >= kMostFrames;
}

void SetPointBatch::put(std::uint16_t axis, const client::ObjectValue& value) {
  client::SetPoint* const newest = newest_of(axis);
  if (newest == nullptr) {
    next_of(axis).objects.push_back(value);
    return;
  }
  std::vector<client::ObjectValue>& objects = newest->objects;
  const auto known = find_value(objects, value.object);
  const bool has_room = objects.size() < client::kMostObjectsOfSetPoint;
  if (!newest->controlword && known == objects.end() && has_room) {
    objects.push_back(value);
  } else if (!is_full_for(axis)) {
    next_of(axis).objects.push_back(value);
  } else {
    ++replaced_;
    if (known != objects.end()) {
      known->value = value.value;
    } else if (has_room) {
      objects.push_back(value);
    }
  }
}

void SetPointBatch::put_controlword(std::uint16_t axis, std::uint16_t word) {
  client::SetPoint* newest = newest_of(axis);
  if (newest == nullptr || (newest->controlword && !is_full_for(axis))) newest = &next_of(axis);
  if (newest->controlword) ++replaced_;
  newest->controlword = word;
}

}  // namespace vdrive::canopen
