# VDBPACK_UNITY: the sources of a room are compiled as one that includes them, so that their headers
# are read and templates instantiated once. What they keep in anonymous namespaces therefore
# has names of its own within a room. Kernels stay apart: their speed does not depend on neighbors.
function(vdbpack_unity target)
    if(NOT VDBPACK_UNITY)
        return()
    endif()
    get_target_property(sources ${target} SOURCES)
    foreach(source IN LISTS sources)
        if(source MATCHES "/pack/front/|/field/band/" OR NOT source MATCHES "/lib/vdbpack/([a-z]+)/|^(cli)/")
            continue()
        endif()
        set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${CMAKE_MATCH_1}${CMAKE_MATCH_2})
    endforeach()
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
        # It takes the included sources for headers.
        target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
    endif()
endfunction()
vdbpack_unity(vdbpack)
vdbpack_unity(vdbpack_grids)
vdbpack_unity(vdbpack_callers)
