#include "live/mark_file.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <tuple>

#include "folder.hpp"

namespace takt::web {
namespace mark_file_test {

Mark mark(int number) {
    return {.time_ms = 1'700'000'000'000 + number,
            .kind = number % 2 == 0 ? Mark::Kind::message : Mark::Kind::command,
            .severity = "info",
            .outcome = number % 2 == 0 ? "" : "done",
            .origin = number % 2 == 0 ? "" : "192.0.2.7",
            .texts = {"mark " + std::to_string(number), "метка \"1\"\n", "мітка"}};
}

class MarkFileTest : public testing::Test {
protected:
    [[nodiscard]] MarkFile::Opened open() const {
        auto opened = MarkFile::open(path_, 5);
        EXPECT_TRUE(opened) << (opened ? "" : name(opened.error().code));
        return opened ? *std::move(opened) : MarkFile::Opened{};
    }
    [[nodiscard]] std::string bytes(const std::string& suffix = "") const {
        std::ifstream file(path_ + suffix, std::ios::binary);
        std::ostringstream all;
        all << file.rdbuf();
        return all.str();
    }
    void write(const std::string& bytes) const { std::ofstream(path_, std::ios::binary) << bytes; }
    void write_marks(int count) const {
        auto opened = open();
        for (int i = 0; i < count; ++i) ASSERT_TRUE(opened.file->append(std::vector{mark(i)}));
    }
    void expect_marks(const std::vector<Mark>& found, int count) const {
        ASSERT_EQ(found.size(), static_cast<std::size_t>(count));
        for (int i = 0; i < count; ++i) EXPECT_EQ(found[static_cast<std::size_t>(i)], mark(i));
    }

    const takt::test::Folder folder_;
    const std::string path_ = folder_ / "plant.marks.jsonl";
};

TEST_F(MarkFileTest, KeepsMarks) {
    write_marks(5);
    const auto opened = open();
    EXPECT_EQ(opened.since_ms, 5);
    expect_marks(opened.marks, 5);
    EXPECT_EQ(opened.cut_bytes, 0u);
    EXPECT_EQ(opened.set_aside, "");
}

// At each place where a power cut may end the file.
TEST_F(MarkFileTest, CutsATornEndOff) {
    write_marks(3);
    const auto whole = bytes();
    const auto last_line = whole.find_last_of('\n', whole.size() - 2) + 1;
    for (auto size = last_line + 1; size < whole.size(); ++size) {
        write(whole.substr(0, size) + (size % 2 == 0 ? std::string(100, '\0') : ""));
        auto opened = open();
        expect_marks(opened.marks, 2);
        EXPECT_GT(opened.cut_bytes, 0u);
        EXPECT_EQ(opened.set_aside, "");
        ASSERT_TRUE(opened.file->append(std::vector{mark(2)}));
        EXPECT_EQ(bytes(), whole);
    }
}

TEST_F(MarkFileTest, BeginsAnewAfterATornHeading) {
    write_marks(0);
    const auto heading = bytes();
    for (std::size_t size = 0; size < heading.size(); ++size) {
        write(heading.substr(0, size));
        EXPECT_EQ(open().set_aside, "");
        EXPECT_EQ(bytes(), heading);
    }
}

TEST_F(MarkFileTest, SetsADamagedFileAsideAndKeepsItsMarks) {
    write_marks(3);
    auto damaged = bytes();
    damaged[damaged.find("mark 1") - 3] = '\x01';
    write(damaged);
    {
        const auto opened = open();
        EXPECT_EQ(opened.set_aside, path_ + ".damaged-1");
        EXPECT_EQ(bytes(".damaged-1"), damaged);
        EXPECT_EQ(opened.marks, (std::vector{mark(0), mark(2)}));
    }
    EXPECT_EQ(open().marks.size(), 2u);
    EXPECT_EQ(open().set_aside, "");
}

TEST_F(MarkFileTest, SetsForeignFilesAside) {
    const std::string foreign[] = {"x",
                                   "takt: 1\n",
                                   std::string(1000, '\xFF'),
                                   "{\"takt\":\"other\"}\n",
                                   std::string(3 * MarkFile::kMostBytes, 'a'),
                                   "[[[[\n[[[\n"};
    int number = 0;
    for (const auto& bytes_there : foreign) {
        write(bytes_there);
        const auto opened = open();
        EXPECT_EQ(opened.set_aside, path_ + ".damaged-" + std::to_string(++number));
        EXPECT_EQ(bytes(".damaged-" + std::to_string(number)), bytes_there);
        EXPECT_TRUE(opened.marks.empty());
        EXPECT_EQ(opened.since_ms, 5);
    }
}

TEST_F(MarkFileTest, LeavesANewerVersionAlone) {
    const std::string newer = "{\"takt\":\"marks\",\"version\":2,\"since\":1}\n{}\n";
    write(newer);
    const auto opened = MarkFile::open(path_, 5);
    ASSERT_FALSE(opened);
    EXPECT_EQ(opened.error().code, Code::unsupported);
    EXPECT_EQ(bytes(), newer);
}

TEST_F(MarkFileTest, HasOneOwner) {
    auto first = open();
    const auto code_of_second = [&] {
        const auto second = MarkFile::open(path_, 5);
        return second ? Code{} : second.error().code;
    };
    EXPECT_EQ(code_of_second(), Code::busy);
    ASSERT_TRUE(first.file->write_anew(7, std::vector{mark(0)}));
    EXPECT_EQ(code_of_second(), Code::busy) << "the new file is locked as well";
    first.file.reset();
    EXPECT_EQ(open().since_ms, 7);
}

TEST_F(MarkFileTest, NoticesAForeignChange) {
    auto opened = open();
    const auto code_of_append = [&] {
        const auto appended = opened.file->append(std::vector{mark(1)});
        return appended ? Code{} : appended.error().code;
    };
    std::filesystem::resize_file(path_, 3);
    EXPECT_EQ(code_of_append(), Code::replaced);
    ASSERT_TRUE(opened.file->write_anew(5, std::vector{mark(0)}));
    std::filesystem::remove(path_);
    EXPECT_EQ(code_of_append(), Code::replaced);
    ASSERT_TRUE(opened.file->write_anew(5, std::vector{mark(0)}));
    EXPECT_EQ(code_of_append(), Code{});
    opened.file.reset();
    expect_marks(open().marks, 2);
}

TEST_F(MarkFileTest, StaysSmall) {
    auto opened = open();
    std::vector<Mark> marks;
    for (int i = 0; i < 2000; ++i) marks.push_back(mark(i));
    marks.front().texts[0].assign(10'000, 'x');
    ASSERT_TRUE(opened.file->append(marks));
    EXPECT_FALSE(opened.file->is_large());
    ASSERT_TRUE(opened.file->append(marks));
    ASSERT_TRUE(opened.file->append(std::vector{mark(0)}));
    EXPECT_TRUE(opened.file->is_large());

    for (auto& its : marks) its.texts[1].assign(10'000, 'x');
    ASSERT_TRUE(opened.file->write_anew(5, marks));
    EXPECT_LE(std::filesystem::file_size(path_), MarkFile::kMostBytes);
    EXPECT_FALSE(opened.file->is_large());
    opened.file.reset();
    const auto again = open();
    EXPECT_EQ(again.marks.back(), marks.back());
    EXPECT_EQ(again.since_ms, marks[marks.size() - again.marks.size() - 1].time_ms + 1);
}

// The limit of the size stands for a full disk.
TEST_F(MarkFileTest, AFullDiskLeavesNoPartOfALine) {
    const auto child = ::fork();
    if (child == 0) {
        std::signal(SIGXFSZ, SIG_IGN);
        auto opened = open();
        const auto whole = bytes().size();
        const rlimit limit{whole + 50, whole + 50};
        ::setrlimit(RLIMIT_FSIZE, &limit);
        const bool failed = !opened.file->append(std::vector{mark(0)});
        ::_exit(failed && bytes().size() == whole ? 0 : 1);
    }
    int status = -1;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_EQ(status, 0);
    EXPECT_TRUE(open().marks.empty());
}

// A killed writer leaves whole marks and no temporary file that disturbs the next run.
TEST_F(MarkFileTest, SurvivesAKillAtAnyMoment) {
    for (int round = 0; round < 20; ++round) {
        const auto child = ::fork();
        if (child == 0) {
            auto opened = open();
            for (int i = 0;; ++i) {
                std::ignore = opened.file->append(std::vector{mark(i)});
                if (i % 5 == 4) std::ignore = opened.file->write_anew(5, std::vector{mark(0), mark(1)});
            }
        }
        while (!std::filesystem::exists(path_)) ::usleep(1000);
        ::usleep(static_cast<useconds_t>(3000 + round * 1700));
        ::kill(child, SIGKILL);
        ::waitpid(child, nullptr, 0);
        auto opened = open();
        EXPECT_EQ(opened.set_aside, "");
        for (const auto& its : opened.marks) EXPECT_EQ(its.texts[1], mark(0).texts[1]);
        ASSERT_TRUE(opened.file->write_anew(5, opened.marks));
        EXPECT_FALSE(std::filesystem::exists(path_ + ".new"));
    }
}

}  // namespace mark_file_test
}  // namespace takt::web
