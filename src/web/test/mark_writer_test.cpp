#include "live/mark_writer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <vector>

#include "folder.hpp"

namespace takt::web {
namespace mark_writer_test {

using namespace std::chrono_literals;

/// The codes of log messages.
class Messages {
public:
    [[nodiscard]] Log log() { return {"web", {.context = this, .write_message = &write}}; }
    [[nodiscard]] std::vector<std::string> codes() const {
        const std::lock_guard lock(mutex_);
        return codes_;
    }

private:
    static void write(void* context, LogLevel, std::string_view, std::string_view code,
                      std::span<const LogArgument>) {
        auto& self = *static_cast<Messages*>(context);
        const std::lock_guard lock(self.mutex_);
        self.codes_.emplace_back(code);
    }
    mutable std::mutex mutex_;
    std::vector<std::string> codes_;
};

class MarkWriterTest : public testing::Test {
protected:
    [[nodiscard]] MarkWriterOptions options() {
        return {path_, [this] { return wanted_.load(); }, messages_.log()};
    }
    static Mark mark(std::string text) {
        return {.time_ms = 1000, .severity = "info", .texts = {std::move(text), "x", "x"}};
    }
    /// Of the marks that a test put.
    static std::string texts(const Marks& marks) {
        std::string all;
        for (const auto& its : marks.after(Marks::kNone).marks)
            if (its.texts[1] == "x") all += its.texts[0] + ' ';
        return all;
    }
    static bool wait(const std::function<bool()>& enough) {
        const auto end = std::chrono::steady_clock::now() + 10s;
        while (!enough() && std::chrono::steady_clock::now() < end) std::this_thread::sleep_for(5ms);
        return enough();
    }
    [[nodiscard]] bool is_written(std::string_view text) const {
        std::ifstream file(path_);
        return std::string(std::istreambuf_iterator<char>(file), {}).find(text) != std::string::npos;
    }
    /// A run of the program that puts marks.
    std::string run(const std::vector<std::string>& put) {
        Marks marks(2000);
        MarkWriter writer(marks, options());
        for (const auto& text : put) marks.put(mark(text));
        writer.end();
        return texts(marks);
    }

    const takt::test::Folder folder_;
    const std::string path_ = folder_ / "plant.marks.jsonl";
    std::atomic<bool> wanted_ = true;
    Messages messages_;
};

TEST_F(MarkWriterTest, ARestartKeepsMarksInTheirOrder) {
    EXPECT_EQ(run({"a", "b"}), "a b ");
    EXPECT_EQ(run({"c"}), "a b c ");
    EXPECT_EQ(run({}), "a b c ");
    EXPECT_TRUE(messages_.codes().empty());
}

TEST_F(MarkWriterTest, WritesWhileTheProgramRuns) {
    Marks marks(2000);
    MarkWriter writer(marks, options());
    marks.put(mark("soon"));
    EXPECT_TRUE(wait([&] { return is_written("soon"); }));
}

TEST_F(MarkWriterTest, WithoutAHistoryThereIsNoFile) {
    wanted_ = false;
    EXPECT_EQ(run({"a"}), "a ");
    EXPECT_FALSE(std::filesystem::exists(path_));
    wanted_ = true;
    EXPECT_EQ(run({"b"}), "b ");
}

TEST_F(MarkWriterTest, KeepsTheNewestOnes) {
    std::vector<std::string> many(Marks::kMost + 10, "x");
    many.front() = "first";
    run(many);
    const auto kept = run({"last"});
    EXPECT_EQ(kept.find("first"), std::string::npos);
    EXPECT_EQ(kept.size(), Marks::kMost * 2 + 3);
    for (int i = 0; i < 6; ++i) run(many);
    EXPECT_LE(std::filesystem::file_size(path_), MarkFile::kMostLines * 100);
}

TEST_F(MarkWriterTest, AFileThatCannotBeWrittenIsReportedOnceAndWrittenLater) {
    std::filesystem::create_directory(path_);
    Marks marks(2000);
    {
        MarkWriter writer(marks, options());
        marks.put(mark("a"));
        ASSERT_TRUE(wait([&] { return !messages_.codes().empty(); }));
        std::this_thread::sleep_for(3 * MarkWriter::kTick);  // further attempts
        EXPECT_EQ(messages_.codes(), std::vector<std::string>{"log.marks.failed"});
        std::filesystem::remove(path_);
        ASSERT_TRUE(wait([&] { return messages_.codes().size() > 1; }));
        EXPECT_EQ(messages_.codes().back(), "log.marks.work");
        const auto shown = marks.after(Marks::kNone).marks;
        EXPECT_EQ(std::ranges::count(shown, "warning", &Mark::severity), 1) << "trends show the failure";
    }
    EXPECT_EQ(run({}), "a ");
}

TEST_F(MarkWriterTest, AFileThatWasRemovedIsWrittenAnew) {
    Marks marks(2000);
    {
        MarkWriter writer(marks, options());
        marks.put(mark("a"));
        ASSERT_TRUE(wait([&] { return is_written("\"a\""); }));
        std::filesystem::remove(path_);
        marks.put(mark("b"));
    }
    EXPECT_EQ(run({}), "a b ");
    EXPECT_TRUE(messages_.codes().empty());
}

TEST_F(MarkWriterTest, DamageIsReported) {
    run({"a", "b"});
    std::filesystem::resize_file(path_, std::filesystem::file_size(path_) - 1);
    EXPECT_EQ(run({}), "a ");
    std::ofstream(path_, std::ios::app) << "?\n";
    EXPECT_EQ(run({}), "a ");
    EXPECT_EQ(messages_.codes(), (std::vector<std::string>{"log.marks.cut", "log.marks.set_aside"}));
}

}  // namespace mark_writer_test
}  // namespace takt::web
