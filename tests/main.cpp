#define CATCH_CONFIG_MAIN
#include <catch2/catch.hpp>

#if defined(VDBPACK_SANITIZED)
// OpenVDB 10 forgets the half-read tree (RootNode::readTopology) and the pages of points
// (PagedInputStream::createHandle) when a file turns out to be damaged; they are not ours to free.
// Everything else that leaks is reported.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
    return "leak:readTopology\nleak:PagedInputStream::createHandle\n";
}
#endif
