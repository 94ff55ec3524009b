# find_package(touchable [COMPONENTS touchable media solver]):
#   touchable           touchable::touchable (libtouchable, C) and touchable::touchable_static
#   media               touchable::media (libtouchable-media, C)
#   solver              touchable::solver: touchable::haptics, touchable::frame, touchable::scene (C++20), over GLM and nlohmann/json
# Without COMPONENTS: what is installed, and of the solver what its own libraries are there for.
include(CMakeFindDependencyMacro)

include("${CMAKE_CURRENT_LIST_DIR}/touchable-targets.cmake" OPTIONAL)  # where only the solver was built there are none

if("solver" IN_LIST touchable_FIND_COMPONENTS OR NOT EXISTS "${CMAKE_CURRENT_LIST_DIR}/touchable-targets.cmake")
  find_dependency(glm)
  find_dependency(nlohmann_json 3)
  find_dependency(Threads)
elseif(NOT touchable_FIND_COMPONENTS)
  find_package(glm QUIET)
  find_package(nlohmann_json 3 QUIET)
  find_package(Threads QUIET)
endif()
if(TARGET glm::glm AND TARGET nlohmann_json::nlohmann_json AND TARGET Threads::Threads)
  include("${CMAKE_CURRENT_LIST_DIR}/touchable-solver-targets.cmake")
endif()

foreach(component IN LISTS touchable_FIND_COMPONENTS)
  if(TARGET touchable::${component})
    set(touchable_${component}_FOUND TRUE)
  elseif(touchable_FIND_REQUIRED_${component})
    set(touchable_FOUND FALSE)
    set(touchable_NOT_FOUND_MESSAGE "this installation has no component ${component}; there are touchable, media and solver")
  endif()
endforeach()
