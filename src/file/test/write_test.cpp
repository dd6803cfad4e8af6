#include "takt/file/write.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cerrno>
#include <filesystem>

#include "folder.hpp"
#include "takt/file/read.hpp"

namespace takt::file {
namespace write_test {

namespace fs = std::filesystem;

class Write : public testing::Test {
protected:
    std::string path(const char* name) const { return folder_ / name; }
    static std::string text(const std::string& path) { return read_file(path, 1 << 20).value_or("none"); }
    std::size_t files() const { return folder_.names().size(); }

    const takt::test::Folder folder_;
};

TEST_F(Write, AFileThatIsThereStaysUnlessItIsToBeReplaced) {
    ASSERT_TRUE(write_file(path("a"), "one", false));
    const auto again = write_file(path("a"), "two", false);
    ASSERT_FALSE(again);
    EXPECT_EQ(again.error(), fail(Code::cannot_open, path("a"), EEXIST).error());
    EXPECT_EQ(text(path("a")), "one");
    ASSERT_EQ(::chmod(path("a").c_str(), 0640), 0);
    ASSERT_TRUE(write_file(path("a"), "two", true));
    EXPECT_EQ(text(path("a")), "two");
    struct ::stat status{};
    ASSERT_EQ(::stat(path("a").c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 07777, 0640U);
    EXPECT_EQ(files(), 1U);
}

TEST_F(Write, LinksStayLinks) {
    ASSERT_TRUE(write_file(path("a"), "one", false));
    fs::create_symlink("a", path("link"));
    EXPECT_FALSE(write_file(path("link"), "two", false));
    ASSERT_TRUE(write_file(path("link"), "two", true));
    EXPECT_TRUE(fs::is_symlink(path("link")));
    EXPECT_EQ(text(path("a")), "two");
}

TEST_F(Write, OnlyRegularFiles) {
    EXPECT_EQ(write_file(folder_.path(), "x", true).error().numbers[0], EISDIR);
    EXPECT_EQ(write_file("/dev/null", "x", true).error().code, Code::unsupported);
    EXPECT_EQ(write_file(path("no/such"), "x", true).error().numbers[0], ENOENT);
    EXPECT_EQ(write_file("", "x", true).error().numbers[0], ENOENT);
    EXPECT_EQ(write_file(std::string("a\0b", 3), "x", true).error().numbers[0], ENOENT);
    EXPECT_EQ(files(), 0U);
}

}  // namespace write_test
}  // namespace takt::file
