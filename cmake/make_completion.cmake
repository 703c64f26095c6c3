# SPDX-License-Identifier: Apache-2.0
# Generates a bash completion for a program without commands: it offers the options in the help of
# the program, otherwise files.
#
#   cmake -D PROGRAM=FILE -D OUTPUT=FILE -P make_completion.cmake
cmake_minimum_required(VERSION 3.25)

execute_process(COMMAND ${PROGRAM} --help OUTPUT_VARIABLE help COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "--[a-z][a-z-]*" options "${help}")
list(REMOVE_DUPLICATES options)
list(SORT options)
list(JOIN options " " words)
cmake_path(GET PROGRAM FILENAME name)
file(WRITE ${OUTPUT} "# bash completion for ${name}, made from: ${name} --help
complete -o default -W \"${words}\" ${name}
")
