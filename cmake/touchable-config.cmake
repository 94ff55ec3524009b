# find_package(touchable): touchable::haptics, touchable::frame, touchable::scene.
include(CMakeFindDependencyMacro)
find_dependency(glm)
find_dependency(nlohmann_json 3)
find_dependency(Threads)
include("${CMAKE_CURRENT_LIST_DIR}/touchable-targets.cmake")
