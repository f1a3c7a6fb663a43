// What most test files use: Catch2, the names of the library, temporary files, expected errors.
// Test sources alone include it, since it opens namespaces.
#pragma once

#include "support/message_of.h"
#include "support/temporary_folder.h"
#include "support/text_file.h"

#include "vdbpack/core/error.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

using namespace vdbpack;
using namespace vdbpack::test;
using Catch::Matchers::Contains;

/// A test in the plane and in space: its body has `Dim`, 2 and 3.
#define DIM_TEST_CASE(name) TEMPLATE_TEST_CASE_SIG(name, "", ((int Dim), Dim), 2, 3)
