// SPDX-License-Identifier: Apache-2.0
// The state of axes: objects for people, arrays of numpy for calculations.
#include "status.hpp"

#include "arguments.hpp"
#include "vdrive/axis_status.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_text.hpp"

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
#include <tuple>
#include <utility>
#include <vector>

namespace vdrive::python {
namespace {

using client::AxisSnapshot;
using client::Observation;

/// Short names for what programs ask most.
struct Alias {
  const char* name;
  std::string_view member;
  const char* text;
};

constexpr std::array kAliases{
    Alias{"position", "load_position_actual_value", "Actual position (6064h), in UU."},
    Alias{"demand", "position_demand_value", "Demand position (6062h), in UU."},
    Alias{"following_error", "load_position_error_value", "Following error (60F4h), in UU."},
    Alias{"velocity", "load_velocity_actual_value", "Actual velocity (606Ch), in UU/s."},
    Alias{"torque", "torque_actual_value",
          "Actual torque (6077h), in parts of 1,000 of the rated."},
    Alias{"statusword", "ds402_statusword", "Statusword (6041h)."},
};

const StatusMember& member_named(std::string_view name) {
  for (const StatusMember& member : status_members()) {
    if (member.name == name) return member;
  }
  throw std::logic_error("the status has no member " + std::string(name));
}

std::string text_of(const StatusMember& member) {
  if (member.address.index == 0) return "Counted by the drive since power-up.";
  const auto row = find_object(member.address);
  const std::string units = row ? english_units(describe(*row)) : "";
  return object_text(member.address) + (units.empty() ? "." : ", in " + units + ".");
}

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

/// @return the dtype of records in which the fields follow each other without gaps. The short name
/// of a member is the title of its field: numpy takes it as a second name.
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

std::vector<const StatusMember*> published_members() {
  std::vector<const StatusMember*> members;
  members.reserve(kStatusMembers);
  for (const StatusMember& member : status_members()) {
    if (member.is_published) members.push_back(&member);
  }
  return members;
}

/// Copies `size` bytes, the least significant of each number first, as on every machine that runs
/// this. @return the place behind them.
std::byte* put(std::byte* place, const void* bytes, std::size_t size) {
  std::memcpy(place, bytes, size);
  return place + size;  // NOLINT(*-pointer-arithmetic): the records lie behind each other
}

/// Copies what put() has written. @return the place behind it.
const std::byte* take_bytes(const std::byte* place, void* bytes, std::size_t size) {
  std::memcpy(bytes, place, size);
  return place + size;  // NOLINT(*-pointer-arithmetic): the records lie behind each other
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

  /// @return the bytes of a record.
  [[nodiscard]] std::size_t size() const {
    std::size_t size = 0;
    for (const Field& field : fields_) size += field.size;
    return size;
  }

  [[nodiscard]] py::dtype type() const { return type_of(fields_); }

  /// Pieces of known sizes, which the compiler copies by single instructions.
  /// @return the place behind the record.
  static std::byte* write(const AxisSnapshot& axis, std::uint64_t missed, std::byte* place) {
    const auto image = std::as_bytes(std::span(&axis.status, 1));
    place = put(place, &axis.tick, sizeof axis.tick);
    place = put(place, &missed, sizeof missed);
    place = put(place, image.data(), kBefore);
    place = put(place, image.last<kBehind>().data(), kBehind);
    place = put(place, &axis.owner_session, sizeof axis.owner_session);
    return put(place, &axis.owner_epoch, sizeof axis.owner_epoch);
  }

  /// What write() has written. @return the place behind the record.
  static const std::byte* read(const std::byte* place, AxisSnapshot& axis, std::uint64_t& missed) {
    const auto image = std::as_writable_bytes(std::span(&axis.status, 1));
    place = take_bytes(place, &axis.tick, sizeof axis.tick);
    place = take_bytes(place, &missed, sizeof missed);
    place = take_bytes(place, image.data(), kBefore);
    place = take_bytes(place, image.last<kBehind>().data(), kBehind);
    place = take_bytes(place, &axis.owner_session, sizeof axis.owner_session);
    return take_bytes(place, &axis.owner_epoch, sizeof axis.owner_epoch);
  }

 private:
  // The members in front of the only one that is not published, and those behind it.
  static constexpr std::size_t kBefore = offsetof(AxisStatus, ds402_controlword);
  static constexpr std::size_t kBehind = sizeof(AxisStatus) - offsetof(AxisStatus, error_code);

  void add(Field field) { fields_.push_back(std::move(field)); }

  /// The table is in the order of the members, which have no gaps.
  void add_members() {
    std::size_t offset = 0;
    for (const StatusMember& member : status_members()) {
      const std::size_t size = size_of(member.data_type);
      const bool is_written = offset + size <= kBefore || offset >= sizeof(AxisStatus) - kBehind;
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

/// @return whether the records have these fields. Titles, the short names, do not count: arrays
///         that an earlier version has saved have none.
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

std::string repr_of(const AxisSnapshot& status) {
  return "<vdrive.Status " + to_string(status.id) + " tick " + std::to_string(status.tick) + " " +
         client::describe_statusword(status.status.ds402_statusword, status.mode()) + ">";
}

/// The members of the status, each under its own name: the table of the core lists them.
void add_members(py::class_<AxisSnapshot>& status) {
  for (const StatusMember* const member : published_members()) {
    const std::string name(member->name);
    status.def_property_readonly(
        name.c_str(),
        [member](const AxisSnapshot& axis) {
          return member->value(axis.status);
        },
        text_of(*member).c_str());
  }
  for (const Alias& alias : kAliases) {
    const StatusMember* const member = &member_named(alias.member);
    status.def_property_readonly(
        alias.name,
        [member](const AxisSnapshot& axis) {
          return member->value(axis.status);
        },
        alias.text);
  }
}

void add_states(py::class_<AxisSnapshot>& status) {
  status
      .def_property_readonly(
          "state",
          [](const AxisSnapshot& axis) {
            return std::string(to_string(axis.state()));
          },
          R"(State of the power drive system, such as "Operation enabled".)")
      .def_property_readonly(
          "power_state",
          [](const AxisSnapshot& axis) {
            return py::module_::import("vdrive._enums")
                .attr("PowerState")(static_cast<std::uint8_t>(axis.state()));
          },
          "The same as a PowerState.")
      .def_property_readonly(
          "mode",
          [](const AxisSnapshot& axis) {
            return std::string(to_string(axis.mode()));
          },
          R"(Operating mode in force (6061h), such as "profile position".)")
      .def_property_readonly(
          "flags",
          [](const AxisSnapshot& axis) {
            return client::statusword_flags(axis.status.ds402_statusword, axis.mode());
          },
          R"(Names of the bits of the statusword that are 1, such as "target reached".)")
      .def_property_readonly(
          "is_enabled",
          [](const AxisSnapshot& axis) {
            return axis.state() == PowerState::operation_enabled;
          },
          "Whether the state is Operation enabled.")
      .def_property_readonly(
          "has_fault",
          [](const AxisSnapshot& axis) {
            return is_fault(axis.state());
          },
          "Whether the state is Fault or Fault reaction active.")
      .def(
          "shows",
          [](const AxisSnapshot& axis, const Number& bits) {
            return axis.shows(whole<std::uint16_t>(bits, {"bits"}));
          },
          py::arg("bits"), "Whether all of `bits` are 1 in the statusword.")
      .def(
          "value",
          [](const AxisSnapshot& axis, const py::object& object) {
            return value_of(axis, object_of(object));
          },
          py::arg("object"),
          "Value of an object that is part of the status, else None. `object` as in Axis.read().");
}

std::vector<std::uint64_t> owners_of(const Observation& sample) {
  std::vector<std::uint64_t> owners;
  owners.reserve(sample.axes.size());
  for (const AxisSnapshot& axis : sample.axes) owners.push_back(axis.owner_session);
  return owners;
}

bool is_equal(const AxisSnapshot& axis, const AxisSnapshot& other) {
  const auto parts = [](const AxisSnapshot& of) {
    return std::tie(of.id.bench, of.id.axis, of.tick, of.owner_session, of.owner_epoch,
                    of.last_sequence, of.skipped);
  };
  return parts(axis) == parts(other) &&
         std::memcmp(&axis.status, &other.status, sizeof(AxisStatus)) == 0;
}

void add_observation(py::module_& module) {
  py::class_<Observation>(module, "Observation", "All watched axes after the same tick.")
      .def_readonly("tick", &Observation::tick, "The tick.")
      .def_readonly("missed", &Observation::missed,
                    "Samples of the stream lost since the one before.")
      .def_readonly(
          "skipped", &Observation::skipped,
          "Ticks since the one before that the tick number jumped over: not run, not lost.")
      .def_readonly("axes", &Observation::axes, "Status of each axis, in the order of the request.")
      .def_property_readonly("owners", &owners_of, "Session that holds each axis, 0 = none.")
      .def(
          "array",
          [](const Observation& sample) {
            Frames frames(sample.axes.size());
            frames.add(sample);
            return py::object(frames.take(1)[py::int_(0)]);
          },
          "The axes as a numpy array of records, a field for each member of the status.")
      .def("__len__",
           [](const Observation& sample) {
             return sample.axes.size();
           })
      .def(
          "__getitem__",
          [](const Observation& sample, const Number& place) {
            const auto axis = whole<std::int64_t>(place, {"place"});
            if (axis < 0 || std::cmp_greater_equal(axis, sample.axes.size())) {
              throw py::index_error("no such axis in the sample");
            }
            return sample.axes[static_cast<std::size_t>(axis)];
          },
          py::arg("place"))
      .def(
          "__eq__",
          [](const Observation& sample, const py::object& object) {
            if (!py::isinstance<Observation>(object)) return false;
            const auto& other = object.cast<const Observation&>();
            return sample.tick == other.tick && sample.missed == other.missed &&
                   sample.skipped == other.skipped &&
                   std::ranges::equal(sample.axes, other.axes, is_equal);
          },
          py::arg("other"), "Whether it shows the same axes with the same values in the same tick.")
      .def("__hash__",
           [](const Observation& sample) {
             return py::hash(py::make_tuple(sample.tick, sample.axes.size()));
           })
      .def("__repr__", [](const Observation& sample) {
        return "<vdrive.Observation tick " + std::to_string(sample.tick) + ", " +
               std::to_string(sample.axes.size()) + " axes>";
      });
}

}  // namespace

Frames::Frames(std::size_t axes) : axes_(axes), row_(axes * layout().size()) {}

void Frames::expect(std::size_t samples) {
  // More grows with the samples: a count that is too large has to fail at none of them.
  constexpr std::size_t kMostAtFirst = std::size_t{1} << 28U;  // [bytes]
  records_.reserve(std::min(samples, kMostAtFirst / std::max<std::size_t>(row_, 1)) * row_);
  // Of a recording of 60 MB the kernel would clear 15,000 pages of 4 kB: a quarter of its time.
  // Where it has no huge pages it refuses, and clears them.
  constexpr std::size_t kHugePage = std::size_t{1} << 21U;
  void* place = records_.data();
  std::size_t room = records_.capacity();
  if (std::align(kHugePage, kHugePage, place, room) != nullptr) {
    static_cast<void>(madvise(place, room, MADV_HUGEPAGE));
  }
}

void Frames::add(const Observation& sample) {
  if (sample.axes.size() != axes_) throw std::logic_error("a sample has other axes");
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
  // The array has the records where they lie, and ends them.
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
        "the frames of a recording have the dtype of vdrive.record_type() and lie behind each "
        "other");
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
  return type_of(fields);  // the table is in the order of the members, which have no gaps
}

namespace {

/// Everything of a snapshot but the status, as a tuple for pickle; the status is its bytes.
py::tuple state_of(const AxisSnapshot& axis) {
  const auto image = std::as_bytes(std::span(&axis.status, 1));
  const py::bytes status(reinterpret_cast<const char*>(image.data()),  // NOLINT(*-reinterpret-cast)
                         image.size());
  return py::make_tuple(axis.id.bench, axis.id.axis, axis.tick, axis.owner_session,
                        axis.owner_epoch, axis.last_sequence, axis.skipped, status);
}

/// @throws py::value_error where another version of vdrive wrote it
AxisSnapshot snapshot_of(const py::tuple& state) {
  constexpr std::size_t kParts = 8;
  if (state.size() != kParts) throw py::value_error("the status is of another version of vdrive");
  AxisSnapshot axis;
  axis.id = {state[0].cast<std::uint32_t>(), state[1].cast<std::uint16_t>()};
  axis.tick = state[2].cast<std::uint64_t>();
  axis.owner_session = state[3].cast<std::uint64_t>();
  axis.owner_epoch = state[4].cast<std::uint32_t>();
  axis.last_sequence = state[5].cast<std::uint64_t>();
  axis.skipped = state[6].cast<std::uint64_t>();
  const auto status = state[7].cast<std::string_view>();
  const auto image = std::as_writable_bytes(std::span(&axis.status, 1));
  if (status.size() != image.size()) {
    throw py::value_error("the status is of another version of vdrive");
  }
  std::memcpy(image.data(), status.data(), image.size());
  return axis;
}

}  // namespace

void add_status(py::module_& module) {
  py::class_<AxisSnapshot> status(module, "Status", "One axis after a tick. UU: user units.");
  status
      .def_property_readonly(
          "id",
          [](const AxisSnapshot& axis) {
            return to_string(axis.id);
          },
          R"(Address of the axis, such as "1.2".)")
      .def(
          "__eq__",
          [](const AxisSnapshot& axis, const py::object& other) {
            return py::isinstance<AxisSnapshot>(other) &&
                   is_equal(axis, other.cast<const AxisSnapshot&>());
          },
          "Whether it is the same axis with the same values in the same tick.")
      .def("__hash__",
           [](const AxisSnapshot& axis) {
             return py::hash(py::make_tuple(axis.id.bench, axis.id.axis, axis.tick));
           })
      .def(py::pickle(&state_of, &snapshot_of))
      .def_readonly("tick", &AxisSnapshot::tick, "The tick.")
      .def_readonly("owner", &AxisSnapshot::owner_session, "Session that holds the axis, 0 = none.")
      .def_readonly("owner_epoch", &AxisSnapshot::owner_epoch, "Epoch of that session.")
      .def("__repr__", &repr_of);
  add_states(status);
  add_members(status);
  add_observation(module);
  module.def(
      "record_type",
      [] {
        load_numpy();
        return layout().type();
      },
      "The numpy dtype of the records of recordings and observations.");
}

}  // namespace vdrive::python
