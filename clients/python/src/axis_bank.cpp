// SPDX-License-Identifier: Apache-2.0
// The drive alone: a bank of axes that the program steps itself.
#include "vdrive/axis_bank.hpp"

#include "arguments.hpp"
#include "errors.hpp"
#include "fork.hpp"
#include "py_session.hpp"
#include "python.hpp"
#include "status.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/plant/model_parameters.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <pybind11/numpy.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace vdrive::python {
namespace {

/// Axis-ticks between two checks for signals: some 10 ms.
constexpr std::int64_t kAxisTicksAtOnce = 262'144;

/// Axis numbers, or values, already converted by the package.
using Integers = py::array_t<std::int64_t, py::array::c_style>;

/// The start of a snapshot. The state of the bank follows.
struct SnapshotHead {
  std::array<char, 8> kind{'v', 'd', 'r', 'v', 'b', 'a', 'n', 'k'};
  std::uint64_t layout = AxisBank::snapshot_layout();
  std::uint64_t axes = 0;
  std::uint64_t period_us = 0;
  std::uint64_t configuration = 0;  // checksum
  std::uint64_t tick = 0;
  std::uint64_t check = 0;  // of everything before it and of the state
};

static_assert(std::has_unique_object_representations_v<SnapshotHead>);

std::uint64_t check_of(const py::bytes& content) {
  return py::module_::import("zlib").attr("crc32")(content).cast<std::uint64_t>();
}

template <typename Plain>
void append(std::string& content, const Plain& plain) {
  std::array<char, sizeof(Plain)> bytes{};
  std::memcpy(bytes.data(), &plain, sizeof(Plain));
  content.append(bytes.data(), bytes.size());
}

/// @return the value of `head.check` for this state.
std::uint64_t check_of(SnapshotHead head, std::string_view state) {
  head.check = 0;
  std::string begin;
  append(begin, head);
  const py::object crc32 = py::module_::import("zlib").attr("crc32");
  return crc32(py::bytes(state.data(), state.size()), crc32(py::bytes(begin)))
      .cast<std::uint64_t>();
}

/// @return a checksum of the arguments from which a bank is constructed.
std::uint64_t check_of(std::span<const AxisConfiguration> axes) {
  std::string content;
  for (const AxisConfiguration& axis : axes) {
    append(content, axis.model.coupling);
    append(content, axis.model.feedback);
    for (const ModelParameter& parameter : kModelParameters) {
      append(content, axis.model.*parameter.member);
    }
    for (const InitialValue& initial : axis.parameters) {
      append(content, initial.address.index);
      append(content, initial.address.subindex);
      append(content, initial.value);
    }
  }
  return check_of(py::bytes(content));
}

/// Steps a bank without the interpreter lock.
void step_unlocked(AxisBank& bank, std::int64_t ticks) {
  const Unlocked unlocked;
  for (std::int64_t done = 0; done < ticks && !is_late(); ++done) bank.step();
}

/// A bank, and the thread that uses it. Every member is guarded by the interpreter lock, except the
/// bank during a step.
class PyAxisBank {
 public:
  /// @throws std::invalid_argument as AxisBank does
  PyAxisBank(const std::vector<AxisConfiguration>& axes, std::chrono::microseconds period)
      : bank_(axes, period), configuration_(check_of(axes)), type_(status_image_type()) {}

  /// The right to use the bank, for the lifetime of this object.
  class Use {
   public:
    /// @throws std::runtime_error while another thread uses the bank; py::error_already_set with
    ///         Forked if a thread of the parent was using it when this process was forked
    explicit Use(PyAxisBank& owner) : owner_(owner) {
      if (owner.in_use_) {
        owner.in_use_->require_own("the step that is under way in this bank");
        throw std::runtime_error(
            "another thread uses this bank: one thread at a time steps, writes or reads it");
      }
      owner.in_use_.emplace();
    }

    ~Use() { owner_.in_use_.reset(); }

    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;

    [[nodiscard]] AxisBank& bank() const noexcept { return owner_.bank_; }

   private:
    PyAxisBank& owner_;
  };

  [[nodiscard]] std::size_t size() const noexcept { return bank_.size(); }

  [[nodiscard]] double period() const { return seconds_of(bank_.period()); }

  [[nodiscard]] std::uint64_t tick() const noexcept { return tick_; }

  /// @return a view of the status images in the memory of the bank; `self` is the Python object of
  ///         this bank.
  [[nodiscard]] py::array status(const py::object& self) const;

  /// @return the tick.
  std::uint64_t step(std::int64_t ticks);

  [[nodiscard]] py::bytes snapshot();

  /// @throws py::value_error if it is not from a bank constructed in the same way
  void restore(const py::bytes& snapshot);

 private:
  /// @throws py::value_error
  void check(const SnapshotHead& head) const;

  AxisBank bank_;
  std::uint64_t configuration_;
  py::dtype type_;
  std::uint64_t tick_ = 0;
  std::optional<Origin> in_use_;
};

py::array PyAxisBank::status(const py::object& self) const {
  const std::span<const AxisStatus> images = bank_.statuses();
  py::array view(type_, std::vector<py::ssize_t>{static_cast<py::ssize_t>(images.size())},
                 images.data(), self);
  // It cannot be made writable again: its base, this object, provides no writable buffer.
  view.attr("setflags")(py::arg("write") = false);
  return view;
}

std::uint64_t PyAxisBank::step(std::int64_t ticks) {
  const Use use(*this);
  const auto most = std::max<std::int64_t>(1, kAxisTicksAtOnce / static_cast<std::int64_t>(size()));
  while (ticks > 0) {
    const std::int64_t part = std::min(ticks, most);
    step_unlocked(use.bank(), part);
    tick_ += static_cast<std::uint64_t>(part);
    ticks -= part;
    handle_signals();
  }
  return tick_;
}

py::bytes PyAxisBank::snapshot() {
  const std::vector<std::byte> state = Use(*this).bank().snapshot().bytes();
  // NOLINTNEXTLINE(*-reinterpret-cast): bytes of Python are characters
  const auto* const first = reinterpret_cast<const char*>(state.data());
  SnapshotHead head{.axes = size(),
                    .period_us = static_cast<std::uint64_t>(bank_.period().count()),
                    .configuration = configuration_,
                    .tick = tick_};
  head.check = check_of(head, std::string_view(first, state.size()));
  std::string content;
  content.reserve(sizeof head + state.size());
  append(content, head);
  content.append(first, state.size());
  return {content};
}

void PyAxisBank::check(const SnapshotHead& head) const {
  const auto require = [](bool holds, const std::string& what) {
    if (!holds) throw py::value_error("the snapshot cannot be restored: " + what);
  };
  require(head.kind == SnapshotHead{}.kind, "these bytes are not of AxisBank.snapshot()");
  require(head.layout == SnapshotHead{}.layout, "it is from another version of vdrive");
  require(head.axes == size(),
          "it has " + std::to_string(head.axes) + " axes, the bank has " + std::to_string(size()));
  const auto period_us = static_cast<std::uint64_t>(bank_.period().count());
  require(head.period_us == period_us, "its period is " + std::to_string(head.period_us) +
                                           " us, that of the bank " + std::to_string(period_us) +
                                           " us");
  require(head.configuration == configuration_,
          "its bank was built with another model or other parameters");
}

void PyAxisBank::restore(const py::bytes& snapshot) {
  const std::string_view content = snapshot;
  SnapshotHead head{.kind{}};
  std::memcpy(&head, content.data(), std::min(sizeof head, content.size()));
  check(head);
  const std::string_view state = content.substr(std::min(sizeof head, content.size()));
  if (check_of(head, state) != head.check) {
    throw py::value_error("the snapshot cannot be restored: its " + std::to_string(content.size()) +
                          " bytes are damaged");
  }
  const Use use(*this);
  use.bank().restore(use.bank().snapshot_from(std::as_bytes(std::span(state))));
  tick_ = head.tick;
}

// ---- axes, objects, values ---------------------------------------------------------------------

/// @throws py::index_error
std::size_t checked_axis(const AxisBank& bank, std::int64_t axis) {
  if (axis >= 0 && std::cmp_less(axis, bank.size())) return static_cast<std::size_t>(axis);
  throw py::index_error("axis = " + std::to_string(axis) + ": must be from 0 to " +
                        std::to_string(bank.size() - 1));
}

/// @param axes numbers, or nothing: all.
/// @throws py::index_error
std::vector<std::size_t> axes_in(const AxisBank& bank, const std::optional<Integers>& axes) {
  std::vector<std::size_t> found(axes ? static_cast<std::size_t>(axes->size()) : bank.size());
  for (std::size_t place = 0; place < found.size(); ++place) {
    found[place] = axes ? checked_axis(bank, axes->data()[place]) : place;
  }
  return found;
}

/// @return the limits of the object if `value` is outside them, otherwise nothing.
std::string limits_of_object(ObjectAddress object, std::int64_t value) {
  const auto row = find_object(object);
  if (!row) return "";
  const ObjectDescription& description = vdrive::describe(*row);
  const TypeRange type = range_of(description.data_type);
  const std::int64_t lowest = std::max(type.lowest, description.lower_limit);
  const std::int64_t highest = std::min(type.highest, description.upper_limit);
  if (value >= lowest && value <= highest) return "";
  return ", must be from " + std::to_string(lowest) + " to " + std::to_string(highest);
}

void write_one(AxisBank& bank, std::size_t axis, ObjectAddress object, std::int64_t value) {
  const AbortCode code = bank.write(axis, object, value);
  if (code == AbortCode::none) return;
  raise(client::Outcome::refused(wire_code(code), "write of " + std::to_string(value) + " to " +
                                                      object_text(object) + " of axis " +
                                                      std::to_string(axis) + " refused" +
                                                      limits_of_object(object, value)));
}

std::int64_t read_one(const AxisBank& bank, std::size_t axis, ObjectAddress object) {
  const ReadResult result = bank.read(axis, object);
  if (result.code == AbortCode::none) return result.value;
  raise(client::Outcome::refused(
      wire_code(result.code),
      "read of " + object_text(object) + " of axis " + std::to_string(axis) + " refused"));
}

void write_object(PyAxisBank& self, std::int64_t axis, std::uint32_t object, std::int64_t value) {
  const PyAxisBank::Use use(self);
  write_one(use.bank(), checked_axis(use.bank(), axis), object_of(object), value);
}

void write_objects(PyAxisBank& self, const std::optional<Integers>& axis, std::uint32_t object,
                   const Integers& values) {
  const PyAxisBank::Use use(self);
  const std::vector<std::size_t> axes = axes_in(use.bank(), axis);
  const auto count = static_cast<std::size_t>(values.size());
  const bool is_one = values.ndim() == 0;
  if (!is_one && count != axes.size()) {
    throw py::value_error(std::to_string(count) + " values for " + std::to_string(axes.size()) +
                          " axes");
  }
  for (std::size_t place = 0; place < axes.size(); ++place) {
    write_one(use.bank(), axes[place], object_of(object), values.data()[is_one ? 0 : place]);
  }
}

std::int64_t read_object(PyAxisBank& self, std::int64_t axis, std::uint32_t object) {
  const PyAxisBank::Use use(self);
  return read_one(use.bank(), checked_axis(use.bank(), axis), object_of(object));
}

Integers read_objects(PyAxisBank& self, const std::optional<Integers>& axis, std::uint32_t object) {
  const PyAxisBank::Use use(self);
  const std::vector<std::size_t> axes = axes_in(use.bank(), axis);
  Integers values(static_cast<py::ssize_t>(axes.size()));
  for (std::size_t place = 0; place < axes.size(); ++place) {
    values.mutable_data()[place] = read_one(use.bank(), axes[place], object_of(object));
  }
  return values;
}

void set_load_noise(PyAxisBank& self, const std::optional<Integers>& axis, double rms,
                    std::uint64_t seed) {
  const PyAxisBank::Use use(self);
  for (const std::size_t each : axes_in(use.bank(), axis)) {
    use.bank().set_load_noise(each, rms, seed);
  }
}

// ---- construction ------------------------------------------------------------------------------

/// @return the choice that `value` names: a key of the model accepts two words, as in a
///         configuration of the service.
template <typename Choice>
Choice choice_of(const std::string& key, const py::handle& value,
                 const std::array<Choice, 2>& choices) {
  const auto text = py::str(value).cast<std::string>();
  for (const Choice choice : choices) {
    if (text == to_string(choice)) return choice;
  }
  raise_configuration_error("model: " + key + " = " + in_quotes(text) + " must be " +
                            std::string(to_string(choices[0])) + " or " +
                            std::string(to_string(choices[1])));
}

void set_number(AxisModel& model, const std::string& key, const py::handle& value) {
  const auto* const row = std::ranges::find(kModelParameters, key, &ModelParameter::name);
  if (row != kModelParameters.end()) {
    if (PyFloat_Check(value.ptr()) == 0) {
      raise_configuration_error("model: " + key + " is a number" +
                                (row->unit.empty() ? "" : ", in " + std::string(row->unit)));
    }
    model.*row->member = value.cast<double>();
    return;
  }
  std::vector<std::string> names{"coupling", "feedback"};
  for (const ModelParameter& parameter : kModelParameters) names.emplace_back(parameter.name);
  raise_configuration_error("model: unknown key " + in_quotes(key) + suggestion(key, names) +
                            "; known keys: " + joined(names));
}

/// @param keys with their numbers as float
AxisModel model_of(const py::dict& keys) {
  AxisModel model;
  for (const auto& [name, value] : keys) {
    const auto key = py::str(name).cast<std::string>();
    if (key == "coupling") {
      model.coupling = choice_of<Coupling>(key, value, {Coupling::rigid, Coupling::two_inertia});
    } else if (key == "feedback") {
      model.feedback =
          choice_of<Feedback>(key, value, {Feedback::single_encoder, Feedback::dual_encoder});
    } else {
      set_number(model, key, value);
    }
  }
  return model;
}

/// @param models one for all axes, one per axis, or none
std::unique_ptr<PyAxisBank> make_bank(
    std::size_t count, std::int64_t period, const std::vector<py::dict>& models,
    const std::vector<std::pair<std::uint32_t, std::int64_t>>& parameters) {
  AxisConfiguration common;
  for (const auto& [object, value] : parameters) {
    common.parameters.push_back({object_of(object), value});
  }
  std::vector<AxisConfiguration> axes(count, common);
  for (std::size_t place = 0; place < models.size(); ++place) {
    const AxisModel model = model_of(models[place]);
    if (models.size() == count) {
      axes[place].model = model;
    } else {
      for (AxisConfiguration& axis : axes) axis.model = model;
    }
  }
  try {
    return std::make_unique<PyAxisBank>(
        axes, std::chrono::round<std::chrono::microseconds>(std::chrono::nanoseconds(period)));
  } catch (const std::invalid_argument& error) {
    raise_configuration_error(error.what());
  }
}

}  // namespace

void add_axis_bank(py::module_& module) {
  module.attr("LARGEST_LOAD_NOISE") = kLargestLoadNoise;
  py::class_<PyAxisBank>(module, "AxisBank")
      .def(py::init(&make_bank))
      .def("size", &PyAxisBank::size)
      .def("period", &PyAxisBank::period)
      .def("tick", &PyAxisBank::tick)
      .def("status",
           [](const py::object& self) {
             return self.cast<const PyAxisBank&>().status(self);
           })
      .def("status_hash",
           [](PyAxisBank& self) {
             return PyAxisBank::Use(self).bank().status_hash();
           })
      .def("write", &write_object)
      .def("write_each", &write_objects)
      .def("read", &read_object)
      .def("read_each", &read_objects)
      .def("step", &PyAxisBank::step)
      .def("set_load_noise", &set_load_noise)
      .def("power_cycle",
           [](PyAxisBank& self, std::int64_t axis) {
             const PyAxisBank::Use use(self);
             use.bank().power_cycle(checked_axis(use.bank(), axis));
           })
      .def("snapshot", &PyAxisBank::snapshot)
      .def("restore", &PyAxisBank::restore);
}

}  // namespace vdrive::python
