// SPDX-License-Identifier: Apache-2.0
// The interpreter as a program of this build: the runtime of a sanitizer has to be part of the
// program that loads the module.
#define PY_SSIZE_T_CLEAN
#include <Python.h>

int main(int count, char** arguments) {
  return Py_BytesMain(count, arguments);
}
