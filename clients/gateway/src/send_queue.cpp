// SPDX-License-Identifier: Apache-2.0
#include "send_queue.hpp"

#include "vdrive/assert.hpp"

namespace vdrive::gateway {

std::size_t SendQueue::push_data(Frame frame) {
  std::size_t dropped = 0;
  data_bytes_ += frame.size();
  data_.push_back(std::move(frame));
  // The newest frame stays, however large, so that a client that reads receives it.
  while (data_.size() > 1 &&
         (data_.size() > limits_.data_frames || data_bytes_ > limits_.data_bytes)) {
    data_bytes_ -= data_.front().size();
    data_.pop_front();
    ++dropped;
  }
  dropped_ += dropped;
  return dropped;
}

bool SendQueue::push_answer(Frame frame, bool is_shared) {
  // The number limit applies to shared answers too: each frame is an entry of the queue.
  const std::size_t cost = is_shared ? 0 : frame.size();
  if (answers_.size() >= limits_.answer_frames || answer_bytes_ + cost > limits_.answer_bytes) {
    return false;
  }
  answer_bytes_ += cost;
  answers_.push_back({std::move(frame), cost});
  return true;
}

std::optional<Frame> SendQueue::pop() {
  std::optional<Frame> frame;
  if (!answers_.empty()) {
    ensure(answer_bytes_ >= answers_.front().cost,
           "the bytes of each answer that waits are counted");
    answer_bytes_ -= answers_.front().cost;
    frame = std::move(answers_.front().frame);
    answers_.pop_front();
  } else if (!data_.empty()) {
    data_bytes_ -= data_.front().size();
    frame = std::move(data_.front());
    data_.pop_front();
  }
  return frame;
}

std::uint64_t SendQueue::take_dropped() noexcept {
  return std::exchange(dropped_, 0);
}

}  // namespace vdrive::gateway
