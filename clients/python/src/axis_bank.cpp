// SPDX-License-Identifier: Apache-2.0
// The drive alone: a bank of axes that the interpreter's program steps itself.
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
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdrive::python {
namespace {

constexpr std::int64_t kMostBankAxes = 1'000'000;

/// Ticks of axes between two looks at the signals that have come: some 10 ms.
constexpr std::int64_t kAxisTicksAtOnce = 262'144;

using Integers = py::array_t<std::int64_t, py::array::c_style>;

/// What a snapshot begins with. The state of the bank follows.
struct SnapshotHead {
  std::array<char, 8> kind{'v', 'd', 'r', 'v', 'b', 'a', 'n', 'k'};
  std::uint64_t layout = AxisBank::snapshot_layout();
  std::uint64_t axes = 0;
  std::uint64_t period_us = 0;
  std::uint64_t configuration = 0;  // check value
  std::uint64_t tick = 0;
  std::uint64_t check = 0;  // of all before it and of the state
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

/// @return what `head.check` is with this state.
std::uint64_t check_of(SnapshotHead head, std::string_view state) {
  head.check = 0;
  std::string begin;
  append(begin, head);
  const py::object crc32 = py::module_::import("zlib").attr("crc32");
  return crc32(py::bytes(state.data(), state.size()), crc32(py::bytes(begin)))
      .cast<std::uint64_t>();
}

/// @return a number that differs when a bank is built in another way.
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

/// Ticks of a bank without the interpreter lock.
void step_unlocked(AxisBank& bank, std::int64_t ticks) {
  const Unlocked unlocked;
  for (std::int64_t done = 0; done < ticks && !is_late(); ++done) bank.step();
}

/// A bank, and the thread that uses it. Every member is guarded by the interpreter lock but for the
/// bank during a step.
class PyAxisBank {
 public:
  /// @throws std::invalid_argument as AxisBank
  PyAxisBank(const std::vector<AxisConfiguration>& axes, std::chrono::microseconds period)
      : bank_(axes, period), configuration_(check_of(axes)), type_(status_image_type()) {}

  /// The right to use the bank until this ends.
  class Use {
   public:
    /// @throws std::runtime_error while another thread uses the bank, py::error_already_set with
    ///         Forked where one of the parent did so when this process was forked
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

  /// @return the images where the bank has them; `self` is this object as Python has it.
  [[nodiscard]] py::array status(const py::object& self) const;

  /// @return the tick.
  std::uint64_t step(const Number& count);

  [[nodiscard]] py::bytes snapshot();

  /// @throws py::value_error when it is not one of a bank that was built as this one
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
  // It cannot be made writable again: its base, this object, offers no buffer to write to.
  view.attr("setflags")(py::arg("write") = false);
  return view;
}

std::uint64_t PyAxisBank::step(const Number& count) {
  std::int64_t ticks = whole_of(count, {"ticks"}, 0, kMostCounted);
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
  require(head.layout == SnapshotHead{}.layout, "it is of another version of vdrive");
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

/// @return whether it is one number; arrays of one number are not.
bool is_number(const py::object& value) {
  return PyIndex_Check(value.ptr()) != 0 && !py::isinstance<py::array>(value);
}

/// @return the numbers of a row of another type; nothing where one is not whole or too large.
template <typename Value>
std::optional<Integers> converted(const py::array& row) {
  constexpr double kEnd = 0x1p63;
  const auto values = py::array_t<Value, py::array::c_style>::ensure(row);
  Integers integers(values.size());
  for (py::ssize_t place = 0; place < values.size(); ++place) {
    const Value value = values.data()[place];
    const auto number = static_cast<double>(value);
    if (!(number >= -kEnd && number < kEnd) || std::floor(number) != number) return std::nullopt;
    integers.mutable_data()[place] = static_cast<std::int64_t>(value);
  }
  return row.ndim() == 0 ? Integers(integers.reshape(std::vector<py::ssize_t>{})) : integers;
}

/// @return nothing where the row is none of whole numbers.
std::optional<Integers> whole_ones(const py::array& row) {
  switch (row.ndim() <= 1 ? row.dtype().kind() : '\0') {
    case 'i':
      return Integers::ensure(row);
    case 'u':
      return converted<std::uint64_t>(row);
    case 'f':
      return converted<double>(row);
    default:
      return std::nullopt;
  }
}

/// @throws py::type_error where they are not whole numbers
Integers integers_of(const py::object& values, const char* what) {
  // As what it is first: numpy would cut the fraction off.
  const py::array row = py::array::ensure(values);
  if (row && row.ndim() == 1 && row.size() == 0) return Integers(0);
  const std::optional<Integers> integers = row ? whole_ones(row) : std::nullopt;
  if (!integers) {
    PyErr_Clear();
    throw py::type_error(std::string(what) + " = " + shown(values) +
                         ": must be a whole number or one row of whole numbers");
  }
  return *integers;
}

std::size_t checked_axis(const AxisBank& bank, std::int64_t axis) {
  if (axis >= 0 && std::cmp_less(axis, bank.size())) return static_cast<std::size_t>(axis);
  throw py::index_error("axis = " + std::to_string(axis) + ": must be from 0 to " +
                        std::to_string(bank.size() - 1));
}

std::size_t checked_axis(const AxisBank& bank, const Number& axis) {
  return checked_axis(bank, whole<std::int64_t>(axis, {"axis"}));
}

/// @param axes numbers, or None: all
std::vector<std::size_t> axes_in(const AxisBank& bank, const py::object& axes) {
  std::vector<std::size_t> found;
  if (axes.is_none()) {
    for (std::size_t axis = 0; axis < bank.size(); ++axis) found.push_back(axis);
    return found;
  }
  const Integers numbers = integers_of(axes, "axis");
  found.reserve(static_cast<std::size_t>(numbers.size()));
  for (py::ssize_t place = 0; place < numbers.size(); ++place) {
    found.push_back(checked_axis(bank, numbers.data()[place]));
  }
  return found;
}

/// @return where `value` is outside of the object's limits these, else nothing.
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

void write_each(AxisBank& bank, const std::vector<std::size_t>& axes, ObjectAddress object,
                const Integers& values) {
  const auto count = static_cast<std::size_t>(values.size());
  const bool is_one = values.ndim() == 0;
  if (!is_one && count != axes.size()) {
    throw py::value_error(std::to_string(count) + " values for " + std::to_string(axes.size()) +
                          " axes");
  }
  for (std::size_t place = 0; place < axes.size(); ++place) {
    write_one(bank, axes[place], object, values.data()[is_one ? 0 : place]);
  }
}

void write_object(PyAxisBank& self, const py::object& axis, const py::object& object,
                  const py::object& value) {
  const ObjectAddress address = object_of(object);
  const PyAxisBank::Use use(self);
  AxisBank& bank = use.bank();
  if (is_number(axis)) {
    write_one(bank, checked_axis(bank, Number{axis}), address,
              whole<std::int64_t>(Number{value}, {"value"}));
  } else {
    write_each(bank, axes_in(bank, axis), address, integers_of(value, "value"));
  }
}

void set_load_noise(PyAxisBank& self, const py::object& axis, const Real& rms, const Number& seed) {
  const double noise = real_within(rms, {"rms", "N.m"}, 0.0, kLargestLoadNoise);
  const std::uint64_t number = count_of(seed, "seed");
  const PyAxisBank::Use use(self);
  AxisBank& bank = use.bank();
  if (is_number(axis)) {
    bank.set_load_noise(checked_axis(bank, Number{axis}), noise, number);
  } else {
    for (const std::size_t each : axes_in(bank, axis)) bank.set_load_noise(each, noise, number);
  }
}

py::object read_object(PyAxisBank& self, const py::object& axis, const py::object& object) {
  const ObjectAddress address = object_of(object);
  const PyAxisBank::Use use(self);
  const AxisBank& bank = use.bank();
  if (is_number(axis)) {
    return py::int_(read_one(bank, checked_axis(bank, Number{axis}), address));
  }
  const std::vector<std::size_t> axes = axes_in(bank, axis);
  py::array_t<std::int64_t> values(static_cast<py::ssize_t>(axes.size()));
  for (std::size_t place = 0; place < axes.size(); ++place) {
    values.mutable_data()[place] = read_one(bank, axes[place], address);
  }
  return values;
}

// ---- construction ------------------------------------------------------------------------------

/// @return the text; of another value what a program writes for it.
std::string text_or_shown(const py::handle& value) {
  return py::isinstance<py::str>(value) ? value.cast<std::string>() : shown(value);
}

/// The two words that a key of the model takes, as in a configuration of the service.
template <typename Choice>
Choice choice_of(const std::string& key, const py::handle& value,
                 const std::array<Choice, 2>& choices) {
  const std::string text = text_or_shown(value);
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
    try {
      model.*row->member = real_of({py::reinterpret_borrow<py::object>(value)}, {});
      return;
    } catch (const py::type_error&) {
      raise_configuration_error("model: " + key + " is a number" +
                                (row->unit.empty() ? "" : ", in " + std::string(row->unit)));
    }
  }
  std::vector<std::string> names{"coupling", "feedback"};
  for (const ModelParameter& parameter : kModelParameters) names.emplace_back(parameter.name);
  std::string known;
  for (const std::string& name : names) known += (known.empty() ? "" : ", ") + name;
  raise_configuration_error("model: unknown key " + in_quotes(key) + suggestion(key, names) +
                            ", known are " + known);
}

AxisModel model_of(const py::dict& keys) {
  AxisModel model;
  for (const auto& [name, value] : keys) {
    const std::string key = text_or_shown(name);
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

/// @param model a dict for all axes, or a dict for each
void set_models(std::vector<AxisConfiguration>& axes, const py::object& model) {
  if (model.is_none()) return;
  if (py::isinstance<py::dict>(model)) {
    const AxisModel common = model_of(py::dict(model));
    for (AxisConfiguration& axis : axes) axis.model = common;
    return;
  }
  if (!py::isinstance<py::sequence>(model) || py::len(model) != axes.size()) {
    raise_configuration_error("model is a dict for all axes or a sequence of " +
                              std::to_string(axes.size()) + " dicts");
  }
  for (std::size_t axis = 0; axis < axes.size(); ++axis) {
    axes[axis].model = model_of(py::dict(model[py::int_(axis)]));
  }
}

std::chrono::microseconds period_of(const Real& seconds) {
  return std::chrono::round<std::chrono::microseconds>(nanoseconds_of(seconds, "period"));
}

/// @throws py::error_already_set with a ConfigurationError outside of the range
std::size_t count_of_axes(const Number& axes) {
  try {
    return static_cast<std::size_t>(whole_of(axes, {"axes"}, 1, kMostBankAxes));
  } catch (const py::value_error& error) {
    raise_configuration_error(error.what());
  }
}

std::unique_ptr<PyAxisBank> make_bank(const Number& axes, const Real& period,
                                      const py::object& model, const py::dict& parameters) {
  const std::size_t count = count_of_axes(axes);
  AxisConfiguration common;
  for (const auto& [object, value] : parameters) {
    const Number number{py::reinterpret_borrow<py::object>(value)};
    common.parameters.push_back({object_of(py::reinterpret_borrow<py::object>(object)),
                                 whole<std::int64_t>(number, {"value"})});
  }
  std::vector<AxisConfiguration> configurations(count, common);
  set_models(configurations, model);
  try {
    return std::make_unique<PyAxisBank>(configurations, period_of(period));
  } catch (const std::invalid_argument& error) {
    raise_configuration_error(error.what());
  }
}

using BankClass = py::class_<PyAxisBank>;

void add_bank_state(BankClass& bank) {
  bank.def("__len__", &PyAxisBank::size)
      .def_property_readonly("period", &PyAxisBank::period, "Length of a tick, in s.")
      .def_property_readonly("tick", &PyAxisBank::tick, "Ticks since the bank was made.")
      .def_property_readonly(
          "status",
          [](const py::object& self) {
            return self.cast<const PyAxisBank&>().status(self);
          },
          "The status image of each axis after the last tick: a numpy array of records, a field "
          "for "
          "each member, that reads where the bank has them. A step, a power cycle and restore() "
          "change it; copy() keeps it. It keeps the bank, and cannot be written. Do not read it "
          "while another thread steps.")
      .def(
          "status_hash",
          [](PyAxisBank& self) {
            return PyAxisBank::Use(self).bank().status_hash();
          },
          "A number that stands for every status image, to compare runs.");
}

void add_access(BankClass& bank) {
  bank.def(
          "write", &write_object, py::arg("axis"), py::arg("object"), py::arg("value"),
          "Writes an object of an axis, numbered from 0, or of several: a row of numbers, or None: "
          "all. Then `value` is one or a row of as many. In force at once. Refused ends at the "
          "first axis that refuses; those before it are written.")
      .def("read", &read_object, py::arg("axis"), py::arg("object"),
           "Reads an object of an axis, or of several into an array. Arguments as in write().")
      .def("step", &PyAxisBank::step, py::arg("ticks") = 1,
           "Steps every axis. Returns the tick. Ctrl-C ends it between two ticks.")
      .def("set_load_noise", &set_load_noise, py::arg("axis"), py::arg("rms"), py::arg("seed") = 0,
           "From the next tick on the load torque of an axis, or of several, has white noise of "
           "`rms` "
           "N.m at the load, 0 = none: another torque each tick, the same for the same seed, and "
           "for "
           "each axis its own. Part of a snapshot.")
      .def(
          "power_cycle",
          [](PyAxisBank& self, const Number& axis) {
            const PyAxisBank::Use use(self);
            use.bank().power_cycle(checked_axis(use.bank(), axis));
          },
          py::arg("axis"),
          "Switches an axis off and on again: the position stays, faults are gone.")
      .def("snapshot", &PyAxisBank::snapshot, "The whole state as bytes, for restore().")
      .def("restore", &PyAxisBank::restore, py::arg("snapshot"),
           "Goes back to a snapshot of this bank, or of one that was made with the same arguments "
           "by the same version of vdrive. A ValueError says why one is refused.");
}

}  // namespace

void add_axis_bank(py::module_& module) {
  BankClass bank(module, "AxisBank",
                 "Servo drives without a service, clock and network: the caller writes objects and "
                 "steps. One thread at a time.");
  bank.def(py::init(&make_bank), py::arg("axes"), py::kw_only(), py::arg("period") = 0.001,
           py::arg("model") = py::none(), py::arg("parameters") = py::dict(),
           "Powers `axes` axes up. `period` of a tick in s, 125 us to 10 ms. `model`: the keys of "
           "`model` in a configuration, a dict for all axes or a sequence with one for each. "
           "`parameters`: values of objects from power-up on.");
  add_bank_state(bank);
  add_access(bank);
}

}  // namespace vdrive::python
