#pragma once

#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <string>

namespace touchable {

/// A file that is there as long as this is.
class TemporaryFile {
public:
    TemporaryFile(const std::string& name, const std::string& text) {
        // Each test case may run as a process of its own beside the others.
        const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
        path_ = ::testing::TempDir() + test->test_suite_name() + "-" + test->name() + "-" + name;
        std::ofstream(path_, std::ios::binary) << text;
    }
    ~TemporaryFile() { std::remove(path_.c_str()); }
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;

    const std::string& path() const { return path_; }

private:
    std::string path_;
};

}  // namespace touchable
