#include "takt/console/control_server.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <functional>
#include <utility>
#include <vector>

#include "takt/os/descriptor.hpp"
#include "takt/report/drawing/progress_text.hpp"
#include "takt/report/states/command_report.hpp"

namespace takt::console {
namespace {

// Bytes that a client may leave unread before its next answer; beyond them it is cut off. An answer with the
// values of a large project is longer.
constexpr std::size_t kMaxAnswers = 256 << 10;
constexpr std::ptrdiff_t kMaxWaiting = 64;  // commands of a client without an answer; then it is not read

}  // namespace

class ControlClient : public std::enable_shared_from_this<ControlClient> {
public:
    /// @param on_closed  called once when nothing is left to do; must not destroy the client
    ControlClient(line::Loop& loop, int fd, const Execute& execute, const Texts& texts,
                  std::function<void()> on_closed)
        : fd_(fd),
          reader_(execute, texts),
          on_closed_(std::move(on_closed)),
          watch_(loop, fd, [this] { read(); }, [this] { write(); }) {}
    ControlClient(const ControlClient&) = delete;
    ControlClient& operator=(const ControlClient&) = delete;

    void start() { watch_.want_read(); }
    [[nodiscard]] bool closed() const { return state_ == State::closed; }
    /// All its commands are answered.
    [[nodiscard]] bool idle() const { return waiting_ == 0; }
    [[nodiscard]] Instant last_command() const { return last_command_; }

    /// Closes the client if it has hung up and the loop has not reported that yet. @returns closed()
    bool close_if_hung_up() {
        pollfd peer{fd_.get(), 0, 0};
        if (::poll(&peer, 1, 0) == 1) close();
        return closed();
    }

    /// Sends a last line, as far as the client reads it, and closes.
    void dismiss(const std::string& why) {
        put(why);
        close();
    }

private:
    enum class State : std::uint8_t {
        open,
        half_closed,  // the client sends nothing more and gets its answers; it may still hang up
        closed,
    };

    // Also called when the client has hung up. After a half-close its answers are no longer read then.
    void read() {
        if (state_ != State::open) return close();
        std::array<char, 4096> buffer;
        const auto count = ::read(fd_.get(), buffer.data(), buffer.size());
        if (count < 0 && errno != EINTR && errno != EAGAIN) return close();
        if (count == 0) state_ = State::half_closed;
        if (count > 0) {
            last_command_ = line::now();
            input_.append(buffer.data(), static_cast<std::size_t>(count));
        }
        execute_input();
    }

    // A line at a time, so that no client has more than kMaxWaiting commands in the host.
    void execute_input() {
        // An answer may arrive after the client has gone.
        const Reply reply = [self = weak_from_this()](const Answer& answer) {
            if (const auto client = self.lock()) client->on_answer(answer);
        };
        executing_ = true;
        while (!input_.empty() && waiting_ < kMaxWaiting && state_ != State::closed) {
            const auto size = std::min(input_.find('\n'), input_.size() - 1) + 1;
            const std::string line = input_.substr(0, size);
            input_.erase(0, size);
            waiting_ += static_cast<std::ptrdiff_t>(reader_.feed(line, reply));
        }
        if (input_.empty() && state_ == State::half_closed)
            waiting_ += static_cast<std::ptrdiff_t>(reader_.end(reply));
        executing_ = false;
        go_on();
    }

    // reader_ may answer before it returns the number of commands; the difference is right afterwards.
    void on_answer(const Answer& answer) {
        --waiting_;
        put(answer.line);
        if (executing_) return;
        if (input_.empty())
            go_on();
        else
            execute_input();
    }

    void go_on() {
        if (state_ == State::open && waiting_ < kMaxWaiting) watch_.want_read();
        if (state_ != State::closed) watch_.want_hang_up();
        if (state_ == State::half_closed && idle() && input_.empty() && unsent_.empty()) close();
    }

    void put(const std::string& text) {
        if (state_ == State::closed) return;
        if (unsent_.size() > kMaxAnswers) return close();
        unsent_ += text;
        send();
    }

    void write() {
        send();
        go_on();
    }

    void send() {
        if (unsent_.empty() || state_ == State::closed) return;
        const auto count = ::send(fd_.get(), unsent_.data(), unsent_.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
        if (count < 0 && errno != EINTR && errno != EAGAIN) return close();
        if (count > 0) unsent_.erase(0, static_cast<std::size_t>(count));
        if (!unsent_.empty()) watch_.want_write();
    }

    // The client sees the end at once; the descriptor is closed with the object.
    void close() {
        if (state_ == State::closed) return;
        state_ = State::closed;
        ::shutdown(fd_.get(), SHUT_RDWR);
        on_closed_();
    }

    os::Descriptor fd_;
    CommandReader reader_;
    std::function<void()> on_closed_;
    line::Watch watch_;
    State state_ = State::open;
    std::string input_;  // not executed yet: at most one read, and the rest of a client that has hung up
    std::string unsent_;
    std::ptrdiff_t waiting_ = 0;  // commands without an answer
    bool executing_ = false;
    Instant last_command_ = line::now();
};

bool is_socket(const std::string& path) {
    struct stat status{};
    return ::lstat(path.c_str(), &status) == 0 && S_ISSOCK(status.st_mode);
}

using Identity = std::pair<dev_t, ino_t>;

/// Of the file itself, also where it is a link; (0, 0): there is none.
Identity identity_of(const std::string& path) {
    struct stat status{};
    return ::lstat(path.c_str(), &status) == 0 ? Identity(status.st_dev, status.st_ino) : Identity();
}

namespace {

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
          identity(identity_of(path)),
          execute(std::move(commands)),
          texts(voice),
          watch(loop, fd, [this] { accept(); }),
          remove_closed(loop, [this](Instant) {
              std::erase_if(clients, [](const auto& client) { return client->closed(); });
          }) {
        watch.want_read();
    }
    ~Impl() {
        clients.clear();
        ::close(fd);
        // Another program may have put its own file there since.
        if (identity_of(path) == identity) ::unlink(path.c_str());
    }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    void accept() {
        const int connection = ::accept4(fd, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
        watch.want_read();
        if (connection < 0) return;
        const auto client = std::make_shared<ControlClient>(loop, connection, execute, texts,
                                                            [this] { remove_closed.set(line::now()); });
        const auto closed = [](const auto& other) { return other->close_if_hung_up(); };
        const auto open = clients.size() - static_cast<std::size_t>(std::ranges::count_if(clients, closed));
        clients.push_back(client);
        if (open < kMaxClients || make_room(*client)) return client->start();
        client->dismiss(
            report::error_line("busy", texts("app.control.full", {{"count", std::to_string(kMaxClients)}})));
    }

    /// Closes the client that has been idle for the longest time. @returns false: none is idle
    bool make_room(const ControlClient& for_client) {
        std::shared_ptr<ControlClient> oldest;
        for (const auto& client : clients) {
            if (client.get() == &for_client || client->closed() || !client->idle()) continue;
            if (!oldest || client->last_command() < oldest->last_command()) oldest = client;
        }
        if (!oldest) return false;
        const auto time = texts.duration(line::now() - oldest->last_command());
        oldest->dismiss(report::error_line("idle", texts("app.control.idle", {{"time", time}})));
        return true;
    }

    line::Loop& loop;
    int fd;
    std::string path;
    Identity identity;
    Execute execute;
    Texts texts;
    std::vector<std::shared_ptr<ControlClient>> clients;  // closed ones until remove_closed
    line::Watch watch;
    line::Timer remove_closed;
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
