# SPDX-License-Identifier: Apache-2.0
# Writes the man page vdrived.yaml(5): the keys come from `vdrived --help-config`, the example is the
# configuration that the package installs.
#
#   cmake -D PROGRAM=... -D EXAMPLE=... -D VERSION=... -D PAGE=... -P make_configuration_page.cmake
cmake_minimum_required(VERSION 3.25)

# Escapes characters that are special in roff.
function(escape variable)
  string(REPLACE "\\" "\\e" text "${${variable}}")
  string(REPLACE "-" "\\-" text "${text}")
  string(REGEX REPLACE "(^|\n)([.'])" "\\1\\\\&\\2" text "${text}")
  set(${variable} "${text}" PARENT_SCOPE)
endfunction()

execute_process(COMMAND ${PROGRAM} --help-config OUTPUT_VARIABLE keys COMMAND_ERROR_IS_FATAL ANY)
escape(keys)
# A key starts at the beginning of a line; its text is indented.
string(REGEX REPLACE "(^|\n)([a-z][^\n]*)\n    " "\\1.TP\n.B \\2\n" keys "${keys}")
file(READ ${EXAMPLE} example)
escape(example)
file(
  WRITE ${PAGE}
  ".TH VDRIVED.YAML 5 \"\" \"vdrive ${VERSION}\" vdrive
.SH NAME
vdrived.yaml \\- configuration of a bench of virtual CiA 402 servo drives
.SH SYNOPSIS
.B vdrived \\-\\-config
.I FILE
.SH DESCRIPTION
A YAML file that describes a bench. A key that the file does not have keeps its default; an unknown
key is an error.
.B vdrived \\-\\-check
.I FILE
checks a file and starts nothing,
.B vdrived \\-\\-print\\-config
prints the configuration in effect.
.SH KEYS
A key a.b is the entry b of the map a; axes is a list of maps.
${keys}.SH EXAMPLES
.nf
${example}.fi
.SH FILES
.TP
.I /etc/vdrive/vdrived.yaml
of vdrived.service
.TP
.I /etc/vdrive/NAME.yaml
of vdrived@NAME.service
.SH SEE ALSO
.BR vdrived (8),
.BR vdrive (1)
")
