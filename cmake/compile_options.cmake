# SPDX-License-Identifier: Apache-2.0
# Compile options of every target of this project.

# Forces have the same bits with every compiler and optimisation level (docs/architecture.md, decision 3): no fused
# multiply-add in place of a product and a sum.
add_compile_options(-ffp-contract=off)
# Modules are also linked into shared libraries, which export only their C functions (capi/).
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_CXX_VISIBILITY_PRESET hidden)
set(CMAKE_VISIBILITY_INLINES_HIDDEN ON)
add_compile_options(-Wall -Wextra -Wpedantic
    $<$<COMPILE_LANGUAGE:CXX>:-Wnon-virtual-dtor> $<$<COMPILE_LANGUAGE:CXX>:-Wold-style-cast> -Wfloat-conversion)
# In a unity build locals of one file would shadow globals of another.
if(NOT CMAKE_UNITY_BUILD)
  add_compile_options(-Wshadow)
endif()
# GCC 13 and 14 give false warnings for std::sort and std::vector inlined at -O3 (clip_picture.hpp,
# inverse3_device.cpp). GCC 12 checks the same without them.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_GREATER_EQUAL 13)
  add_compile_options(-Wno-array-bounds -Wno-free-nonheap-object -Wno-stringop-overflow -Wno-maybe-uninitialized)
endif()
# GCC's own collector does not run. Of seven large units user time fell by 6 to 16 % (GCC 12: formats 28.7 to 24.2 s,
# test_commands 20.7 to 17.6, clip 17.8 to 15.9, haptics 18.0 to 16.9), memory rose by 0.1 to 0.7 GB, to 2.3 at most.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  add_compile_options(--param=ggc-min-expand=1000 --param=ggc-min-heapsize=4000000)
endif()
if(TOUCHABLE_WERROR)
  add_compile_options(-Werror)
endif()
if(TOUCHABLE_SANITIZE)
  add_compile_options(-fsanitize=${TOUCHABLE_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${TOUCHABLE_SANITIZE})
  # Sanitize only this project: instrumenting the JSON library's templates took a third of the compile time of files
  # that read JSON. The library's own assertions stay on. The fuzzer instruments them: its bytes reach them first.
  if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang" AND NOT TOUCHABLE_SANITIZE MATCHES "fuzzer")
    add_compile_options(-fsanitize-ignorelist=${PROJECT_SOURCE_DIR}/cmake/not_sanitized.txt)
  endif()
  # GNU's linker takes a second for each of forty programs, LLVM's a quarter of a second.
  find_program(TOUCHABLE_LLD ld.lld DOC "LLVM's linker (Debian: lld); may be absent")
  if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang" AND TOUCHABLE_LLD)
    add_link_options(-fuse-ld=lld)
  endif()
endif()

# With Clang's sanitizers a precompiled header is built once for all modules, and once for the unoptimised ones: it
# saves a third of a small module's compile time, a tenth of a large one's. Other builds have none.
if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang" AND TOUCHABLE_SANITIZE AND NOT TOUCHABLE_SANITIZE MATCHES "fuzzer")
  add_compile_options(-fPIC -pthread)  # sharing a precompiled header requires the same options for all
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/precompiled.cpp CONTENT "")
  foreach(name IN ITEMS precompiled unhurried_precompiled)
    add_library(touchable_${name} OBJECT ${PROJECT_BINARY_DIR}/precompiled.cpp)
    target_compile_features(touchable_${name} PUBLIC cxx_std_20)
    target_compile_options(touchable_${name} PRIVATE "SHELL:-Xclang -fno-pch-timestamp")  # allows caching
    target_precompile_headers(touchable_${name} PRIVATE ${PROJECT_SOURCE_DIR}/cmake/precompiled.hpp)
  endforeach()
  target_compile_options(touchable_unhurried_precompiled PRIVATE -O0)
  # Without these settings ccache recompiles every file that uses a precompiled header.
  if(CMAKE_CXX_COMPILER_LAUNCHER MATCHES "ccache$")
    list(PREPEND CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros)
  endif()
endif()
function(touchable_reads target precompiled)
  if(TARGET touchable_${precompiled})
    set_target_properties(${target} PROPERTIES PRECOMPILE_HEADERS_REUSE_FROM touchable_${precompiled})
  endif()
endfunction()

# touchable_optimise(target release|little). release: sanitizers compile it without optimisation, because its tests
# are short. little: also Release uses -Og, because it takes long to compile and little time to run, such as a module
# that reads words (a file of it that loops over pixels gets -O3 by itself). The fuzzer, which runs file readers all the time, compiles everything with -O1.
function(touchable_optimise target level)
  if(TOUCHABLE_SANITIZE AND NOT TOUCHABLE_SANITIZE MATCHES "fuzzer")
    target_compile_options(${target} PRIVATE -O0)
    touchable_reads(${target} unhurried_precompiled)
  elseif(NOT TOUCHABLE_SANITIZE AND level STREQUAL "little" AND CMAKE_BUILD_TYPE STREQUAL "Release")
    target_compile_options(${target} PRIVATE -Og)
  endif()
endfunction()

# One module: all .cpp files of the folder whose CMakeLists.txt calls this, as the static library `touchable_<name>`. Includes are
# written from the root of the project.
# touchable_module(name [HEADERS x.hpp...] [USES module...] [PUBLIC_LIBRARIES target...] [LIBRARIES target...]
#                  [SOURCES x.cpp...] [WITHOUT x.cpp...] [OPTIMISED release|little])
# HEADERS: headers that other modules may include; tests/modules checks this. USES: modules whose headers it includes.
# PUBLIC_LIBRARIES: included by its public headers. SOURCES: only these. WITHOUT: excludes these.
# OPTIMISED: see touchable_optimise.
function(touchable_module name)
  cmake_parse_arguments(MODULE "" "OPTIMISED" "HEADERS;USES;PUBLIC_LIBRARIES;LIBRARIES;SOURCES;WITHOUT" ${ARGN})
  if(NOT MODULE_SOURCES)
    file(GLOB MODULE_SOURCES CONFIGURE_DEPENDS RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} *.cpp)
    list(REMOVE_ITEM MODULE_SOURCES "" ${MODULE_WITHOUT})
  endif()
  set(target touchable_${name})
  add_library(${target} STATIC ${MODULE_SOURCES})
  add_library(touchable::${name} ALIAS ${target})
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_include_directories(${target} PUBLIC
      $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:include/touchable>)
  list(TRANSFORM MODULE_USES PREPEND touchable_)
  target_link_libraries(${target} PUBLIC ${MODULE_USES} ${MODULE_PUBLIC_LIBRARIES} PRIVATE ${MODULE_LIBRARIES})
  touchable_reads(${target} precompiled)
  if(MODULE_OPTIMISED)
    touchable_optimise(${target} ${MODULE_OPTIMISED})
  endif()
endfunction()
