# find_package(touchable): touchable::haptics, touchable::frame, touchable::scene.
include(CMakeFindDependencyMacro)
find_dependency(PkgConfig)
find_dependency(glm)
find_dependency(nlohmann_json 3)
find_dependency(Threads)
pkg_check_modules(XXHASH REQUIRED QUIET IMPORTED_TARGET libxxhash)
include("${CMAKE_CURRENT_LIST_DIR}/touchable-targets.cmake")
