# Writes the source of core/version.h: cmake -DSOURCE=FOLDER -DVERSION=1.2.3 -DFILE=version.cpp -P version.cmake
if(EXISTS ${SOURCE}/.git)
    execute_process(
        COMMAND git -C ${SOURCE} describe --always --abbrev=8 --dirty=.changed --exclude "*"
        OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE RESULT_VARIABLE failed ERROR_QUIET)
    if(NOT failed)
        string(APPEND VERSION "+${commit}")
    endif()
endif()
# Written, and compiled again, only where it changes.
file(CONFIGURE OUTPUT ${FILE} CONTENT [[
#include "vdbpack/core/version.h"

const char* vdbpack::version() {
    return "@VERSION@";
}
]] @ONLY)
