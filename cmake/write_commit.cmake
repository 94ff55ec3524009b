# SPDX-License-Identifier: Apache-2.0
# Writes the header TO if changed: the commit of the sources in SOURCE, with "-dirty" if they differ from it.
cmake_minimum_required(VERSION 3.25)
execute_process(COMMAND git -C "${SOURCE}" describe --always --dirty --abbrev=10
    OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE status)
if(NOT status EQUAL 0)
  set(commit unknown)
endif()
file(CONFIGURE OUTPUT "${TO}" CONTENT "#pragma once\n\nnamespace touchable {\nconstexpr const char* measured_commit = \"@commit@\";\n}\n" @ONLY)
