# SPDX-License-Identifier: Apache-2.0
# Installs the C libraries: shared with their soname, libtouchable also static, headers, CMake package, pkg-config.

# Collects the static modules that a target links, directly or indirectly.
function(touchable_modules_of target into)
  set(modules ${${into}})
  get_target_property(linked ${target} LINK_LIBRARIES)
  foreach(module IN LISTS linked)
    if(TARGET "${module}")
      get_target_property(type ${module} TYPE)
      get_target_property(imported ${module} IMPORTED)
      get_target_property(aliased ${module} ALIASED_TARGET)
      if(aliased)
        set(module ${aliased})
      endif()
      if(type STREQUAL "STATIC_LIBRARY" AND NOT imported AND NOT module IN_LIST modules)
        list(APPEND modules ${module})
        touchable_modules_of(${module} modules)
      endif()
    endif()
  endforeach()
  set(${into} ${modules} PARENT_SCOPE)
endfunction()

# One static archive with the objects of libtouchable.so.
get_target_property(touchable_objects touchable_shared SOURCES)
set(touchable_modules "")
touchable_modules_of(touchable_shared touchable_modules)
foreach(module IN LISTS touchable_modules)
  list(APPEND touchable_objects $<TARGET_OBJECTS:${module}>)
endforeach()
list(REMOVE_DUPLICATES touchable_objects)
add_library(touchable_static STATIC ${touchable_objects})
set_target_properties(touchable_static PROPERTIES OUTPUT_NAME touchable LINKER_LANGUAGE CXX
    ARCHIVE_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/capi)
target_link_libraries(touchable_static INTERFACE $<INSTALL_INTERFACE:stdc++> $<INSTALL_INTERFACE:m>)  # also for projects in C only

set_target_properties(touchable_shared PROPERTIES EXPORT_NAME touchable)
set_target_properties(touchable_media_shared PROPERTIES EXPORT_NAME media)
target_link_libraries(touchable_media_shared INTERFACE touchable_shared)  # clips give scenes of that library
set(touchable_libraries touchable_shared touchable_static touchable_media_shared)
foreach(library IN LISTS touchable_libraries)
  target_include_directories(${library} INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/capi> $<INSTALL_INTERFACE:include>)
endforeach()
add_library(touchable::touchable ALIAS touchable_shared)
add_library(touchable::touchable_static ALIAS touchable_static)
add_library(touchable::media ALIAS touchable_media_shared)

install(TARGETS ${touchable_libraries} EXPORT touchable_libraries
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT touchable_libraries NAMESPACE touchable:: FILE touchable-targets.cmake DESTINATION ${touchable_package})
install(FILES capi/touchable.h capi/touchable.hpp DESTINATION include)

file(STRINGS capi/touchable.h touchable_header_version REGEX "^#define TOUCH_VERSION ")
math(EXPR touchable_version_number "${PROJECT_VERSION_MAJOR} * 10000 + ${PROJECT_VERSION_MINOR} * 100 + ${PROJECT_VERSION_PATCH}")
if(NOT touchable_header_version STREQUAL "#define TOUCH_VERSION ${touchable_version_number}")
  message(FATAL_ERROR "capi/touchable.h has \"${touchable_header_version}\"; must be ${touchable_version_number} for version ${PROJECT_VERSION}")
endif()

file(RELATIVE_PATH touchable_prefix_from_pc ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
string(REGEX REPLACE "/$" "" touchable_prefix_from_pc "${touchable_prefix_from_pc}")
foreach(name IN ITEMS touchable touchable-media)
  configure_file(cmake/${name}.pc.in ${PROJECT_BINARY_DIR}/${name}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endforeach()
