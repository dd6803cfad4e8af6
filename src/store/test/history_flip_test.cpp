// Changes a bit of every third byte of a small history file, one after the other. A reader then returns what
// was written, or it reports damage or an error, and all that it returns is something that was written. A
// writer keeps to the same. TAKT_HISTORY_FLIPS=all changes each bit of each byte.
#include <gtest/gtest.h>

#include <SQLiteCpp/SQLiteCpp.h>
#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "history_rig.hpp"

namespace takt::store {
namespace history_flip_test {

using namespace history_rig;

const HistoryRange kOfFile{kStart - kHour, kStart + 10 * kHour};

/// What a reader returns of a file.
struct Contents {
    std::map<std::string, std::vector<HistorySample>> samples;  // by variable
    std::map<std::string, std::string> pictures;                // their numbers as a text
    std::vector<HistoryGap> gaps;
    bool reported = false;  // damage, or an error
};

std::string text_of(const HistoryPicture& picture) {
    std::ostringstream text;
    text.precision(17);
    text << picture.samples << ' ' << picture.min.value_or(-1) << ' ' << picture.max.value_or(-1) << ' '
         << picture.mean.value_or(-1) << ' ' << picture.good_share << ' ' << picture.known_until_ns;
    for (const auto& pixel : picture.pixels)
        text << ' ' << pixel.index << ' ' << pixel.samples << ' ' << pixel.first.value << ' '
             << pixel.min.value << ' ' << pixel.max.value << ' ' << pixel.last.value;
    return text.str();
}

Contents contents_of(const std::string& path) {
    Contents contents{.reported = true};
    auto reader = HistoryReader::open(path);
    if (!reader) return contents;
    const auto all = reader->series();
    if (!all) return contents;
    bool failed = false;
    for (const auto& info : *all) {
        auto& samples = contents.samples[info.series.name + ' ' + info.series.unit];
        const auto read = reader->read(info.id, kOfFile, [&](const HistorySample& sample) {
            samples.push_back(sample);
            return true;
        });
        const auto picture = reader->picture(info.id, kOfFile, 5);
        failed = failed || !read || !picture;
        if (picture) contents.pictures[info.series.name] = text_of(*picture);
    }
    const auto gaps = reader->gaps(kOfFile);
    if (gaps) contents.gaps = *gaps;
    contents.reported = failed || !gaps || !reader->damage().empty();
    return contents;
}

/// Whether `some` is `all` with elements left out.
template <class T, class Same>
bool is_part(const std::vector<T>& some, const std::vector<T>& all, Same same) {
    auto at = all.begin();
    for (const auto& element : some) {
        at = std::find_if(at, all.end(), [&](const auto& other) { return same(element, other); });
        if (at == all.end()) return false;
        ++at;
    }
    return true;
}

bool is_gap_part(const Contents& some, const Contents& all) {
    std::vector<HistoryGap> old;
    for (const auto& gap : some.gaps)
        if (gap.cause != GapCause::damaged) old.push_back(gap);
    return is_part(old, all.gaps, std::equal_to<>());
}

/// Nothing but what was written.
bool is_right(const Contents& some, const Contents& all) {
    for (const auto& [variable, samples] : some.samples) {
        const auto its = all.samples.find(variable);
        if (its == all.samples.end() || !is_part(samples, its->second, same)) return false;
    }
    return is_gap_part(some, all);
}

bool is_complete(const Contents& some, const Contents& all) {
    if (some.samples.size() != all.samples.size() || some.gaps.size() < all.gaps.size()) return false;
    return std::ranges::all_of(some.samples, [&](const auto& entry) {
        return entry.second.size() == all.samples.at(entry.first).size();
    });
}

std::string summary_of(const Contents& contents) {
    std::ostringstream text;
    for (const auto& [variable, samples] : contents.samples)
        text << "; " << variable << ": " << samples.size() << " samples";
    text << "; " << contents.gaps.size() << " gaps; " << (contents.reported ? "reported" : "not reported");
    for (const auto& [variable, picture] : contents.pictures) text << "\n" << variable << ": " << picture;
    return text.str();
}

class HistoryFlipTest : public InDirectory {
protected:
    const std::string path_ = directory_ / "plant.history.db";
    std::string bytes_;

    /// Closed and open chunks and a log of three variables, and gaps, in pages of 512 bytes.
    void SetUp() override {
        const HistoryOptions options{.chunk_samples = 20, .log_commits = 6};
        {
            const auto history = std::move(History::open(path_, options)->history);
            const auto level = history->series({"level", "tank", DataType::int16, true, "m"}).value();
            const auto pump = history->series({"pump", "tank", DataType::boolean, false, ""}).value();
            const auto text = history->series({"text", "tank", DataType::string, false, ""}).value();
            for (std::int64_t i = 0; i < 80; ++i) {
                const std::int64_t time = kStart + i * 60 * kSecond;
                history->append(level, {.time_ns = time, .value = static_cast<double>(i * 7919 % 1013)});
                history->append(pump, {.time_ns = time, .value = i % 3 == 0});
                if (i % 5 == 0)
                    history->append(text, {.time_ns = time, .value = "text " + std::to_string(i)});
                if (i % 30 == 29) history->append(HistoryGap{time, time + kSecond, GapCause::quota, 5});
                if (i % 10 == 9) ASSERT_TRUE(history->commit(time));
            }
        }
        SQLite::Database(path_, SQLite::OPEN_READWRITE)
            .exec("PRAGMA journal_mode = DELETE; PRAGMA page_size = 512; VACUUM");
        bytes_ = bytes_of(path_);
        ASSERT_LT(bytes_.size(), 20'000U);
    }
    void write_byte(std::size_t at, char byte) const {
        std::fstream file(path_, std::ios::in | std::ios::out | std::ios::binary);
        file.seekp(static_cast<std::streamoff>(at)).put(byte);
    }
    [[nodiscard]] char changed(std::size_t at, unsigned bit) const {
        return static_cast<char>(static_cast<unsigned char>(bytes_[at]) ^ 1U << bit);
    }
    [[nodiscard]] static bool is_thorough() {
        const char* const wanted = std::getenv("TAKT_HISTORY_FLIPS");
        return wanted != nullptr && std::string(wanted) == "all";
    }
};

TEST_F(HistoryFlipTest, AReaderReportsEachLossAndReturnsNoWrongValue) {
    const auto all = contents_of(path_);
    ASSERT_FALSE(all.reported);
    ASSERT_EQ(all.samples.size(), 3U);
    std::size_t reported = 0;
    const unsigned bits = is_thorough() ? 8 : 1;
    const std::size_t step = is_thorough() ? 1 : 3;
    for (std::size_t at = 0; at < bytes_.size(); at += step) {
        for (unsigned i = 0; i < bits; ++i) {
            const unsigned bit = bits == 8 ? i : static_cast<unsigned>(at * 5 % 8);
            write_byte(at, changed(at, bit));
            const auto some = contents_of(path_);
            EXPECT_TRUE(is_right(some, all)) << "byte " << at << " bit " << bit << summary_of(some);
            EXPECT_TRUE(some.reported || (is_complete(some, all) && some.pictures == all.pictures))
                << "byte " << at << " bit " << bit << summary_of(some);
            reported += some.reported ? 1 : 0;
        }
        write_byte(at, bytes_[at]);
    }
    EXPECT_GT(reported, bytes_.size() / step / 10);
}

TEST_F(HistoryFlipTest, AWriterReportsEachLossAndLeavesNoWrongValue) {
    const auto all = contents_of(path_);
    const std::size_t step = is_thorough() ? 7 : 61;
    for (std::size_t at = 0; at < bytes_.size(); at += step) {
        for (const char* suffix : {"-wal", "-shm", "-journal"}) std::filesystem::remove(path_ + suffix);
        overwrite(path_, bytes_);
        const auto bit = static_cast<unsigned>(at * 5 % 8);
        write_byte(at, changed(at, bit));
        bool reported = false;
        {
            const auto opened = History::open(path_);
            reported = !opened || !opened->set_aside.empty() || !opened->damage.empty();
            if (opened) std::filesystem::remove(opened->set_aside);  // at most 999 of them are kept
        }
        const auto some = contents_of(path_);
        ASSERT_TRUE(is_right(some, all)) << "byte " << at << " bit " << bit;
        ASSERT_TRUE(reported || some.reported || is_complete(some, all)) << "byte " << at << " bit " << bit;
    }
}

}  // namespace history_flip_test
}  // namespace takt::store
