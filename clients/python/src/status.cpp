// SPDX-License-Identifier: Apache-2.0
// The state of axes as numpy arrays, and the meaning of their words and objects.
#include "status.hpp"

#include "arguments.hpp"
#include "values.hpp"
#include "vdrive/axis_status.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <pybind11/numpy.h>

#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <deque>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdrive::python {
namespace {

using client::AxisSnapshot;
using client::Observation;

/// Short names for frequently used members: those of vdrive.Status.
struct Alias {
  const char* name;
  std::string_view member;
};

constexpr std::array kAliases{
    Alias{"position", "load_position_actual_value"},
    Alias{"demand", "position_demand_value"},
    Alias{"following_error", "load_position_error_value"},
    Alias{"velocity", "load_velocity_actual_value"},
    Alias{"torque", "torque_actual_value"},
    Alias{"statusword", "ds402_statusword"},
};

/// A field of a record.
struct Field {
  std::string name;
  std::string format;
  std::size_t size;
};

Field field_of(const StatusMember& member) {
  const bool is_signed = range_of(member.data_type).lowest < 0;
  const std::size_t size = size_of(member.data_type);
  return {std::string(member.name), (is_signed ? "<i" : "<u") + std::to_string(size), size};
}

/// @return the dtype of records whose fields have no gaps. The short name of a member is the title
///         of its field, which numpy accepts as a second name.
py::dtype type_of(const std::vector<Field>& fields) {
  py::list names;
  py::list formats;
  py::list titles;
  for (const Field& field : fields) {
    names.append(field.name);
    formats.append(field.format);
    const auto* const alias = std::ranges::find(kAliases, field.name, &Alias::member);
    titles.append(alias == kAliases.end() ? py::object(py::none()) : py::str(alias->name));
  }
  py::dict description;
  description["names"] = names;
  description["formats"] = formats;
  description["titles"] = titles;
  return py::dtype::from_args(description);
}

/// Copies `size` bytes, least significant byte first, as on every supported machine.
/// @return the place after them.
std::byte* put(std::byte* place, const void* bytes, std::size_t size) {
  std::memcpy(place, bytes, size);
  return place + size;  // NOLINT(*-pointer-arithmetic): one record follows the other
}

/// Copies the bytes written by put().
/// @return the place after them.
const std::byte* take_bytes(const std::byte* place, void* bytes, std::size_t size) {
  std::memcpy(bytes, place, size);
  return place + size;  // NOLINT(*-pointer-arithmetic): one record follows the other
}

/// The records of an array: tick and missed samples, the members of the status, the owner.
class RecordLayout {
 public:
  RecordLayout() {
    add({"tick", "<u8", sizeof(std::uint64_t)});
    add({"missed", "<u8", sizeof(std::uint64_t)});
    add_members();
    add({"owner", "<u8", sizeof(std::uint64_t)});
    add({"owner_epoch", "<u4", sizeof(std::uint32_t)});
  }

  /// @return the size of a record in bytes.
  [[nodiscard]] std::size_t size() const {
    std::size_t size = 0;
    for (const Field& field : fields_) size += field.size;
    return size;
  }

  [[nodiscard]] py::dtype type() const { return type_of(fields_); }

  /// Copies pieces of fixed size, which the compiler turns into single instructions.
  /// @return the place after the record.
  static std::byte* write(const AxisSnapshot& axis, std::uint64_t missed, std::byte* place) {
    const auto image = std::as_bytes(std::span(&axis.status, 1));
    place = put(place, &axis.tick, sizeof axis.tick);
    place = put(place, &missed, sizeof missed);
    place = put(place, image.data(), kBefore);
    place = put(place, image.last<kAfter>().data(), kAfter);
    place = put(place, &axis.owner_session, sizeof axis.owner_session);
    return put(place, &axis.owner_epoch, sizeof axis.owner_epoch);
  }

  /// Reads a record written by write().
  /// @return the place after the record.
  static const std::byte* read(const std::byte* place, AxisSnapshot& axis, std::uint64_t& missed) {
    const auto image = std::as_writable_bytes(std::span(&axis.status, 1));
    place = take_bytes(place, &axis.tick, sizeof axis.tick);
    place = take_bytes(place, &missed, sizeof missed);
    place = take_bytes(place, image.data(), kBefore);
    place = take_bytes(place, image.last<kAfter>().data(), kAfter);
    place = take_bytes(place, &axis.owner_session, sizeof axis.owner_session);
    return take_bytes(place, &axis.owner_epoch, sizeof axis.owner_epoch);
  }

 private:
  // The members before the only unpublished one, and those after it.
  static constexpr std::size_t kBefore = offsetof(AxisStatus, ds402_controlword);
  static constexpr std::size_t kAfter = sizeof(AxisStatus) - offsetof(AxisStatus, error_code);

  void add(Field field) { fields_.push_back(std::move(field)); }

  /// The table is in the order of the members, which have no gaps.
  void add_members() {
    std::size_t offset = 0;
    for (const StatusMember& member : status_members()) {
      const std::size_t size = size_of(member.data_type);
      const bool is_written = offset + size <= kBefore || offset >= sizeof(AxisStatus) - kAfter;
      if (member.is_published != is_written) {
        throw std::logic_error("a record is written without " + std::string(member.name) +
                               ", or with it although it is not published");
      }
      if (member.is_published) add(field_of(member));
      offset += size;
    }
  }

  std::vector<Field> fields_;
};

const RecordLayout& layout() {
  static const RecordLayout only;
  return only;
}

/// @return whether the records have these fields. Titles (the short names) are not compared: arrays
///         saved by an earlier version have none.
bool has_layout(const py::dtype& type) {
  const py::dtype own = layout().type();
  const py::tuple names = own.attr("names");
  if (!names.equal(type.attr("names")) || own.itemsize() != type.itemsize()) return false;
  const py::slice type_and_offset(0, 2, 1);
  return std::all_of(names.begin(), names.end(), [&](const py::handle name) {
    const py::object field = own.attr("fields")[name][type_and_offset];
    return field.equal(type.attr("fields")[name][type_and_offset]);
  });
}

std::vector<std::uint64_t> owners_of(const Observation& sample) {
  std::vector<std::uint64_t> owners;
  owners.reserve(sample.axes.size());
  for (const AxisSnapshot& axis : sample.axes) owners.push_back(axis.owner_session);
  return owners;
}

/// @throws py::index_error
py::tuple axis_of(const Observation& sample, std::int64_t place) {
  if (place < 0 || std::cmp_greater_equal(place, sample.axes.size())) {
    throw py::index_error("no such axis in the sample");
  }
  return tuple_of(sample.axes[static_cast<std::size_t>(place)]);
}

void add_observation(py::module_& module) {
  py::class_<Observation>(module, "Observation")
      .def_readonly("tick", &Observation::tick)
      .def_readonly("missed", &Observation::missed)
      .def_readonly("skipped", &Observation::skipped)
      .def("axes",
           [](const Observation& sample) {
             return tuples_of(sample.axes);
           })
      .def("owners", &owners_of)
      .def("array",
           [](const Observation& sample) {
             Frames frames(sample.axes.size());
             frames.add(sample);
             return py::object(frames.take(1)[py::int_(0)]);
           })
      .def("size",
           [](const Observation& sample) {
             return sample.axes.size();
           })
      .def("axis", &axis_of);
}

/// Adds functions that decode the words of a status.
void add_meanings(py::module_& module) {
  module.def("power_state", [](std::uint16_t statusword) {
    return static_cast<std::uint8_t>(decode_power_state(statusword));
  });
  module.def("state_text", [](std::uint16_t statusword) {
    return to_string(decode_power_state(statusword));
  });
  module.def("is_enabled", [](std::uint16_t statusword) {
    return decode_power_state(statusword) == PowerState::operation_enabled;
  });
  module.def("has_fault", [](std::uint16_t statusword) {
    return is_fault(decode_power_state(statusword));
  });
  module.def("mode_text", [](std::int8_t mode) {
    return to_string(static_cast<OperatingMode>(mode));
  });
  module.def("statusword_flags", [](std::uint16_t statusword, std::int8_t mode) {
    return client::statusword_flags(statusword, static_cast<OperatingMode>(mode));
  });
  module.def("statusword_text", [](std::uint16_t statusword, std::int8_t mode) {
    return client::describe_statusword(statusword, static_cast<OperatingMode>(mode));
  });
  module.def("status_value", [](std::string_view image, std::uint32_t object) {
    AxisSnapshot axis;
    std::memcpy(&axis.status, image.data(), std::min(image.size(), sizeof axis.status));
    return value_of(axis, object_of(object));
  });
}

/// @throws py::key_error if the dictionary has no object with that name or address
std::uint32_t object_named(const std::string& name) {
  if (const auto named = parse_object(name)) {
    return std::uint32_t{named->index} << kSubindexBits | named->subindex;
  }
  const std::string meant = address_suggestion(name);
  throw py::key_error("the dictionary has no object " + in_quotes(name) +
                      (meant.empty() ? suggestion(name, names_of_objects()) : meant));
}

}  // namespace

Frames::Frames(std::size_t axes) : axes_(axes), row_(axes * layout().size()) {}

void Frames::expect(std::size_t samples) {
  // An excessive count must not fail before any sample has arrived, so memory beyond this is
  // allocated only as samples arrive.
  constexpr std::size_t kMostAtFirst = std::size_t{1} << 28U;  // [bytes]
  records_.reserve(std::min(samples, kMostAtFirst / std::max<std::size_t>(row_, 1)) * row_);
  // Without huge pages, the kernel clears 15,000 pages of 4 kB for a recording of 60 MB, which
  // takes a quarter of the time. A kernel that has no huge pages ignores the advice.
  constexpr std::size_t kHugePage = std::size_t{1} << 21U;
  void* place = records_.data();
  std::size_t room = records_.capacity();
  if (std::align(kHugePage, kHugePage, place, room) != nullptr) {
    static_cast<void>(madvise(place, room, MADV_HUGEPAGE));
  }
}

void Frames::add(const Observation& sample) {
  if (sample.axes.size() != axes_)
    throw std::logic_error("the sample has a different number of axes");
  const std::size_t begin = records_.size();
  records_.resize(begin + row_);
  std::byte* place = std::span(records_).subspan(begin).data();
  for (const AxisSnapshot& axis : sample.axes) {
    place = RecordLayout::write(axis, sample.missed, place);
  }
  ++samples_;
}

py::array Frames::take(std::size_t most) {
  const std::size_t count = std::min(most, samples_);
  auto taken = std::make_unique<std::vector<std::byte>>();
  taken->swap(records_);
  if (count < samples_) {
    const auto end = taken->begin() + static_cast<std::ptrdiff_t>(count * row_);
    records_.assign(end, taken->end());
    taken->erase(end, taken->end());
  }
  samples_ -= count;
  const std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(count),
                                       static_cast<py::ssize_t>(axes_)};
  // The array uses the records in place and owns them.
  const std::byte* const first = taken->data();
  const py::capsule owner(taken.get(), [](void* records) {
    // NOLINTNEXTLINE(cppcoreguidelines-owning-memory): released below
    delete static_cast<std::vector<std::byte>*>(records);
  });
  static_cast<void>(taken.release());
  return {layout().type(), shape, first, owner};
}

FrameView::FrameView(const py::array& frames, std::size_t axes)
    : records_(static_cast<const std::byte*>(frames.data())),
      samples_(static_cast<std::size_t>(frames.ndim() == 2 ? frames.shape(0) : 0)) {
  if (frames.ndim() != 2 || std::cmp_not_equal(frames.shape(1), axes)) {
    throw py::value_error(
        "the frames of a recording have a row per sample and a column for each of "
        "its " +
        std::to_string(axes) + " axes");
  }
  const bool is_dense = (frames.flags() & py::array::c_style) != 0;
  if (!is_dense || !has_layout(frames.dtype())) {
    throw py::value_error(
        "the frames of a recording have the dtype of vdrive.record_type() and no gaps between "
        "them");
  }
}

void FrameView::read(std::size_t row, Observation& sample) const {
  const std::size_t begin = row * sample.axes.size() * layout().size();
  const std::byte* place = records_ + begin;  // NOLINT(*-pointer-arithmetic): rows of one size
  for (AxisSnapshot& axis : sample.axes) {
    place = RecordLayout::read(place, axis, sample.missed);
  }
  sample.tick = sample.axes.front().tick;
}

py::array frames_of(const std::deque<Observation>& samples, std::size_t axes) {
  Frames frames(axes);
  frames.expect(samples.size());
  for (const Observation& sample : samples) frames.add(sample);
  return frames.take(samples.size());
}

py::dtype status_image_type() {
  load_numpy();
  std::vector<Field> fields;
  fields.reserve(kStatusMembers);
  for (const StatusMember& member : status_members()) fields.push_back(field_of(member));
  return type_of(fields);  // the table is in the order of the members, without gaps
}

void add_status(py::module_& module) {
  add_observation(module);
  add_meanings(module);
  module.attr("STATUS_SIZE") = sizeof(AxisStatus);
  module.def("object_named", &object_named);
  module.def("record_type", [] {
    load_numpy();
    return layout().type();
  });
}

}  // namespace vdrive::python
