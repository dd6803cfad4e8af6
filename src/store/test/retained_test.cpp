// Retained values: they come back exactly, after any end, and damage is never taken for them.
#include "takt/store/retained.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <random>
#include <thread>

#include "directory.hpp"

namespace takt::store {
namespace retained_test {

namespace fs = std::filesystem;
using value::Value;

class RetainedTest : public InDirectory {
protected:
    [[nodiscard]] std::string path() const { return path_.string(); }
    [[nodiscard]] RetainedFile::Opened opened() const {
        auto result = RetainedFile::open(path(), {});
        EXPECT_TRUE(result) << name(result.error().code);
        return std::move(*result);
    }

    fs::path path_ = directory_ / "plant.state";
};

Retained level(std::int64_t number) {
    return {.name = "level", .type = DataType::int16, .value = number};
}

void wait_for(const RetainedFile& file, std::uint64_t ticket) {
    while (file.progress().durable < ticket) std::this_thread::yield();
}

bool equal(const std::vector<Retained>& a, const std::vector<Retained>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Retained& x, const Retained& y) {
        return x.name == y.name && x.type == y.type && x.scaled == y.scaled &&
               value::same(x.value, y.value) && value::same(x.wanted, y.wanted);
    });
}

std::vector<Retained> of_every_type() {
    return {
        {.name = "a bool", .type = DataType::boolean, .value = true},
        {.name = "b", .type = DataType::int64, .value = std::numeric_limits<std::int64_t>::min()},
        {.name = "c", .type = DataType::uint64, .value = std::numeric_limits<std::uint64_t>::max()},
        {.name = "d", .type = DataType::float32, .value = double{0.1F}, .wanted = double{1e-45F}},
        {.name = "e", .type = DataType::float64, .value = std::numeric_limits<double>::infinity()},
        {.name = "f", .type = DataType::int16, .scaled = true, .value = 12.3, .wanted = -0.0},
        {.name = "g", .type = DataType::string, .value = std::string("a 'quoted'\n\0\xC3\xA4", 15)},
        {.name = "h", .type = DataType::string, .value = std::string()},
        {.name = "i", .type = DataType::int32, .wanted = std::int64_t{-7}},
    };
}

TEST_F(RetainedTest, EveryTypeComesBackExactly) {
    const auto kept = of_every_type();
    {
        const auto file = opened();
        EXPECT_TRUE(file.values.empty());
        for (const auto& entry : kept) (void)file.file->put(entry);
    }
    const auto again = opened();
    EXPECT_TRUE(equal(again.values, kept));
    EXPECT_TRUE(again.set_aside.empty());
}

TEST_F(RetainedTest, TheLastValueOfEachNameIsKept) {
    std::mt19937 random(7);
    std::map<std::string, std::int64_t> last;
    for (int round = 0; round < 8; ++round) {
        {
            const auto file = opened();
            for (auto i = random() % 40; i > 0; --i) {
                const std::string name(1, static_cast<char>('a' + random() % 5));
                last[name] = static_cast<std::int64_t>(random());
                (void)file.file->put({.name = name, .type = DataType::int64, .value = last[name]});
            }
        }
        const auto again = RetainedFile::read(path());
        ASSERT_TRUE(again && again->size() == last.size());
        for (const auto& entry : *again) EXPECT_EQ(entry.value, Value(last[entry.name]));
    }
}

TEST_F(RetainedTest, WhatIsDurableIsThereAfterAKillAtAnyMoment) {
    for (int round = 0; round < 8; ++round) {
        int ends[2];
        ASSERT_EQ(::pipe(ends), 0);
        const pid_t child = ::fork();
        if (child == 0) {
            auto file = RetainedFile::open(path(), {});
            for (std::int64_t i = 1 + round * 1000; file; ++i) {
                wait_for(*file->file, file->file->put(level(i)));
                if (::write(ends[1], &i, sizeof i) != sizeof i) break;
            }
            ::_exit(1);
        }
        ::close(ends[1]);
        std::int64_t acknowledged = 0;
        for (int i = 0; i <= round; ++i)
            ASSERT_EQ(::read(ends[0], &acknowledged, sizeof acknowledged), ssize_t{sizeof acknowledged});
        ::kill(child, SIGKILL);
        while (::read(ends[0], &acknowledged, sizeof acknowledged) == ssize_t{sizeof acknowledged}) {}
        ::close(ends[0]);
        ::waitpid(child, nullptr, 0);
        const auto again = opened();
        ASSERT_TRUE(again.set_aside.empty());
        ASSERT_EQ(again.values.size(), 1U);
        EXPECT_GE(std::get<std::int64_t>(again.values[0].value), acknowledged);
        EXPECT_LE(std::get<std::int64_t>(again.values[0].value), acknowledged + 1);
    }
}

TEST_F(RetainedTest, AFlippedBitIsNeverTakenForAValue) {
    const auto kept = of_every_type();
    {
        const auto file = opened();
        for (const auto& entry : kept) (void)file.file->put(entry);
    }
    const std::string whole = bytes_of(path_);
    std::size_t found = 0;
    for (std::size_t at = 0; at < whole.size(); at += at < 150 ? 1 : 17) {
        std::string flipped = whole;
        flipped[at] = static_cast<char>(flipped[at] ^ (1 << at % 8));
        overwrite(path_, flipped);
        const auto read = RetainedFile::read(path());
        if (read)
            EXPECT_TRUE(equal(*read, kept)) << at;
        else
            ++found;
    }
    EXPECT_GT(found, 20U);
}

struct Damage {
    const char* what;
    std::string (*of)(const std::string& whole);
};

TEST_F(RetainedTest, ADamagedFileIsKeptAside) {
    constexpr Damage kDamages[] = {
        {"cut", [](const std::string& whole) { return whole.substr(0, whole.size() / 2); }},
        {"empty", [](const std::string&) { return std::string(); }},
        {"short", [](const std::string& whole) { return whole.substr(0, 50); }},
        {"text", [](const std::string& whole) { return whole.substr(0, 100) + "takt: 1\n"; }},
        {"zeros", [](const std::string& whole) { return whole.substr(0, 100) + std::string(9000, '\0'); }},
        {"one byte", [](const std::string& whole) { return whole.substr(0, 1); }},
        {"only zeros", [](const std::string& whole) { return std::string(whole.size(), '\0'); }},
        {"a lost sector",
         [](const std::string& whole) { return std::string(512, '\0') + whole.substr(512); }},
    };
    int number = 0;
    for (const auto& damage : kDamages) {
        fs::remove(path_);
        wait_for(*opened().file, 0);
        { (void)opened().file->put(level(7)); }
        const auto damaged = damage.of(bytes_of(path_));
        overwrite(path_, damaged);
        {
            const auto file = opened();
            EXPECT_EQ(file.set_aside, path() + ".damaged-" + std::to_string(++number)) << damage.what;
            EXPECT_TRUE(file.values.empty()) << damage.what;
            EXPECT_EQ(fs::file_size(file.set_aside), damaged.size()) << damage.what;
            (void)file.file->put(level(8));
        }
        EXPECT_EQ(opened().values.size(), 1U) << damage.what;
    }
}

TEST_F(RetainedTest, AForeignFileIsLeftAlone) {
    wait_for(*opened().file, 0);
    std::string other = bytes_of(path_);
    other.replace(68, 4, "Mine");
    for (const std::string& foreign :
         {std::string("{"), std::string("my thesis\n"), std::string(9000, 'x'),
          std::string(16, '\0') + "my disk image", other, other.substr(0, other.size() / 2)}) {
        overwrite(path_, foreign);
        const auto refused = RetainedFile::open(path(), {});
        ASSERT_FALSE(refused) << foreign.substr(0, 20);
        EXPECT_EQ(refused.error().code, Code::unsupported);
        EXPECT_EQ(RetainedFile::read(path()).error().code, Code::unsupported);
        EXPECT_EQ(bytes_of(path_), foreign);
        EXPECT_EQ(std::distance(fs::directory_iterator(directory_), {}), 1);
    }
    fs::remove(path_);
    ASSERT_EQ(::mkfifo(path_.c_str(), 0600), 0);
    EXPECT_EQ(RetainedFile::open(path(), {}).error().code, Code::unsupported);
    EXPECT_TRUE(fs::is_fifo(path_));
}

TEST_F(RetainedTest, OneProgramAtATime) {
    const auto first = opened();
    const auto second = RetainedFile::open(path(), {});
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().code, Code::busy);
}

TEST_F(RetainedTest, NothingIsDurableInAFileThatIsNotAtItsPath) {
    for (const bool replaced : {false, true}) {
        fs::remove(path_);
        const auto file = opened();
        wait_for(*file.file, file.file->put(level(1)));
        fs::rename(path_, directory_ / "elsewhere");
        if (replaced) std::ofstream(path_) << "x";
        const auto ticket = file.file->put(level(2));
        while (file.file->progress().failed < ticket) std::this_thread::yield();
        EXPECT_LT(file.file->progress().durable, ticket);
        EXPECT_EQ(file.file->progress().why.code, Code::replaced);
        fs::remove(path_);
        fs::rename(directory_ / "elsewhere", path_);
        wait_for(*file.file, ticket);  // put back: the next attempt succeeds
    }
}

/// Writes into the file without replacing it, as `: > FILE` and `cp OLD FILE` do.
void write_in_place(const fs::path& path, const std::string& bytes, bool truncate) {
    std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out |
                                (truncate ? std::ios::trunc : std::ios::openmode{}));
    file << bytes;
}

TEST_F(RetainedTest, NothingIsDurableInAFileThatIsOverwrittenInPlace) {
    struct Case {
        const char* what;
        std::string bytes;
        bool truncate;
    };
    wait_for(*opened().file, 0);
    {
        const auto file = opened();
        wait_for(*file.file, file.file->put(level(1)));
    }
    const std::string older = bytes_of(path_);
    for (const auto& [what, bytes, truncate] :
         {Case{"emptied", "", true}, Case{"shorter", older.substr(0, older.size() / 2), true},
          Case{"zeros", std::string(older.size(), '\0'), false},
          Case{"zeros in the header", std::string(100, '\0'), false}, Case{"an older copy", older, false}}) {
        SCOPED_TRACE(what);
        fs::remove(path_);
        const auto file = opened();
        wait_for(*file.file, file.file->put(level(2)));
        const std::string before = bytes_of(path_);
        write_in_place(path_, bytes, truncate);
        const auto ticket = file.file->put(level(3));
        while (file.file->progress().failed < ticket && file.file->progress().durable < ticket)
            std::this_thread::yield();
        EXPECT_LT(file.file->progress().durable, ticket);
        EXPECT_EQ(file.file->progress().why.code, Code::replaced);
        if (!bytes.empty()) continue;
        write_in_place(path_, before, true);
        wait_for(*file.file, ticket);  // put back: the next attempt succeeds
    }
}

TEST_F(RetainedTest, WhatCannotBeOpenedSaysWhyAndLeavesNothing) {
    const auto nowhere = RetainedFile::open((directory_ / "none" / "x.state").string(), {});
    ASSERT_FALSE(nowhere);
    EXPECT_EQ(nowhere.error().code, Code::cannot_open);
    EXPECT_EQ(nowhere.error().numbers[0], ENOENT);
    fs::create_directory(path_);
    EXPECT_FALSE(RetainedFile::open(path(), {}));
    EXPECT_EQ(std::distance(fs::directory_iterator(directory_), {}), 1);
    EXPECT_EQ(RetainedFile::read((directory_ / "no.state").string()).error().code, Code::not_found);
}

TEST_F(RetainedTest, ProgressIsReportedAndTicketsAreCoveredTogether) {
    std::atomic<int> commits = 0;
    std::uint64_t last = 0;
    {
        auto file = RetainedFile::open(path(), [&commits] { ++commits; });
        ASSERT_TRUE(file);
        for (std::int64_t i = 0; i < 500; ++i) last = file->file->put(level(i));
        EXPECT_EQ(last, 500U);
        wait_for(*file->file, last);
        EXPECT_EQ(file->file->progress().failed, 0U);
    }
    EXPECT_GE(commits, 1);
    EXPECT_LT(commits, 500);  // written together, not one by one
}

}  // namespace retained_test
}  // namespace takt::store
