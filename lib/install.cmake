# Installs the library, the headers that its users include, and what find_package(vdbpack) reads.
include(CMakePackageConfigHelpers)
include(GNUInstallDirs)

# What users include, and all that it includes.
set(entry_headers vdbpack/vdbpack.h vdbpack/field/narrow_band.h)
set(headers)
while(entry_headers)
    list(POP_FRONT entry_headers header)
    if(header IN_LIST headers)
        continue()
    endif()
    list(APPEND headers "${header}")
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/${header}")
    file(STRINGS "${CMAKE_CURRENT_SOURCE_DIR}/${header}" includes REGEX "^#include \"vdbpack/")
    list(TRANSFORM includes REPLACE "^#include \"(.*)\".*" "\\1")
    list(APPEND entry_headers ${includes})
endwhile()

list(LENGTH headers count)
if(count GREATER 60)
    message(FATAL_ERROR "${count} headers would be installed, more than 60: declare a type instead of "
                        "including its header, or move private parts into the .cpp")
endif()

install(TARGETS vdbpack EXPORT vdbpackTargets ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}")
foreach(header ${headers})
    get_filename_component(folder "${header}" DIRECTORY)
    install(FILES "${header}" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/${folder}")
endforeach()

set(package_folder "${CMAKE_INSTALL_LIBDIR}/cmake/vdbpack")
install(EXPORT vdbpackTargets NAMESPACE vdbpack:: DESTINATION "${package_folder}")
configure_package_config_file(vdbpackConfig.cmake.in
    "${CMAKE_CURRENT_BINARY_DIR}/vdbpackConfig.cmake" INSTALL_DESTINATION "${package_folder}")
write_basic_package_version_file("${CMAKE_CURRENT_BINARY_DIR}/vdbpackConfigVersion.cmake"
    COMPATIBILITY SameMinorVersion)
install(FILES "${CMAKE_CURRENT_BINARY_DIR}/vdbpackConfig.cmake"
              "${CMAKE_CURRENT_BINARY_DIR}/vdbpackConfigVersion.cmake"
        DESTINATION "${package_folder}")
