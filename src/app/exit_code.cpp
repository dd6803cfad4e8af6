#include "exit_code.hpp"

#include <cerrno>
#include <cstdio>
#include <cstdlib>

#include "log.hpp"
#include "output.hpp"

namespace takt::app {

ExitCode exit_code(const Error& error) {
    switch (error.code) {
        case Code::cannot_open:  // interrupted while connecting: no answer came yet
            return error.numbers[0] == ECANCELED ? ExitCode::timed_out : ExitCode::cannot_open;
        case Code::busy:
        case Code::connection_lost:
        case Code::closed_by_peer:
        case Code::tls_failed:
        case Code::io_failed:
        case Code::replaced: return ExitCode::cannot_open;
        case Code::timed_out: return ExitCode::timed_out;
        case Code::modbus_exception: return ExitCode::exception;
        case Code::bad_checksum:
        case Code::unexpected_reply:
        case Code::misdirected:
        case Code::not_modbus:
        case Code::malformed:
        case Code::too_short:
        case Code::too_long: return ExitCode::bad_frame;
        case Code::out_of_range:
        case Code::unsupported:
        case Code::not_found:
        case Code::overflow:
        case Code::not_writable:
        case Code::read_only:
        case Code::queue_full:
        case Code::syntax: return ExitCode::usage;
    }
    return ExitCode::usage;
}

ExitCode ended_by(const Texts& texts, const Error& error) {
    print_error(texts.describe(error));
    return exit_code(error);
}

ExitCode ended_with(const std::string& text, ExitCode code) {
    print_error(text);
    return code;
}

int end_status(text::Language language, ExitCode code) {
    for (const auto& [path, number] : {LostOutput{"stdout", stdout_error()}, lost_output()}) {
        if (number == 0 || number == EPIPE) continue;
        const Texts texts(language);
        const bool stalled = number == ETIMEDOUT;
        print_error(stalled ? texts("app.output_stalled", {{"name", path}})
                            : texts.describe(fail(Code::io_failed, path, number).error()));
        if (code == ExitCode::ok) code = stalled ? ExitCode::partly : ExitCode::cannot_open;
    }
    return static_cast<int>(code);
}

void leave_program(text::Language language, ExitCode code) {
    end_log();
    const int status = end_status(language, code);
    std::fflush(nullptr);
    std::_Exit(status);
}

}  // namespace takt::app
