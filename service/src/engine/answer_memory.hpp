// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <list>
#include <vector>

namespace vdrive::service {

/// The fate of a numbered message, derived from the latest messages of its sender.
enum class Fate : std::uint8_t {
  unknown,    ///< it has not arrived yet
  taken,      ///< it has arrived and is not answered: it is in progress, or it needs no answer
  answered,   ///< its answer is kept
  forgotten,  ///< it is too old to be known, or its answer was dropped
};

/// Which messages of which sender have arrived, and what was answered, so that a message acts once,
/// however often it arrives. Fixed size: nothing allocates after construction, as far as assigning
/// an answer does not. A new sender replaces the sender whose last message is the oldest.
template <typename Answer>
class AnswerMemory {
 public:
  static constexpr std::size_t kSenders = 1'024;
  static constexpr std::size_t kAnswers = 1'024;  ///< of all senders; the oldest is dropped first
  /// Below kAnswers: a sender that asks without a pause leaves room for the others.
  static constexpr std::size_t kAnswersPerSender = 128;
  /// How many numbers below the highest one of a sender are remembered.
  static constexpr std::uint64_t kWindow = 1'024;

  /// @param prepare makes room in each answer
  template <typename Prepare>
  explicit AnswerMemory(Prepare prepare) : senders_(kSenders), order_(kAnswers) {
    ids_.reserve(kSenders);
    for (Slot& slot : order_) prepare(slot.answer);
  }

  ~AnswerMemory() = default;
  AnswerMemory(const AnswerMemory&) = delete;
  AnswerMemory& operator=(const AnswerMemory&) = delete;

  /// @return what became of message `number` of `sender`.
  [[nodiscard]] Fate fate_of(std::uint64_t sender, std::uint64_t number) const noexcept {
    const std::size_t place = find(sender);
    if (place == ids_.size() || number > senders_[place].highest) return Fate::unknown;
    const Sender& known = senders_[place];
    if (known.highest - number >= kWindow) return Fate::forgotten;
    if (!known.taken.contains(number)) return Fate::unknown;
    if (!known.answered.contains(number)) return Fate::taken;
    return slot_of(known, number) == nullptr ? Fate::forgotten : Fate::answered;
  }

  /// Message `number`, whose fate was unknown, has arrived.
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
    const auto slot =
        known.count == kAnswersPerSender ? known.oldest : order_.begin();  // or of no sender
    detach(*slot);
    order_.splice(order_.end(), order_, slot);
    slot->sender = &known;
    slot->number = number;
    (known.count++ == 0 ? known.oldest : known.newest->next) = slot;
    known.newest = slot;
    return &slot->answer;
  }

  /// @return the answer to message `number`, never nullptr when its fate is `answered`.
  [[nodiscard]] const Answer* answer_to(std::uint64_t sender, std::uint64_t number) const noexcept {
    const std::size_t place = find(sender);
    const Slot* const slot = place == ids_.size() ? nullptr : slot_of(senders_[place], number);
    return slot == nullptr ? nullptr : &slot->answer;
  }

 private:
  struct Sender;
  struct Slot;
  using SlotPlace = typename std::list<Slot>::iterator;

  /// The last kWindow numbers, one bit each.
  class Numbers {
   public:
    [[nodiscard]] bool contains(std::uint64_t number) const noexcept {
      return (words_[word_of(number)] & bit_of(number)) != 0;
    }

    void add(std::uint64_t number) noexcept { words_[word_of(number)] |= bit_of(number); }

    /// Makes room for the numbers behind `highest` up to `next`.
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
    std::size_t count = 0;  ///< answers that are kept, in a chain from the oldest
    SlotPlace oldest;
    SlotPlace newest;
  };

  struct Slot {
    Answer answer;
    Sender* sender = nullptr;  ///< nullptr = free
    std::uint64_t number = 0;
    SlotPlace next;  ///< of the same sender; holds when there is one
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
      return known;
    }
    const auto silent = std::ranges::min_element(senders_, {}, &Sender::last_use);
    while (silent->count > 0) {  // what is no longer asked for is replaced first
      const SlotPlace slot = silent->oldest;
      detach(*slot);
      order_.splice(order_.begin(), order_, slot);
    }
    *silent = {};
    const auto place = static_cast<std::size_t>(silent - senders_.begin());
    ids_[place] = sender;
    return place;
  }

  [[nodiscard]] static const Slot* slot_of(const Sender& sender, std::uint64_t number) noexcept {
    SlotPlace slot = sender.oldest;
    for (std::size_t count = 0; count < sender.count; ++count) {
      if (slot->number == number) return &*slot;
      slot = slot->next;
    }
    return nullptr;
  }

  /// Frees the slot, which is its sender's oldest: answers go in the order in which they came.
  static void detach(Slot& slot) noexcept {
    if (slot.sender != nullptr) {
      slot.sender->oldest = slot.next;
      --slot.sender->count;
      slot.sender = nullptr;
    }
  }

  std::vector<std::uint64_t> ids_;  ///< of the senders, close together
  std::vector<Sender> senders_;
  std::list<Slot> order_;  ///< free ones, then the answers from the oldest
  std::uint64_t uses_ = 0;
  mutable std::size_t last_found_ = 0;  ///< the sender of one message often sends the next
};

}  // namespace vdrive::service
