// Replacing a file that another program replaces at the same time: no edit is lost.
#include "takt/os/file_exchange.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <set>
#include <stop_token>
#include <thread>
#include <utility>

#include "folder.hpp"
#include "takt/os/replace.hpp"

namespace takt::os {
namespace exchange_test {

using takt::test::Folder;

using Names = std::vector<std::string>;

::mode_t mode_of(const std::string& path) {
    struct stat status{};
    return ::stat(path.c_str(), &status) == 0 ? status.st_mode & 07777 : 0;
}

/// Exchanges with an edit of another program before some of the exchanges.
ExchangeOptions with_edits(const Folder& folder, Names edits) {
    return {[&folder, edits = std::move(edits), turn = std::size_t{0}](const std::string& first,
                                                                       const std::string& second) mutable {
        if (turn < edits.size() && !edits[turn].empty()) {
            folder.write("edit", edits[turn]);
            std::filesystem::rename(folder / "edit", second);
        }
        ++turn;
        return exchange_names(first, second);
    }};
}

ExchangeOptions without_exchange() {
    return {[](const std::string&, const std::string&) { return EINVAL; }};
}

TEST(ExchangeFile, KeepsTheOldFileWithItsMode) {
    for (const auto& options : {ExchangeOptions(), without_exchange()}) {
        const Folder folder;
        folder.write("a", "old");
        folder.write("a~", "older");
        ASSERT_EQ(::chmod((folder / "a").c_str(), 0600), 0);
        const auto done = exchange_file(folder / "a", "new", "old", options);
        ASSERT_TRUE(done && done->replaced);
        EXPECT_EQ(done->backup, folder / "a~");
        EXPECT_EQ(folder.read("a"), "new");
        EXPECT_EQ(folder.read("a~"), "old");
        EXPECT_EQ(mode_of(folder / "a"), 0600u);
        EXPECT_EQ(mode_of(folder / "a~"), 0600u);
        EXPECT_EQ(folder.names(), (Names{"a", "a~"}));
    }
}

TEST(ExchangeFile, KeepsTheOwnerOfBothFiles) {
    if (::geteuid() != 0) GTEST_SKIP() << "only root can give a file to another user";
    const Folder folder;
    folder.write("a", "old");
    ASSERT_EQ(::chown((folder / "a").c_str(), 12345, 12346), 0);
    ASSERT_TRUE(exchange_file(folder / "a", "new", "old"));
    for (const auto* const name : {"a", "a~"}) {
        struct stat status{};
        ASSERT_EQ(::stat((folder / name).c_str(), &status), 0);
        EXPECT_EQ(status.st_uid, 12345u) << name;
        EXPECT_EQ(status.st_gid, 12346u) << name;
    }
}

TEST(ExchangeFile, KeepsALinkAndTheBackupOfItsTarget) {
    const Folder folder;
    folder.write("target", "old");
    std::filesystem::create_symlink("target", folder / "link");
    ASSERT_TRUE(exchange_file(folder / "link", "new", "old"));
    EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
    EXPECT_EQ(folder.read("target"), "new");
    EXPECT_EQ(folder.read("target~"), "old");
}

TEST(ExchangeFile, PutsTheEditOfAnotherProgramBack) {
    for (const auto& options : {ExchangeOptions(), without_exchange()}) {
        const Folder folder;
        folder.write("a", "edit");
        folder.write("a~", "older");
        const auto done = exchange_file(folder / "a", "new", "old", options);
        ASSERT_TRUE(done);
        EXPECT_FALSE(done->replaced);
        EXPECT_EQ(done->kept, Names{});
        EXPECT_EQ(folder.read("a"), "edit");
        EXPECT_EQ(folder.read("a~"), "older");
        EXPECT_EQ(folder.names(), (Names{"a", "a~"}));
    }
}

TEST(ExchangeFile, KeepsBothEditsAroundTheFirstExchange) {
    const Folder folder;
    folder.write("a", "old");
    folder.write("a.conflict", "of an earlier conflict");
    const auto done = exchange_file(folder / "a", "new", "old", with_edits(folder, {"one", "two"}));
    ASSERT_TRUE(done);
    EXPECT_FALSE(done->replaced);
    EXPECT_EQ(done->kept, Names{folder / "a.conflict.2"});
    EXPECT_EQ(folder.read("a"), "two");
    EXPECT_EQ(folder.read("a.conflict.2"), "one");
    EXPECT_EQ(folder.read("a.conflict"), "of an earlier conflict");
    EXPECT_EQ(folder.names(), (Names{"a", "a.conflict", "a.conflict.2"}));
}

TEST(ExchangeFile, LeavesTheNewestEditWhereEditsDoNotEnd) {
    const Folder folder;
    folder.write("a", "old");
    // The third edit replaces the first one, which was back at the path: its program saw that one.
    const auto three = exchange_file(folder / "a", "new", "old", with_edits(folder, {"one", "two", "three"}));
    ASSERT_TRUE(three);
    EXPECT_EQ(folder.read("a"), "three");
    EXPECT_EQ(folder.read("a.conflict"), "two");
    Names edits;
    for (int i = 0; i < 100; ++i) edits.push_back("edit " + std::to_string(i));
    const auto endless = exchange_file(folder / "a", "new", "three", with_edits(folder, edits));
    ASSERT_TRUE(endless && !endless->replaced);
    ASSERT_EQ(endless->kept.size(), 1u);
    EXPECT_NE(folder.read("a"), "new");
    EXPECT_EQ(folder.names(), (Names{"a", "a.conflict", "a.conflict.2"}));
}

TEST(ExchangeFile, DoesNotReplaceWhatIsNoFileAnyMore) {
    const Folder folder;
    const auto missing = exchange_file(folder / "a", "new", "old");
    ASSERT_TRUE(missing);
    EXPECT_FALSE(missing->replaced);
    EXPECT_EQ(folder.names(), Names{});
    folder.write("a", "old");
    const auto linked =
        exchange_file(folder / "a", "new", "old",
                      {[&, first = true](const std::string& from, const std::string& to) mutable {
                          if (std::exchange(first, false)) {
                              std::filesystem::rename(to, folder / "b");
                              std::filesystem::create_symlink("b", to);
                          }
                          return exchange_names(from, to);
                      }});
    ASSERT_TRUE(linked);
    EXPECT_FALSE(linked->replaced);
    EXPECT_TRUE(std::filesystem::is_symlink(folder / "a"));
    EXPECT_EQ(folder.names(), (Names{"a", "b"}));
}

TEST(ExchangeFile, WritesNothingWhereTheBackupIsAFolder) {
    const Folder folder;
    folder.write("a", "old");
    std::filesystem::create_directory(folder / "a~");
    EXPECT_EQ(exchange_file(folder / "a", "new", "old").error(),
              fail(Code::cannot_open, folder / "a~", EISDIR).error());
    EXPECT_EQ(folder.read("a"), "old");
    EXPECT_EQ(folder.names(), (Names{"a", "a~"}));
}

/// Another program that replaces the file in a tight loop. It exchanges instead of renaming, so that it knows
/// which files it displaced itself: each of its edits that it did not displace must be found.
class Writer {
public:
    explicit Writer(const Folder& folder)
        : folder_(folder), thread_([this](const std::stop_token& ended) { run(ended); }) {}

    /// Ends the loop. @returns the edits that were at the path and that the writer did not displace
    std::set<std::string> end() {
        thread_ = {};
        for (const auto& text : displaced_) written_.erase(text);
        return written_;
    }

private:
    void run(const std::stop_token& ended) {
        for (int i = 0; !ended.stop_requested(); ++i) {
            const auto text = "edit " + std::to_string(i);
            folder_.write("edit", text);
            replace();
            written_.insert(text);
            // Bursts, so that some saves find the file that they read.
            if (i % 64 == 63) std::this_thread::sleep_for(std::chrono::microseconds(500));
        }
    }

    /// The file may be missing for a moment, on a file system without exchange.
    void replace() {
        for (;;) {
            if (exchange_names(folder_ / "edit", folder_ / "a") == 0) {
                displaced_.insert(folder_.read("edit"));
                ::unlink((folder_ / "edit").c_str());
                return;
            }
            if (rename_to_free(folder_ / "edit", folder_ / "a") == 0) return;
        }
    }

    const Folder& folder_;
    std::set<std::string> written_;
    std::set<std::string> displaced_;
    std::jthread thread_;  // the last one
};

/// Without a disk, on which 1,000 saves take longer than a test may.
std::filesystem::path in_memory() {
    const std::filesystem::path memory = "/dev/shm";
    return ::access(memory.c_str(), W_OK) == 0 ? memory : std::filesystem::temp_directory_path();
}

void lose_nothing(const ExchangeOptions& options, int saves) {
    const Folder folder(in_memory());
    folder.write("a", "first");
    Writer writer(folder);
    std::set<std::string> found;
    int replaced = 0;
    for (int i = 0; i < saves; ++i) {
        const auto expected = folder.read("a");
        const auto done = exchange_file(folder / "a", "save " + std::to_string(i), expected, options);
        ASSERT_TRUE(done);
        for (const auto& kept : done->kept) {
            found.insert(folder.read(kept.substr(folder.path().size() + 1)));
            std::filesystem::remove(kept);
        }
        if (!done->replaced) continue;
        ++replaced;
        EXPECT_EQ(folder.read("a~"), expected);
        found.insert(expected);
    }
    auto lost = writer.end();
    found.insert(folder.read("a"));
    for (const auto& text : found) lost.erase(text);
    EXPECT_EQ(lost, std::set<std::string>{});
    for (const auto& name : folder.names()) EXPECT_FALSE(name.ends_with(".new")) << name;
    testing::Test::RecordProperty("replaced", replaced);
}

TEST(ExchangeFile, LosesNoEditOfAProgramThatReplacesTheFileInALoop) {
    lose_nothing({}, 1000);
}

TEST(ExchangeFile, LosesNoEditOnAFileSystemWithoutExchange) {
    lose_nothing(without_exchange(), 200);
}

}  // namespace exchange_test
}  // namespace takt::os
