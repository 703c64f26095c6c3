// SPDX-License-Identifier: Apache-2.0
#include "program/command_line.hpp"

int main(int argument_count, char** arguments) {
  return vdrive::service::run_command_line(argument_count, arguments);
}
