// Access rules against the bytes that reach a line: rules as a project states them, requests to an endpoint
// with own units and two lines behind it, and an oracle that shares no code with the product.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "takt/base/token_bucket.hpp"
#include "takt/bus/transaction_engine.hpp"
#include "takt/endpoint/line_gateway.hpp"
#include "takt/endpoint/request_handler.hpp"
#include "takt/file/load.hpp"
#include "takt/model/findings.hpp"
#include "takt/serve/server.hpp"
#include "takt/wire/frame.hpp"

namespace takt::test {

using Pdu = std::vector<std::uint8_t>;

inline constexpr std::array<std::string_view, 4> kAreas{"coil", "discrete_input", "input_register",
                                                        "holding_register"};
inline constexpr int kCoil = 0, kDiscrete = 1, kInput = 2, kHolding = 3;

/// The clients, and the networks that contain them.
struct Client {
    std::string_view peer;
    std::vector<std::string_view> networks;
};
inline const std::vector<Client>& clients() {
    static const std::vector<Client> all{
        {"192.0.2.7:5", {"192.0.2.7", "192.0.2.0/24", "::ffff:192.0.2.0/120"}},
        {"[::ffff:192.0.2.7]:6", {"192.0.2.7", "192.0.2.0/24", "::ffff:192.0.2.0/120"}},
        {"192.0.2.8:7", {"192.0.2.0/24", "::ffff:192.0.2.0/120"}},
        {"[2001:db8::1]:8", {"2001:db8::/32", "::/0"}},
        {"[2001:db8::2]:8", {"2001:db8::/32", "::/0"}},
        {"/dev/ttyS5", {"serial"}},
    };
    return all;
}
/// Clients with one number share a rate.
inline int rate_owner(std::size_t client) {
    constexpr std::array<int, 6> kOwners{0, 0, 1, 2, 2, 3};
    return kOwners[client];
}

/// A rule as a project states it.
struct RuleText {
    std::vector<std::string> peers;
    std::vector<std::pair<int, int>> units;
    std::vector<std::string> functions;  ///< "read", "write" or codes
    int area = -1;
    std::vector<std::pair<int, int>> items;
    std::string rule = "allow";
    int rate = 0;  ///< and burst

    [[nodiscard]] std::string yaml() const {
        const auto ranges = [](const std::vector<std::pair<int, int>>& all) {
            std::string text;
            for (const auto& [first, last] : all)
                text += (text.empty() ? "" : ", ") + std::to_string(first) + ".." + std::to_string(last);
            return "[" + text + "]";
        };
        const auto list = [](const std::vector<std::string>& all) {
            std::string text;
            for (const auto& one : all) text += (text.empty() ? "\"" : ", \"") + one + "\"";
            return "[" + text + "]";
        };
        std::string text = "- {rule: " + rule;
        if (!peers.empty()) text += ", peers: " + list(peers);
        if (!units.empty()) text += ", units: " + ranges(units);
        if (!functions.empty()) text += ", functions: " + list(functions);
        if (area >= 0) text += ", area: " + std::string(kAreas[static_cast<std::size_t>(area)]);
        if (area >= 0 && !items.empty()) text += ", items: " + ranges(items);
        if (rate > 0 && rule != "deny") text += ", rate: " + std::to_string(rate);
        return text + "}\n";
    }
};

/// The rules as the product reads them. Empty if the text is no valid rules.
inline std::optional<std::vector<model::AccessRule>> parse(const std::vector<RuleText>& rules) {
    std::string text;
    for (const auto& rule : rules) text += rule.yaml();
    if (rules.empty()) return std::vector<model::AccessRule>();
    const auto loaded = file::load_text("access.yaml", text);
    const auto checked = model::interpret_access(loaded.document);
    const auto is_error = [](const auto& finding) { return finding.severity == model::Severity::error; };
    if (!loaded.readable || std::ranges::any_of(checked.findings, is_error)) return std::nullopt;
    return checked.rules;
}

/// The result of a request by the specification.
struct Facts {
    bool well_formed = false;  ///< has the form that its function demands
    bool known = true;
    bool broadcast = false;  ///< may be sent to all units of a line
    bool writes = true;
    struct Item {
        int area;
        int address;
        bool write;
    };
    std::vector<Item> items;
};

inline Facts facts_of(const Pdu& pdu) {
    Facts facts;
    const std::size_t size = pdu.size();
    const auto word = [&](std::size_t at) { return at + 1 < size ? pdu[at] * 256 + pdu[at + 1] : -1; };
    const auto touch = [&](int area, std::size_t at, bool write, int count) {
        if (word(at) < 0 || count < 0) return;
        for (int i = 0; i < std::max(count, 1); ++i)
            facts.items.push_back({area, (word(at) + i) % 65536, write});
    };
    const auto read = [&](int area, int most) {
        facts.writes = false;
        touch(area, 1, false, word(3));
        facts.well_formed = size == 5 && word(3) >= 1 && word(3) <= most;
    };
    const auto write = [&](int area, int most, bool bits) {
        touch(area, 1, true, word(3));
        const int bytes = bits ? (word(3) + 7) / 8 : 2 * word(3);
        facts.well_formed = size > 5 && word(3) >= 1 && word(3) <= most && pdu[5] == bytes &&
                            size == 6U + static_cast<unsigned>(bytes);
        facts.broadcast = true;
    };
    const auto one = [&](int area, std::size_t length) {
        touch(area, 1, true, 1);
        facts.well_formed = size == length;
        facts.broadcast = true;
    };
    const auto files = [&](bool with_values) {
        facts.well_formed = size > 1 && size == 2U + pdu[1] && pdu[1] >= (with_values ? 9 : 7);
        int answer = 2;
        for (std::size_t at = 2; facts.well_formed && at < size;) {
            const int registers = word(at + 5);
            facts.well_formed = pdu[at] == 6 && registers >= 1 && registers <= 124;
            answer += 2 + 2 * registers;
            at += 7U + (with_values ? 2U * static_cast<unsigned>(registers) : 0U);
            facts.well_formed = facts.well_formed && at <= size && (with_values || answer <= 253);
        }
    };
    switch (pdu[0]) {
        case 1: read(kCoil, 2000); break;
        case 2: read(kDiscrete, 2000); break;
        case 3: read(kHolding, 125); break;
        case 4: read(kInput, 125); break;
        case 5:
            one(kCoil, 5);
            facts.well_formed = facts.well_formed && (word(3) == 0 || word(3) == 0xFF00);
            break;
        case 6: one(kHolding, 5); break;
        case 7:
        case 11:
        case 12:
        case 17:
            facts.writes = false;
            facts.well_formed = size == 1;
            break;
        case 8: {
            const int sub = word(1);
            facts.writes = sub >= 0 && sub != 0 && sub != 2 && (sub < 11 || sub > 18);
            facts.well_formed = (sub >= 0 && sub <= 18) || sub == 20;
            facts.well_formed = facts.well_formed && (sub == 0 ? size % 2 == 1 : size == 5);
            break;
        }
        case 15: write(kCoil, 1968, true); break;
        case 16: write(kHolding, 123, false); break;
        case 20:
            facts.writes = false;
            files(false);
            break;
        case 21:
            files(true);
            facts.broadcast = true;
            break;
        case 22: one(kHolding, 7); break;
        case 23:
            touch(kHolding, 1, false, word(3));
            touch(kHolding, 5, true, word(7));
            facts.well_formed = size > 9 && word(3) >= 1 && word(3) <= 125 && word(7) >= 1 &&
                                word(7) <= 121 && pdu[9] == 2 * word(7) && size == 10U + pdu[9];
            break;
        case 24:
            facts.writes = false;
            touch(kHolding, 1, false, 1);
            facts.well_formed = size == 3;
            break;
        case 43:
            facts.writes = size > 1 && pdu[1] != 14;
            facts.well_formed = size > 1 && (pdu[1] != 14 || (size == 4 && pdu[2] >= 1 && pdu[2] <= 4));
            break;
        default: facts.known = false; facts.well_formed = pdu[0] > 0 && pdu[0] < 128;
    }
    return facts;
}

/// Decides item by item and unit by unit.
class Oracle {
public:
    void set(std::vector<RuleText> rules) {
        rules_ = std::move(rules);
        buckets_.clear();
    }

    enum class Verdict { allowed, refused, too_fast };

    Verdict decide(Instant t, std::size_t client, const std::vector<int>& units, const Pdu& pdu) {
        if (rules_.empty()) return Verdict::allowed;
        std::vector<bool> deciders(rules_.size());
        Facts facts = facts_of(pdu);
        if (!facts.known || (pdu[0] == 43 && facts.writes))
            for (int area = 0; area < 4; ++area)
                for (const int address : places()) facts.items.push_back({area, address, true});
        for (const int unit : units)
            if (!allowed(client, unit, pdu, facts, deciders)) return Verdict::refused;
        return charge(t, client, deciders) ? Verdict::allowed : Verdict::too_fast;
    }

private:
    struct Bucket {
        std::size_t rule;
        int owner;
        TokenBucket tokens;
    };

    bool allowed(std::size_t client, int unit, const Pdu& pdu, const Facts& facts,
                 std::vector<bool>& deciders) {
        if (facts.items.empty()) return permits(client, unit, pdu, nullptr, facts.writes, deciders);
        return std::ranges::all_of(facts.items, [&](const Facts::Item& item) {
            return permits(client, unit, pdu, &item, item.write, deciders);
        });
    }

    // One address of each stretch that the rules treat alike.
    [[nodiscard]] std::vector<int> places() const {
        std::vector<int> all{0};
        for (const auto& rule : rules_)
            for (const auto& [first, last] : rule.items) {
                all.push_back(first);
                if (last < 65535) all.push_back(last + 1);
            }
        return all;
    }

    bool permits(std::size_t client, int unit, const Pdu& pdu, const Facts::Item* item, bool writes,
                 std::vector<bool>& deciders) {
        for (std::size_t i = 0; i < rules_.size(); ++i) {
            const RuleText& rule = rules_[i];
            if (rule.area >= 0 && (!item || item->area != rule.area || !in(rule.items, item->address)))
                continue;
            if (!in(rule.units, unit) || !peer_fits(rule, client) || !function_fits(rule, pdu)) continue;
            deciders[i] = true;
            return rule.rule == "allow" || (rule.rule == "read_only" && !writes);
        }
        return false;
    }

    static bool in(const std::vector<std::pair<int, int>>& ranges, int number) {
        return ranges.empty() || std::ranges::any_of(ranges, [number](const auto& range) {
                   return range.first <= number && number <= range.second;
               });
    }
    static bool peer_fits(const RuleText& rule, std::size_t client) {
        if (rule.peers.empty()) return true;
        return std::ranges::any_of(clients()[client].networks, [&](std::string_view network) {
            return std::ranges::find(rule.peers, network) != rule.peers.end();
        });
    }
    static bool function_fits(const RuleText& rule, const Pdu& pdu) {
        constexpr std::array kReads{1, 2, 3, 4, 7, 11, 12, 17, 20, 24};
        constexpr std::array kWrites{5, 6, 15, 16, 21, 22, 23};
        if (rule.functions.empty()) return pdu[0] < 128;
        return std::ranges::any_of(rule.functions, [&](const std::string& name) {
            const auto has = [&](const auto& codes) {
                return std::ranges::find(codes, pdu[0]) != codes.end();
            };
            if (name == "read") return has(kReads) || (pdu[0] == 43 && pdu.size() > 1 && pdu[1] == 14);
            if (name == "write") return has(kWrites) || (pdu[0] == 43 && pdu.size() > 1 && pdu[1] != 14);
            return std::stoi(name) == pdu[0];
        });
    }

    Bucket& bucket(std::size_t rule, int owner) {
        for (auto& one : buckets_)
            if (one.rule == rule && one.owner == owner) return one;
        const auto rate = static_cast<std::uint32_t>(rules_[rule].rate);
        buckets_.push_back(
            {rule, owner, *TokenBucket::create(rate, Duration(std::chrono::seconds(1)) / rate)});
        return buckets_.back();
    }
    bool charge(Instant t, std::size_t client, const std::vector<bool>& deciders) {
        std::vector<std::size_t> charged;
        for (std::size_t i = 0; i < rules_.size(); ++i)
            if (deciders[i] && rules_[i].rate > 0 && rules_[i].rule != "deny") charged.push_back(i);
        const int owner = rate_owner(client);
        for (const std::size_t i : charged)
            if (bucket(i, owner).tokens.next_admission(t) > t) return false;
        for (const std::size_t i : charged) (void)bucket(i, owner).tokens.admit(t);
        return true;
    }

    std::vector<RuleText> rules_;
    std::vector<Bucket> buckets_;
};

/// An endpoint with the own units 3 and 4, whose devices behind the lines refuse everything with exception 4.
///
///   unit 0     every unit of line 0 (RTU)
///   5, 6       the same on line 0
///   30         unit 5 of line 0
///   31         every unit of line 0
///   32         unit 7 of line 1 (Modbus TCP)
///   33         unit 0 of line 1, which is no broadcast there
///   99         none
class RulesWorld {
public:
    static constexpr std::array kUnits{0, 1, 3, 4, 5, 6, 30, 31, 32, 33, 99, 255};

    RulesWorld() : handler(&server_, {UnitId{3}, UnitId{4}, UnitId{0}, UnitId{5}, UnitId{6}}, nullptr) {
        for (std::size_t i = 0; i < units_.size(); ++i) {
            units_[i].id = UnitId{static_cast<std::uint8_t>(i + 3)};
            probes_[i] = &seen_[i];
            units_[i].extensions = std::span(probes_).subspan(i, 1);
        }
        server_ = serve::Server(units_);
        std::vector<serve::Upstream> upstreams;
        for (auto& line : lines_) {
            line->engine.on_link(now_, true);
            line->gateway.work(now_);
            upstreams.push_back({&line->gateway.gateway(), {}, {}, {}});
        }
        const auto route = [](int from, int to, std::size_t line) {
            return serve::Route{UnitId{static_cast<std::uint8_t>(from)},
                                UnitId{static_cast<std::uint8_t>(to)}, line};
        };
        handler.set_routes(serve::RouteTable(0, std::move(upstreams),
                                             {route(0, 0, 0), route(5, 5, 0), route(6, 6, 0), route(30, 5, 0),
                                              route(31, 0, 0), route(32, 7, 1), route(33, 0, 1)}));
    }
    RulesWorld(const RulesWorld&) = delete;
    RulesWorld& operator=(const RulesWorld&) = delete;

    /// @returns false: the rules are not valid, and nothing changes
    bool set(const std::vector<RuleText>& rules) {
        const auto parsed = parse(rules);
        if (!parsed) return false;
        handler.set_access(*parsed);
        oracle_.set(rules);
        return true;
    }

    /// The events: the frames on the lines in hexadecimal, "0: 05 06 …", and requests of own units, "own
    /// 3".
    using Events = std::vector<std::string>;
    struct Result {
        Events expected;
        Events seen;
        bool refused_by_rule = false;  ///< exception 1 or 6 is expected
        std::optional<Pdu> answer;     ///< at once
    };

    /// A client asks, and everything is brought to its end.
    Result ask(std::size_t client, int unit, const Pdu& pdu) {
        const bool broadcast = clients()[client].peer[0] == '/' && unit == 0;
        const serve::Context context{
            now_, UnitId{static_cast<std::uint8_t>(unit)}, broadcast, clients()[client].peer, {}};
        Result result;
        const auto verdict = expect(client, unit, broadcast, pdu, result.expected);
        result.refused_by_rule = verdict != Oracle::Verdict::allowed;
        seen_events_.clear();
        const auto answer = handler.handle(context, wire::RequestView(pdu));
        if (answer.kind == serve::Answer::Kind::response)
            result.answer = Pdu(answer.pdu.begin(), answer.pdu.end());
        play();
        result.seen = seen_events_;
        return result;
    }

    /// The rule's answer and nothing else, where the oracle refuses.
    static bool answered_right(const Result& result, const Pdu& pdu, bool broadcast) {
        if (!result.refused_by_rule) return true;
        if (broadcast) return !result.answer;
        return result.answer && result.answer->size() == 2 && (*result.answer)[0] == (pdu[0] | 0x80) &&
               ((*result.answer)[1] == 1 || (*result.answer)[1] == 6);
    }

private:
    struct Probe final : serve::Extension {
        Probe(RulesWorld& own_world, int number) : world(own_world), unit(number) {}
        bool handle(serve::Unit&, const serve::Context&, const wire::RequestView&, serve::Answer&) override {
            return false;
        }
        bool admit(const serve::Context&, const wire::RequestView&) override {
            world.seen_events_.push_back("own " + std::to_string(unit));
            return true;
        }
        RulesWorld& world;
        int unit;
    };
    struct Line final : endpoint::SharedLine {
        Line(RulesWorld& world, bool rtu)
            : engine(config(rtu)),
              gateway({.broadcast = rtu}, *this,
                      [&world](const serve::Gateway::Reply& reply) { world.handler.on_relayed(reply); }) {}
        static bus::LineConfig config(bool rtu) {
            bus::LineConfig config;
            config.framing = rtu ? wire::Framing::rtu : wire::Framing::tcp;
            config.format.baud = 115200;
            config.echo = bus::Echo::absent;
            return config;
        }
        [[nodiscard]] bool link_up() const override { return engine.link_up(); }
        [[nodiscard]] bool can_accept() const override { return engine.idle() && engine.can_submit(); }
        [[nodiscard]] bool may_start(Instant t, UnitId unit, const bus::AnswerShape& shape) const override {
            return engine.ambiguity(t, unit, shape) != bus::Ambiguity::held;
        }
        [[nodiscard]] takt::Result<void> submit(Instant t, const bus::Transaction& transaction) override {
            return engine.submit(t, transaction);
        }
        [[nodiscard]] std::optional<bus::Outcome> take_outcome() override { return engine.take_outcome(); }
        [[nodiscard]] bool withdraw() override { return false; }
        void poke() override {}

        bus::TransactionEngine engine;
        endpoint::LineGateway gateway;
    };

    // The target of the request, and its visible effects.
    Oracle::Verdict expect(std::size_t client, int unit, bool broadcast, const Pdu& pdu, Events& events) {
        struct Hop {
            int from, to;
            std::size_t line;
        };
        constexpr std::array kHops{Hop{0, 0, 0},  Hop{5, 5, 0},  Hop{6, 6, 0}, Hop{30, 5, 0},
                                   Hop{31, 0, 0}, Hop{32, 7, 1}, Hop{33, 0, 1}};
        const auto hop = std::ranges::find(kHops, unit, &Hop::from);
        const bool relayed = hop != kHops.end();
        const bool to_all = relayed && hop->to == 0 && hop->line == 0;
        std::vector<int> units;
        std::vector<int> own;
        if (broadcast)
            own = {3, 4};
        else if (unit == 3 || unit == 4)
            own = {unit};
        else if (!relayed && (unit == 0 || unit == 255))
            own = {3};
        units = own;
        for (int all = 1; to_all && all < 256; ++all) units.push_back(all);
        if (relayed && !to_all) units.push_back(hop->to);
        if (units.empty()) units.push_back(unit);
        const auto verdict = oracle_.decide(now_, client, units, pdu);
        if (verdict != Oracle::Verdict::allowed) return verdict;
        for (const int one : own) events.push_back("own " + std::to_string(one));
        const Facts facts = facts_of(pdu);
        if (!relayed || !facts.well_formed || (to_all && !facts.broadcast)) return verdict;
        events.push_back(frame(hop->line, hop->to, pdu));
        return verdict;
    }

    static std::string frame(std::size_t line, int unit, const Pdu& pdu) {
        return std::to_string(line) + ": " + std::to_string(unit) + " " + hex(pdu);
    }
    static std::string hex(Bytes bytes) {
        constexpr std::string_view kDigits = "0123456789abcdef";
        std::string text;
        for (const std::uint8_t byte : bytes) text += {kDigits[byte >> 4], kDigits[byte & 15]};
        return text;
    }

    // The bytes of each frame are taken apart here again; the check of an RTU frame is its own.
    void note(std::size_t index, Bytes bytes) {
        std::string text = std::to_string(index) + ": ";
        if (index == 0) {
            unsigned crc = 0xFFFF;
            for (const std::uint8_t byte : bytes) {
                crc ^= byte;
                for (int i = 0; i < 8; ++i) crc = (crc >> 1) ^ ((crc & 1) != 0 ? 0xA001U : 0U);
            }
            text +=
                crc == 0 ? std::to_string(bytes[0]) + " " + hex(bytes.subspan(1, bytes.size() - 3)) : "bad";
        } else {
            const bool whole = bytes.size() > 7 && bytes.size() == 6U + bytes[4] * 256U + bytes[5];
            text += whole ? std::to_string(bytes[6]) + " " + hex(bytes.subspan(7)) : "bad";
        }
        seen_events_.push_back(text);
    }

    void play() {
        for (int step = 0; step < 1000; ++step) {
            bool busy = false;
            for (std::size_t i = 0; i < lines_.size(); ++i) {
                Line& line = *lines_[i];
                line.gateway.work(now_);
                const Bytes sent = line.engine.transmit(now_);
                if (!sent.empty()) {
                    note(i, sent);
                    respond(i, sent);
                }
                line.gateway.work(now_);
                busy = busy || line.gateway.gateway().waiting() > 0;
            }
            if (!busy) return;
            Instant next = kNever;
            for (const auto& line : lines_) next = std::min(next, line->engine.next_wakeup());
            now_ = std::max(now_ + Duration(std::chrono::microseconds(100)), std::min(next, now_ + kStep));
            for (const auto& line : lines_) line->engine.on_tick(now_);
        }
    }

    void respond(std::size_t index, Bytes sent) {
        Line& line = *lines_[index];
        const bool rtu = index == 0;
        const UnitId unit{rtu ? sent[0] : sent[6]};
        if (rtu && unit.value == 0) return;
        const auto function = static_cast<std::uint8_t>((rtu ? sent[1] : sent[7]) | 0x80);
        const auto transaction = static_cast<std::uint16_t>(rtu ? 0 : sent[0] * 256 + sent[1]);
        const Pdu answer{function, 4};
        const auto bytes = wire::encode_frame(rtu ? wire::Framing::rtu : wire::Framing::tcp, unit,
                                              transaction, Bytes(answer));
        now_ += kStep;
        line.engine.on_tick(now_);
        line.engine.on_bytes(now_, bytes.span());
    }

    static constexpr Duration kStep = std::chrono::milliseconds(25);  // longer than any frame at 115200 bit/s

    Instant now_ = Instant{} + std::chrono::hours(1);
    std::array<serve::Unit, 2> units_;
    std::array<Probe, 2> seen_{Probe{*this, 3}, Probe{*this, 4}};
    std::array<serve::Extension*, 2> probes_{};
    serve::Server server_{{}};
    Events seen_events_;
    Oracle oracle_;
    std::array<std::unique_ptr<Line>, 2> lines_{std::make_unique<Line>(*this, true),
                                                std::make_unique<Line>(*this, false)};

public:
    endpoint::RequestHandler handler;
};

}  // namespace takt::test
