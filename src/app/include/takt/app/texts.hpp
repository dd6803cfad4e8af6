// The program's voice: messages in the user's language, and errors on stderr.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/model/findings.hpp"
#include "takt/text/language.hpp"
#include "takt/value/value.hpp"

namespace takt::app {

/// Messages by code, in one language. Cheap to copy.
class Texts {
public:
    explicit Texts(text::Language language) : language_(language) {}

    using Arguments = std::vector<std::pair<std::string, std::string>>;

    /// The message of `code` with its {placeholders} filled in.
    [[nodiscard]] std::string operator()(std::string_view code, const Arguments& arguments = {}) const;

    /// What a finding says, and what to do about it (empty where there is nothing to say).
    [[nodiscard]] std::string message(const model::Finding& finding) const;
    [[nodiscard]] std::string advice(const model::Finding& finding) const;

    /// "what. advice"
    [[nodiscard]] std::string describe(const Error& error) const;

    /// How good a value is and why, in words: "bad, time-out".
    [[nodiscard]] std::string quality(value::Quality quality, value::Reason reason) const;

    /// Writes `takt: <text>` to stderr.
    void complain(const std::string& text) const;

    [[nodiscard]] text::Language language() const { return language_; }

private:
    text::Language language_;
};

/// Writes all of `text` to stdout or stderr, as far as somebody reads it.
void print(const std::string& text);
void talk(const std::string& text);

/// The operating system's number of the first print() that failed (a full disk, a closed pipe); 0: none.
[[nodiscard]] int print_error();

/// The same of what was written to stdout in another way; 0 is nothing.
void note_print_error(int number);

/// The same of another file or stream.
struct LostOutput {
    std::string path;
    int number = 0;
};
void note_lost_output(const std::string& path, int number);
/// The first of them; number 0: none.
[[nodiscard]] const LostOutput& lost_output();

/// A sentence that is to go on: without the full stop at its end.
[[nodiscard]] std::string without_stop(std::string sentence);

}  // namespace takt::app
