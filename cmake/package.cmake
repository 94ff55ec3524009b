# What another project links: `find_package(touchable)` gives touchable::haptics, and with it frames and scenes
# (docs/linking.md).

include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

foreach(room IN ITEMS base scene frame haptics)
  set_target_properties(touchable_${room} PROPERTIES EXPORT_NAME ${room})
endforeach()
# Headers have arithmetic that reaches a force, too (docs/architecture.md, decision 3).
target_compile_options(touchable_base INTERFACE $<INSTALL_INTERFACE:-ffp-contract=off>)
install(TARGETS touchable_base touchable_scene touchable_frame touchable_haptics EXPORT touchable
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY engine/scene engine/frame DESTINATION include/touchable/engine FILES_MATCHING PATTERN "*.hpp")
install(DIRECTORY haptics_cpu DESTINATION include/touchable FILES_MATCHING PATTERN "*.hpp")
file(GLOB touchable_base_headers CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/engine/*.hpp)
install(FILES ${touchable_base_headers} DESTINATION include/touchable/engine)
install(FILES shaders/hue_code.h DESTINATION include/touchable/shaders)

set(touchable_package ${CMAKE_INSTALL_LIBDIR}/cmake/touchable)
install(EXPORT touchable NAMESPACE touchable:: FILE touchable-targets.cmake DESTINATION ${touchable_package})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/touchable-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES cmake/touchable-config.cmake ${PROJECT_BINARY_DIR}/touchable-config-version.cmake
    DESTINATION ${touchable_package})
