# SPDX-License-Identifier: Apache-2.0
# Debian packages by CPack, one per component; deploy/package.sh builds them.
#
#   vdrived         the service, its units, its first configuration
#   vdrive          the tool, its completion, the scenarios
#   vdrive-gateway  the gateway to browsers and dashboards, its unit, its completion
#   vdrive-ros2     the bridge to ROS 2, its unit, its completion
#   vdrive-canopen  the bridge to CANopen, its unit, its completion
#   libvdrive-dev   the libraries for programs in C++: archives, headers, CMake package
#   python3-vdrive  the Python module, where it was built
#   vdrive-doc      the documents, the IDL, the examples

cmake_host_system_information(RESULT system QUERY DISTRIB_INFO)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "vdrive maintainers <maintainers@vdrive.invalid>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "virtual CiA 402 servo drives on DDS")
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_SOURCE_DIR}/build/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL service tool gateway ros2 canopen development documents)
if(TARGET vdrive_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/cmake/finish_packages.cmake)

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
# Packages for both Debian releases are in one repository, and those for the newer release must have
# the higher version.
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
if(system_ID STREQUAL "debian")
  string(APPEND CPACK_DEBIAN_PACKAGE_RELEASE ~deb${system_VERSION_ID})
endif()
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(CPACK_DEBIAN_SERVICE_PACKAGE_NAME vdrived)
set(CPACK_DEBIAN_SERVICE_PACKAGE_SECTION misc)
set(CPACK_DEBIAN_SERVICE_DESCRIPTION "The service: it hosts simulated servo axes. Each behaves like a CiA 402 drive,
with a motor, a load, servo loops and encoders behind it. Programs command and
watch it over DDS.")
set(CPACK_DEBIAN_SERVICE_PACKAGE_SUGGESTS "vdrive, vdrive-doc")
set(debian ${PROJECT_SOURCE_DIR}/deploy/debian)
set(CPACK_DEBIAN_SERVICE_PACKAGE_CONTROL_EXTRA ${debian}/conffiles ${debian}/postinst
                                               ${debian}/prerm ${debian}/postrm)

set(CPACK_DEBIAN_TOOL_PACKAGE_NAME vdrive)
set(CPACK_DEBIAN_TOOL_PACKAGE_SECTION misc)
set(CPACK_DEBIAN_TOOL_DESCRIPTION "The tool: it finds the drives of vdrived, commands them, reads and writes
their objects, records what they do and runs scenarios.")
# A machine that only commands benches elsewhere needs only the tool.
set(CPACK_DEBIAN_TOOL_PACKAGE_RECOMMENDS vdrived)
set(CPACK_DEBIAN_TOOL_PACKAGE_SUGGESTS vdrive-doc)

set(CPACK_DEBIAN_GATEWAY_PACKAGE_NAME vdrive-gateway)
set(CPACK_DEBIAN_GATEWAY_PACKAGE_SECTION misc)
set(CPACK_DEBIAN_GATEWAY_DESCRIPTION "The gateway: it shows the drives of vdrived in a browser, and to Foxglove,
Lichtblick and PlotJuggler, and lets them command with the option --control.")
set(CPACK_DEBIAN_GATEWAY_PACKAGE_SUGGESTS "vdrived, vdrive-doc")
set(CPACK_DEBIAN_GATEWAY_PACKAGE_CONTROL_EXTRA ${debian}/gateway/postinst ${debian}/gateway/prerm
                                               ${debian}/gateway/postrm)

set(CPACK_DEBIAN_ROS2_PACKAGE_NAME vdrive-ros2)
set(CPACK_DEBIAN_ROS2_PACKAGE_SECTION misc)
set(CPACK_DEBIAN_ROS2_DESCRIPTION "The bridge to ROS 2: it shows the drives of vdrived as joints and lets
ros2_control and trajectories move them, over plain DDS and without ROS.")
set(CPACK_DEBIAN_ROS2_PACKAGE_SUGGESTS "vdrived, vdrive-doc")
set(CPACK_DEBIAN_ROS2_PACKAGE_CONTROL_EXTRA ${debian}/ros2/postinst ${debian}/ros2/prerm
                                            ${debian}/ros2/postrm)

set(CPACK_DEBIAN_CANOPEN_PACKAGE_NAME vdrive-canopen)
set(CPACK_DEBIAN_CANOPEN_PACKAGE_SECTION misc)
set(CPACK_DEBIAN_CANOPEN_DESCRIPTION "The bridge to CANopen: each axis of vdrived, or of a bench of its own, is a
CANopen node (CiA 301, CiA 402) on SocketCAN or on a socketcand server.")
set(CPACK_DEBIAN_CANOPEN_PACKAGE_SUGGESTS "vdrived, vdrive, vdrive-doc, python3-can, can-utils")
set(CPACK_DEBIAN_CANOPEN_PACKAGE_CONTROL_EXTRA ${debian}/canopen/postinst ${debian}/canopen/prerm
                                               ${debian}/canopen/postrm)

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libvdrive-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_DESCRIPTION "The libraries for programs in C++: archives, headers and the CMake package of
vdrive::client (sessions over DDS), vdrive::bench (a bench in the process of the
program, without DDS) and vdrive::core (the drive alone).")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
    "libeigen3-dev (>= 3.4), libspdlog-dev, libyaml-cpp-dev")
# For the component client: a program without DDS does not need these.
set(dds "libfastrtps-dev (>= 2.9)")
if(system_ID STREQUAL "debian" AND system_VERSION_ID VERSION_GREATER_EQUAL 13)
  set(dds "libfastdds-dev (>= 3.1)")
endif()
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_RECOMMENDS "${dds}, libssl-dev, libtinyxml2-dev")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SUGGESTS vdrive-doc)

set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-vdrive)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_DESCRIPTION "The Python module: import vdrive finds the drives of vdrived, commands and
observes them; a plug-in of pytest gives each test a bench of its own.")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "vdrived, vdrive-canopen, vdrive-doc, python3-can, python3-pytest, python3-matplotlib")
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${debian}/python/postinst ${debian}/python/prerm)
if(TARGET vdrive_python)
  # The module name contains the version of the interpreter.
  get_target_property(version vdrive_python VDRIVE_PYTHON_VERSION)
  get_target_property(next vdrive_python VDRIVE_NEXT_PYTHON_VERSION)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
      "python3 (>= ${version}), python3 (<< ${next}~), python3-numpy")
endif()

set(CPACK_DEBIAN_DOCUMENTS_PACKAGE_NAME vdrive-doc)
set(CPACK_DEBIAN_DOCUMENTS_PACKAGE_SECTION doc)
set(CPACK_DEBIAN_DOCUMENTS_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_DOCUMENTS_DESCRIPTION "The documents: tutorial, guides, reference, explanation; the IDL of the network
contract; programs that use the client library or a DDS library alone.")

include(CPack)
