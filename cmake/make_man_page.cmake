# SPDX-License-Identifier: Apache-2.0
# Runs help2man on a program; where it has words of its own, their help follows as it is.
cmake_minimum_required(VERSION 3.25)

execute_process(COMMAND ${PROGRAM} --help OUTPUT_VARIABLE help COMMAND_ERROR_IS_FATAL ANY)
set(words_options)
if(help MATCHES "--help-all")
  execute_process(COMMAND ${PROGRAM} --help-all OUTPUT_VARIABLE all COMMAND_ERROR_IS_FATAL ANY)
  string(LENGTH "${help}" length)
  string(SUBSTRING "${all}" ${length} -1 words)
  # Characters that mean something to roff: the backslash, the minus, a dot that begins a line.
  string(REPLACE "\\" "\\e" words "${words}")
  string(REPLACE "-" "\\-" words "${words}")
  string(REGEX REPLACE "\n([.'])" "\n\\\\&\\1" words "${words}")
  file(WRITE ${PAGE}.words "[words]\n.nf\n${words}.fi\n")
  set(words_options --include=${PAGE}.words)
endif()

execute_process(
  COMMAND ${HELP2MAN} --no-info --section=${SECTION} --name=${SUMMARY} --manual=vdrive
          ${words_options} --output=${PAGE} ${PROGRAM} COMMAND_ERROR_IS_FATAL ANY)
