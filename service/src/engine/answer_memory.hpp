// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/lazy_slots.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace vdrive::service {

/// The fate of a numbered message, derived from the latest messages of its sender.
enum class Fate : std::uint8_t {
  unknown,    ///< it has not arrived yet
  taken,      ///< it has arrived but has no answer: it is in progress, or needs no answer
  answered,   ///< its answer is kept
  forgotten,  ///< it is too old to be remembered, or its answer was dropped
};

/// Remembers which messages have arrived from each sender, and their answers, so that a message
/// acts once, however often it arrives. Fixed size: nothing allocates after construction, unless
/// the assignment of an answer does. Slots never used cost no memory. When the table is full, a
/// new sender replaces the sender whose last message is the oldest.
template <typename Answer>
class AnswerMemory {
 public:
  static constexpr std::size_t kSenders = 1'024;
  static constexpr std::size_t kAnswers = 1'024;  ///< of all senders; the oldest is dropped first
  /// Below kAnswers, so that a sender that never pauses leaves room for the others.
  static constexpr std::size_t kAnswersPerSender = 128;
  /// How many numbers are remembered below the highest one of a sender.
  static constexpr std::uint64_t kWindow = 1'024;

  AnswerMemory() : senders_(kSenders), slots_(kAnswers) { ids_.reserve(kSenders); }

  ~AnswerMemory() = default;
  AnswerMemory(const AnswerMemory&) = delete;
  AnswerMemory& operator=(const AnswerMemory&) = delete;

  /// @return the fate of message `number` of `sender`.
  [[nodiscard]] Fate fate_of(std::uint64_t sender, std::uint64_t number) const noexcept {
    const std::size_t place = find(sender);
    if (place == ids_.size() || number > senders_[place].highest) return Fate::unknown;
    const Sender& known = senders_[place];
    if (known.highest - number >= kWindow) return Fate::forgotten;
    if (!known.taken.contains(number)) return Fate::unknown;
    if (!known.answered.contains(number)) return Fate::taken;
    return slot_of(known, number) == nullptr ? Fate::forgotten : Fate::answered;
  }

  /// Notes the arrival of message `number`, whose fate was unknown.
  void take(std::uint64_t sender, std::uint64_t number) noexcept {
    Sender& known = senders_[find_or_add(sender)];
    known.last_use = ++uses_;
    if (number > known.highest) {
      known.taken.forget(known.highest, number);
      known.answered.forget(known.highest, number);
      known.highest = number;
    }
    known.taken.add(number);
  }

  /// @return where to put the answer to message `number`; nullptr unless its fate is `taken`.
  [[nodiscard]] Answer* keep(std::uint64_t sender, std::uint64_t number) noexcept {
    if (fate_of(sender, number) != Fate::taken) return nullptr;
    Sender& known = senders_[find(sender)];
    known.answered.add(number);
    Slot& slot = vacate_for(known);
    slot.sender = &known;
    slot.number = number;
    (known.count++ == 0 ? known.oldest : known.newest->next) = &slot;
    known.newest = &slot;
    slot.older = newest_;
    slot.newer = nullptr;
    (newest_ == nullptr ? oldest_ : newest_->newer) = &slot;
    newest_ = &slot;
    return &slot.answer;
  }

  /// @return the answer to message `number`; not nullptr if its fate is `answered`.
  [[nodiscard]] const Answer* answer_to(std::uint64_t sender, std::uint64_t number) const noexcept {
    const std::size_t place = find(sender);
    const Slot* const slot = place == ids_.size() ? nullptr : slot_of(senders_[place], number);
    return slot == nullptr ? nullptr : &slot->answer;
  }

 private:
  struct Sender;
  struct Slot;

  /// The last kWindow numbers, one bit each.
  class Numbers {
   public:
    [[nodiscard]] bool contains(std::uint64_t number) const noexcept {
      return (words_[word_of(number)] & bit_of(number)) != 0;
    }

    void add(std::uint64_t number) noexcept { words_[word_of(number)] |= bit_of(number); }

    /// Clears the bits of the numbers after `highest`, up to `next`.
    void forget(std::uint64_t highest, std::uint64_t next) noexcept {
      if (next - highest >= kWindow) {
        words_ = {};
        return;
      }
      for (std::uint64_t number = highest + 1; number <= next; ++number) {
        words_[word_of(number)] &= ~bit_of(number);
      }
    }

   private:
    static constexpr std::uint64_t kBits = 64;

    static std::size_t word_of(std::uint64_t number) noexcept { return number % kWindow / kBits; }

    static std::uint64_t bit_of(std::uint64_t number) noexcept {
      return std::uint64_t{1} << (number % kBits);
    }

    std::array<std::uint64_t, kWindow / kBits> words_{};
  };

  struct Sender {
    std::uint64_t highest = 0;
    std::uint64_t last_use = 0;
    Numbers taken;
    Numbers answered;
    std::size_t count = 0;   ///< kept answers, in a chain from the oldest
    Slot* oldest = nullptr;  ///< valid if `count` > 0, like `newest`
    Slot* newest = nullptr;
  };

  struct Slot {
    Sender* sender = nullptr;
    std::uint64_t number = 0;
    Slot* next = nullptr;   ///< next answer to the same sender; valid if there is one
    Slot* older = nullptr;  ///< among the answers to all senders
    Slot* newer = nullptr;  ///< likewise; in a free slot, the next free slot
    Answer answer;
  };

  [[nodiscard]] std::size_t find(std::uint64_t sender) const noexcept {
    if (last_found_ < ids_.size() && ids_[last_found_] == sender) return last_found_;
    const auto found = std::ranges::find(ids_, sender);
    const auto place = static_cast<std::size_t>(found - ids_.begin());
    last_found_ = place;
    return place;
  }

  std::size_t find_or_add(std::uint64_t sender) noexcept {
    const std::size_t known = find(sender);
    if (known < ids_.size()) return known;
    if (ids_.size() < kSenders) {
      ids_.push_back(sender);
      static_cast<void>(senders_.reach(known));
      return known;
    }
    const auto senders = senders_.made();
    const auto silent = std::ranges::min_element(senders, {}, &Sender::last_use);
    while (silent->count > 0) {  // free the slots, so that they are reused first
      Slot& slot = *silent->oldest;
      detach(slot);
      slot.newer = std::exchange(free_, &slot);
    }
    *silent = {};
    const auto place = static_cast<std::size_t>(silent - senders.begin());
    ids_[place] = sender;
    return place;
  }

  [[nodiscard]] static const Slot* slot_of(const Sender& sender, std::uint64_t number) noexcept {
    const Slot* slot = sender.oldest;
    for (std::size_t count = 0; count < sender.count; ++count) {
      if (slot->number == number) return slot;
      slot = slot->next;
    }
    return nullptr;
  }

  /// @return a slot for the next answer to `sender`: a free one, or the one of the oldest answer.
  [[nodiscard]] Slot& vacate_for(const Sender& sender) noexcept {
    if (sender.count < kAnswersPerSender) {
      if (free_ != nullptr) return *std::exchange(free_, free_->newer);
      const std::size_t used = slots_.made().size();
      if (used < kAnswers) return slots_.reach(used);
    }
    Slot& slot = sender.count < kAnswersPerSender ? *oldest_ : *sender.oldest;
    detach(slot);
    return slot;
  }

  /// Drops an answer. It must be the oldest one to its sender; answers are dropped in the order in
  /// which they were added.
  void detach(Slot& slot) noexcept {
    slot.sender->oldest = slot.next;
    --slot.sender->count;
    (slot.older == nullptr ? oldest_ : slot.older->newer) = slot.newer;
    (slot.newer == nullptr ? newest_ : slot.newer->older) = slot.older;
  }

  std::vector<std::uint64_t> ids_;  ///< of the senders; contiguous for a fast search
  LazySlots<Sender> senders_;
  LazySlots<Slot> slots_;
  Slot* free_ = nullptr;    ///< the first of the slots that were vacated
  Slot* oldest_ = nullptr;  ///< of all answers
  Slot* newest_ = nullptr;
  std::uint64_t uses_ = 0;
  mutable std::size_t last_found_ = 0;  ///< the next message is often from the same sender
};

}  // namespace vdrive::service
