// One command to a running project, over its control socket.
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "takt/app/commands.hpp"
#include "takt/app/texts.hpp"

namespace takt::app {
namespace {

constexpr int kAnswerLimitMs =
    30'000;  // a write is answered when its outcome is known, at the latest when it expires

Result<int> connect_to(const std::string& path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (path.size() >= sizeof address.sun_path) return fail(Code::cannot_open, path, ENAMETOOLONG);
    std::memcpy(address.sun_path, path.data(), path.size());
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
    return line + '\n';
}

Result<std::string> ask(int fd, const std::string& path, const std::string& command) {
    if (::send(fd, command.data(), command.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(command.size()))
        return fail(Code::connection_lost, path, errno);
    std::string answer;
    while (!answer.ends_with('\n')) {
        pollfd readable{fd, POLLIN, 0};
        if (::poll(&readable, 1, kAnswerLimitMs) == 0) return fail(Code::timed_out, path, kAnswerLimitMs);
        std::array<char, 4096> buffer;
        const auto count = ::read(fd, buffer.data(), buffer.size());
        if (count <= 0) return fail(Code::connection_lost, path, count < 0 ? errno : 0);
        answer.append(buffer.data(), static_cast<std::size_t>(count));
    }
    return answer;
}

}  // namespace

ExitCode ctl(const CommonOptions& common, const CtlOptions& options) {
    const Texts texts(common.language);
    const auto fd = connect_to(options.path);
    const auto answer = fd ? ask(*fd, options.path, command_of(options.words))
                           : Result<std::string>(std::unexpected(fd.error()));
    if (fd) ::close(*fd);
    if (!answer) {
        texts.complain(texts.describe(answer.error()));
        return exit_code(answer.error());
    }
    print(*answer);
    return answer->starts_with("ok") || answer->starts_with("done") ? ExitCode::ok : ExitCode::no;
}

}  // namespace takt::app
