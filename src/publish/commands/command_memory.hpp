// The last commands by their ids: none is executed twice.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "commands/command_answer.hpp"

namespace takt::publish {

/// Keeps the last kMost accepted and the last kMost refused commands. Refused ones are kept apart: they
/// cannot push out accepted ones. A command without an outcome is never forgotten: fewer than kMost are open.
class CommandMemory {
public:
    static constexpr std::size_t kMost = 1024;

    struct Entry {
        std::uint64_t content = 0;            ///< a hash of the payload
        std::optional<CommandAnswer> answer;  ///< nothing: it has no outcome yet
    };

    /// @returns nullptr: not known
    [[nodiscard]] Entry* find(const std::string& id);
    /// @param id  not known yet
    void add(const std::string& id, bool accepted, Entry entry);

private:
    std::map<std::string, Entry> entries_;
    std::deque<std::string> accepted_;  // oldest first
    std::deque<std::string> refused_;
};

}  // namespace takt::publish
