# SPDX-License-Identifier: Apache-2.0
# Kernels: shaders/name.comp, which shares shaders/name.h with C++, becomes SPIR-V words in a header in the build
# folder: #include "shaders/name.spv.h" defines touchable::name_spv. A name with an ending, for drawing, is the file
# name: name.vert defines touchable::name_vert_spv.

find_program(TOUCHABLE_GLSLANG glslangValidator REQUIRED DOC "GLSL to SPIR-V (Debian: glslang-tools)")
find_program(TOUCHABLE_SPIRV_OPT spirv-opt REQUIRED DOC "SPIR-V, unrolled (Debian: spirv-tools)")

# Generated headers, needed to compile a single file (tests/file_by_file.py).
add_custom_target(generated_headers)

# touchable_shaders(target [FROM folder] [OPTIMISED] name...): `target` may include the words of these kernels.
# `folder`, from the root of the sources: where they are (default: shaders); every header there is an input of every
# kernel. OPTIMISED: Mesa takes half a second to unroll the loops of a large network at each program start, even with
# a cache; unrolled here, it is ready in a tenth of that. Other kernels gain little, and some become slower. It takes
# eight seconds, so only Release builds do it.
function(touchable_shaders target)
  cmake_parse_arguments(SHADERS "OPTIMISED" "FROM" "" ${ARGN})
  if(NOT SHADERS_FROM)
    set(SHADERS_FROM shaders)
  endif()
  file(GLOB shared_headers CONFIGURE_DEPENDS
      "${PROJECT_SOURCE_DIR}/${SHADERS_FROM}/*.h" "${PROJECT_SOURCE_DIR}/shaders/*.h")
  foreach(name IN LISTS SHADERS_UNPARSED_ARGUMENTS)
    if(NOT TARGET shader_${name})
      set(source "${PROJECT_SOURCE_DIR}/${SHADERS_FROM}/${name}")
      if(NOT name MATCHES "[.]")
        string(APPEND source ".comp")
      endif()
      touchable_kernel(${name} "${source}" "${shared_headers}" "${SHADERS_OPTIMISED}")
    endif()
    add_dependencies(${target} shader_${name})
  endforeach()
  target_include_directories(${target} PRIVATE "${PROJECT_BINARY_DIR}")
endfunction()

# The header is written at configure time and includes the words, which are made at build time.
function(touchable_kernel name source shared_headers optimised)
  set(words "${PROJECT_BINARY_DIR}/shaders/${name}.spv.inc")
  string(REPLACE "." "_" identifier "${name}")
  file(CONFIGURE OUTPUT "${PROJECT_BINARY_DIR}/shaders/${name}.spv.h" @ONLY CONTENT [[
#pragma once

#include <cstdint>

namespace touchable {
inline constexpr std::uint32_t @identifier@_spv[] = {
#include "shaders/@name@.spv.inc"
};
}  // namespace touchable
]])
  set(binary "${PROJECT_BINARY_DIR}/shaders/${name}.spv")
  set(optimise "")
  if(optimised AND CMAKE_BUILD_TYPE STREQUAL "Release")
    set(optimise COMMAND "${TOUCHABLE_SPIRV_OPT}" --target-env=vulkan1.3 -O --preserve-spec-constants --preserve-bindings
        -o "${binary}" "${binary}")
  endif()
  set(to_words "${PROJECT_SOURCE_DIR}/cmake/words_of.cmake")
  add_custom_command(OUTPUT "${words}"
      COMMAND "${TOUCHABLE_GLSLANG}" --quiet --target-env vulkan1.3 "-I${PROJECT_SOURCE_DIR}" -V -o "${binary}" "${source}"
      ${optimise}
      COMMAND "${CMAKE_COMMAND}" "-DBINARY=${binary}" "-DWORDS=${words}" -P "${to_words}"
      DEPENDS "${source}" ${shared_headers} "${to_words}"
      COMMENT "Compiling the kernel ${name}"
      VERBATIM)
  add_custom_target(shader_${name} DEPENDS "${words}")
  add_dependencies(generated_headers shader_${name})
endfunction()
