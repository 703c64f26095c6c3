# SPDX-License-Identifier: Apache-2.0
# Run by CPack on the staged files before it packs them: makes the changes that Debian's rules require
# in addition to an installation below one prefix.
cmake_minimum_required(VERSION 3.25)

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# Configuration belongs in /etc, not below /usr.
file(GLOB configurations LIST_DIRECTORIES true ${CPACK_TEMPORARY_DIRECTORY}/*/usr/etc)
foreach(directory ${configurations})
  cmake_path(GET directory PARENT_PATH prefix)
  cmake_path(GET prefix PARENT_PATH root)
  file(RENAME ${directory} ${root}/etc)
endforeach()

# The installation contains the full licence, but Debian has its text only once, so a reference
# replaces it. The changelog is in Debian's format, with the date of SOURCE_DATE_EPOCH
# (deploy/package.sh).
string(TIMESTAMP day "%a, %d %b %Y %H:%M:%S +0000" UTC)
file(GLOB licences ${CPACK_TEMPORARY_DIRECTORY}/*/usr/share/doc/*/copyright)
foreach(licence ${licences})
  cmake_path(GET licence PARENT_PATH documents)
  file(COPY_FILE ${CMAKE_CURRENT_LIST_DIR}/../deploy/debian/copyright ${licence})
  # Building a package releases what is still under Unreleased.
  file(READ ${CMAKE_CURRENT_LIST_DIR}/../CHANGELOG.md news)
  string(REPLACE "\n## Unreleased\n" "\n## ${CPACK_PACKAGE_VERSION}\n" news "${news}")
  file(WRITE ${documents}/NEWS "${news}")
  file(WRITE ${documents}/changelog "vdrive (${CPACK_PACKAGE_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE}) stable; urgency=medium\n\n"
       "  * What changed is in NEWS.\n\n -- ${CPACK_PACKAGE_CONTACT}  ${day}\n")
  run(gzip -9n ${documents}/NEWS ${documents}/changelog)
endforeach()

file(GLOB_RECURSE pages ${CPACK_TEMPORARY_DIRECTORY}/*.[1-8])
list(FILTER pages INCLUDE REGEX "/share/man/man[1-8]/")
foreach(page ${pages})
  run(gzip -9n ${page})
endforeach()

# CPack strips programs only, and the debug information of the archives is ten times their code.
file(GLOB_RECURSE archives ${CPACK_TEMPORARY_DIRECTORY}/*.a)
foreach(archive ${archives})
  run(strip --strip-debug ${archive})
endforeach()
