// The audit log: its lines, its bounds, and the entries that it leaves out.
#include "takt/endpoint/audit_log.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "folder.hpp"

namespace takt::endpoint {
namespace audit_log_test {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

AuditRecord write_of(std::uint16_t start) {
    AuditRecord record;
    record.time = std::chrono::system_clock::time_point(1795294801234ms);
    record.peer.assign("192.0.2.7:50100");
    record.unit = 3;
    record.function = 16;
    record.items = AuditRecord::Items{wire::Area::holding_register, start, 2};
    record.old_values = {0, 0, 1, 0};
    record.new_values = {0, 7, 255, 255};
    return record;
}

TEST(AuditLine, OfAWrite) {
    EXPECT_EQ(audit_line(write_of(5)),
              R"({"time":"2026-11-21T21:00:01.234Z","event":"write","peer":"192.0.2.7:50100","unit":3,)"
              R"("function":16,"area":"holding_register","start":5,"count":2,"old":[0,256],"new":[7,65535]})"
              "\n");
}

TEST(AuditLine, OfBits) {
    AuditRecord record = write_of(5);
    record.broadcast = true;
    record.items = AuditRecord::Items{wire::Area::coil, 5, 10};
    record.old_values = {0x01, 0x02};
    record.new_values = {0x80, 0x01};
    const std::string line = audit_line(record);
    EXPECT_NE(line.find(R"("broadcast":true,"area":"coil","start":5,"count":10,"old":[1,0,0,0,0,0,0,0,0,1],)"
                        R"("new":[0,0,0,0,0,0,0,1,1,0]})"),
              std::string::npos)
        << line;
}

TEST(AuditLine, OfARelayedWrite) {
    AuditRecord record = write_of(5);
    record.old_values.clear();
    record.new_values.clear();
    record.broadcast = true;
    record.relayed_to = 0;
    record.request = {6, 0, 5, 0, 7};
    record.outcome = AuditRecord::Outcome::sent;
    EXPECT_EQ(
        audit_line(record),
        R"({"time":"2026-11-21T21:00:01.234Z","event":"write","peer":"192.0.2.7:50100","unit":3,)"
        R"("function":16,"broadcast":true,"relayed_to":0,"area":"holding_register","start":5,"count":2,)"
        R"("request":"0600050007","outcome":"sent"})"
        "\n");
}

TEST(AuditLine, OfARefusal) {
    AuditRecord record;
    record.event = AuditRecord::Event::refused;
    record.peer.assign("a\"b\\\n");
    record.function = 6;
    record.request = {6, 0, 1, 0xAB, 2};
    record.why = "rule";
    record.exception = 1;
    EXPECT_EQ(
        audit_line(record),
        R"({"time":"1970-01-01T00:00:00.000Z","event":"refused","peer":"a\"b\\\n","unit":0,"function":6,)"
        R"("request":"060001ab02","why":"rule","exception":1})"
        "\n");
}

class AuditLogTest : public testing::Test {
protected:
    [[nodiscard]] static std::string text(const std::string& path) {
        std::ifstream file(path);
        std::ostringstream all;
        all << file.rdbuf();
        return all.str();
    }
    [[nodiscard]] static auto lines(const std::string& path) {
        const std::string all = text(path);
        return std::ranges::count(all, '\n');
    }

    const takt::test::Folder folder_;
    const std::string path_ = folder_ / "audit.log";
};

TEST_F(AuditLogTest, GoesOnWhereItWas) {
    for (int i = 0; i < 2; ++i) {
        const auto log = std::move(AuditLog::open(path_)).value();
        log->put(Instant{}, write_of(1));
        EXPECT_EQ(log->finish(), 0u);
    }
    EXPECT_EQ(text(path_), audit_line(write_of(1)) + audit_line(write_of(1)));
}

TEST_F(AuditLogTest, IsBoundedInSizeAndNumber) {
    AuditLog::Options options;
    options.old_files = 2;
    options.file_bytes = 3 * audit_line(write_of(1000)).size();
    {
        const auto log = std::move(AuditLog::open(path_, options)).value();
        for (std::uint16_t i = 1000; i < 1020; ++i) log->put(Instant{}, write_of(i));
    }
    std::string all;
    for (const std::string& path : {path_ + ".2", path_ + ".1", path_}) {
        EXPECT_LE(fs::file_size(path), options.file_bytes) << path;
        EXPECT_GT(fs::file_size(path), 0u) << path;
        all += text(path);
    }
    EXPECT_FALSE(fs::exists(path_ + ".3"));
    std::string expected;
    const auto kept = std::ranges::count(all, '\n');
    for (auto i = 1020 - kept; i < 1020; ++i) expected += audit_line(write_of(static_cast<std::uint16_t>(i)));
    EXPECT_EQ(all, expected) << "the newest lines, in their order";
}

TEST_F(AuditLogTest, WhatComesTooFastIsCounted) {
    AuditLog::Options options;
    options.writes_per_second = 10;
    options.refusals_per_second = 1;
    AuditRecord refusal = write_of(1);
    refusal.event = AuditRecord::Event::refused;
    {
        const auto log = std::move(AuditLog::open(path_, options)).value();
        const Instant t = Instant{} + 1h;
        for (int i = 0; i < 1000; ++i) log->put(t, refusal);
        for (int i = 0; i < 25; ++i) log->put(t, write_of(1));
        log->put(t + 100ms, write_of(2));
    }
    const std::string all = text(path_);
    const auto count = [&all](std::string_view what) {
        std::size_t found = 0;
        for (std::size_t at = all.find(what); at != std::string::npos; at = all.find(what, at + 1)) ++found;
        return found;
    };
    EXPECT_EQ(count(R"("event":"write")"), 21u) << "the flood of refusals hides none of them";
    EXPECT_EQ(count(R"("event":"refused")"), 2u);
    std::uint64_t left_out = 0;
    for (std::size_t at = all.find(R"("count":)", all.find("left_out")); at != std::string::npos;) {
        left_out += std::stoull(all.substr(at + 8));
        at = all.find("left_out", at);
        if (at != std::string::npos) at = all.find(R"("count":)", at);
    }
    EXPECT_EQ(left_out, 998u + 5u);
}

TEST_F(AuditLogTest, AFloodOfOnePeerHidesNoOther) {
    AuditLog::Options options;
    options.writes_per_second = 10;
    options.refusals_per_second = 1;
    options.peers = 3;
    {
        const auto log = std::move(AuditLog::open(path_, options)).value();
        const Instant t = Instant{} + 1h;
        const auto put = [&](std::string_view peer, std::uint16_t start, AuditRecord::Event event,
                             Instant at) {
            AuditRecord record = write_of(start);
            record.event = event;
            record.peer.assign(peer);
            log->put(at, record);
        };
        using Event = AuditRecord::Event;
        for (int i = 0; i < 1000; ++i) {
            const std::string port = std::to_string(5000 + i);
            put("192.0.2.7:" + port, 1, Event::write, t);
            put("192.0.2.7:" + port, 1, Event::refused, t);
            put("[2001:db8::" + std::to_string(i) + "]:1", 2, Event::write, t + 1ms);
        }
        put("192.0.2.8:1", 3001, Event::write, t + 1ms);
        put("192.0.2.8:1", 3002, Event::refused, t + 1ms);
        put("/dev/ttyS1", 3003, Event::write, t + 2ms);  // replaces the first peer
        put("/dev/ttyS2", 3004, Event::write, t + 2ms);
        put("192.0.2.8:1", 3005, Event::refused, t + 2ms);
        put("192.0.2.8:1", 3006, Event::refused, t + 2ms);
    }
    const std::string all = text(path_);
    const auto count = [&all](std::string_view what) {
        std::size_t found = 0;
        for (std::size_t at = all.find(what); at != std::string::npos; at = all.find(what, at + 1)) ++found;
        return found;
    };
    EXPECT_EQ(count(R"("start":1,)"), 22u) << "twenty writes and two refusals";
    EXPECT_EQ(count(R"("start":2,)"), 20u) << "the addresses of one network are one peer";
    for (const int start : {3001, 3002, 3003, 3004, 3005})
        EXPECT_EQ(count("\"start\":" + std::to_string(start) + ","), 1u) << start;
    EXPECT_EQ(count(R"("start":3006,)"), 0u);
}

TEST_F(AuditLogTest, SaysWhereItCannotBe) {
    EXPECT_EQ(AuditLog::open(folder_ / "nowhere/x").error().code, Code::cannot_open);
}

}  // namespace audit_log_test
}  // namespace takt::endpoint
