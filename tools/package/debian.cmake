# A package for Debian of the component `program`: cpack -G DEB --config BUILD/CPackConfig.cmake, or
# tools/package/make_deb. It depends on the libraries that it was linked to (dpkg-shlibdeps).
set(VDBPACK_MAINTAINER "The vdb_pack authors <vdb-pack@example.org>" CACHE STRING
    "Name and address in a package")
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_VENDOR "The vdb_pack authors")
set(CPACK_PACKAGE_CONTACT "${VDBPACK_MAINTAINER}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_COMPONENTS_ALL program)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME vdbpack)
set(CPACK_DEBIAN_PROGRAM_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(description "vdb_pack converts a surface mesh or an image from CT to a signed
distance field (OpenVDB), packs it densely and without overlaps, cuts voids
as in trabecular bone, verifies the pack, and writes files for Houdini,
Blender, ParaView, YADE and LAMMPS.")
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64" AND VDBPACK_AVX2)
    string(APPEND description "
It needs a processor with AVX2.")
endif()
set(CPACK_DEBIAN_PROGRAM_DESCRIPTION "${description}")

# What Debian's policy asks for.
set(doc ${CMAKE_INSTALL_DATAROOTDIR}/doc/vdbpack)
add_custom_command(OUTPUT ${PROJECT_BINARY_DIR}/package/changelog.gz
    COMMAND ${CMAKE_COMMAND} -E make_directory ${PROJECT_BINARY_DIR}/package
    COMMAND gzip -9 -n -c ${CMAKE_CURRENT_LIST_DIR}/changelog > ${PROJECT_BINARY_DIR}/package/changelog.gz
    DEPENDS ${CMAKE_CURRENT_LIST_DIR}/changelog VERBATIM)
add_custom_target(vdb_pack_changelog ALL DEPENDS ${PROJECT_BINARY_DIR}/package/changelog.gz)
install(FILES ${PROJECT_BINARY_DIR}/package/changelog.gz ${CMAKE_CURRENT_LIST_DIR}/copyright
        DESTINATION ${doc} COMPONENT program)
include(CPack)
