#include "takt/os/rotation.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "folder.hpp"
#include "takt/os/open.hpp"

namespace takt::os {
namespace rotation_test {

using Names = std::vector<std::string>;

struct RotationTest : testing::Test {
    takt::test::Folder folder;
    std::string path = folder / "a";
    NumberedName name = [this](unsigned number) {
        return number == 0 ? path : path + "." + std::to_string(number);
    };
    Descriptor file = opened();

    Descriptor opened() {
        auto begun = open_anew(path);
        return begun ? *std::move(begun) : Descriptor();
    }
    /// @returns the error; nothing: it succeeded
    std::optional<Error> rotate(unsigned old_files) {
        auto next = begin_next_file(file.get(), old_files, name);
        if (!next) return next.error();
        file = *std::move(next);
        return {};
    }
    void put(const std::string& text) { ASSERT_TRUE(write_all(file.get(), text)); }
};

TEST_F(RotationTest, KeepsTheNewestFilesInOrder) {
    for (const char* text : {"one", "two", "three", "four"}) {
        put(text);
        ASSERT_FALSE(rotate(2));
    }
    EXPECT_EQ(folder.names(), (Names{"a", "a.1", "a.2"}));
    EXPECT_EQ(folder.read("a"), "");
    EXPECT_EQ(folder.read("a.1"), "four");
    EXPECT_EQ(folder.read("a.2"), "three");
}

TEST_F(RotationTest, EmptiesTheFileWithoutOldOnes) {
    put("one");
    ASSERT_FALSE(rotate(0));
    put("two");
    EXPECT_EQ(folder.names(), Names{"a"});
    EXPECT_EQ(folder.read("a"), "two");
    EXPECT_EQ(open_anew(path).error().code, Code::busy);
}

TEST_F(RotationTest, NeverLeavesTheNameToAnotherProgram) {
    std::atomic<bool> ended = false;
    std::atomic<int> attempts = 0;
    std::atomic<int> opened = 0;
    std::thread other([&] {
        while (!ended) {
            opened += open_anew(path) ? 1 : 0;
            ++attempts;
        }
    });
    for (int i = 0; i < 100 || attempts < 100; ++i) EXPECT_FALSE(rotate(2));
    ended = true;
    other.join();
    EXPECT_EQ(opened, 0);
}

TEST_F(RotationTest, BeginsAgainWhereTheFileWasRemoved) {
    put("one");
    std::filesystem::remove(path);
    ASSERT_FALSE(rotate(2));
    put("two");
    EXPECT_EQ(folder.names(), Names{"a"});
    EXPECT_EQ(folder.read("a"), "two");
}

TEST_F(RotationTest, LeavesTheFileOfAnother) {
    std::filesystem::rename(path, folder / "moved");
    folder.write("a", "of another");
    EXPECT_EQ(rotate(2)->code, Code::replaced);
    EXPECT_EQ(rotate(0)->code, Code::replaced);
    put("one");
    EXPECT_EQ(folder.read("moved"), "one");
    EXPECT_EQ(folder.read("a"), "of another");
}

TEST_F(RotationTest, AFailureCostsNoOldFile) {
    put("current");
    std::filesystem::create_directory(folder / "a.1");
    folder.write("a.2", "old");
    EXPECT_EQ(rotate(1)->code, Code::io_failed);
    std::filesystem::create_directory(folder / "a.3");
    for (int i = 0; i < 3; ++i) EXPECT_EQ(rotate(3)->code, Code::io_failed) << "no file replaces a folder";
    put(", grown");
    EXPECT_EQ(folder.read("a"), "current, grown");
    EXPECT_EQ(folder.read("a.2"), "old");
}

}  // namespace rotation_test
}  // namespace takt::os
