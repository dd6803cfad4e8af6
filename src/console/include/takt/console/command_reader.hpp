// Commands as lines of text, and their answers.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <utility>

#include "takt/base/result.hpp"
#include "takt/console/control.hpp"
#include "takt/file/json.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::console {

using report::Texts;

/// The answer to one command, for both kinds of readers.
struct Answer {
    std::string line;  ///< with its line end
    file::Json json;   ///< null: the line alone
    /// What a command that begins with `--json` is answered with; null: `json`.
    file::Json data = {};
};

/// Gets the answer to one command; may be called later, and is not called when the run ends before.
using Reply = std::function<void(const Answer&)>;

/// Carries out one line of text.
/// @param texts  those of the answer
/// @returns the error of a line that is no command; then `reply` is not called
using Execute = std::function<Result<void>(const std::string& line, const Reply& reply, const Texts& texts)>;

[[nodiscard]] Answer error_answer(const Texts& texts, const Error& error);
/// `text` says more than the error.
[[nodiscard]] Answer error_answer(const Texts& texts, const Error& error, std::string_view text,
                                  std::string_view command = {}, std::string_view name = {});
/// @param usage  the commands, separated by ", "; each begins with its verb
[[nodiscard]] Answer unknown_command(const Texts& texts, std::string_view word, std::string_view usage);
[[nodiscard]] Answer quit_answer();

/// Executes lines of text; empty lines are ignored. Errors are answered. The answer to a line that begins
/// with `--json` is one line of JSON. `--lang TAG` before it selects the language of the answer.
class CommandReader {
public:
    CommandReader(Execute execute, const Texts& texts) : execute_(std::move(execute)), texts_(texts) {}

    /// @param reply  gets the answer to every command found in `bytes`, in any order and perhaps later
    /// @returns how many were found
    std::size_t feed(std::string_view bytes, const Reply& reply);

    /// The stream has ended: executes a last line without a line end. @returns as feed()
    std::size_t end(const Reply& reply);

private:
    bool execute(Result<std::string> line, const Reply& asked);

    Execute execute_;
    Texts texts_;
    LineSplitter splitter_;
};

}  // namespace takt::console
