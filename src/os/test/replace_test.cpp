// Replacing a file: readers see the old or the new file; links, modes and files of others are kept.
#include "takt/os/replace.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

#include "folder.hpp"
#include "takt/os/open.hpp"

namespace takt::os {
namespace replace_test {

using takt::test::Folder;

using Names = std::vector<std::string>;

::mode_t mode_of(const std::string& path) {
    struct stat status{};
    return ::stat(path.c_str(), &status) == 0 ? status.st_mode & 07777 : 0;
}

TEST(ReplaceFile, CreatesAFileWithTheGivenMode) {
    const Folder folder;
    ASSERT_TRUE(replace_file(folder / "a", "text", {.mode = 0600}));
    EXPECT_EQ(folder.read("a"), "text");
    EXPECT_EQ(mode_of(folder / "a"), 0600u);
    EXPECT_EQ(folder.names(), Names{"a"});
}

TEST(ReplaceFile, KeepsTheModeOfAnExistingFile) {
    const Folder folder;
    folder.write("a", "old");
    ASSERT_EQ(::chmod((folder / "a").c_str(), 0604), 0);
    ASSERT_TRUE(replace_file(folder / "a", "new", {.mode = 0666}));
    EXPECT_EQ(folder.read("a"), "new");
    EXPECT_EQ(mode_of(folder / "a"), 0604u);
}

TEST(ReplaceFile, KeepsALinkAndReplacesItsTarget) {
    const Folder folder;
    folder.write("target", "old");
    std::filesystem::create_symlink("target", folder / "link");
    ASSERT_TRUE(replace_file(folder / "link", "new", {}));
    EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
    EXPECT_EQ(folder.read("target"), "new");
}

TEST(ReplaceFile, RefusesTheLinkOfAnotherUser) {
    if (::geteuid() != 0) GTEST_SKIP() << "only root can give a link to another user";
    const Folder folder;
    folder.write("target", "old");
    std::filesystem::create_symlink("target", folder / "link");
    ASSERT_EQ(::lchown((folder / "link").c_str(), 12345, 12345), 0);
    const auto refused = replace_file(folder / "link", "new", {});
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, Code::cannot_open);
    EXPECT_EQ(refused.error().numbers[0], ELOOP);
    EXPECT_EQ(folder.read("target"), "old");
}

TEST(ReplaceFile, LeavesAnExistingFileWhereItMustNotReplaceIt) {
    const Folder folder;
    folder.write("a", "old");
    const auto replaced = replace_file(folder / "a", "new", {.replace = false});
    ASSERT_FALSE(replaced);
    EXPECT_EQ(replaced.error(), fail(Code::cannot_open, folder / "a", EEXIST).error());
    EXPECT_EQ(folder.read("a"), "old");
}

TEST(ReplaceFile, NoticesAFileThatAppearsWhileItWrites) {
    const Folder folder;
    auto replacement = FileReplacement::begin(folder / "a", {.replace = false});
    ASSERT_TRUE(replacement);
    folder.write("a", "of another program");
    const auto committed = replacement->commit();
    ASSERT_FALSE(committed);
    EXPECT_EQ(committed.error().numbers[0], EEXIST);
    EXPECT_EQ(folder.read("a"), "of another program");
}

TEST(ReplaceFile, RejectsWhatIsNotARegularFile) {
    const Folder folder;
    ASSERT_EQ(::mkfifo((folder / "fifo").c_str(), 0600), 0);
    EXPECT_EQ(replace_file(folder / "fifo", "x", {}).error().code, Code::unsupported);
    EXPECT_EQ(replace_file(folder / ".", "x", {}).error().numbers[0], EISDIR);
    EXPECT_EQ(replace_file("", "x", {}).error().code, Code::cannot_open);
    EXPECT_EQ(replace_file(folder / "none/a", "x", {}).error().numbers[0], ENOENT);
    EXPECT_EQ(folder.names(), Names{"fifo"});
}

TEST(ReplaceFile, RemovesTheTemporaryFileWhenItIsGivenUp) {
    const Folder folder;
    folder.write("a", "old");
    {
        auto replacement = FileReplacement::begin(folder / "a", {});
        ASSERT_TRUE(replacement);
        ASSERT_TRUE(write_all(replacement->descriptor(), "half"));
        EXPECT_EQ(folder.names().size(), 2u);
    }
    EXPECT_EQ(folder.names(), Names{"a"});
    EXPECT_EQ(folder.read("a"), "old");
}

TEST(ReplaceFile, ChoosesAnotherNameThanAnExistingTemporaryFile) {
    const Folder folder;
    const auto taken = "a." + std::to_string(::getpid()) + "-0.new";
    folder.write(taken, "of another program");
    ASSERT_TRUE(replace_file(folder / "a", "text", {}));
    EXPECT_EQ(folder.read(taken), "of another program");
    EXPECT_EQ(folder.read("a"), "text");
}

FileReplacement::Options named(bool ours) {
    return {.mode = 0600,
            .replace = true,
            .temporary_suffix = ".new",
            .may_overwrite = [ours](int) -> Result<bool> { return ours; },
            .lock = true};
}

TEST(NamedReplacement, OverwritesATemporaryFileOfAnEarlierRun) {
    const Folder folder;
    folder.write("a.new", "left by an earlier run");
    auto replacement = FileReplacement::begin(folder / "a", named(true));
    ASSERT_TRUE(replacement);
    ASSERT_TRUE(write_all(replacement->descriptor(), "text"));
    ASSERT_TRUE(replacement->commit());
    EXPECT_EQ(folder.read("a"), "text");
    EXPECT_EQ(folder.names(), Names{"a"});
}

TEST(NamedReplacement, NeverTouchesATemporaryFileThatIsNotOurs) {
    const Folder folder;
    folder.write("a.new", "of another program");
    EXPECT_EQ(FileReplacement::begin(folder / "a", named(false)).error(),
              fail(Code::unsupported, folder / "a.new").error());
    auto without_test = named(true);
    without_test.may_overwrite = {};
    EXPECT_FALSE(FileReplacement::begin(folder / "a", without_test));
    EXPECT_EQ(folder.read("a.new"), "of another program");
}

TEST(NamedReplacement, NeverFollowsALinkUnderTheTemporaryName) {
    const Folder folder;
    folder.write("victim", "text");
    std::filesystem::create_symlink("victim", folder / "a.new");
    EXPECT_FALSE(FileReplacement::begin(folder / "a", named(true)));
    EXPECT_EQ(folder.read("victim"), "text");
    EXPECT_TRUE(std::filesystem::is_symlink(folder / "a.new"));
}

TEST(NamedReplacement, IsBusyWhileAnotherOneIsBeingWritten) {
    const Folder folder;
    auto first = FileReplacement::begin(folder / "a", named(true));
    ASSERT_TRUE(first);
    EXPECT_EQ(FileReplacement::begin(folder / "a", named(true)).error().code, Code::busy);
    EXPECT_EQ(folder.names(), Names{"a.new"}) << "the second one leaves the first one's file";
    EXPECT_TRUE(first->commit());
}

TEST(OpenFile, CreatesALogFileForOwnerAndGroup) {
    const Folder folder;
    const auto old = ::umask(0);
    const auto file = open_for_append(folder / "log");
    ::umask(old);
    ASSERT_TRUE(file);
    EXPECT_EQ(mode_of(folder / "log"), 0640u);
    EXPECT_NE(::fcntl(file->get(), F_GETFD) & FD_CLOEXEC, 0);
}

TEST(OpenFile, AppendsToAnExistingFile) {
    const Folder folder;
    folder.write("log", "1\n");
    const auto file = open_for_append(folder / "log");
    ASSERT_TRUE(file);
    ASSERT_TRUE(write_all(file->get(), "2\n"));
    EXPECT_EQ(folder.read("log"), "1\n2\n");
}

TEST(OpenFile, WritesNothingThroughALink) {
    const Folder folder;
    folder.write("mine", "kept\n");
    std::filesystem::create_symlink("mine", folder / "link");
    std::filesystem::create_symlink("nowhere", folder / "dangling");
    std::filesystem::create_symlink("/dev/../" + (folder / "mine"), folder / "through dots");
    for (const char* const name : {"link", "dangling", "through dots"})
        for (const auto& opened :
             {open_for_append(folder / name).error(), open_anew(folder / name).error()}) {
            EXPECT_EQ(opened.code, Code::cannot_open) << name;
            EXPECT_EQ(opened.subject.view(), folder / name);
        }
    EXPECT_EQ(open_for_append(folder / "link").error().numbers[0], ELOOP);
    EXPECT_EQ(open_anew(folder / "link").error().numbers[0], ELOOP);
    EXPECT_EQ(folder.read("mine"), "kept\n");
    EXPECT_FALSE(std::filesystem::exists(folder / "nowhere"));
}

TEST(OpenFile, FollowsTheLinksOfTheSystem) {
    const Folder folder;
    folder.write("output", "1\n");
    const Descriptor output(::open((folder / "output").c_str(), O_WRONLY | O_APPEND));
    const auto number = std::to_string(output.get());
    std::filesystem::create_symlink("/dev/fd/" + number, folder / "link");
    std::filesystem::create_symlink("/dev/null", folder / "null");
    for (const std::string& path : {"/dev/fd/" + number, "/proc/self/fd/" + number, folder / "link"}) {
        const auto file = open_for_append(path);
        ASSERT_TRUE(file) << path;
        ASSERT_TRUE(write_all(file->get(), "2\n"));
    }
    EXPECT_EQ(folder.read("output"), "1\n2\n2\n2\n");
    EXPECT_TRUE(open_anew(folder / "null"));
    EXPECT_TRUE(open_anew(folder / "link"));
    EXPECT_EQ(folder.read("output"), "");
}

TEST(OpenFile, CreatesFilesThatOthersCannotRead) {
    const Folder folder;
    const mode_t umask = ::umask(0);
    ASSERT_TRUE(open_for_append(folder / "log"));
    ASSERT_TRUE(open_anew(folder / "frames"));
    ::umask(umask);
    for (const char* const name : {"log", "frames"})
        EXPECT_EQ(std::filesystem::status(folder / name).permissions(), std::filesystem::perms{0640}) << name;
}

TEST(OpenFile, BeginsAnewWithAnExistingFile) {
    const Folder folder;
    folder.write("frames", "old frames\n");
    const auto file = open_anew(folder / "frames");
    ASSERT_TRUE(file);
    ASSERT_TRUE(write_all(file->get(), "new\n"));
    EXPECT_EQ(folder.read("frames"), "new\n");
    EXPECT_TRUE(open_anew("/dev/null"));
    ASSERT_EQ(::mkfifo((folder / "fifo").c_str(), 0600), 0);
    EXPECT_EQ(open_anew(folder / "fifo").error().numbers[0], ENXIO) << "does not wait for a reader";
}

TEST(OpenFile, OneProgramAtATimeBeginsAFileAnew) {
    const Folder folder;
    folder.write("frames", "of an ended program\n");
    {
        const auto first = open_anew(folder / "frames");
        ASSERT_TRUE(first && write_all(first->get(), "frames of the first\n"));
        EXPECT_EQ(open_anew(folder / "frames").error(),
                  (Error{Code::busy, std::string_view(folder / "frames")}));
        EXPECT_EQ(folder.read("frames"), "frames of the first\n");
    }
    EXPECT_TRUE(open_anew(folder / "frames"));
    EXPECT_EQ(folder.read("frames"), "");
    EXPECT_TRUE(open_anew("/dev/null") && open_anew("/dev/null")) << "a device is shared";
}

TEST(OpenFile, RejectsWhatIsNotARegularFileWithoutWaiting) {
    const Folder folder;
    ASSERT_EQ(::mkfifo((folder / "fifo").c_str(), 0600), 0);
    EXPECT_EQ(open_for_append(folder / "fifo").error().code, Code::unsupported);
    EXPECT_EQ(open_for_reading(folder / "fifo").error().code, Code::unsupported);
    EXPECT_EQ(open_for_update("/dev/null").error().code, Code::unsupported);
    EXPECT_EQ(open_for_reading(folder / "").error().numbers[0], EISDIR);
    EXPECT_EQ(open_for_reading(folder / "none").error().numbers[0], ENOENT);
}

TEST(OpenFile, AStreamMayBeAFifo) {
    const Folder folder;
    ASSERT_EQ(::mkfifo((folder / "fifo").c_str(), 0600), 0);
    const auto stream = open_stream(folder / "fifo");
    ASSERT_TRUE(stream) << "does not wait for a writer";
    const auto writer = open_anew(folder / "fifo");
    ASSERT_TRUE(writer && write_all(writer->get(), "ab"));
    char bytes[4];
    EXPECT_EQ(::read(stream->get(), bytes, sizeof bytes), 2);
    EXPECT_EQ(open_stream("/dev/null").error().code, Code::unsupported);
    EXPECT_EQ(open_stream(folder / "").error().numbers[0], EISDIR);
}

TEST(ReadAll, ReadsUpToALimit) {
    const Folder folder;
    folder.write("a", std::string(100'000, 'x'));
    const auto read = [&](std::size_t limit) {
        return read_all(open_for_reading(folder / "a").value().get(), "a", limit);
    };
    EXPECT_EQ(read(100'000)->size(), 100'000u);
    EXPECT_EQ(read(99'999).error().code, Code::too_long);
    EXPECT_EQ(read_all(-1, "a", 1).error(), fail(Code::io_failed, "a", EBADF).error());
}

}  // namespace replace_test
}  // namespace takt::os
