// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "python.hpp"

namespace vdrive::python {

/// pybind11 answers arguments that it cannot convert with the whole signature and a list of all
/// arguments. From now on the TypeError of this call names what is wrong in one line: an argument
/// with its value and what it must be, or an argument that is missing or unknown. A call that
/// succeeds costs nothing more. With the interpreter lock.
/// @param call of pybind11; every other one stays as it is
void name_mistakes_of(PyMethodDef& call);

}  // namespace vdrive::python
