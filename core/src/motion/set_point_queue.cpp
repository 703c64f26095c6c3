// SPDX-License-Identifier: Apache-2.0
#include "vdrive/motion/set_point_queue.hpp"

#include "vdrive/cia402/controlword.hpp"

namespace vdrive {

SetPointOutcome SetPointQueue::controlword(std::uint16_t word, std::uint16_t previous_word,
                                           bool accepting, bool moving,
                                           const SetPoint& candidate) noexcept {
  const bool edge = (word & ~previous_word & Controlword::kNewSetPoint) != 0;
  if (!edge) {
    release_acknowledge(word);
    return SetPointOutcome::none;
  }
  if (!accepting) return SetPointOutcome::ignored;
  const bool immediately = (word & Controlword::kChangeSetImmediately) != 0;
  if (immediately || !moving) {
    full_ = false;
    acknowledge_ = true;
    return SetPointOutcome::started;
  }
  if (full_) return SetPointOutcome::ignored;
  buffered_ = candidate;
  full_ = true;
  acknowledge_ = true;
  return SetPointOutcome::buffered;
}

bool SetPointQueue::take_buffered(std::uint16_t word, SetPoint& next) noexcept {
  if (!full_) return false;
  next = buffered_;
  full_ = false;
  release_acknowledge(word);
  return true;
}

void SetPointQueue::drop_buffered(std::uint16_t word) noexcept {
  full_ = false;
  release_acknowledge(word);
}

void SetPointQueue::clear() noexcept {
  full_ = false;
  acknowledge_ = false;
}

void SetPointQueue::release_acknowledge(std::uint16_t word) noexcept {
  if ((word & Controlword::kNewSetPoint) == 0 && !full_) acknowledge_ = false;
}

}  // namespace vdrive
