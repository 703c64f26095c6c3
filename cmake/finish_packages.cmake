# SPDX-License-Identifier: Apache-2.0
# Run by CPack on what it has staged, before it packs: what the rules of Debian ask for beyond an
# installation below one prefix.
cmake_minimum_required(VERSION 3.25)

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# Configuration belongs into /etc and not below /usr.
file(GLOB configurations LIST_DIRECTORIES true ${CPACK_TEMPORARY_DIRECTORY}/*/usr/etc)
foreach(directory ${configurations})
  cmake_path(GET directory PARENT_PATH prefix)
  cmake_path(GET prefix PARENT_PATH root)
  file(RENAME ${directory} ${root}/etc)
endforeach()

file(GLOB_RECURSE pages ${CPACK_TEMPORARY_DIRECTORY}/*.[1-8])
list(FILTER pages INCLUDE REGEX "/share/man/man[1-8]/")
foreach(page ${pages})
  run(gzip -9n ${page})
endforeach()

# CPack strips programs; the debug information of the archives is ten times their code.
file(GLOB_RECURSE archives ${CPACK_TEMPORARY_DIRECTORY}/*.a)
foreach(archive ${archives})
  run(strip --strip-debug ${archive})
endforeach()
