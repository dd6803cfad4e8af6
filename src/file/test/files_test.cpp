#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "folder.hpp"
#include "outline.hpp"
#include "takt/file/read.hpp"

namespace takt::file {
namespace files_test {

using Findings = std::vector<std::string>;

class Files : public testing::Test {
protected:
    [[nodiscard]] std::string path(const std::string& name) const { return folder_ / name; }
    std::string write(const std::string& name, std::string_view text) const {
        folder_.write(name, text);
        return path(name);
    }

private:
    const takt::test::Folder folder_;
};

TEST_F(Files, TablesStandBesideTheProject) {
    const auto project = write("x/p.yaml", "lines: [{devices: [{variables: tables/t.csv}]}]\n");
    const auto table = write("x/tables/t.csv", "name,bit\nPump,3\n");
    const auto loaded = load_project(project);
    EXPECT_EQ(locations_and_codes(loaded), Findings{});
    EXPECT_EQ(loaded.document.files, (std::vector{project, table}));
    EXPECT_TRUE(outline(loaded.document.root).contains("{name@1/1:1: Pump@1/2:1, bit@1/1:6: 3@1/2:6}@1/2:1"));
}

TEST_F(Files, WhatIsNoFileIsRefusedWithoutWaiting) {
    ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
    std::filesystem::create_symlink("loop", path("loop"));
    write("big", std::string(kMaxFileBytes + 1, '#'));
    const struct {
        std::string path;
        std::string finding;
    } cases[] = {
        {path("none.yaml"), "0:0 not_found"},
        {path("big/x.yaml"), "0:0 not_found"},
        {path(""), "0:0 is_directory"},
        {path("pipe"), "0:0 not_regular"},
        {"/dev/zero", "0:0 not_regular"},
        {"/dev/tty", "0:0 not_regular"},
        {path("big"), "0:0 too_large"},
        {path("loop"), "0:0 cannot_read"},

        {std::string("a\0b", 3), "0:0 not_found"},
    };
    for (const auto& [path, finding] : cases) {
        const auto loaded = load_project(path);
        EXPECT_EQ(locations_and_codes(loaded), Findings{finding}) << path;
        EXPECT_FALSE(loaded.readable);
        EXPECT_EQ(loaded.document.files, std::vector{path});
    }
}

/// Root may read everything: while this lives, the process has the user id of nobody(65534).
class WithoutRights {
public:
    WithoutRights() : user_(::geteuid()) {
        if (user_ == 0) {
            EXPECT_EQ(::seteuid(kNobody), 0);
        }
    }
    ~WithoutRights() {
        if (user_ == 0) {
            EXPECT_EQ(::seteuid(user_), 0);
        }
    }
    WithoutRights(const WithoutRights&) = delete;
    WithoutRights& operator=(const WithoutRights&) = delete;

private:
    static constexpr ::uid_t kNobody = 65534;
    ::uid_t user_;
};

TEST_F(Files, WithoutPermission) {
    const auto name = write("p.yaml", "a: 1\n");
    ASSERT_EQ(::chmod(name.c_str(), 0), 0);
    const WithoutRights nobody;
    EXPECT_EQ(locations_and_codes(load_project(name)), Findings{"0:0 no_permission"});
}

TEST_F(Files, ReadsUpToItsLimitExactly) {
    const auto name = write("f", std::string(100'000, 'x'));
    EXPECT_EQ(read_file(name, 100'000)->size(), 100'000U);
    EXPECT_EQ(read_file(name, 99'999).error().code, Code::too_long);
    // no size to go by
    EXPECT_EQ(read_file("/proc/self/maps", 10).error().code, Code::too_long);
    EXPECT_FALSE(read_file("/proc/self/maps", kMaxFileBytes)->empty());
    EXPECT_EQ(read_file("/proc/self/mem", 10).error().code, Code::io_failed);
}

}  // namespace files_test
}  // namespace takt::file
