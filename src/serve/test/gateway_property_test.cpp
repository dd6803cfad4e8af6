// After any interleaving each request has exactly one answer, its own; no client waits for more than one
// transaction of each other client; no read is older than the writes before it.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <deque>
#include <map>
#include <set>

#include "rig.hpp"

namespace takt::serve {
namespace gateway_property_test {

using namespace test;
using bus::Status;

constexpr std::uint64_t kClients = 5;

/// One register in each of two units; its value is the number of writes to it.
struct World {
    explicit World(const GatewayConfig& config) : rig(config) {}

    struct Request {
        std::uint64_t client = 0;
        std::uint8_t unit = 0;
        bool read = false;
        int value_before = 0;  ///< of the unit: the last execution that was answered when it was asked
        std::set<std::uint64_t> before;  ///< clients whose transactions went first
        int transactions = 0;
    };

    void submit(std::uint64_t client, std::uint8_t unit, bool read) {
        Request request{client, unit, read, answered_writes[unit], {}, 0};
        const auto token = rig.ask(client, unit, read ? "03 00 00 00 01" : write(++last_written));
        if (rig.answer(token).empty())
            open.emplace(token, request);
        else
            judge(token, request);
    }

    void begin() {
        if (rig.sent) return;
        rig.gateway.on_tick(rig.now);
        const bool expected = rig.gateway.has_next();
        RC_ASSERT(!rig.begin().empty() == expected);
        if (!expected) return;
        const auto& sent = *rig.sent;
        in_flight_writes = sent.request.function() == 6;
        if (in_flight_writes) {
            values[sent.unit.value] = word(sent.request.pdu(), 3);
            executed[values[sent.unit.value]] = ++executions;
        }
        value_read = values[sent.unit.value];
    }

    void end(Status status) {
        if (!rig.sent) return;
        const std::uint8_t unit = rig.sent->unit.value;
        const std::string answer =
            in_flight_writes ? hex(rig.sent->request.pdu()) : hex(pdu_of_read(value_read).span());
        if (in_flight_writes && status == Status::ok) answered_writes[unit] = executed[values[unit]];
        rig.end(status, status == Status::exception ? (in_flight_writes ? "86 04" : "83 04") : answer);
        settle();
    }

    void forget(std::size_t index) {
        if (open.empty()) return;
        auto gone = open.begin();
        std::advance(gone, static_cast<std::ptrdiff_t>(index % open.size()));
        rig.gateway.forget(1, gone->first);
        forgotten.insert(gone->first);
        open.erase(gone);
    }

    void settle() {
        for (auto request = open.begin(); request != open.end();) {
            if (rig.answer(request->first).empty()) {
                ++request;
                continue;
            }
            judge(request->first, request->second);
            request = open.erase(request);
        }
        for (const auto token : forgotten) RC_ASSERT(rig.answer(token).empty());
        RC_ASSERT(rig.answered_twice == 0);
    }

    void judge(serve::Token token, const Request& request) {
        const auto answer = pdu(rig.answer(token));
        const std::uint8_t function = request.read ? 3 : 6;
        RC_ASSERT((answer[0] & 0x7F) == function);
        if (answer[0] != 3) return;
        RC_ASSERT(executed[word(answer.span(), 2)] >= request.value_before);
    }

    static std::string write(int value) { return hex(pdu_of({6, 0, 0, value >> 8, value & 255}).span()); }
    static wire::Pdu pdu_of_read(int value) { return pdu_of({3, 2, value >> 8, value & 255}); }
    static wire::Pdu pdu_of(std::initializer_list<int> bytes) {
        wire::Pdu made;
        for (const int byte : bytes) made.push_back(static_cast<std::uint8_t>(byte));
        return made;
    }
    static int word(Bytes bytes, std::size_t at) { return bytes[at] << 8 | bytes[at + 1]; }

    Rig rig;
    std::map<serve::Token, Request> open;
    std::set<serve::Token> forgotten;
    std::map<std::uint8_t, int> values;
    std::map<std::uint8_t, int> answered_writes;  // as `executed`
    std::map<int, int> executed;                  // by value: writes are executed in another order than asked
    int executions = 0;
    int last_written = 0;
    int value_read = 0;
    bool in_flight_writes = false;
};

TEST(GatewayProperties, EachRequestHasOneAnswerItsOwnAndNoneFromBeforeAWrite) {
    EXPECT_TRUE(rc::check([] {
        World world({.requests = *rc::gen::inRange<std::size_t>(2, 12), .per_client = 3, .cached = 2});
        world.rig.policy.cache = std::chrono::milliseconds(*rc::gen::inRange(0, 40));
        world.rig.policy.attempts = *rc::gen::inRange<std::uint16_t>(1, 3);
        world.rig.policy.max_wait = std::chrono::milliseconds(*rc::gen::inRange(5, 100));
        const auto steps = *rc::gen::container<std::vector<int>>(60, rc::gen::inRange(0, 1000));
        for (const int step : steps) {
            const int what = step % 10;
            const auto unit = static_cast<std::uint8_t>(1 + step / 10 % 2);
            const auto client = static_cast<std::uint64_t>(step / 20 % static_cast<int>(kClients));
            world.rig.now += std::chrono::milliseconds(step % 7);
            if (what < 4)
                world.submit(client, unit, what != 0);
            else if (what < 6)
                world.begin();
            else if (what < 8)
                world.end(step % 3 == 0 ? Status::timeout : step % 3 == 1 ? Status::exception : Status::ok);
            else if (what == 8)
                world.forget(static_cast<std::size_t>(step));
            else
                world.rig.gateway.on_link(step % 4 != 0);
            world.rig.gateway.on_tick(world.rig.now);
            world.rig.collect();
            world.settle();
        }
        world.rig.gateway.on_link(true);
        for (int left = 0; left < 200 && (world.rig.gateway.waiting() > 0 || world.rig.sent); ++left) {
            world.begin();
            world.end(Status::ok);
            world.settle();
        }
        RC_ASSERT(world.open.empty());
    }));
}

TEST(GatewayProperties, NoClientWaitsForMoreThanOneTransactionOfEachOther) {
    EXPECT_TRUE(rc::check([] {
        Rig rig({.requests = 64, .per_client = 8});
        rig.policy.attempts = *rc::gen::inRange<std::uint16_t>(1, 3);
        rig.policy.max_wait = 1h;
        // A client is served when its first request is. Counts of others' requests served since then.
        struct Waiting {
            std::deque<serve::Token> tokens;
            std::map<std::uint64_t, int> since;
        };
        std::map<std::uint64_t, Waiting> clients;
        std::map<std::string, std::uint64_t> owner;
        int next = 0;
        const auto note_answers = [&] {
            for (auto& [client, waiting] : clients)
                while (!waiting.tokens.empty() && !rig.answer(waiting.tokens.front()).empty()) {
                    waiting.tokens.pop_front();
                    waiting.since.clear();
                }
        };
        for (const int step : *rc::gen::container<std::vector<int>>(80, rc::gen::inRange(0, 1000))) {
            const auto client = static_cast<std::uint64_t>(step % 3 == 0 ? step % 5 : 0);  // 0 floods
            if (step % 2 == 0) {
                const std::string request = World::write(++next).replace(0, 2, step % 4 == 0 ? "06" : "03");
                const auto token = rig.ask(client, 1, request);
                owner[request] = client;
                if (rig.answer(token).empty()) clients[client].tokens.push_back(token);
                continue;
            }
            const auto begun = rig.begin();
            if (begun.empty()) continue;
            const auto served = owner.at(begun.substr(3));
            for (auto& [other, waiting] : clients) {
                if (other == served || waiting.tokens.empty()) continue;
                ++waiting.since[served];
                RC_ASSERT(waiting.since[served] <= 1);
            }
            rig.end(step % 5 == 0 ? Status::timeout : Status::exception, step % 5 == 0 ? "" : "83 04");
            if (step % 5 == 0) clients[served].since.clear();
            note_answers();
        }
    }));
}

}  // namespace gateway_property_test
}  // namespace takt::serve
