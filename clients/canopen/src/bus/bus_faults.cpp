// SPDX-License-Identifier: Apache-2.0
#include "bus/bus_faults.hpp"

#include "node/node_settings.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

namespace vdrive::canopen {
namespace {

constexpr std::string_view kGrammar =
    "lost, late TIME, doubled, duplicate or bus_off, then PERCENT%, sent or received, seed N, "
    "from TIME, for TIME as needed, such as late 4ms 10% from 2s for 500ms";

constexpr unsigned kAllFrames = 100;  // [%]

struct KindRow {
  std::string_view word;
  BusFaultKind kind{};
  bool is_of_frames = false;  ///< affects a share of the frames, in one direction or both
};

constexpr std::array kKinds{
    KindRow{"lost", BusFaultKind::lost, true},
    KindRow{"late", BusFaultKind::late, true},
    KindRow{"doubled", BusFaultKind::doubled, true},
    KindRow{"duplicate", BusFaultKind::duplicate, false},
    KindRow{"bus_off", BusFaultKind::bus_off, false},
};

/// Thrown only inside this file: parsing can fail in many places.
struct BadFault {
  std::string reason;
};

/// Splits a text into words.
class FaultWords final {
 public:
  explicit FaultWords(std::string_view text) : rest_(text) { skip_blanks(); }

  [[nodiscard]] bool empty() const noexcept { return rest_.empty(); }

  [[nodiscard]] std::string_view rest() const noexcept { return rest_; }

  std::string_view take() {
    if (empty()) throw BadFault{"a word is missing at the end"};
    const std::string_view word = rest_.substr(0, rest_.find_first_of(" \t"));
    rest_.remove_prefix(word.size());
    skip_blanks();
    return word;
  }

  DriveTime take_time() {
    const std::string_view word = take();
    const auto time = parse_duration(word);
    if (!time) throw BadFault{in_quotes(word) + " is not a time such as 4ms"};
    return std::chrono::ceil<DriveTime>(*time);
  }

  /// @param what name of the quantity in the error message
  DriveTime take_length(std::string_view what) {
    const DriveTime time = take_time();
    if (time == DriveTime{}) throw BadFault{std::string(what) + " needs a time above 0"};
    return time;
  }

 private:
  void skip_blanks() {
    rest_.remove_prefix(std::min(rest_.find_first_not_of(" \t"), rest_.size()));
  }

  std::string_view rest_;
};

unsigned percent_of(std::string_view word) {
  const auto percent = parse_digits<unsigned>(word.substr(0, word.size() - 1));
  if (!percent || *percent == 0 || *percent > kAllFrames) {
    throw BadFault{in_quotes(word) + " is not 1% to 100%"};
  }
  return *percent;
}

const KindRow& take_kind(FaultWords& words) {
  const std::string_view word = words.take();
  const auto* const row = std::ranges::find(kKinds, word, &KindRow::word);
  if (row == kKinds.end()) throw BadFault{in_quotes(word) + " is not a fault of the bus"};
  return *row;
}

/// Handles `word` if it selects frames.
/// @return whether it does
bool take_choice(std::string_view word, FaultWords& words, BusFault& fault) {
  if (word.ends_with('%')) {
    fault.percent = percent_of(word);
  } else if (word == "sent" || word == "received") {
    fault.direction = word == "sent" ? FrameDirection::sent : FrameDirection::received;
  } else if (word == "seed") {
    const std::string_view seed = words.take();
    const auto number = parse_digits<std::uint64_t>(seed);
    if (!number)
      throw BadFault{in_quotes(seed) + " is not a seed: write a whole number, 0 or more"};
    fault.seed = *number;
  } else {
    return false;
  }
  return true;
}

BusFault take_fault(FaultWords& words, DriveTime now) {
  const KindRow& row = take_kind(words);
  BusFault fault{.kind = row.kind, .from = now};
  if (row.kind == BusFaultKind::late) fault.delay = words.take_length(row.word);
  std::optional<DriveTime> length;
  while (!words.empty()) {
    const std::string_view word = words.take();
    if (word == "from") {
      fault.from = words.take_time();
    } else if (word == "for") {
      length = words.take_length(word);
    } else if (!row.is_of_frames || !take_choice(word, words, fault)) {
      throw BadFault{in_quotes(word) + " does not apply to " + std::string(row.word)};
    }
  }
  if (length) fault.until = fault.from + *length;
  return fault;
}

template <typename Read>
std::variant<BusFault, std::string> fault_or_refusal(const Read& read) {
  try {
    return read();
  } catch (const BadFault& bad) {
    return bad.reason + "; write " + std::string(kGrammar);
  }
}

/// The finaliser of SplitMix64: each bit of the result depends on every bit of `value`.
std::uint64_t mixed(std::uint64_t value) {
  value += 0x9E3779B97F4A7C15U;
  value = (value ^ value >> 30U) * 0xBF58476D1CE4E5B9U;
  value = (value ^ value >> 27U) * 0x94D049BB133111EBU;
  return value ^ value >> 31U;
}

bool hits(const BusFault& fault, FrameDirection direction, std::uint64_t number) {
  if (fault.direction && *fault.direction != direction) return false;
  // Lets faults with the same seed affect different frames.
  const auto stream = static_cast<std::uint64_t>(fault.kind) << 16U |
                      std::uint64_t{fault.node} << 8U | static_cast<std::uint64_t>(direction);
  return mixed(mixed(mixed(fault.seed) ^ stream) ^ number) % kAllFrames < fault.percent;
}

bool acts_on(const BusFault& fault, std::uint8_t node, DriveTime now) {
  return (fault.node == 0 || fault.node == node) && now >= fault.from &&
         (!fault.until || now < *fault.until);
}

}  // namespace

std::variant<BusFault, std::string> parse_bus_fault(std::string_view text, DriveTime now) {
  return fault_or_refusal([&] {
    FaultWords words(text);
    return take_fault(words, now);
  });
}

std::variant<BusFault, std::string> parse_fault_of_node(std::string_view text) {
  return fault_or_refusal([&] {
    FaultWords words(text);
    FaultWords after(text);
    const auto node = parse_digits<unsigned>(words.empty() ? "" : after.take());
    if (node && *node > kHighestNodeId) throw BadFault{"a node id is 1 to 127, 0 is every node"};
    BusFault fault = take_fault(node ? after : words, DriveTime{});
    fault.node = static_cast<std::uint8_t>(node.value_or(0));
    return fault;
  });
}

bool BusFaults::add(const BusFault& fault, DriveTime now) {
  std::erase_if(faults_, [now](const BusFault& known) {
    return known.until && *known.until <= now;
  });
  if (faults_.size() >= kMostFaults) return false;
  faults_.push_back(fault);
  return true;
}

void BusFaults::clear(std::uint8_t node) {
  std::erase_if(faults_, [node](const BusFault& fault) {
    return node == 0 || fault.node == node;
  });
}

FrameFate BusFaults::fate_of(std::uint8_t node, FrameDirection direction, std::uint64_t number,
                             DriveTime now) {
  FrameFate fate;
  for (const BusFault& fault : faults_) {
    if (!acts_on(fault, node, now)) continue;
    const bool is_hit = hits(fault, direction, number);
    fate.is_lost = fate.is_lost || fault.kind == BusFaultKind::bus_off ||
                   (fault.kind == BusFaultKind::lost && is_hit);
    fate.is_doubled = fate.is_doubled || (fault.kind == BusFaultKind::doubled && is_hit);
    if (fault.kind == BusFaultKind::late && is_hit) fate.delay = std::max(fate.delay, fault.delay);
  }
  if (fate != FrameFate{}) ++disturbed_;
  return fate;
}

bool BusFaults::acts(BusFaultKind kind, std::uint8_t node, DriveTime now) const {
  return std::ranges::any_of(faults_, [&](const BusFault& fault) {
    return fault.kind == kind && acts_on(fault, node, now);
  });
}

}  // namespace vdrive::canopen
