# SPDX-License-Identifier: Apache-2.0
# Runs fastddsgen on one file. The generator reports some failures with exit code 0 and leaves
# half-written files behind, so its output decides; it also writes to the system's shared temporary
# directory unless another one is given, where two builds of the same file would collide.
cmake_minimum_required(VERSION 3.25)

function(run_checked)
  execute_process(
    COMMAND ${ARGN}
    RESULT_VARIABLE result
    OUTPUT_VARIABLE output
    ERROR_VARIABLE output)
  if(NOT result EQUAL 0 OR output MATCHES "ERROR|Error:|[eE]xception")
    file(REMOVE_RECURSE ${OUTPUT})
    message(FATAL_ERROR "${ARGV0} refused ${IDL} (exit code ${result}):\n${output}")
  endif()
endfunction()

file(MAKE_DIRECTORY ${OUTPUT} ${TEMPORARY})
run_checked(${GENERATOR} -cs -replace -t ${TEMPORARY} -d ${OUTPUT} ${IDL})
if(SECOND_PARSER)
  run_checked(${SECOND_PARSER} -l c -o ${TEMPORARY} ${IDL})
endif()
