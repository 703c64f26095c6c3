// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/codec.hpp"

#include "bounds.hpp"

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

/// A sample of AxisStatus behind the encapsulation, as CDR lays it out from a multiple of 8.
struct StatusLayout {
  std::uint32_t bench;
  std::uint16_t axis;
  std::uint16_t gap_before_tick;
  std::uint64_t tick;
  std::uint64_t owner_session;
  std::uint32_t owner_epoch;
  std::uint32_t gap_before_sequence;
  std::uint64_t last_sequence;
  std::uint16_t ds402_statusword;
  std::int8_t op_mode_actual;
  std::uint8_t motor_op_status;
  std::uint16_t error_code;
  std::uint8_t error_register;
  std::uint8_t digital_inputs;
  std::int32_t position_demand_value;
  std::int32_t load_position_actual_value;
  std::int32_t load_position_error_value;
  std::int32_t motor_position_actual_value;
  std::int32_t motor_position_error_value;
  std::int32_t velocity_demand_value;
  std::int32_t load_velocity_actual_value;
  std::int32_t load_velocity_error_value;
  std::int32_t motor_velocity_actual_value;
  std::int32_t motor_velocity_error_value;
  std::int16_t current_actual_value;
  std::int16_t gap_before_current_error;
  std::int32_t current_error_value;
  std::int16_t torque_demand;
  std::int16_t torque_actual_value;
  std::uint32_t ignored_set_points;
  std::uint32_t fault_count;
  std::uint32_t objects;  ///< length of an empty sequence
};

static_assert(kEncapsulation + sizeof(StatusLayout) == kAxisStatusSize &&
              std::is_trivially_copyable_v<StatusLayout>);
static_assert(sizeof(StatusLayout) % 8 == 0, "each axis of a frame begins at a multiple of 8");

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

StatusLayout layout_of(const AxisStatus& status, const AxisAddress& address, std::uint64_t tick,
                       const Ownership& owner) noexcept {
  return {.bench = address.bench,
          .axis = address.axis,
          .gap_before_tick = 0,
          .tick = tick,
          .owner_session = owner.session,
          .owner_epoch = owner.epoch,
          .gap_before_sequence = 0,
          .last_sequence = owner.last_sequence,
          .ds402_statusword = status.ds402_statusword,
          .op_mode_actual = status.op_mode_actual,
          .motor_op_status = status.motor_op_status,
          .error_code = status.error_code,
          .error_register = status.error_register,
          .digital_inputs = status.digital_inputs,
          .position_demand_value = status.position_demand_value,
          .load_position_actual_value = status.load_position_actual_value,
          .load_position_error_value = status.load_position_error_value,
          .motor_position_actual_value = status.motor_position_actual_value,
          .motor_position_error_value = status.motor_position_error_value,
          .velocity_demand_value = status.velocity_demand_value,
          .load_velocity_actual_value = status.load_velocity_actual_value,
          .load_velocity_error_value = status.load_velocity_error_value,
          .motor_velocity_actual_value = status.motor_velocity_actual_value,
          .motor_velocity_error_value = status.motor_velocity_error_value,
          .current_actual_value = status.current_actual_value,
          .gap_before_current_error = 0,
          .current_error_value = status.current_error_value,
          .torque_demand = status.torque_demand,
          .torque_actual_value = status.torque_actual_value,
          .ignored_set_points = status.ignored_set_points,
          .fault_count = status.fault_count,
          .objects = 0};
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
  if (!CdrReader(sample).is_good()) {
    return false;
  }
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
    if (spare_.size() < spare_.capacity()) {
      spare_.push_back(std::move(axes.back()));
    }
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
  if (!fits) {
    return Decoding::too_many_axes;
  }
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
  if (axes > msg::MAX_AXES_PER_FRAME) {
    return Decoding::too_many_axes;
  }
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
  return kEncapsulation + sizeof(FrameLayout) + axes * sizeof(StatusLayout);
}

std::size_t encode_status_frame(const StatusFrameHead& head, const AxesAfterTick& axes,
                                std::span<std::byte> output) noexcept {
  const std::size_t count = axes.status.size();
  const std::size_t size = encoded_status_frame_size(count);
  if (output.size() < size) {
    return 0;
  }
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
    const StatusLayout layout = layout_of(axes.status[axis], {head.bench, axes.numbers[axis]},
                                          head.tick, axes.owners[axis]);
    std::memcpy(place, &layout, sizeof layout);
    place += sizeof layout;
  }
  return size;
}

std::size_t encode_axis_status(const AxisStatus& status, const AxisAddress& address,
                               std::uint64_t tick, const Ownership& owner,
                               std::span<std::byte> output) noexcept {
  if (output.size() < kAxisStatusSize) {
    return 0;
  }
  const StatusLayout layout = layout_of(status, address, tick, owner);
  std::memcpy(output.data(), kLittleEndian.data(), kEncapsulation);
  std::memcpy(&output[kEncapsulation], &layout, sizeof layout);
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
