# SPDX-License-Identifier: Apache-2.0
# The CMake package: `find_package(touchable)` defines touchable::solver, the solver's modules in C++ (docs/install.md),
# and, if all parts are built, the C libraries (cmake/libraries.cmake), as separate targets that need nothing else.

include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

add_library(touchable_solver INTERFACE)
add_library(touchable::solver ALIAS touchable_solver)
target_link_libraries(touchable_solver INTERFACE touchable_haptics)
foreach(module IN ITEMS base scene haptics solver)
  set_target_properties(touchable_${module} PROPERTIES EXPORT_NAME ${module})
endforeach()
# Headers also contain arithmetic that affects forces (docs/architecture.md, decision 3).
target_compile_options(touchable_base INTERFACE $<INSTALL_INTERFACE:-ffp-contract=off>)
install(TARGETS touchable_base touchable_scene touchable_haptics touchable_solver EXPORT touchable_solver
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY engine/base engine/scene DESTINATION include/touchable/engine FILES_MATCHING PATTERN "*.hpp")
install(DIRECTORY haptics_cpu DESTINATION include/touchable FILES_MATCHING PATTERN "*.hpp")
install(FILES shaders/hue_code.h DESTINATION include/touchable/shaders)

set(touchable_package ${CMAKE_INSTALL_LIBDIR}/cmake/touchable)
install(EXPORT touchable_solver NAMESPACE touchable:: FILE touchable-solver-targets.cmake DESTINATION ${touchable_package})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/touchable-config-version.cmake COMPATIBILITY SameMinorVersion)
# The name that find_package searches exists only in the installation, not in a checkout or a build folder.
install(FILES cmake/touchable-config.cmake.in DESTINATION ${touchable_package} RENAME touchable-config.cmake)
install(FILES ${PROJECT_BINARY_DIR}/touchable-config-version.cmake DESTINATION ${touchable_package})
