// Shared by the tests of this module: PDUs from text, collected answers and records, projects from text.
#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hex.hpp"
#include "takt/endpoint/audit_log.hpp"
#include "takt/endpoint/line_gateway.hpp"
#include "takt/endpoint/notice.hpp"
#include "takt/file/load.hpp"
#include "takt/model/findings.hpp"
#include "takt/serve/answer.hpp"

namespace takt::endpoint::test {

using takt::test::to_hex;

/// "03 00 00 00 01"
inline wire::Pdu pdu(std::string_view hex) {
    wire::Pdu made;
    made.assign(takt::test::from_hex(hex));
    return made;
}

/// The clients of a listener.
struct Answers final : serve::AnswerSink {
    bool complete(serve::Token token, Bytes pdu) override {
        if (only && *only != token) return false;
        given.emplace(token, to_hex(pdu));
        if (on_answer) on_answer();
        return true;
    }
    [[nodiscard]] bool has(serve::Token token) const { return given.contains(token); }
    /// The answer; "": none yet.
    [[nodiscard]] std::string of(serve::Token token) const { return has(token) ? given.at(token) : ""; }

    std::map<serve::Token, std::string> given;
    std::optional<serve::Token> only;  // the one that is waited for here
    std::function<void()> on_answer;
};

/// Collects audit records.
struct Records final : AuditSink {
    void put(Instant, const AuditRecord& record) override { all.push_back(record); }
    std::vector<AuditRecord> all;
};

/// Collects notices.
struct Notices {
    [[nodiscard]] NoticeSink sink() {
        return [this](const Notice& notice) { all.push_back(notice); };
    }
    /// The codes, in order, each followed by a space.
    [[nodiscard]] std::string codes() const {
        std::string text;
        for (const auto& notice : all) text += notice.code + ' ';
        return text;
    }
    /// Of the last notice.
    [[nodiscard]] std::string argument(std::string_view name) const {
        const auto& arguments = all.back().arguments;
        const auto found = std::ranges::find(arguments, name, [](const auto& one) { return one.first; });
        return found == arguments.end() ? "" : found->second;
    }
    std::vector<Notice> all;
};

/// A line with one relayed request at a time, played by the test.
struct FakeLine final : SharedLine {
    [[nodiscard]] bool link_up() const override { return up; }
    [[nodiscard]] bool can_accept() const override { return up && !flight && !outcome; }
    [[nodiscard]] bool may_start(Instant, UnitId unit, const bus::AnswerShape&) const override {
        return unit != held_back;
    }
    [[nodiscard]] Result<void> submit(Instant, const bus::Transaction& transaction) override {
        if (rejects) return fail(Code::unsupported, "line");
        flight = transaction;
        return {};
    }
    [[nodiscard]] std::optional<bus::Outcome> take_outcome() override {
        return std::exchange(outcome, std::nullopt);
    }
    [[nodiscard]] bool withdraw() override {
        const bool can = flight.has_value() && !sent;
        if (can) flight.reset();
        return can;
    }
    void poke() override { ++pokes; }

    void answer(std::string_view response) {
        outcome =
            bus::Outcome{.id = flight->id, .unit = flight->unit, .status = bus::Status::ok, .sent = true};
        response_bytes = pdu(response);
        outcome->response = wire::ResponseView(response_bytes.span());
        flight.reset();
    }

    bool up = true;
    bool rejects = false;
    std::optional<UnitId> held_back;
    bool sent = true;  // the submitted transaction is on the wire
    std::optional<bus::Transaction> flight;
    std::optional<bus::Outcome> outcome;
    wire::Pdu response_bytes;  // of `outcome`
    int pokes = 0;
};

/// A project from YAML that has no errors.
inline model::Project project(const std::string& yaml) {
    auto loaded = file::load_text("plant.yaml", yaml);
    auto checked = model::interpret(loaded.document);
    if (!loaded.readable || checked.has_errors()) throw std::runtime_error(checked.findings.at(0).code);
    return std::move(checked.project);
}

}  // namespace takt::endpoint::test
