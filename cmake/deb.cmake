# SPDX-License-Identifier: Apache-2.0
# A Debian package of everything that is installed: `cmake --build build/release --target deb` (docs/install.md).

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME touchable)
set(CPACK_PACKAGE_VENDOR "touchable developers")
set(CPACK_PACKAGE_CONTACT "touchable developers <noreply@touchable.invalid>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "touch depth video and feel its forces")
set(CPACK_PACKAGE_DESCRIPTION "\
touchable makes a surface of every frame of a depth video, and computes
the force on each fingertip there a thousand times a second. A mouse is
enough to try it; haptic devices push back.
.
The package has the program, its libraries for C and C++ (libtouchable and
libtouchable-media), and what is needed to build programs that link these.")
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)

set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION video)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/capi)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(debian ${PROJECT_BINARY_DIR}/debian)
file(CONFIGURE OUTPUT ${debian}/triggers CONTENT "activate-noawait ldconfig\n")
# The trigger does all. Unless it gets files of these names, CPack adds scripts that call ldconfig; it warns that there are none.
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA ${debian}/triggers ${debian}/none/postinst ${debian}/none/postrm)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "mesa-vulkan-drivers, libxcursor1, fonts-dejavu-core, hdf5-tools, python3, python3-matplotlib")
# For Blender's exporter, and for programs that link the solver's modules.
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "blender, libglm-dev, nlohmann-json3-dev")
# What the package alone has: what Debian's checker has to leave, and a changelog of Debian's form, dated as the newest release.
set(CPACK_INSTALLED_DIRECTORIES ${debian}/usr usr)
configure_file(cmake/debian/lintian-overrides ${debian}/usr/share/lintian/overrides/touchable COPYONLY)
file(STRINGS CHANGELOG.md release REGEX "^## .*[(][0-9]+-[0-9]+-[0-9]+[)]" LIMIT_COUNT 1)
string(REGEX REPLACE ".*[(](.*)[)].*" "\\1" release "${release}")
execute_process(COMMAND ${CMAKE_COMMAND} -E env LC_ALL=C date -u -R -d "${release}" OUTPUT_VARIABLE release OUTPUT_STRIP_TRAILING_WHITESPACE)
set(changelog ${debian}/usr/share/doc/touchable/changelog)
file(CONFIGURE OUTPUT ${changelog} CONTENT "\
touchable (${PROJECT_VERSION}) unstable; urgency=medium

  * CHANGELOG.md beside this file says what has changed.

 -- ${CPACK_PACKAGE_CONTACT}  ${release}
")
execute_process(COMMAND gzip -9nf ${changelog})
include(CPack)

add_custom_target(deb
    COMMAND ${CMAKE_CPACK_COMMAND} -G DEB
    WORKING_DIRECTORY ${PROJECT_BINARY_DIR} COMMENT "Making the Debian package" VERBATIM)
add_dependencies(deb installed_files)
