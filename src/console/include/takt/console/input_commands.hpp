// Commands from a stream, in most cases standard input.
#pragma once

#include <memory>

#include "takt/console/command_reader.hpp"
#include "takt/line/loop.hpp"

namespace takt::console {

/// Executes the lines that are read from a descriptor. After its end nothing more is executed.
class InputCommands {
public:
    /// @param descriptor  must outlive it
    /// @param reply       gets the answers to all commands
    InputCommands(line::Loop& loop, int descriptor, Execute execute, const Texts& texts, Reply reply);

private:
    void read();

    int descriptor_;
    CommandReader reader_;
    Reply reply_;
    line::Watch watch_;
};

}  // namespace takt::console
