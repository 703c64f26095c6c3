# SPDX-License-Identifier: Apache-2.0
# Runs help2man on a program and appends the help of its commands, if it has any.
cmake_minimum_required(VERSION 3.25)

# Escapes characters that are special in roff: the backslash, the minus, and a dot at the start of a
# line.
function(add_section title text layout)
  string(REPLACE "\\" "\\e" text "${text}")
  string(REPLACE "-" "\\-" text "${text}")
  string(REGEX REPLACE "(^|\n)([.'])" "\\1\\\\&\\2" text "${text}")
  if(layout STREQUAL "as_it_is")
    set(text ".nf\n${text}\n.fi")
  endif()
  file(APPEND ${PAGE}.sections "[${title}]\n${text}\n\n")
endfunction()

file(WRITE ${PAGE}.sections "")
execute_process(COMMAND ${PROGRAM} --help OUTPUT_VARIABLE help COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${PROGRAM} --version OUTPUT_VARIABLE version COMMAND_ERROR_IS_FATAL ANY)
if(help MATCHES "--help-all")
  execute_process(COMMAND ${PROGRAM} --help-all OUTPUT_VARIABLE all COMMAND_ERROR_IS_FATAL ANY)
  string(LENGTH "${help}" length)
  string(SUBSTRING "${all}" ${length} -1 commands)
  add_section(commands "${commands}" as_it_is)
endif()

# help2man would format the examples and the text after them as one paragraph. So it gets only the
# help before them, and they become separate sections.
if(help MATCHES "\nExamples:\n(.*)\n\nEnvironment: ([^\n]*)\nExit codes: ([^\n]*)")
  add_section(examples "${CMAKE_MATCH_1}" as_it_is)
  add_section(environment "${CMAKE_MATCH_2}" filled)
  add_section("exit status" "${CMAKE_MATCH_3}" filled)
  string(FIND "${help}" "\nExamples:\n" length)
  string(SUBSTRING "${help}" 0 ${length} help)
endif()
set(sections)
file(SIZE ${PAGE}.sections size)
if(size GREATER 0)
  set(sections --include=${PAGE}.sections)
endif()
file(WRITE ${PAGE}.help "${help}")
# A page describes a version, not a particular build of it.
string(REGEX REPLACE " \\(.*\\)" "" version "${version}")
file(WRITE ${PAGE}.version "${version}")
cmake_path(GET PROGRAM FILENAME name)
file(WRITE ${PAGE}.program/${name} "#!/bin/sh\nexec cat \"${PAGE}.\${1#--}\"\n")
file(CHMOD ${PAGE}.program/${name} PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)

execute_process(
  COMMAND ${HELP2MAN} --no-info --section=${SECTION} --name=${SUMMARY} --manual=vdrive
          ${sections} --output=${PAGE} ${PAGE}.program/${name}
          COMMAND_ERROR_IS_FATAL ANY)

# Omits the month of creation, so that the same help gives the same page.
file(READ ${PAGE} text)
string(REGEX REPLACE "(\n\\.TH [^ ]+ \"[0-9]\" )\"[^\"]*\"" "\\1\"\"" text "${text}")
file(WRITE ${PAGE} "${text}")
