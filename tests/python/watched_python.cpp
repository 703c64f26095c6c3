// SPDX-License-Identifier: Apache-2.0
// The Python interpreter as a program of this build: the program that loads the module must be
// linked with the runtime of the sanitizer.
#define PY_SSIZE_T_CLEAN
#include <Python.h>

int main(int count, char** arguments) {
  return Py_BytesMain(count, arguments);
}
