#include "takt/os/rotating_file.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <csignal>
#include <filesystem>
#include <string>

#include "folder.hpp"

namespace takt::os {
namespace rotating_file_test {

using takt::test::Folder;

using Names = std::vector<std::string>;

std::unique_ptr<RotatingFile> open(const Folder& folder, std::size_t file_bytes, unsigned old_files) {
    auto opened = RotatingFile::open(folder / "log", {.file_bytes = file_bytes, .old_files = old_files});
    EXPECT_TRUE(opened);
    return opened ? *std::move(opened) : nullptr;
}

TEST(RotatingFile, KeepsTheNewestFilesInOrder) {
    const Folder folder;
    const auto file = open(folder, 8, 2);
    for (const char* line : {"one\n", "two\n", "three\n", "four\n", "five\n"})
        EXPECT_EQ(file->write(line).error, 0);
    EXPECT_EQ(folder.names(), (Names{"log", "log.1", "log.2"}));
    EXPECT_EQ(folder.read("log"), "five\n");
    EXPECT_EQ(folder.read("log.1"), "four\n");
    EXPECT_EQ(folder.read("log.2"), "three\n");
}

TEST(RotatingFile, ContinuesAnExistingFile) {
    const Folder folder;
    folder.write("log", "old\n");
    const auto file = open(folder, 8, 1);
    (void)file->write("new\n");
    EXPECT_EQ(folder.read("log"), "old\nnew\n");
    (void)file->write("next\n");
    EXPECT_EQ(folder.read("log.1"), "old\nnew\n");
    EXPECT_EQ(folder.read("log"), "next\n");
}

TEST(RotatingFile, DividesALargeTextAtLineEnds) {
    const Folder folder;
    const auto file = open(folder, 8, 5);
    EXPECT_EQ(file->write("1\n2\n3\n4\n5\n6\nlonger than a file\n7\n").bytes, 33u);
    EXPECT_EQ(folder.read("log.3"), "1\n2\n3\n4\n");
    EXPECT_EQ(folder.read("log.2"), "5\n6\n");
    EXPECT_EQ(folder.read("log.1"), "longer than a file\n");
    EXPECT_EQ(folder.read("log"), "7\n");
}

TEST(RotatingFile, NeverRenamesALinkOfTheSystem) {
    const Folder folder;
    folder.write("target", "");
    const auto target = open_for_append(folder / "target");
    ASSERT_TRUE(target);
    std::filesystem::create_symlink("/dev/fd/" + std::to_string(target->get()), folder / "log");
    const auto file = open(folder, 4, 2);
    for (const char* line : {"one\n", "two\n", "six\n"}) EXPECT_EQ(file->write(line).error, 0);
    EXPECT_EQ(folder.names(), (Names{"log", "target"}));
    EXPECT_EQ(folder.read("target"), "one\ntwo\nsix\n");
}

TEST(RotatingFile, TruncatesWithoutOldFiles) {
    const Folder folder;
    const auto file = open(folder, 4, 0);
    (void)file->write("one\n");
    (void)file->write("two\n");
    EXPECT_EQ(folder.names(), Names{"log"});
    EXPECT_EQ(folder.read("log"), "two\n");
}

TEST(RotatingFile, BeginsAnewAndLocked) {
    const Folder folder;
    folder.write("log", "old\n");
    const auto file = RotatingFile::open(folder / "log", {.file_bytes = 8, .old_files = 1, .anew = true});
    ASSERT_TRUE(file);
    for (const char* line : {"one\n", "two\n", "three\n"}) {
        EXPECT_EQ((*file)->write(line).error, 0);
        EXPECT_EQ(open_anew(folder / "log").error().code, Code::busy);
    }
    EXPECT_EQ(folder.read("log.1"), "one\ntwo\n");
    EXPECT_EQ(folder.read("log"), "three\n");
}

TEST(RotatingFile, GrowsWhereTheNextFileCannotBegin) {
    const Folder folder;
    std::filesystem::create_directory(folder / "log.1");
    const auto file = RotatingFile::open(folder / "log", {.file_bytes = 4, .old_files = 1, .anew = true});
    ASSERT_TRUE(file);
    for (const char* line : {"one\n", "two\n"}) EXPECT_EQ((*file)->write(line).error, 0);
    EXPECT_EQ(folder.read("log"), "one\ntwo\n");
    std::filesystem::remove(folder / "log.1");
    EXPECT_EQ((*file)->write("six\n").error, 0);
    EXPECT_EQ(folder.read("log.1"), "one\ntwo\n");
    EXPECT_EQ(folder.read("log"), "six\n");
}

TEST(RotatingFile, CreatesFilesWithTheGivenMode) {
    const Folder folder;
    const auto opened = RotatingFile::open(folder / "log", {.mode = 0600});
    ASSERT_TRUE(opened);
    struct stat status{};
    ASSERT_EQ(::stat((folder / "log").c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 07777, 0600u);
}

TEST(RotatingFile, IsNotOpenedWhereItCannotBeWritten) {
    const Folder folder;
    EXPECT_EQ(RotatingFile::open(folder / "none/log", {}).error().code, Code::cannot_open);
    EXPECT_EQ(RotatingFile::open("/dev/null", {}).error().code, Code::unsupported);
}

// A limit of the file size stands for a full disk: the kernel writes what fits and then reports an error.
TEST(RotatingFile, LeavesNoPartOfALineWhenAWriteFails) {
    const Folder folder;
    const auto file = open(folder, 1000, 1);
    ASSERT_NE(::signal(SIGXFSZ, SIG_IGN), SIG_ERR);
    rlimit limit{};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &limit), 0);
    const rlimit small{.rlim_cur = 10, .rlim_max = limit.rlim_max};
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
    const auto written = file->write("first\nsecond\nthird\n");
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
    EXPECT_EQ(written.bytes, 6u);
    EXPECT_EQ(written.error, EFBIG);
    EXPECT_FALSE(written.closed);
    EXPECT_EQ(folder.read("log"), "first\n");
    EXPECT_EQ(file->write("fourth\n").error, 0);
    EXPECT_EQ(folder.read("log"), "first\nfourth\n");
}

}  // namespace rotating_file_test
}  // namespace takt::os
