# SPDX-License-Identifier: Apache-2.0
# Runs help2man on a program; the help of its commands follows, if it has any.
cmake_minimum_required(VERSION 3.25)

execute_process(COMMAND ${PROGRAM} --help OUTPUT_VARIABLE help COMMAND_ERROR_IS_FATAL ANY)
set(commands_options)
if(help MATCHES "--help-all")
  execute_process(COMMAND ${PROGRAM} --help-all OUTPUT_VARIABLE all COMMAND_ERROR_IS_FATAL ANY)
  string(LENGTH "${help}" length)
  string(SUBSTRING "${all}" ${length} -1 commands)
  # Characters that mean something to roff: the backslash, the minus, a dot that begins a line.
  string(REPLACE "\\" "\\e" commands "${commands}")
  string(REPLACE "-" "\\-" commands "${commands}")
  string(REGEX REPLACE "\n([.'])" "\n\\\\&\\1" commands "${commands}")
  file(WRITE ${PAGE}.commands "[commands]\n.nf\n${commands}.fi\n")
  set(commands_options --include=${PAGE}.commands)
endif()

execute_process(
  COMMAND ${HELP2MAN} --no-info --section=${SECTION} --name=${SUMMARY} --manual=vdrive
          ${commands_options} --output=${PAGE} ${PROGRAM} COMMAND_ERROR_IS_FATAL ANY)
