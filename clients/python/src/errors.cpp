// SPDX-License-Identifier: Apache-2.0
#include "errors.hpp"

#include <string>

namespace vdrive::python {
namespace {

py::object error_class(const char* name) {
  return py::module_::import("vdrive._errors").attr(name);
}

const char* class_name(client::OutcomeKind kind) {
  switch (kind) {
    case client::OutcomeKind::refused:
      return "Refused";
    case client::OutcomeKind::timed_out:
      return "TimedOut";
    case client::OutcomeKind::not_found:
      return "NotFound";
    case client::OutcomeKind::lost:
      return "Lost";
    case client::OutcomeKind::ok:
    case client::OutcomeKind::failed:
      break;
  }
  return "Failed";
}

/// @return an Owner, or None.
py::object owner_of(const client::Outcome& outcome) {
  const client::AxisOwner* const owner = outcome.owner();
  if (owner == nullptr) return py::none();
  const client::SessionName name = owner->name.value_or(client::SessionName{});
  return error_class("Owner")(owner->axis.axis == 0 ? std::string() : to_string(owner->axis),
                              owner->session, name.program, name.process, name.host);
}

[[noreturn]] void raise_object(const py::object& exception) {
  PyErr_SetObject(py::type::of(exception).ptr(), exception.ptr());
  throw py::error_already_set();
}

}  // namespace

py::object exception_of(const client::Outcome& outcome) {
  return error_class(class_name(outcome.kind()))(outcome.message(), outcome.code(),
                                                 owner_of(outcome));
}

void raise(const client::Outcome& outcome) {
  raise_object(exception_of(outcome));
}

void raise_configuration_error(const std::string& message) {
  raise_object(error_class("ConfigurationError")(message));
}

}  // namespace vdrive::python
