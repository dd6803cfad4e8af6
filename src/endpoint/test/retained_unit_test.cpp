// Retained registers: the kept values, the time of a write's answer, and the effect of a failing disk.
#include "retained_unit.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <functional>

#include "folder.hpp"
#include "hook_chain.hpp"
#include "support.hpp"
#include "tasks.hpp"

namespace takt::endpoint {
namespace retained_unit_test {

namespace fs = std::filesystem;
using store::Durability;
using test::pdu;
using test::to_hex;
using wire::Area;

/// A file in memory whose writes fail while the test wants it.
struct MemoryFile final : store::BlockFile {
    [[nodiscard]] Result<std::uint64_t> size() override { return bytes.size(); }
    [[nodiscard]] Result<void> read_at(std::uint64_t offset, std::span<std::uint8_t> into) override {
        std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(offset), into.size(), into.begin());
        return {};
    }
    [[nodiscard]] Result<void> write_at(std::uint64_t offset, Bytes written) override {
        if (fails) return fail(Code::io_failed, "memory", 5);
        std::ranges::copy(written, bytes.begin() + static_cast<std::ptrdiff_t>(offset));
        return {};
    }
    [[nodiscard]] Result<void> sync() override { return {}; }

    std::vector<std::uint8_t> bytes;
    std::atomic<bool> fails = false;
};

/// Unit 1: ten holding registers; the coils are their bits; ten discrete inputs of their own.
struct Bench {
    explicit Bench(RetainSpec spec) : retained(units[0], std::move(spec), pending, notices.sink()) {
        units[0].id = UnitId{1};
        units[0].banks.holding_registers.values = registers;
        units[0].banks.coils = {.count = 160, .overlay = serve::BitOverlay{Area::holding_register, 0}};
        units[0].banks.discrete_inputs = {.count = 10, .packed = bits};
        units[0].hooks = &retained;
        server = serve::Server(units);
        pending.add(answers);
    }
    /// Keeps in memory instead of in the file of the spec.
    void begin() {
        const auto layout = retained.layout().value();
        auto storage = std::make_unique<MemoryFile>();
        file = storage.get();
        file->bytes.resize(store::RegisterFile::file_size(layout));
        auto made = store::RegisterFile::make(*storage, layout, retained.image());
        retained.begin({std::move(storage), *std::move(made)}, post());
    }
    RetainedUnit::Post post() {
        return [this](std::function<void()> task) { tasks.post(std::move(task)); };
    }
    std::string ask(std::string_view request) {
        const auto bytes = pdu(request);
        pending.begin(bytes.span());
        const auto answer = pending.end(server.handle({.unit = UnitId{1}}, wire::RequestView(bytes.span())));
        token = answer.token;
        return answer.kind == serve::Answer::Kind::pending ? "pending" : to_hex(answer.pdu.span());
    }

    std::array<std::uint16_t, 10> registers{};
    std::array<std::uint8_t, 2> bits{};
    std::array<serve::Unit, 1> units;
    serve::Server server{{}};
    test::Answers answers;
    test::Notices notices;
    takt::test::Tasks tasks;
    PendingAnswers pending;
    RetainedUnit retained;
    MemoryFile* file = nullptr;
    serve::Token token = 0;
};

RetainSpec registers(std::uint16_t first, std::uint16_t last,
                     Durability durability = Durability::acknowledged) {
    RetainSpec spec;
    spec.items[static_cast<std::size_t>(Area::holding_register)] = {{first, last}};
    spec.durability = durability;
    spec.path = "nowhere";
    return spec;
}

TEST(RetainedUnit, AWriteIsAnsweredWhenTheDiskHasIt) {
    Bench bench(registers(2, 4));
    bench.begin();
    EXPECT_EQ(bench.ask("06 00 00 00 09"), "06 00 00 00 09") << "not a retained register";
    EXPECT_EQ(bench.ask("06 00 02 00 09"), "pending");
    EXPECT_EQ(bench.registers[2], 9) << "in force at once";
    EXPECT_FALSE(bench.answers.has(bench.token));
    bench.tasks.run_one();
    EXPECT_EQ(bench.answers.of(bench.token), "06 00 02 00 09");
    EXPECT_EQ(bench.ask("06 00 02 00 09"), "06 00 02 00 09") << "the disk has it already";
    bench.retained.finish();
    EXPECT_EQ(bench.retained.statistics().written.failures, 0u);
    EXPECT_TRUE(bench.notices.all.empty());
}

TEST(RetainedUnit, OtherDurabilitiesAnswerAtOnce) {
    for (const auto durability : {Durability::interval, Durability::at_end}) {
        Bench bench(registers(0, 9, durability));
        bench.begin();
        EXPECT_EQ(bench.ask("06 00 02 00 09"), "06 00 02 00 09");
        bench.retained.finish();
        EXPECT_GE(bench.retained.statistics().written.commits, 1u);
    }
}

TEST(RetainedUnit, AFailingDiskTakesBackWhatWaits) {
    Bench bench(registers(0, 9));
    bench.registers[2] = 7;
    bench.begin();
    bench.file->fails = true;
    EXPECT_EQ(bench.ask("06 00 02 00 09"), "pending");
    const auto first = bench.token;
    EXPECT_EQ(bench.ask("10 00 03 00 01 02 00 05"), "pending");
    const auto second = bench.token;
    while (!bench.answers.has(second)) bench.tasks.run_one();
    EXPECT_EQ(bench.answers.of(first), "86 04");
    EXPECT_EQ(bench.answers.of(second), "90 04");
    EXPECT_EQ(bench.registers[2], 7) << "what the disk has";
    EXPECT_EQ(bench.registers[3], 0);
    EXPECT_EQ(bench.notices.codes(), "endpoint.registers.failed ") << "once a second at most";
    ASSERT_TRUE(bench.notices.all[0].error);
    EXPECT_EQ(bench.notices.all[0].error->code, Code::io_failed);
    bench.file->fails = false;
    EXPECT_EQ(bench.ask("06 00 02 00 09"), "pending");
    bench.tasks.run_one();
    EXPECT_EQ(bench.answers.of(bench.token), "06 00 02 00 09") << "the next write is tried anew";
}

TEST(RetainedUnit, TheEndAnswersWhatWaits) {
    Bench bench(registers(0, 9));
    bench.begin();
    std::vector<serve::Token> tokens;
    for (const auto* const request : {"06 00 02 00 01", "06 00 02 00 02", "06 00 03 00 03"}) {
        EXPECT_EQ(bench.ask(request), "pending");
        tokens.push_back(bench.token);
    }
    bench.retained.finish();
    for (const auto token : tokens) EXPECT_TRUE(bench.answers.has(token));
    EXPECT_EQ(bench.pending.size(), 0u);
}

TEST(RetainedUnit, BitsOverRegistersAreKeptAsRegisters) {
    RetainSpec spec = registers(4, 4);
    spec.items[static_cast<std::size_t>(Area::coil)] = {{0, 20}};
    spec.items[static_cast<std::size_t>(Area::discrete_input)] = {{1, 9}};
    Bench bench(spec);
    const auto layout = bench.retained.layout();
    ASSERT_TRUE(layout);
    ASSERT_EQ(layout->ranges.size(), 3u);
    EXPECT_TRUE(layout->ranges[0].bits);
    EXPECT_EQ(layout->ranges[0].first, 1);
    EXPECT_EQ(layout->ranges[1].first, 0) << "coils 0..20 are registers 0 and 1";
    EXPECT_EQ(layout->ranges[1].last, 1);
    EXPECT_EQ(layout->ranges[2].first, 4);
    bench.begin();
    EXPECT_EQ(bench.ask("05 00 11 FF 00"), "pending");
    EXPECT_EQ(bench.registers[1], 2);
    EXPECT_EQ(bench.ask("05 00 20 FF 00"), "05 00 20 FF 00") << "register 2 is not kept";
}

TEST(RetainedUnit, ItemsMustExist) {
    Bench bench(registers(8, 12));
    EXPECT_EQ(bench.retained.layout().error().code, Code::not_found);
    EXPECT_EQ(bench.retained.layout().error().subject.view(), "holding_register 10");
    EXPECT_FALSE(bench.retained.open(bench.post()));
}

class RetainedFile : public testing::Test {
protected:
    RetainedFile() { spec_.path = folder_ / "unit.registers"; }

    /// Opens the file, writes one register, ends. @returns the codes of the notices
    std::string run(std::uint8_t value, std::uint16_t expected) {
        Bench bench(spec_);
        bench.registers[2] = 100;
        EXPECT_TRUE(bench.retained.open(bench.post()));
        EXPECT_EQ(bench.registers[2], expected);
        (void)bench.ask("06 00 02 00 " + to_hex({&value, 1}));
        bench.retained.finish();
        return bench.notices.codes();
    }

    const takt::test::Folder folder_;
    RetainSpec spec_ = registers(0, 9);
};

TEST_F(RetainedFile, BringsTheValuesBack) {
    EXPECT_EQ(run(7, 100), "endpoint.registers.new ");
    EXPECT_EQ(run(8, 7), "");
    EXPECT_EQ(run(9, 8), "");
}

TEST_F(RetainedFile, OfAnotherLayoutGivesWhatBothHave) {
    (void)run(7, 100);
    spec_.items[static_cast<std::size_t>(Area::holding_register)] = {{2, 3}};
    EXPECT_EQ(run(8, 7), "endpoint.registers.other_layout ");
}

TEST_F(RetainedFile, ThatIsSomethingElseIsLeftAlone) {
    fs::create_directory(spec_.path);
    Bench bench(spec_);
    EXPECT_FALSE(bench.retained.open(bench.post()));
    EXPECT_TRUE(fs::is_directory(spec_.path));
}

}  // namespace retained_unit_test
}  // namespace takt::endpoint
