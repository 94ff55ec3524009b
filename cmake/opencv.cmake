# SPDX-License-Identifier: Apache-2.0
# OpenCV is used only by tests and benchmarks: its median is compared with ours, and a test reads camera files that it
# writes. The target `touchable_opencv` always exists; it defines TOUCHABLE_HAS_OPENCV if OpenCV is found (Debian:
# libopencv-imgproc-dev, which has no CMake package).

find_path(TOUCHABLE_OPENCV_INCLUDE opencv2/imgproc.hpp PATH_SUFFIXES opencv4 DOC "OpenCV's headers; may be absent")
find_library(TOUCHABLE_OPENCV_CORE opencv_core DOC "May be absent")
find_library(TOUCHABLE_OPENCV_IMGPROC opencv_imgproc DOC "May be absent")

add_library(touchable_opencv INTERFACE)
if(TOUCHABLE_OPENCV_INCLUDE AND TOUCHABLE_OPENCV_CORE AND TOUCHABLE_OPENCV_IMGPROC)
  target_include_directories(touchable_opencv SYSTEM INTERFACE "${TOUCHABLE_OPENCV_INCLUDE}")
  target_link_libraries(touchable_opencv INTERFACE "${TOUCHABLE_OPENCV_IMGPROC}" "${TOUCHABLE_OPENCV_CORE}")
  target_compile_definitions(touchable_opencv INTERFACE TOUCHABLE_HAS_OPENCV)
else()
  message(STATUS "OpenCV's core and imgproc are not here: no comparison with its median")
endif()
