// SPDX-License-Identifier: Apache-2.0
// What every class of the module has, so that it behaves as one that is written in Python: its
// calls have signatures and say in one line what is wrong with their arguments, an object without
// content is refused, its objects show no address, and a pickle of any protocol works or is
// refused.
#include "python.hpp"
#include "signatures.hpp"
#include "wrong_call.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace vdrive::python {
namespace {

/// @return such as "timeout=60.0", as `inspect` reads it.
std::string without_type(const Parameter& parameter) {
  if (parameter.value.empty()) return std::string(parameter.name);
  // `inspect` reads literals only, and <Until.done: 0> is none.
  const bool is_literal = !parameter.value.starts_with('<');
  return std::string(parameter.name) + "=" + (is_literal ? std::string(parameter.value) : "...");
}

/// @param text as pybind11 documents a call: "wait(self: vdrive.Motion, timeout: float = 60.0) ->
///        None", and more
/// @return "wait(self, timeout=60.0)"; nothing for another text. With "$self" `inspect` would leave
///         the object out, and of a bound call the first parameter as well.
std::optional<std::string> signature_of(std::string_view text) {
  const auto read = read_signature(text);
  if (!read || read->name.empty()) return std::nullopt;
  std::string signature = std::string(read->name) + "(";
  for (const Parameter& parameter : read->parameters) {
    if (!signature.ends_with('(')) signature += ", ";
    signature += without_type(parameter);
  }
  return signature + ")";
}

/// Python finds the signature of a call that is compiled in front of its text.
void show_signature(PyMethodDef& definition) {
  if (definition.ml_doc == nullptr) return;
  const std::string text = definition.ml_doc;
  const auto signature = signature_of(text);
  // Python compares the name in front of it with that of the call.
  if (!signature || !signature->starts_with(std::string(definition.ml_name) + "(")) return;
  char* const shown = strdup((*signature + "\n--\n\n" + text).c_str());
  if (shown == nullptr) return;
  // pybind11 has made it by strdup, and frees what stands here.
  std::free(const_cast<char*>(std::exchange(definition.ml_doc, shown)));  // NOLINT
}

/// @param call an attribute of a class or of the module; what is no call stays as it is
void complete_call(PyObject* call) {
  if (PyInstanceMethod_Check(call) != 0) call = PyInstanceMethod_Function(call);
  if (PyCFunction_Check(call) == 0) return;
  // NOLINTNEXTLINE(*-reinterpret-cast): as the macros of Python do it
  PyMethodDef& definition = *reinterpret_cast<PyCFunctionObject*>(call)->m_ml;
  show_signature(definition);
  name_mistakes_of(definition);
}

/// Where an object gets its C++ part before its constructor has run, pybind11 asks for memory only.
void* refuse_memory(std::size_t /*size*/) {
  throw py::type_error("this object has no content: it was made by __new__ alone");
}

/// Protocols 0 and 1 would make an object without its C++ part, which ends the program.
py::object reduce_by_later_protocol(const py::object& object, int protocol) {
  constexpr int kFirstThatRefuses = 2;
  const py::object reduce = py::module_::import("builtins").attr("object").attr("__reduce_ex__");
  return reduce(object, std::max(protocol, kFirstThatRefuses));
}

std::string repr_of_class(const py::object& object) {
  return "<vdrive." + py::type::of(object).attr("__name__").cast<std::string>() + ">";
}

void complete(const py::type& type) {
  // NOLINTNEXTLINE(*-reinterpret-cast): as the macros of Python do it
  auto* const class_of_python = reinterpret_cast<PyTypeObject*>(type.ptr());
  py::detail::get_type_info(class_of_python)->operator_new = &refuse_memory;
  for (const auto& [name, attribute] : type.attr("__dict__").attr("copy")().cast<py::dict>()) {
    complete_call(attribute.ptr());
  }
  type.attr("__reduce_ex__") = py::cpp_function(&reduce_by_later_protocol, py::is_method(type),
                                                py::name("__reduce_ex__"), py::arg("protocol"));
  const py::object usual = py::module_::import("builtins").attr("object").attr("__repr__");
  const py::object present = type.attr("__repr__");
  if (present.is(usual)) {
    type.attr("__repr__") =
        py::cpp_function(&repr_of_class, py::is_method(type), py::name("__repr__"));
  }
}

}  // namespace

void complete_classes(const py::module_& module) {
  for (const auto& [name, value] : module.attr("__dict__").attr("copy")().cast<py::dict>()) {
    const bool is_ours =
        py::isinstance<py::type>(value) &&
        py::type::of(value).attr("__name__").cast<std::string>() == "pybind11_type";
    if (is_ours) {
      complete(py::reinterpret_borrow<py::type>(value));
    } else {
      complete_call(value.ptr());
    }
  }
}

}  // namespace vdrive::python
