# SPDX-License-Identifier: Apache-2.0

find_program(VDRIVE_FASTDDSGEN fastddsgen REQUIRED)
find_program(VDRIVE_IDLC idlc DOC "IDL compiler of Cyclone DDS, a second check of our IDL")

# vdrive_generate_idl(<target> <file>.idl [WITHOUT_SUPPORT])
# An object library with the C++ code that fastddsgen makes of the file, and its include directory.
# WITHOUT_SUPPORT leaves its type support out, and with it the DDS library.
# The second vendor's compiler reads each file too, when it is there: what it refuses fails the
# build, because then only one vendor's DDS could exchange messages with a bench.
function(vdrive_generate_idl target idl)
  cmake_parse_arguments(PARSE_ARGV 2 arg "WITHOUT_SUPPORT" "" "")
  cmake_path(GET idl STEM name)
  cmake_path(ABSOLUTE_PATH idl)
  set(output ${CMAKE_CURRENT_BINARY_DIR}/generated)
  set(generated ${output}/${name}.cxx ${output}/${name}.h ${output}/${name}PubSubTypes.cxx
                ${output}/${name}PubSubTypes.h)
  add_custom_command(
    OUTPUT ${generated}
    COMMAND
      ${CMAKE_COMMAND} -D GENERATOR=${VDRIVE_FASTDDSGEN} -D "SECOND_PARSER=$<$<BOOL:${VDRIVE_IDLC}>:${VDRIVE_IDLC}>"
      -D IDL=${idl} -D OUTPUT=${output} -D TEMPORARY=${CMAKE_CURRENT_BINARY_DIR}/fastddsgen
      -P ${PROJECT_SOURCE_DIR}/cmake/run_fastddsgen.cmake
    DEPENDS ${idl} ${PROJECT_SOURCE_DIR}/cmake/run_fastddsgen.cmake
    COMMENT "Generating C++ from ${name}.idl"
    VERBATIM)
  set(libraries fastcdr fastrtps)
  if(arg_WITHOUT_SUPPORT)
    list(FILTER generated EXCLUDE REGEX "PubSubTypes")
    set(libraries fastcdr)
  endif()
  add_library(${target} OBJECT ${generated})
  vdrive_target_defaults(${target} GENERATED)
  vdrive_make_position_independent(${target})
  target_include_directories(${target} SYSTEM PUBLIC $<BUILD_INTERFACE:${output}>)
  target_link_libraries(${target} PUBLIC ${libraries})
  # Texts of a message have a type of the DDS library that needs its header only.
  target_include_directories(
    ${target} SYSTEM
    PUBLIC $<BUILD_INTERFACE:$<TARGET_PROPERTY:fastrtps,INTERFACE_INCLUDE_DIRECTORIES>>)
endfunction()
