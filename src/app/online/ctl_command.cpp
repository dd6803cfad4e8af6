// One command to a running project, over its control socket. Answers about the state of the project come as
// JSON, which this program turns into text in its own language.
#include "commands.hpp"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <optional>

#include "output.hpp"
#include "stoppable_input.hpp"
#include "takt/file/json_members.hpp"
#include "takt/report/states/command_report.hpp"
#include "takt/report/states/state_report.hpp"
#include "takt/text/escape.hpp"
#include "texts.hpp"

namespace takt::app {
namespace {

/// A write is answered when its outcome is known, at the latest when it expires.
constexpr std::chrono::milliseconds kAnswerLimit{30'000};

bool is_other_file(const std::string& path) {
    struct stat status{};
    return ::stat(path.c_str(), &status) == 0 && !S_ISSOCK(status.st_mode);
}

Result<int> connect_to(const std::string& path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (path.size() >= sizeof address.sun_path) return fail(Code::cannot_open, path, ENAMETOOLONG);
    std::memcpy(address.sun_path, path.data(), path.size());
    if (is_other_file(path)) return fail(Code::cannot_open, path, ENOTSOCK);
    const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (fd < 0) return fail(Code::cannot_open, path, errno);
    if (::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return fd;
    const int reason = errno;
    ::close(fd);
    return fail(Code::cannot_open, path, reason);
}

/// One word of a command as `takt run` reads it: in quotes where it has blanks.
std::string quoted(const std::string& word) {
    return word.find(' ') == std::string::npos ? word : '"' + word + '"';
}

std::string command_of(const std::vector<std::string>& words) {
    std::string line;
    for (std::size_t i = 0; i < words.size(); ++i)
        line += (i == 0 ? "" : " ") + (i == 1 ? quoted(words[i]) : words[i]);
    std::replace(line.begin(), line.end(), '\n', ' ');
    return line;
}

/// @returns nothing when stopped by a signal before the answer came
Result<std::optional<std::string>> ask(int fd, const std::string& path, const std::string& command) {
    auto input = StoppableInput::around(path, fd);
    const std::string line = command + '\n';
    // A full server sends an error line before it closes; that line is printed instead of the socket error.
    const bool sent = ::send(fd, line.data(), line.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(line.size());
    const int reason = sent ? 0 : errno;
    std::string answer;
    while (!answer.ends_with('\n')) {
        TAKT_TRY(const bool readable, input.wait(kAnswerLimit));
        if (StoppableInput::stopped()) return std::optional<std::string>();
        if (!readable) return fail(Code::timed_out, path, kAnswerLimit.count());
        std::array<char, 4096> buffer;
        const auto count = ::read(fd, buffer.data(), buffer.size());
        if (count <= 0) return fail(Code::connection_lost, path, count < 0 ? errno : reason);
        answer.append(buffer.data(), static_cast<std::size_t>(count));
    }
    return std::optional(answer);
}

/// Why a value is not good, as an exit code.
ExitCode exit_code_of(const std::string& reason) {
    if (reason == "never_connected" || reason == "link_lost") return ExitCode::cannot_open;
    if (reason == "timeout" || reason == "not_answering") return ExitCode::timed_out;
    if (reason.starts_with("exception")) return ExitCode::exception;
    if (reason == "bad_checksum" || reason == "unexpected_reply") return ExitCode::bad_frame;
    return ExitCode::no;  // not read yet, stale, switched off
}

/// The answer has values, but the pattern selects none.
bool selects_nothing(const file::Json& answer) {
    const auto* const values = answer.find("values");
    const auto* const list = values ? std::get_if<file::Json::Array>(&values->value()) : nullptr;
    return list && list->empty();
}

/// An error answer: a command or a value that cannot be parsed is bad usage.
ExitCode exit_code_of_error(std::string_view code) {
    return code == "syntax" ? ExitCode::usage : ExitCode::no;
}

ExitCode exit_code_of(const file::Json& answer) {
    const auto event = string_member(answer, "event");
    if (event == "error") return exit_code_of_error(string_member(answer, "code"));
    if (selects_nothing(answer)) return ExitCode::no;
    if (event == "outcome") return string_member(answer, "outcome") == "done" ? ExitCode::ok : ExitCode::no;
    const auto quality = string_member(answer, "quality");
    if (string_member(answer, "command") != "get" || quality == "good") return ExitCode::ok;
    const auto cause = string_member(answer, "cause");
    return exit_code_of(cause.empty() ? string_member(answer, "reason") : cause);
}

/// How old the last good value is, as a part of a sentence.
std::string age_words(const Texts& texts, const file::Json& value) {
    const auto age = time_member(value, "age_ms");
    return age ? texts("app.ctl.age", {{"age", texts.duration(*age)}}) : std::string();
}

/// The value on stdout; what is wrong with it on stderr.
void print_value(const Texts& texts, const file::Json& value) {
    print(text::escape_line(report::get_line(value)) + '\n');
    if (string_member(value, "quality") == "good") return;
    print_error(texts("app.ctl.not_good", {{"name", string_member(value, "name")},
                                           {"quality", report::quality_text(texts, value)},
                                           {"age", age_words(texts, value)}}));
}

void print_answer(const Texts& texts, const CtlOptions& options, const file::Json& answer) {
    const auto command = string_member(answer, "command");
    const auto columns = columns_of(STDOUT_FILENO);
    if (selects_nothing(answer))
        print_error(texts("app.ctl.no_match", {{"pattern", options.words.back()}}));
    else if (string_member(answer, "event") == "error")
        print(report::error_line(string_member(answer, "code"), string_member(answer, "text")));
    else if (command == "get")
        print_value(texts, answer);
    else if (command == "status")
        print_wrapped(report::status_text(texts, answer, columns));
    else if (command == "list")
        print_wrapped(report::list_text(texts, answer, columns));
    else
        print_wrapped(report::values_text(texts, answer, columns));
}

constexpr std::size_t kLongestAnswer = std::size_t{1} << 30;

/// The commands whose answers this program turns into text.
bool needs_json(const CtlOptions& options) {
    const auto& verb = options.words.front();
    return options.json || verb == "get" || verb == "status" || verb == "list" || verb == "values";
}

/// Of an answer in one line: `ok …`, `done …`, `error CODE …`, or another outcome.
ExitCode exit_code_of_line(std::string_view answer) {
    constexpr std::string_view kError = "error ";
    if (answer.starts_with("ok") || answer.starts_with("done")) return ExitCode::ok;
    if (!answer.starts_with(kError)) return ExitCode::no;
    answer.remove_prefix(kError.size());
    return exit_code_of_error(answer.substr(0, answer.find(' ')));
}

ExitCode finish_with(const Texts& texts, const CtlOptions& options, const std::string& answer) {
    if (!needs_json(options)) {
        print(answer);
        return exit_code_of_line(answer);
    }
    const auto json = file::Json::parse(answer, kLongestAnswer);
    if (!json || options.json)
        print(answer);
    else
        print_answer(texts, options, *json);
    return json ? exit_code_of(*json) : ExitCode::no;
}

}  // namespace

ExitCode ctl(const CommonOptions& common, const CtlOptions& options) {
    const Texts texts(common.language);
    const std::string command = command_of(options.words);
    if (command.find_first_not_of(" \t") == std::string::npos)
        return ended_with(texts("app.ctl.empty"), ExitCode::usage);
    const auto fd = connect_to(options.path);
    const std::string asked = "--lang " + std::string(text::tag(common.language)) +
                              (needs_json(options) ? " --json " : " ") + command;
    const auto answer =
        fd ? ask(*fd, options.path, asked) : Result<std::optional<std::string>>(std::unexpected(fd.error()));
    if (fd) ::close(*fd);
    if (!answer) return ended_by(texts, answer.error());
    if (!*answer)
        return ended_with(texts("app.ctl.interrupted", {{"command", command}}), ExitCode::timed_out);
    return finish_with(texts, options, **answer);
}

}  // namespace takt::app
