// A folder for each test, and files as a power cut or another program leaves them.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "folder.hpp"

namespace takt::store {

class InDirectory : public testing::Test {
protected:
    const takt::test::Folder folder_;
    const std::filesystem::path directory_ = folder_.path();
};

inline std::string bytes_of(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream all;
    all << file.rdbuf();
    return all.str();
}

inline void overwrite(const std::filesystem::path& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

}  // namespace takt::store
