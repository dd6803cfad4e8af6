// The way of completed answers to the slave of a serial port.
#pragma once

#include "takt/line/driver.hpp"
#include "takt/serve/answer.hpp"
#include "takt/serve/serial_slave.hpp"

namespace takt::line {

/// Gives answers to the slave, and lets its driver send them. The loop's thread only.
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

}  // namespace takt::line
