// A directory of its own for each test, and files as a power cut or somebody else leaves them.
#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace takt::store {

class InDirectory : public testing::Test {
protected:
    InDirectory() {
        std::string pattern = (std::filesystem::temp_directory_path() / "takt-store-XXXXXX").string();
        directory_ = ::mkdtemp(pattern.data());
    }
    ~InDirectory() override { std::filesystem::remove_all(directory_); }

    std::filesystem::path directory_;
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
