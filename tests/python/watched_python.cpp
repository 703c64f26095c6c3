// SPDX-License-Identifier: Apache-2.0
// The interpreter as a program of this build, since the runtime of a sanitizer must be linked into
// the program that loads the module.
#define PY_SSIZE_T_CLEAN
#include <Python.h>

int main(int count, char** arguments) {
  return Py_BytesMain(count, arguments);
}
