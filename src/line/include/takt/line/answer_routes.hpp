// The ways of completed answers to the engines that wait for them.
#pragma once

#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

#include "takt/line/driver.hpp"
#include "takt/serve/answer.hpp"
#include "takt/serve/serial_slave.hpp"

namespace takt::line {

/// To the slave of a serial port. The loop's thread only.
class SerialAnswers final : public serve::AnswerSink {
public:
    /// @param slave, driver  outlive it
    SerialAnswers(serve::SerialSlave& slave, Driver& driver) : slave_(slave), driver_(driver) {}

    bool complete(serve::Token token, Bytes pdu) override {
        if (!slave_.complete(now(), token, pdu)) return false;
        driver_.poke();
        return true;
    }

private:
    serve::SerialSlave& slave_;
    Driver& driver_;
};

/// To all places where one responder answers: the one of them that waits takes it. The loop's thread only.
class AnswerRoutes final : public serve::AnswerSink {
public:
    /// @param sink  is removed, or outlives it
    void add(serve::AnswerSink& sink) { sinks_.push_back(&sink); }
    void remove(serve::AnswerSink& sink) { std::erase(sinks_, &sink); }

    /// Is told of every answer before it is given; at most one, empty: nobody.
    void watch(std::function<void(serve::Token, Bytes)> watcher) { watcher_ = std::move(watcher); }

    /// Of the answers that go this way.
    [[nodiscard]] serve::Tokens& tokens() { return tokens_; }

    bool complete(serve::Token token, Bytes pdu) override {
        if (watcher_) watcher_(token, pdu);
        return std::ranges::any_of(sinks_,
                                   [&](serve::AnswerSink* sink) { return sink->complete(token, pdu); });
    }

private:
    std::vector<serve::AnswerSink*> sinks_;
    std::function<void(serve::Token, Bytes)> watcher_;
    serve::Tokens tokens_;
};

}  // namespace takt::line
