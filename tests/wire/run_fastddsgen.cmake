# SPDX-License-Identifier: Apache-2.0
# Runs fastddsgen on one file, with another name for the module of its types. The generator reports
# some failures with exit code 0 and leaves half-written files, so its output is checked. By default
# it also writes to the system's shared temporary directory, where two builds of the same file would
# collide.
cmake_minimum_required(VERSION 3.25)

cmake_path(GET IDL FILENAME name)
file(READ ${IDL} text)
string(REGEX REPLACE "(module |::)${MODULE}([ :{])" "\\1fast_msg\\2" text "${text}")
file(MAKE_DIRECTORY ${OUTPUT} ${TEMPORARY})
file(WRITE ${TEMPORARY}/fast_${name} "${text}")
execute_process(
  COMMAND ${GENERATOR} -cs -replace ${OPTIONS} -t ${TEMPORARY} -d ${OUTPUT} ${TEMPORARY}/fast_${name}
  RESULT_VARIABLE result
  OUTPUT_VARIABLE output
  ERROR_VARIABLE output)
if(NOT result EQUAL 0 OR output MATCHES "ERROR|Error:|[eE]xception")
  file(REMOVE_RECURSE ${OUTPUT})
  message(FATAL_ERROR "${GENERATOR} refused ${IDL} (exit code ${result}):\n${output}")
endif()
