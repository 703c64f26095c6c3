// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/codec.hpp"

#include "bounds.hpp"
#include "status_members.hpp"

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>

#include <array>
#include <bit>
#include <concepts>
#include <cstring>
#include <type_traits>
#include <utility>

namespace vdrive::wire {
namespace {

static_assert(std::endian::native == std::endian::little,
              "status samples are copied as they stand in memory and announced as CDR_LE");

constexpr std::array<std::byte, kEncapsulation> kLittleEndian{std::byte{0}, std::byte{1},
                                                              std::byte{0}, std::byte{0}};

/// Reads plain CDR of either byte order. After the first failure every value is 0.
class CdrReader {
 public:
  explicit CdrReader(std::span<const std::byte> sample) noexcept
      : sample_(sample),
        is_good_(sample.size() >= kEncapsulation && sample[0] == std::byte{0} &&
                 (sample[1] == std::byte{0} || sample[1] == std::byte{1})),
        swaps_(is_good_ && sample[1] == std::byte{0}) {}

  [[nodiscard]] bool is_good() const noexcept { return is_good_; }

  /// Alignment counts from the end of the encapsulation.
  template <std::integral Number>
  Number next() noexcept {
    constexpr std::size_t kSize = sizeof(Number);
    position_ = (position_ - kEncapsulation + kSize - 1) / kSize * kSize + kEncapsulation;
    if (!is_good_ || position_ + kSize > sample_.size()) {
      is_good_ = false;
      return 0;
    }
    std::array<std::byte, kSize> bytes{};
    std::memcpy(bytes.data(), &sample_[position_], kSize);
    position_ += kSize;
    if (swaps_) {
      for (std::size_t low = 0, high = kSize - 1; low < high; ++low, --high) {
        std::swap(bytes[low], bytes[high]);
      }
    }
    return std::bit_cast<Number>(bytes);
  }

  double next_double() noexcept { return std::bit_cast<double>(next<std::uint64_t>()); }

 private:
  std::span<const std::byte> sample_;
  std::size_t position_ = kEncapsulation;
  bool is_good_;
  bool swaps_;
};

void read_command(CdrReader& reader, msg::AxisCommand& command) {
  command.axis(reader.next<std::uint16_t>());
  command.members(reader.next<std::uint16_t>());
  command.ds402_controlword(reader.next<std::uint16_t>());
  command.op_mode_cmd(reader.next<std::int8_t>());
  command.position_user_target_value(reader.next<std::int32_t>());
  command.profile_velocity(reader.next<std::uint32_t>());
  command.profile_acc(reader.next<std::uint32_t>());
  command.profile_dec(reader.next<std::uint32_t>());
  command.positioning_option_code(reader.next<std::uint16_t>());
}

/// Where the next number of a sample lies, behind the encapsulation.
constexpr std::size_t aligned(std::size_t position, std::size_t size) noexcept {
  return (position + size - 1) / size * size;
}

/// Calls `put(value)` for each member of an AxisStatus, in the order of the IDL.
template <typename Put>
constexpr void for_each_value(const AxisStatus& status, const AxisAddress& address,
                              std::uint64_t tick, const Ownership& owner, const Put& put) {
  put(address.bench);
  put(address.axis);
  put(tick);
  put(owner.session);
  put(owner.epoch);
  put(owner.last_sequence);
  for_each_status_member([&](auto member, const auto& /*in_message*/) {
    put(status.*member);
  });
}

/// @return bytes of an AxisStatus that begins at `start`, of which only the remainder by 8 counts.
constexpr std::size_t status_size(std::size_t start) noexcept {
  std::size_t position = start;
  for_each_value({}, {}, 0, {}, [&position](auto value) {
    position = aligned(position, sizeof value) + sizeof value;
  });
  return position - start;
}

// The first axis of a frame begins at a multiple of 8. It ends 4 bytes behind one, and so does
// every further axis.
constexpr std::size_t kFirstStatus = status_size(0);
constexpr std::size_t kFurtherStatus = status_size(kFirstStatus);
static_assert(kFirstStatus == 108 && kFurtherStatus == 112);
static_assert(kEncapsulation + kFirstStatus == kAxisStatusSize);
static_assert((kFirstStatus + kFurtherStatus) % 8 == kFirstStatus % 8);

struct FrameLayout {
  std::uint32_t bench;
  std::uint32_t gap_before_incarnation;
  std::uint64_t incarnation;
  std::uint64_t tick;
  std::int64_t time_ns;
  std::uint16_t part;
  std::uint16_t parts;
  std::uint32_t axes;  ///< length of the sequence
};

static_assert(sizeof(FrameLayout) == 40 && std::is_trivially_copyable_v<FrameLayout>);

/// Writes an AxisStatus that begins at a position with the remainder `kStart` by 8.
/// @return the place behind it.
template <std::size_t kStart>
std::byte* put_status(const AxisStatus& status, const AxisAddress& address, std::uint64_t tick,
                      const Ownership& owner, std::byte* place) noexcept {
  // Straight to its place: a copy of what was just written in small pieces would have to wait.
  std::size_t position = kStart % 8;
  std::byte* const origin = place - position;
  for_each_value(status, address, tick, owner, [&](auto value) {
    const std::size_t begin = aligned(position, sizeof value);
    std::memset(origin + position, 0, begin - position);
    std::memcpy(origin + begin, &value, sizeof value);
    position = begin + sizeof value;
  });
  return origin + position;
}

}  // namespace

template <typename Message>
std::size_t encoded_size(const Message& message) {
  return kEncapsulation + Message::getCdrSerializedSize(message);
}

template <typename Message>
std::size_t encode(const Message& message, std::span<std::byte> output) noexcept {
  using eprosima::fastcdr::Cdr;
  try {
    // The buffer takes a pointer to characters and writes into the bytes of `output` only.
    eprosima::fastcdr::FastBuffer buffer(
        reinterpret_cast<char*>(output.data()),  // NOLINT(*-reinterpret-cast)
        output.size());
    Cdr cdr(buffer, Cdr::LITTLE_ENDIANNESS, Cdr::DDS_CDR);
    cdr.serialize_encapsulation();
    message.serialize(cdr);
    return cdr.getSerializedDataLength();
  } catch (...) {  // not enough room
    return 0;
  }
}

template <typename Message>
bool decode(std::span<const std::byte> sample, Message& message) noexcept {
  using eprosima::fastcdr::Cdr;
  if (!CdrReader(sample).is_good()) return false;
  try {
    // The buffer takes a mutable pointer; only reading functions are called.
    eprosima::fastcdr::FastBuffer buffer(
        const_cast<char*>(                                  // NOLINT(*-const-cast)
            reinterpret_cast<const char*>(sample.data())),  // NOLINT(*-reinterpret-cast)
        sample.size());
    Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
    cdr.read_encapsulation();
    message.deserialize(cdr);
    return within_bounds(message);
  } catch (...) {  // ends early, or claims an absurd length
    return false;
  }
}

CommandDecoder::CommandDecoder(std::size_t spare) {
  spare_.reserve(spare + msg::MAX_AXES_PER_FRAME);
  for (std::size_t count = 0; count < spare; ++count) {
    spare_.emplace_back().objects().reserve(msg::MAX_OBJECTS_PER_AXIS);
  }
}

/// A vector that shrinks would throw the room of its elements' sequences away.
void CommandDecoder::resize(std::vector<msg::AxisCommand>& axes, std::size_t count) {
  axes.reserve(msg::MAX_AXES_PER_FRAME);
  while (axes.size() > count) {
    if (spare_.size() < spare_.capacity()) spare_.push_back(std::move(axes.back()));
    axes.pop_back();
  }
  while (axes.size() < count) {
    if (spare_.empty()) {
      axes.emplace_back();
    } else {
      axes.push_back(std::move(spare_.back()));
      spare_.pop_back();
    }
  }
}

Decoding CommandDecoder::decode(std::span<const std::byte> sample, msg::CommandFrame& frame) {
  CdrReader reader(sample);
  frame.bench(reader.next<std::uint32_t>());
  frame.incarnation(reader.next<std::uint64_t>());
  frame.session(reader.next<std::uint64_t>());
  frame.epoch(reader.next<std::uint32_t>());
  frame.sequence_number(reader.next<std::uint64_t>());
  frame.apply_at_tick(reader.next<std::uint64_t>());
  frame.valid_until_tick(reader.next<std::uint64_t>());
  frame.flags(reader.next<std::uint32_t>());
  const auto count = reader.next<std::uint32_t>();
  const bool fits = count <= msg::MAX_AXES_PER_FRAME;
  resize(frame.axes(), fits ? count : 0);
  if (!fits) return Decoding::too_many_axes;
  for (auto& command : frame.axes()) {
    read_command(reader, command);
    const auto objects = reader.next<std::uint32_t>();
    if (objects > msg::MAX_OBJECTS_PER_AXIS) {
      resize(frame.axes(), 0);
      return Decoding::too_many_objects;
    }
    command.objects().resize(objects);
    for (auto& object : command.objects()) {
      object.index(reader.next<std::uint16_t>());
      object.subindex(reader.next<std::uint8_t>());
      object.value(reader.next<std::int64_t>());
    }
  }
  return reader.is_good() ? Decoding::good : Decoding::malformed;
}

// NOLINTNEXTLINE(readability-convert-member-functions-to-static): one object decodes both kinds
Decoding CommandDecoder::decode(std::span<const std::byte> sample, msg::Request& request) {
  CdrReader reader(sample);
  request.client(reader.next<std::uint64_t>());
  request.request_id(reader.next<std::uint64_t>());
  request.bench(reader.next<std::uint32_t>());
  request.incarnation(reader.next<std::uint64_t>());
  request.session(reader.next<std::uint64_t>());
  request.kind(reader.next<std::uint32_t>());
  request.ticks(reader.next<std::uint64_t>());
  request.last_sequence(reader.next<std::uint64_t>());
  request.rate(reader.next_double());
  request.snapshot(reader.next<std::uint64_t>());
  request.axes().reserve(msg::MAX_AXES_PER_FRAME);
  request.objects().reserve(msg::MAX_OBJECTS_PER_REQUEST);
  request.axes().clear();
  request.objects().clear();
  const auto axes = reader.next<std::uint32_t>();
  if (axes > msg::MAX_AXES_PER_FRAME) return Decoding::too_many_axes;
  for (std::uint32_t count = 0; count < axes; ++count) {
    request.axes().push_back(reader.next<std::uint16_t>());
  }
  const auto objects = reader.next<std::uint32_t>();
  if (objects > msg::MAX_OBJECTS_PER_REQUEST) {
    request.axes().clear();
    return Decoding::too_many_objects;
  }
  request.objects().resize(objects);
  for (auto& object : request.objects()) {
    object.axis(reader.next<std::uint16_t>());
    object.index(reader.next<std::uint16_t>());
    object.subindex(reader.next<std::uint8_t>());
    object.value(reader.next<std::int64_t>());
  }
  return reader.is_good() ? Decoding::good : Decoding::malformed;
}

std::size_t encoded_status_frame_size(std::size_t axes) noexcept {
  const std::size_t of_axes = axes == 0 ? 0 : kFirstStatus + (axes - 1) * kFurtherStatus;
  return kEncapsulation + sizeof(FrameLayout) + of_axes;
}

std::size_t encode_status_frame(const StatusFrameHead& head, const AxesAfterTick& axes,
                                std::span<std::byte> output) noexcept {
  const std::size_t count = axes.status.size();
  const std::size_t size = encoded_status_frame_size(count);
  if (output.size() < size) return 0;
  const FrameLayout frame{.bench = head.bench,
                          .gap_before_incarnation = 0,
                          .incarnation = head.incarnation,
                          .tick = head.tick,
                          .time_ns = head.time_ns,
                          .part = head.part,
                          .parts = head.parts,
                          .axes = static_cast<std::uint32_t>(count)};
  std::byte* place = output.data();
  std::memcpy(place, kLittleEndian.data(), kEncapsulation);
  place += kEncapsulation;
  std::memcpy(place, &frame, sizeof frame);
  place += sizeof frame;
  for (std::size_t axis = 0; axis < count; ++axis) {
    const auto put = axis == 0 ? put_status<0> : put_status<kFirstStatus>;
    place = put(axes.status[axis], {head.bench, axes.numbers[axis]}, head.tick, axes.owners[axis],
                place);
  }
  return size;
}

std::size_t encode_axis_status(const AxisStatus& status, const AxisAddress& address,
                               std::uint64_t tick, const Ownership& owner,
                               std::span<std::byte> output) noexcept {
  if (output.size() < kAxisStatusSize) return 0;
  std::memcpy(output.data(), kLittleEndian.data(), kEncapsulation);
  put_status<0>(status, address, tick, owner, &output[kEncapsulation]);
  return kAxisStatusSize;
}

template std::size_t encoded_size(const msg::CommandFrame&);
template std::size_t encoded_size(const msg::CommandReply&);
template std::size_t encoded_size(const msg::Request&);
template std::size_t encoded_size(const msg::Reply&);
template std::size_t encoded_size(const msg::StatusFrame&);
template std::size_t encoded_size(const msg::AxisStatus&);
template std::size_t encoded_size(const msg::AxisParameters&);
template std::size_t encoded_size(const msg::Event&);
template std::size_t encoded_size(const msg::BenchDescription&);
template std::size_t encoded_size(const msg::BenchState&);

template std::size_t encode(const msg::CommandFrame&, std::span<std::byte>) noexcept;
template std::size_t encode(const msg::CommandReply&, std::span<std::byte>) noexcept;
template std::size_t encode(const msg::Request&, std::span<std::byte>) noexcept;
template std::size_t encode(const msg::Reply&, std::span<std::byte>) noexcept;
template std::size_t encode(const msg::StatusFrame&, std::span<std::byte>) noexcept;
template std::size_t encode(const msg::AxisStatus&, std::span<std::byte>) noexcept;
template std::size_t encode(const msg::AxisParameters&, std::span<std::byte>) noexcept;
template std::size_t encode(const msg::Event&, std::span<std::byte>) noexcept;
template std::size_t encode(const msg::BenchDescription&, std::span<std::byte>) noexcept;
template std::size_t encode(const msg::BenchState&, std::span<std::byte>) noexcept;

template bool decode(std::span<const std::byte>, msg::CommandFrame&) noexcept;
template bool decode(std::span<const std::byte>, msg::CommandReply&) noexcept;
template bool decode(std::span<const std::byte>, msg::Request&) noexcept;
template bool decode(std::span<const std::byte>, msg::Reply&) noexcept;
template bool decode(std::span<const std::byte>, msg::StatusFrame&) noexcept;
template bool decode(std::span<const std::byte>, msg::AxisStatus&) noexcept;
template bool decode(std::span<const std::byte>, msg::AxisParameters&) noexcept;
template bool decode(std::span<const std::byte>, msg::Event&) noexcept;
template bool decode(std::span<const std::byte>, msg::BenchDescription&) noexcept;
template bool decode(std::span<const std::byte>, msg::BenchState&) noexcept;

}  // namespace vdrive::wire
