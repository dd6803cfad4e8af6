#include "takt/console/control_server.hpp"

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>
#include <vector>

#include "takt/report/command_report.hpp"
#include "takt/report/progress_text.hpp"

namespace takt::console {
namespace {

constexpr std::size_t kMaxAnswers = 256 << 10;  // bytes a client may leave unread before it is cut off

class ControlClient : public std::enable_shared_from_this<ControlClient> {
public:
    ControlClient(line::Loop& loop, int fd, const Execute& execute, const Texts& texts)
        : fd_(fd),
          reader_(execute, texts),
          watch_(std::make_unique<line::Watch>(loop, fd, [this] { read(); }, [this] { write(); })) {
        watch_->want_read();
    }
    ~ControlClient() {
        watch_.reset();
        ::close(fd_);
    }
    ControlClient(const ControlClient&) = delete;
    ControlClient& operator=(const ControlClient&) = delete;

    [[nodiscard]] bool closed() const { return closed_; }
    /// All its commands are answered.
    [[nodiscard]] bool idle() const { return commands_ == answers_; }
    [[nodiscard]] Instant last_command() const { return last_command_; }

    /// Sends a last line, as far as the client reads it, and closes.
    void dismiss(const std::string& why) {
        put(why);
        closed_ = true;
    }

private:
    void read() {
        std::array<char, 4096> buffer;
        const auto count = ::read(fd_, buffer.data(), buffer.size());
        if (count == 0 || (count < 0 && errno != EINTR && errno != EAGAIN)) {
            closed_ = true;
            return;
        }
        if (count > 0) {
            // An answer may arrive after the client has gone.
            const Reply reply = [self = weak_from_this()](const Answer& answer) {
                const auto client = self.lock();
                if (!client) return;
                ++client->answers_;
                client->put(answer.line);
            };
            last_command_ = line::now();
            commands_ += reader_.feed({buffer.data(), static_cast<std::size_t>(count)}, reply);
        }
        if (!closed_) watch_->want_read();
    }

    void put(const std::string& text) {
        if (unsent_.size() + text.size() > kMaxAnswers) closed_ = true;
        if (closed_) return;
        unsent_ += text;
        write();
    }

    void write() {
        if (unsent_.empty() || closed_) return;
        const auto count = ::send(fd_, unsent_.data(), unsent_.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
        if (count < 0 && errno != EINTR && errno != EAGAIN) closed_ = true;
        if (count > 0) unsent_.erase(0, static_cast<std::size_t>(count));
        if (!unsent_.empty() && !closed_) watch_->want_write();
    }

    int fd_;
    CommandReader reader_;
    std::unique_ptr<line::Watch> watch_;
    std::string unsent_;
    std::size_t commands_ = 0;
    std::size_t answers_ = 0;
    Instant last_command_ = line::now();
    bool closed_ = false;
};

bool is_socket(const std::string& path) {
    struct stat status{};
    return ::lstat(path.c_str(), &status) == 0 && S_ISSOCK(status.st_mode);
}

bool is_served(const sockaddr_un& address) {
    const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const bool connected = ::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
    ::close(fd);
    return connected;
}

}  // namespace

struct ControlServer::Impl {
    Impl(line::Loop& event_loop, int descriptor, std::string socket_path, Execute commands,
         const Texts& voice)
        : loop(event_loop),
          fd(descriptor),
          path(std::move(socket_path)),
          execute(std::move(commands)),
          texts(voice),
          watch(loop, fd, [this] { accept(); }) {
        watch.want_read();
    }
    ~Impl() {
        clients.clear();
        ::close(fd);
        ::unlink(path.c_str());
    }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    void accept() {
        std::erase_if(clients, [](const auto& client) { return client->closed(); });
        const int connection = ::accept4(fd, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
        watch.want_read();
        if (connection < 0) return;
        const auto client = std::make_shared<ControlClient>(loop, connection, execute, texts);
        if (clients.size() < kMaxClients || make_room()) return clients.push_back(client);
        client->dismiss(
            report::error_line("busy", texts("app.control.full", {{"count", std::to_string(kMaxClients)}})));
    }

    /// Closes the client that has been idle for the longest time. @returns false: none is idle
    bool make_room() {
        const auto use = [](const auto& client) { return client->idle() ? client->last_command() : kNever; };
        const auto oldest = std::ranges::min_element(clients, {}, use);
        if (!(*oldest)->idle()) return false;
        const auto time = report::rough_time(line::now() - (*oldest)->last_command());
        (*oldest)->dismiss(report::error_line("idle", texts("app.control.idle", {{"time", time}})));
        clients.erase(oldest);
        return true;
    }

    line::Loop& loop;
    int fd;
    std::string path;
    Execute execute;
    Texts texts;
    std::vector<std::shared_ptr<ControlClient>> clients;
    line::Watch watch;
};

Result<std::unique_ptr<ControlServer>> ControlServer::listen(line::Loop& loop, const std::string& path,
                                                             Execute execute, const Texts& texts) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (path.size() >= sizeof address.sun_path) return fail(Code::cannot_open, path, ENAMETOOLONG);
    std::memcpy(address.sun_path, path.data(), path.size());
    if (is_socket(path)) {
        if (is_served(address)) return fail(Code::busy, path);
        ::unlink(path.c_str());
    }
    const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    const mode_t old_mask = ::umask(0077);
    const bool bound =
        fd >= 0 && ::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
    const int reason = errno;
    ::umask(old_mask);
    if (!bound || ::listen(fd, 16) != 0) {
        if (fd >= 0) ::close(fd);
        return fail(Code::cannot_open, path, bound ? errno : reason);
    }
    return std::unique_ptr<ControlServer>(
        new ControlServer(std::make_unique<Impl>(loop, fd, path, std::move(execute), texts)));
}

ControlServer::ControlServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

ControlServer::~ControlServer() = default;

}  // namespace takt::console
