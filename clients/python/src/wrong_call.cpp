// SPDX-License-Identifier: Apache-2.0
#include "wrong_call.hpp"

#include "arguments.hpp"
#include "signatures.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <exception>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdrive::python {
namespace {

/// A type in a signature, and the values that pybind11 takes for it. Numbers are not here: the
/// calls take any object for one and judge it themselves.
struct ArgumentKind {
  std::string_view type;
  bool (*fits)(const py::handle& value);
  std::string_view wanted;
};

bool fits_text(const py::handle& value) {
  return PyUnicode_Check(value.ptr()) != 0 || PyBytes_Check(value.ptr()) != 0;
}

bool fits_truth(const py::handle& value) {
  const PyNumberMethods* const methods = Py_TYPE(value.ptr())->tp_as_number;
  return value.is_none() || (methods != nullptr && methods->nb_bool != nullptr);
}

bool fits_function(const py::handle& value) {
  return PyCallable_Check(value.ptr()) != 0;
}

bool fits_dict(const py::handle& value) {
  return PyDict_Check(value.ptr()) != 0;
}

bool fits_bytes(const py::handle& value) {
  return PyBytes_Check(value.ptr()) != 0;
}

bool fits_row(const py::handle& value) {
  return py::isinstance<py::iterable>(value);
}

bool fits_texts(const py::handle& value) {
  if (fits_text(value) || PySequence_Check(value.ptr()) == 0) return false;
  return std::all_of(value.begin(), value.end(), fits_text);
}

constexpr std::array kArgumentKinds{
    ArgumentKind{"str", &fits_text, "a text"},
    ArgumentKind{"bool", &fits_truth, "True or False"},
    ArgumentKind{"function", &fits_function, "a function"},
    ArgumentKind{"Callable", &fits_function, "a function"},
    ArgumentKind{"dict", &fits_dict, "a dict"},
    ArgumentKind{"bytes", &fits_bytes, "bytes"},
    ArgumentKind{"Iterable", &fits_row, "a sequence"},
    ArgumentKind{"List[str]", &fits_texts, "a list of texts"},
};

/// @return "a vdrive.NAME", where `type` is the class NAME of this module and the value is no
///         object of it; else nothing.
std::optional<std::string> class_instead(const py::handle& value, std::string_view type) {
  const std::string name(type.substr(type.rfind('.') + 1));
  const py::object known =
      py::getattr(py::module_::import("vdrive._vdrive"), name.c_str(), py::none());
  if (known.is_none() || py::isinstance(value, known)) return std::nullopt;
  return "a vdrive." + name;
}

/// @return what the value has to be instead; nothing where it fits.
std::optional<std::string> wanted_instead(const py::handle& value, const Parameter& parameter) {
  constexpr std::string_view kOptional = "Optional[";
  std::string_view type = parameter.type;
  const bool is_optional = type.starts_with(kOptional);
  if (value.is_none() && (is_optional || parameter.value == "None")) return std::nullopt;
  if (is_optional) {
    type = type.substr(kOptional.size(), type.size() - kOptional.size() - 1);
  }
  const auto* const kind = std::ranges::find(kArgumentKinds, type, &ArgumentKind::type);
  if (kind == kArgumentKinds.end()) return class_instead(value, type);
  if (kind->fits(value)) return std::nullopt;
  return std::string(kind->wanted);
}

/// A call that pybind11 could not make.
class WrongCall {
 public:
  /// @param signature of a constructor without its object, which `given` has not either
  WrongCall(std::string name, Signature signature, std::vector<py::handle> given, py::dict keywords)
      : name_(std::move(name)),
        parameters_(std::move(signature.parameters)),
        given_(std::move(given)),
        keywords_(std::move(keywords)),
        has_object_(!parameters_.empty() && parameters_.front().name == "self") {
    const auto star = std::ranges::find_if(parameters_, [](const Parameter& parameter) {
      return parameter.name.starts_with('*');
    });
    places_ = static_cast<std::size_t>(star - parameters_.begin());
  }

  [[nodiscard]] std::string mistake() const {
    for (const auto find :
         {&WrongCall::too_many, &WrongCall::unknown, &WrongCall::missing, &WrongCall::wrong}) {
      if (auto found = (this->*find)()) return std::move(*found);
    }
    return name_ + "() does not take these arguments";
  }

 private:
  [[nodiscard]] std::optional<std::string> too_many() const {
    if (given_.size() <= places_) return std::nullopt;
    const std::size_t object = has_object_ ? 1 : 0;
    return name_ + "() takes " + counted(places_ - object, "argument", "arguments") +
           " without a name, not " + std::to_string(given_.size() - object);
  }

  [[nodiscard]] std::optional<std::string> unknown() const {
    for (const auto& [key, value] : keywords_) {
      const auto keyword = py::str(key).cast<std::string>();
      const auto named = std::ranges::find(parameters_, keyword, &Parameter::name);
      const auto place = static_cast<std::size_t>(named - parameters_.begin());
      if (named == parameters_.end()) {
        return name_ + "() has no argument " + in_quotes(keyword) + suggestion(keyword, names());
      }
      if (place < given_.size()) return name_ + "() got " + in_quotes(keyword) + " twice";
    }
    return std::nullopt;
  }

  [[nodiscard]] std::optional<std::string> missing() const {
    for (std::size_t place = 0; place < parameters_.size(); ++place) {
      const Parameter& parameter = parameters_[place];
      if (parameter.name.starts_with('*') || !parameter.value.empty() || value_of(place)) continue;
      return name_ + "() needs the argument " + in_quotes(parameter.name);
    }
    return std::nullopt;
  }

  [[nodiscard]] std::optional<std::string> wrong() const {
    for (std::size_t place = 0; place < parameters_.size(); ++place) {
      const py::handle value = value_of(place);
      if (!value) continue;
      const auto wanted = wanted_instead(value, parameters_[place]);
      if (wanted) {
        return std::string(parameters_[place].name) + " = " + shown(value) + ": must be " + *wanted;
      }
    }
    return std::nullopt;
  }

  /// @return what the program gave for a parameter, or a null handle.
  [[nodiscard]] py::handle value_of(std::size_t place) const {
    if (place < places_ && place < given_.size()) return given_[place];
    const std::string name(parameters_[place].name);
    return PyDict_GetItemString(keywords_.ptr(), name.c_str());
  }

  [[nodiscard]] std::vector<std::string> names() const {
    std::vector<std::string> known;
    for (const Parameter& parameter : parameters_) known.emplace_back(parameter.name);
    return known;
  }

  std::string name_;
  std::vector<Parameter> parameters_;
  std::vector<py::handle> given_;
  py::dict keywords_;
  bool has_object_;
  std::size_t places_ = 0;  ///< of parameters that need no name
};

/// @param message of a TypeError
/// @return what is wrong with these arguments; nothing where pybind11 has not written the message.
std::optional<std::string> mistake_in(std::string_view message, const py::tuple& arguments,
                                      const py::dict& keywords) {
  constexpr std::string_view kMark =
      " arguments. The following argument types are supported:\n    1. ";
  const std::size_t mark = message.find(kMark);
  if (mark == std::string_view::npos) return std::nullopt;
  const std::size_t begin = mark + kMark.size();
  auto signature = read_signature(message.substr(begin, message.find('\n', begin) - begin));
  if (!signature) return std::nullopt;
  // A constructor shows the name of its class there, and leaves out the object.
  const bool is_constructor = !signature->name.empty();
  std::vector<py::handle> given;
  for (const py::handle argument : arguments) given.push_back(argument);
  if (is_constructor && !given.empty()) given.erase(given.begin());
  const std::string_view name = is_constructor
                                    ? signature->name.substr(signature->name.rfind('.') + 1)
                                    : message.substr(0, message.find('('));
  return WrongCall(std::string(name), std::move(*signature), std::move(given), keywords).mistake();
}

/// Instead of the present error, if it is one of pybind11.
void explain_error(const py::tuple& arguments, const py::dict& keywords) {
  py::error_already_set error;
  try {
    const auto message = py::str(error.value()).cast<std::string>();
    if (const auto mistake = mistake_in(message, arguments, keywords)) {
      PyErr_SetString(PyExc_TypeError, mistake->c_str());
      return;
    }
  } catch (const std::exception&) {
    // A text that is no UTF-8: the message of pybind11 is better than none.
  }
  error.restore();
}

/// What every call of pybind11 runs.
PyCFunctionWithKeywords& dispatcher() {
  static PyCFunctionWithKeywords only = nullptr;
  return only;
}

/// Calls it. Its own message of a wrong call throws where a keyword is no UTF-8.
PyObject* call(PyObject* function, PyObject* arguments, PyObject* keywords) noexcept {
  try {
    return dispatcher()(function, arguments, keywords);
  } catch (py::error_already_set& error) {
    error.restore();
    return nullptr;
  }
}

PyObject* dispatch(PyObject* function, PyObject* arguments, PyObject* keywords) {
  PyObject* const result = call(function, arguments, keywords);
  if (result == nullptr && PyErr_ExceptionMatches(PyExc_TypeError) != 0) {
    explain_error(py::reinterpret_borrow<py::tuple>(arguments),
                  keywords == nullptr ? py::dict() : py::reinterpret_borrow<py::dict>(keywords));
  }
  return result;
}

}  // namespace

void name_mistakes_of(PyMethodDef& call) {
  if (call.ml_flags != (METH_VARARGS | METH_KEYWORDS)) return;
  // As the macros of Python do it: the flags say which type the function has.
  const auto present = std::bit_cast<PyCFunctionWithKeywords>(call.ml_meth);
  if (dispatcher() == nullptr) dispatcher() = present;
  if (present != dispatcher()) return;
  call.ml_meth = std::bit_cast<PyCFunction>(&dispatch);
}

}  // namespace vdrive::python
