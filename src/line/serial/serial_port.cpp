// Serial ports through termios2 (asm/termbits.h), which accepts any bit rate. <termios.h> defines conflicting
// names, so none of its functions can be used here.
//
// A port is opened with two locks: flock() excludes other well-behaved programs, TIOCEXCL excludes further
// open() calls. At the end the original termios, RS-485 and low-latency settings are restored, but no echo.
#include "takt/line/serial_port.hpp"

#include <asm/termbits.h>
#include <fcntl.h>
#include <linux/serial.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <ctime>
#include <utility>

#include "loop/marked_input.hpp"
#include "serial/receive_trigger.hpp"
#include "takt/os/descriptor.hpp"

namespace takt::line {
namespace {

using model::Rs485;
using wire::Parity;

struct StandardBaud {
    std::uint32_t baud;
    tcflag_t flag;
};
constexpr std::array kStandardBauds{
    StandardBaud{50, B50},           StandardBaud{75, B75},           StandardBaud{110, B110},
    StandardBaud{134, B134},         StandardBaud{150, B150},         StandardBaud{200, B200},
    StandardBaud{300, B300},         StandardBaud{600, B600},         StandardBaud{1200, B1200},
    StandardBaud{1800, B1800},       StandardBaud{2400, B2400},       StandardBaud{4800, B4800},
    StandardBaud{9600, B9600},       StandardBaud{19200, B19200},     StandardBaud{38400, B38400},
    StandardBaud{57600, B57600},     StandardBaud{115200, B115200},   StandardBaud{230400, B230400},
    StandardBaud{460800, B460800},   StandardBaud{500000, B500000},   StandardBaud{576000, B576000},
    StandardBaud{921600, B921600},   StandardBaud{1000000, B1000000}, StandardBaud{1152000, B1152000},
    StandardBaud{1500000, B1500000}, StandardBaud{2000000, B2000000}, StandardBaud{2500000, B2500000},
    StandardBaud{3000000, B3000000}, StandardBaud{3500000, B3500000}, StandardBaud{4000000, B4000000},
};

tcflag_t baud_flag(std::uint32_t baud) {
    const auto standard = std::ranges::find(kStandardBauds, baud, &StandardBaud::baud);
    return standard != kStandardBauds.end() ? standard->flag : tcflag_t{BOTHER};
}

tcflag_t size_flag(int data_bits) {
    switch (data_bits) {
        case 5: return CS5;
        case 6: return CS6;
        case 7: return CS7;
        default: return CS8;
    }
}

// Raw mode (termios(3), noncanonical). PARMRK marks faulty characters in the input; MarkedInput decodes the
// marks. The port is non-blocking. With VMIN = 1 an empty port gives EAGAIN and a hung-up port gives 0.
termios2 raw_mode(const termios2& original, const wire::CharacterFormat& format) {
    termios2 settings = original;
    settings.c_iflag = INPCK | PARMRK;
    settings.c_oflag = 0;
    settings.c_lflag = 0;
    settings.c_cflag = CREAD | CLOCAL | size_flag(format.data_bits) | baud_flag(format.baud);
    if (format.parity != Parity::none) settings.c_cflag |= PARENB;
    if (format.parity == Parity::odd) settings.c_cflag |= PARODD;
    if (format.stop_bits == 2) settings.c_cflag |= CSTOPB;
    settings.c_ispeed = settings.c_ospeed = format.baud;
    settings.c_cc[VMIN] = 1;
    settings.c_cc[VTIME] = 0;
    return settings;
}

bool is_pseudo_terminal_device(const struct stat& status) {
    constexpr unsigned kFirstMajor = 136;  // Unix98 pseudo-terminals (Documentation/admin-guide/devices.txt)
    constexpr unsigned kLastMajor = 143;
    return S_ISCHR(status.st_mode) && major(status.st_rdev) >= kFirstMajor &&
           major(status.st_rdev) <= kLastMajor;
}

Result<void> check_ranges(const wire::CharacterFormat& format) {
    if (format.baud < 50 || format.baud > 4'000'000)
        return fail(Code::out_of_range, "baud", format.baud, 50, 4'000'000);
    if (format.data_bits < 5 || format.data_bits > 8)
        return fail(Code::out_of_range, "data_bits", format.data_bits, 5, 8);
    if (format.stop_bits < 1 || format.stop_bits > 2)
        return fail(Code::out_of_range, "stop_bits", format.stop_bits, 1, 2);
    return {};
}

std::unexpected<Error> cannot_open(const std::string& path) {
    return fail(Code::cannot_open, path, errno);
}

Result<os::Descriptor> open_locked(const std::string& path, bool read_only) {
    const int access = read_only ? O_RDONLY : O_RDWR;
    os::Descriptor fd(::open(path.c_str(), access | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
    if (!fd && errno == EBUSY) return fail(Code::busy, path);
    if (!fd) return cannot_open(path);
    termios2 probe{};
    if (::ioctl(fd.get(), TCGETS2, &probe) != 0) return cannot_open(path);
    if (::flock(fd.get(), LOCK_EX | LOCK_NB) != 0) return fail(Code::busy, path);
    if (::ioctl(fd.get(), TIOCEXCL) != 0) return cannot_open(path);
    return fd;
}

// A driver does not report an unsupported setting. It silently keeps or substitutes another one, so the
// settings are read back. A bit rate may differ by at most 2 %.
Result<void> check_taken(int fd, const std::string& path, const wire::CharacterFormat& format,
                         const termios2& wanted) {
    termios2 got{};
    if (::ioctl(fd, TCGETS2, &got) != 0) return cannot_open(path);
    const auto differs = [&](tcflag_t mask) { return ((got.c_cflag ^ wanted.c_cflag) & mask) != 0; };
    const auto refuse = [&](std::string_view what, unsigned value) {
        return fail(Code::unsupported, path + " " + std::string(what) + "=" + std::to_string(value));
    };
    const std::uint32_t deviation =
        got.c_ospeed > wanted.c_ospeed ? got.c_ospeed - wanted.c_ospeed : wanted.c_ospeed - got.c_ospeed;
    if (deviation > wanted.c_ospeed / 50) return refuse("baud", wanted.c_ospeed);
    if (differs(PARENB | PARODD))
        return fail(Code::unsupported, path + (format.parity == Parity::even  ? " parity=even"
                                               : format.parity == Parity::odd ? " parity=odd"
                                                                              : " parity=none"));
    if (differs(CSTOPB)) return refuse("stop_bits", format.stop_bits);
    if (differs(CSIZE)) return refuse("data_bits", format.data_bits);
    return {};
}

}  // namespace

struct SerialPort::Impl {
    os::Descriptor fd;
    std::string path;
    termios2 original{};
    bool configured = false;
    bool pseudo = false;
    std::optional<serial_rs485> original_rs485;
    std::optional<serial_struct> original_serial;
    Rs485 mode = Rs485::none;
    bool sending = false;  // RTS mode
    std::optional<SerialLatency> latency;
    std::optional<unsigned> original_trigger;
    MarkedInput input;

    ~Impl();
    Result<void> configure(const SerialSettings& settings);
    Result<void> apply(const wire::CharacterFormat& format);
    bool enable_kernel_rs485();
    Result<void> configure_rs485(const SerialSettings& settings);
    [[nodiscard]] int ask_low_latency();
    [[nodiscard]] unsigned lower_receive_trigger();
    void set_sending(bool on);
    std::optional<bool> transmitter_empty() const;
    void wait_sent() const;
};

SerialPort::Impl::~Impl() {
    if (!fd) return;
    if (configured) {
        wait_sent();
        set_sending(false);
        if (original_rs485) ::ioctl(fd.get(), TIOCSRS485, &*original_rs485);
        if (original_serial) ::ioctl(fd.get(), TIOCSSERIAL, &*original_serial);
        if (original_trigger) (void)ReceiveTrigger(path).set(*original_trigger);
        if (!pseudo) original.c_lflag &= ~static_cast<tcflag_t>(ECHO | ECHONL);
        ::ioctl(fd.get(), TCSETS2, &original);
    }
    ::ioctl(fd.get(), TIOCNXCL);
    ::flock(fd.get(), LOCK_UN);
}

// tcdrain() can block for ever (a stuck adapter). The queue is polled instead, for at most 0.3 s; then the
// rest is discarded.
void SerialPort::Impl::wait_sent() const {
    for (int attempt = 0; attempt < 300; ++attempt) {
        int queued = 0;
        if (::ioctl(fd.get(), TIOCOUTQ, &queued) != 0) return;
        if (queued == 0 && transmitter_empty().value_or(true)) return;
        const timespec pause{0, 1'000'000};
        ::nanosleep(&pause, nullptr);
    }
    ::ioctl(fd.get(), TCFLSH, TCOFLUSH);
}

std::optional<bool> SerialPort::Impl::transmitter_empty() const {
    unsigned status = 0;
    if (::ioctl(fd.get(), TIOCSERGETLSR, &status) == 0) return (status & TIOCSER_TEMT) != 0;
    int queued = 0;
    if (::ioctl(fd.get(), TIOCOUTQ, &queued) == 0 && queued > 0) return false;
    return std::nullopt;
}

Result<void> SerialPort::Impl::configure(const SerialSettings& settings) {
    if (::ioctl(fd.get(), TCGETS2, &original) != 0) return cannot_open(path);
    struct stat status{};
    pseudo = ::fstat(fd.get(), &status) == 0 && is_pseudo_terminal_device(status);
    TAKT_CHECK(apply(settings.format));
    TAKT_CHECK(configure_rs485(settings));
    if (settings.low_latency && !pseudo) latency = {ask_low_latency(), lower_receive_trigger()};
    ::ioctl(fd.get(), TCFLSH, TCIFLUSH);
    return {};
}

Result<void> SerialPort::Impl::apply(const wire::CharacterFormat& format) {
    const termios2 wanted = raw_mode(original, format);
    if (::ioctl(fd.get(), TCSETS2, &wanted) != 0) return cannot_open(path);
    configured = true;
    return pseudo ? Result<void>() : check_taken(fd.get(), path, format, wanted);
}

bool SerialPort::Impl::enable_kernel_rs485() {
    serial_rs485 config{};
    if (::ioctl(fd.get(), TIOCGRS485, &config) != 0) return false;
    const serial_rs485 before = config;
    config.flags |= SER_RS485_ENABLED | SER_RS485_RTS_ON_SEND;
    config.flags &= ~static_cast<decltype(config.flags)>(SER_RS485_RTS_AFTER_SEND | SER_RS485_RX_DURING_TX);
    if (::ioctl(fd.get(), TIOCSRS485, &config) != 0) return false;
    original_rs485 = before;
    return true;
}

Result<void> SerialPort::Impl::configure_rs485(const SerialSettings& settings) {
    if (pseudo || settings.rs485 == Rs485::none) return {};
    if (settings.rs485 == Rs485::rts) {
        int rts = TIOCM_RTS;
        if (::ioctl(fd.get(), TIOCMBIC, &rts) != 0) return fail(Code::unsupported, path + " rs485=rts");
        mode = Rs485::rts;
    } else if (enable_kernel_rs485()) {
        mode = Rs485::kernel;
    } else if (settings.rs485 == Rs485::kernel) {
        return fail(Code::unsupported, path + " rs485=kernel");
    }
    return {};
}

// Some drivers (cdc_acm) accept the flag and drop it: it is read back.
int SerialPort::Impl::ask_low_latency() {
    constexpr int kLowLatency = static_cast<int>(ASYNC_LOW_LATENCY);
    serial_struct serial{};
    if (::ioctl(fd.get(), TIOCGSERIAL, &serial) != 0) return errno;
    if ((serial.flags & kLowLatency) != 0) return 0;
    const serial_struct before = serial;
    serial.flags |= kLowLatency;
    if (::ioctl(fd.get(), TIOCSSERIAL, &serial) != 0) return errno;
    original_serial = before;
    if (::ioctl(fd.get(), TIOCGSERIAL, &serial) != 0) return errno;
    return (serial.flags & kLowLatency) != 0 ? 0 : EOPNOTSUPP;
}

unsigned SerialPort::Impl::lower_receive_trigger() {
    const ReceiveTrigger trigger(path);
    const auto before = trigger.characters().value_or(1);
    if (before <= 1 || trigger.set(1) != 0) return before;
    original_trigger = before;
    return trigger.characters().value_or(1);
}

void SerialPort::Impl::set_sending(bool on) {
    if (mode != Rs485::rts || sending == on) return;
    int rts = TIOCM_RTS;
    ::ioctl(fd.get(), on ? TIOCMBIS : TIOCMBIC, &rts);
    sending = on;
}

bool is_pseudo_terminal(const std::string& path) {
    struct stat status{};
    return ::stat(path.c_str(), &status) == 0 && is_pseudo_terminal_device(status);
}

SerialPort::SerialPort(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
SerialPort::~SerialPort() = default;

Result<std::unique_ptr<SerialPort>> SerialPort::open(const SerialSettings& settings) {
    TAKT_CHECK(check_ranges(settings.format));
    TAKT_TRY(os::Descriptor fd, open_locked(settings.path, settings.read_only));
    auto impl = std::make_unique<Impl>();
    impl->fd = std::move(fd);
    impl->path = settings.path;
    TAKT_CHECK(impl->configure(settings));
    return std::unique_ptr<SerialPort>(new SerialPort(std::move(impl)));
}

int SerialPort::fd() const {
    return impl_->fd.get();
}
Rs485 SerialPort::rs485() const {
    return impl_->mode;
}
void SerialPort::set_sending(bool on) {
    impl_->set_sending(on);
}
std::optional<bool> SerialPort::transmitter_empty() const {
    return impl_->transmitter_empty();
}

std::optional<SerialLatency> SerialPort::latency() const {
    return impl_->latency;
}

SerialCounters SerialPort::counters() const {
    return {impl_->input.faulty_characters(), impl_->input.breaks()};
}

Result<std::size_t> SerialPort::read(std::span<std::uint8_t> buffer) {
    const ssize_t got = ::read(impl_->fd.get(), buffer.data(), buffer.size());
    if (got > 0) return impl_->input.decode(buffer.first(static_cast<std::size_t>(got)));
    if (got < 0 && (errno == EAGAIN || errno == EINTR)) return 0;
    return fail(Code::connection_lost, impl_->path, got == 0 ? EIO : errno);
}

Result<std::size_t> SerialPort::read_characters(std::span<wire::Character> characters) {
    std::array<std::uint8_t, 512> bytes;
    const auto room = std::min(bytes.size(), characters.size());
    const ssize_t got = ::read(impl_->fd.get(), bytes.data(), room);
    if (got < 0 && (errno == EAGAIN || errno == EINTR)) return 0;
    if (got <= 0) return fail(Code::connection_lost, impl_->path, got == 0 ? EIO : errno);
    std::size_t count = 0;
    for (const auto byte : std::span(bytes).first(static_cast<std::size_t>(got)))
        if (const auto character = impl_->input.take(byte)) characters[count++] = *character;
    return count;
}

Result<void> SerialPort::set_format(const wire::CharacterFormat& format) {
    TAKT_CHECK(check_ranges(format));
    TAKT_CHECK(impl_->apply(format));
    impl_->input = {};
    ::ioctl(impl_->fd.get(), TCFLSH, TCIFLUSH);
    return {};
}

Result<std::size_t> SerialPort::write(Bytes bytes) {
    set_sending(true);
    const ssize_t taken = ::write(impl_->fd.get(), bytes.data(), bytes.size());
    if (taken >= 0) return static_cast<std::size_t>(taken);
    if (errno == EAGAIN || errno == EINTR) return 0;
    return fail(Code::connection_lost, impl_->path, errno);
}

}  // namespace takt::line
