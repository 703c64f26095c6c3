# SPDX-License-Identifier: Apache-2.0
# Man pages and completions, made by the programs themselves at each build, so they are always current.
include(GNUInstallDirs)

find_program(VDRIVE_HELP2MAN help2man DOC "Makes man pages of the programs' own help")
set(documents ${PROJECT_BINARY_DIR}/documents)
file(MAKE_DIRECTORY ${documents})

# vdrive_man_page(<target> <section> <summary> <component>)
function(vdrive_man_page target section summary component)
  if(NOT VDRIVE_HELP2MAN)
    return()
  endif()
  set(page ${documents}/${target}.${section})
  add_custom_command(
    OUTPUT ${page}
    COMMAND
      ${CMAKE_COMMAND} -D HELP2MAN=${VDRIVE_HELP2MAN} -D PROGRAM=$<TARGET_FILE:${target}> -D
      PAGE=${page} -D SECTION=${section} -D SUMMARY=${summary} -P
      ${PROJECT_SOURCE_DIR}/cmake/make_man_page.cmake
    DEPENDS ${target} ${PROJECT_SOURCE_DIR}/cmake/make_man_page.cmake
    COMMENT "Making the man page of ${target}"
    VERBATIM)
  add_custom_target(${target}_man_page ALL DEPENDS ${page})
  if(VDRIVE_INSTALL)
    install(FILES ${page} DESTINATION ${CMAKE_INSTALL_MANDIR}/man${section} COMPONENT ${component})
  endif()
endfunction()

vdrive_man_page(vdrive 1 "commands virtual CiA 402 servo drives over DDS" tool)
vdrive_man_page(vdrived 8 "a bench of virtual CiA 402 servo drives on DDS" service)

vdrive_man_page(vdrive-gateway 8 "shows virtual servo drives to browsers and dashboards" gateway)
vdrive_man_page(vdrive-ros2 8 "shows virtual servo drives to ROS 2 as joints" ros2)
vdrive_man_page(vdrive-canopen 8 "shows virtual servo drives to CAN masters as CANopen nodes" canopen)

set(configuration_page ${documents}/vdrived.yaml.5)
set(configuration_example ${PROJECT_SOURCE_DIR}/deploy/systemd/vdrived.yaml)
add_custom_command(
  OUTPUT ${configuration_page}
  COMMAND
    ${CMAKE_COMMAND} -D PROGRAM=$<TARGET_FILE:vdrived> -D EXAMPLE=${configuration_example} -D
    VERSION=${PROJECT_VERSION} -D PAGE=${configuration_page} -P
    ${PROJECT_SOURCE_DIR}/cmake/make_configuration_page.cmake
  DEPENDS vdrived ${configuration_example} ${PROJECT_SOURCE_DIR}/cmake/make_configuration_page.cmake
  COMMENT "Making the man page of the configuration"
  VERBATIM)
add_custom_target(vdrived_configuration_page ALL DEPENDS ${configuration_page})
if(VDRIVE_INSTALL)
  install(FILES ${configuration_page} DESTINATION ${CMAKE_INSTALL_MANDIR}/man5 COMPONENT service)
endif()

# vdrive_completion(<shell> <directory below share> <name there>)
function(vdrive_completion shell directory name)
  set(script ${documents}/vdrive.${shell})
  add_custom_command(
    OUTPUT ${script}
    COMMAND $<TARGET_FILE:vdrive> completion ${shell} > ${script}
    DEPENDS vdrive
    COMMENT "Making the completion of vdrive for ${shell}"
    VERBATIM)
  add_custom_target(vdrive_completion_${shell} ALL DEPENDS ${script})
  if(VDRIVE_INSTALL)
    install(
      FILES ${script}
      DESTINATION ${CMAKE_INSTALL_DATADIR}/${directory}
      RENAME ${name}
      COMPONENT tool)
  endif()
endfunction()

vdrive_completion(bash bash-completion/completions vdrive)
vdrive_completion(zsh zsh/vendor-completions _vdrive)
vdrive_completion(fish fish/vendor_completions.d vdrive.fish)

# vdrive_simple_completion(<target> <component>)
function(vdrive_simple_completion target component)
  set(completion ${documents}/${target}.bash)
  add_custom_command(
    OUTPUT ${completion}
    COMMAND ${CMAKE_COMMAND} -D PROGRAM=$<TARGET_FILE:${target}> -D OUTPUT=${completion} -P
            ${PROJECT_SOURCE_DIR}/cmake/make_completion.cmake
    DEPENDS ${target} ${PROJECT_SOURCE_DIR}/cmake/make_completion.cmake
    COMMENT "Making the completion of ${target}"
    VERBATIM)
  add_custom_target(${target}_completion ALL DEPENDS ${completion})
  if(VDRIVE_INSTALL)
    install(
      FILES ${completion}
      DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
      RENAME ${target}
      COMPONENT ${component})
  endif()
endfunction()

vdrive_simple_completion(vdrive-gateway gateway)
vdrive_simple_completion(vdrive-ros2 ros2)
vdrive_simple_completion(vdrive-canopen canopen)
