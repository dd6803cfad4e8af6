// The commands a running project understands, on standard input and on the control socket
// (docs/commands/run.md).
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

#include "takt/base/result.hpp"

namespace takt::console {

/// Separate the words of a command line.
inline constexpr std::string_view kCommandBlanks = " \t\r";

/// `set NAME VALUE`, `write NAME VALUE`, `get NAME`, `status`, `list`, `values [PATTERN]`, `quit`. A name
/// with blanks is in double quotes; the value is the rest of the line.
struct ControlCommand {
    enum class Verb { set, write, get, status, list, values, quit };
    Verb verb = Verb::get;
    std::string name;  ///< of values: the pattern, empty for all
    std::string value;
};

inline constexpr std::string_view kControlUsage =
    "status, list, values [PATTERN], get NAME, set NAME VALUE, write NAME VALUE, quit";

/// @returns syntax with the line as its subject; not_found (word): no such command
[[nodiscard]] Result<ControlCommand> parse_control(std::string_view line);

/// Cuts a stream of bytes into lines of at most kMaxLine bytes; a longer one is reported once as too_long and
/// skipped to its end.
class LineSplitter {
public:
    static constexpr std::size_t kMaxLine = 4096;

    /// Calls `on_line` for each line that is complete by now, without its line end; `on_line` gets an error
    /// for an overlong one.
    void feed(std::string_view bytes, const std::function<void(Result<std::string>)>& on_line);

    /// The stream has ended. @returns what came after the last line end; the next line begins anew
    [[nodiscard]] std::string end();

private:
    std::string line_;
    bool skipping_ = false;
};

}  // namespace takt::console
