# touchable_c_library(name room libraries...): the shared library lib<name>.so.0 of a room, which exports touch_* alone.
function(touchable_c_library name room)
  string(REPLACE "-" "_" target ${name}_shared)
  add_library(${target} SHARED $<TARGET_OBJECTS:${room}>)
  set_target_properties(${target} PROPERTIES OUTPUT_NAME ${name} LINKER_LANGUAGE CXX LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/capi
      VERSION ${PROJECT_VERSION} SOVERSION 0
      # Beside each other wherever they lie, and never in the folder that a program happens to be in.
      BUILD_WITH_INSTALL_RPATH ON INSTALL_RPATH "$ORIGIN"
      LINK_DEPENDS ${PROJECT_SOURCE_DIR}/capi/exported.map)
  target_link_libraries(${target} PRIVATE ${ARGN})
  target_link_options(${target} PRIVATE -Wl,--version-script=${PROJECT_SOURCE_DIR}/capi/exported.map)
  if(NOT TOUCHABLE_SANITIZE)  # whose own functions come with the program
    target_link_options(${target} PRIVATE -Wl,--no-undefined)
  endif()
endfunction()
