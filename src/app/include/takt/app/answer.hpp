// The answer to one command of a running project.
#pragma once

#include <cstdint>
#include <string>

#include "takt/file/json.hpp"

namespace takt::app {

struct Answer {
    enum class Kind { ok, error, outcome };
    Kind kind = Kind::ok;
    std::string command;   ///< set, write, get, quit; empty where the command was not understood
    std::uint64_t id = 0;  ///< of `set` and `write`: which of them since the run began, from 1; 0: none
    std::string line;      ///< of an outcome
    std::string device;    ///< likewise
    std::string name;
    std::string value;          ///< of ok
    std::string quality;        ///< of `get` where it is not good
    std::string waiting;        ///< of `set`: waiting (not written yet), superseded (by a later one)
    std::string outcome;        ///< done, refused, unknown, expired
    std::string reason;         ///< why it was not done
    std::string wanted;         ///< what was to be written
    std::string written;        ///< where another value was read back than was written
    std::string read_back;      ///< and that value
    bool rounded = false;       ///< what is written is the nearest value the device can hold
    bool not_retained = false;  ///< it is to survive the end of the run, and will not
    std::string code;           ///< stable code of an error
    std::string text;           ///< what the error says
};

/// "ok NAME VALUE", "ok NAME VALUE rounded", "ok NAME VALUE waiting", "error CODE text", "done NAME",
/// "refused NAME exception 2 wanted 50", "refused NAME differs written 50 read 49"; with its line end.
[[nodiscard]] std::string to_line(const Answer& answer);

/// {"event":"answer"|"error"|"outcome", …}
[[nodiscard]] file::Json to_json(const Answer& answer);

}  // namespace takt::app
