// SPDX-License-Identifier: Apache-2.0
// Headers that many files include and that parse slowly: Clang's sanitized builds parse them once (compile_options.cmake).
#include <algorithm>
#include <array>
#include <atomic>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <deque>
#include <filesystem>
#include <fstream>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#if __has_include(<gtest/gtest.h>)
#define GTEST_HAS_PTHREAD 1  // as in its CMake target
#include <gtest/gtest.h>
#endif
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <set>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>
