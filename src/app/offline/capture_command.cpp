// takt capture: a serial line that is overheard, or the packets of a network interface.
#include "commands.hpp"

#include <algorithm>
#include <cerrno>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "offline/interface_packets.hpp"
#include "output.hpp"
#include "progress.hpp"
#include "takt/capture/pcapng_writer.hpp"
#include "takt/capture/serial_pairing.hpp"
#include "takt/console/capture_log.hpp"
#include "takt/line/driver.hpp"
#include "takt/line/serial_port.hpp"
#include "takt/os/packet_socket.hpp"
#include "takt/report/times/latency_report.hpp"
#include "takt/wire/framer.hpp"
#include "texts.hpp"
#include "work_loop.hpp"

namespace takt::app {
namespace {

constexpr Duration kFlushInterval = std::chrono::milliseconds(200);  // of packets to their file
constexpr Duration kTimeout = std::chrono::seconds(1);               // a repeated write after it is a request
/// Adapters deliver late: a pause inside a frame that is no end of it.
constexpr Duration kPause = std::chrono::milliseconds(20);

/// Takes the frames of both directions of a line and sends nothing.
class Overhearing final : public Engine {
public:
    /// @param on_link  called when the port is opened and when it is lost
    Overhearing(const model::Line& line, wire::TrafficObserver& observer, std::function<void(bool)> on_link)
        : observer_(observer), framer_(config_of(line)), pairing_(kTimeout), on_link_(std::move(on_link)) {}

    void on_link(Instant, bool up) override {
        framer_.reset();
        on_link_(up);
    }
    void on_bytes(Instant t, Bytes bytes) override {
        while (!bytes.empty()) {
            const auto step = framer_.push(t, bytes);
            bytes = bytes.subspan(step.consumed);
            settle(t, step);
        }
    }
    void on_tick(Instant t) override { settle(t, framer_.on_tick(t)); }
    [[nodiscard]] Bytes transmit(Instant) override { return {}; }
    [[nodiscard]] Instant next_wakeup() const override { return framer_.next_wakeup(); }
    [[nodiscard]] std::uint64_t frames() const { return frames_; }

private:
    static wire::FramerConfig config_of(const model::Line& line) {
        wire::FramerConfig config{.framing = line.framing, .side = wire::Side::slave};
        config.silence = std::max(kPause, wire::t3_5(line.format));
        return config;
    }

    // Of an overheard line a request counts as received, and a response as sent.
    void settle(Instant t, const wire::FramerStep& step) {
        if (step.complete) {
            const auto frame = framer_.frame();
            const auto role =
                pairing_.on_frame(t.time_since_epoch().count(), frame.unit.value, frame.pdu).role;
            const bool response =
                role == capture::SerialPairing::Role::response || role == capture::SerialPairing::Role::stray;
            observer_.on_frame(t, response ? wire::Direction::sent : wire::Direction::received, frame.unit,
                               frame.pdu, framer_.raw());
            ++frames_;
            framer_.expect_more();
        } else if (step.fault != wire::FrameFault::none) {
            observer_.on_fault(t, step.fault, framer_.dropped());
        }
    }

    wire::TrafficObserver& observer_;
    wire::StandaloneFramer framer_;
    capture::SerialPairing pairing_;
    std::function<void(bool)> on_link_;
    std::uint64_t frames_ = 0;
};

class SerialCapture {
public:
    SerialCapture(const Texts& texts, const CaptureOptions& options) : texts_(texts), options_(options) {}

    Result<void> run() {
        TAKT_CHECK(work_loop_.begin());
        TAKT_TRY(const auto target, line::parse_target(options_.target));
        auto line = target.as_line();
        line.rs485 = model::Rs485::none;  // the driver stays off
        host::TrafficTap tap;
        const auto observer = tap.factory()(line);
        Overhearing overhearing(line, *observer, [&](bool up) { note_link(line.port, up); });
        auto source = console::tap_source(tap);
        source.overheard = true;
        // The port comes first: a capture of before is not overwritten if it cannot be opened.
        TAKT_TRY(const auto driver, line::open_line(work_loop_.loop(), line, overhearing));
        TAKT_TRY(auto file, console::CaptureFile::open(options_.file));
        const console::CaptureLog log(std::move(file), std::move(source), file_reports(texts_));
        print_status(texts_("app.latency.listening", {{"interface", driver->name()}}) + '\n');
        work_loop_.work(options_.run_for);
        frames_ = overhearing.frames();
        if (lost_) return fail(Code::connection_lost, line.port);
        return {};
    }

    [[nodiscard]] std::uint64_t frames() const { return frames_; }

private:
    // The driver opens a lost port again, as for every line.
    void note_link(const std::string& port, bool up) {
        if (up && lost_) print_status(texts_("app.latency.listening", {{"interface", port}}) + '\n');
        if (!up && !lost_) print_status(texts_("app.capture.lost", {{"port", port}}) + '\n');
        lost_ = !up;
    }

    Texts texts_;
    const CaptureOptions& options_;
    WorkLoop work_loop_;
    std::uint64_t frames_ = 0;
    bool lost_ = false;
};

/// The kernel keeps packets while the disk is slow, so one thread reads and writes.
class InterfaceCapture {
public:
    InterfaceCapture(const Texts& texts, const CaptureOptions& options) : texts_(texts), options_(options) {}

    Result<void> run() {
        TAKT_TRY(auto socket, os::PacketSocket::open(options_.interface));
        TAKT_TRY(auto file, console::CaptureFile::open(options_.file));
        TAKT_CHECK(begin_file(file, 0));
        const Instant start = line::now();
        Instant flushed = start;
        const auto on_read = [&]() -> Result<bool> {
            const Instant now = line::now();
            if (blocks_.size() >= kChunk || now - flushed >= kFlushInterval) {
                TAKT_CHECK(flush(file, socket));
                flushed = now;
            }
            return !options_.run_for || now - start < *options_.run_for;
        };
        TAKT_CHECK(
            read_packets(texts_, options_.interface, socket, kFlushInterval,
                         {.on_packet = [this](const auto& packet) { add(packet); }, .on_read = on_read}));
        TAKT_CHECK(flush(file, socket));
        TAKT_CHECK(end_file(file, socket.dropped()));
        report_dropped(socket.dropped());
        return {};
    }

    [[nodiscard]] std::uint64_t frames() const { return packets_; }

private:
    static constexpr std::size_t kChunk = 8 << 10;  // bytes of one write

    /// @param dropped  up to now
    Result<void> begin_file(console::CaptureFile& file, std::uint64_t dropped) {
        in_file_ = 0;
        dropped_before_ = dropped;
        std::string head;
        capture::append_section(head);
        capture::append_interface(head, capture::LinkType::raw, options_.interface);
        return file.write(head);
    }
    /// Writes the statistics of the file.
    Result<void> end_file(console::CaptureFile& file, std::uint64_t dropped) const {
        const auto lost = dropped - dropped_before_;
        std::string statistics;
        capture::append_statistics(statistics,
                                   {.time_ns = last_ns_, .received = in_file_ + lost, .dropped = lost});
        return file.write(statistics);
    }
    void report_dropped(std::uint64_t count) const {
        if (count == 0) return;
        print_error(
            texts_("app.capture.dropped", {{"interface", options_.interface},
                                           {"count", report::grouped_number(count, texts_.language())},
                                           {"file", options_.file.path}}));
    }
    void add(const os::ReceivedPacket& packet) {
        ++packets_;
        ++waiting_;
        last_ns_ = packet.time_ns;
        capture::append_packet(
            blocks_, {.time_ns = packet.time_ns,
                      .data = {reinterpret_cast<const char*>(packet.data.data()), packet.data.size()},
                      .original_length = packet.length});
    }
    // Packets that are larger than a file have one of their own. A file that cannot be rotated goes on with
    // another section.
    Result<void> flush(console::CaptureFile& file, os::PacketSocket& socket) {
        if (in_file_ > 0 && file.is_full(blocks_.size())) {
            const auto dropped = socket.dropped();
            TAKT_CHECK(end_file(file, dropped));
            const auto rotated = file.rotate();
            const bool failed_before = std::exchange(rotation_failed_, !rotated);
            if (!rotated && !failed_before) file_reports(texts_).on_not_rotated(rotated.error());
            TAKT_CHECK(begin_file(file, dropped));
        }
        TAKT_CHECK(file.write(blocks_));
        blocks_.clear();
        in_file_ += std::exchange(waiting_, 0);
        return {};
    }

    Texts texts_;
    const CaptureOptions& options_;
    std::string blocks_;         // not written yet
    std::uint64_t waiting_ = 0;  // packets of blocks_
    std::uint64_t in_file_ = 0;  // packets written since the file began
    std::uint64_t packets_ = 0;
    std::uint64_t dropped_before_ = 0;  // the file began
    std::int64_t last_ns_ = 0;          // of the last packet
    bool rotation_failed_ = false;      // the last one
};

void print_done(const Texts& texts, const CaptureOptions& options, std::uint64_t frames) {
    print_status(texts("app.capture.done", {{"file", options.file.path},
                                            {"count", report::grouped_number(frames, texts.language())}}) +
                 '\n');
}

template <class Source>
ExitCode record(const Texts& texts, const CaptureOptions& options) {
    Source source(texts, options);
    if (const auto recorded = source.run(); !recorded) {
        const auto& error = recorded.error();
        if (source.frames() > 0) print_done(texts, options, source.frames());
        const auto code = ended_by(texts, error);
        if (error.code == Code::cannot_open && error.numbers[0] == EPERM && !options.interface.empty())
            print_status("    " + texts("app.latency.rights") + '\n');
        return code;
    }
    print_done(texts, options, source.frames());
    return ExitCode::ok;
}

}  // namespace

ExitCode capture(const CommonOptions& common, const CaptureOptions& given) {
    const Texts texts(common.language);
    auto options = given;
    if (options.file.path == "-") options.file.path = "/dev/stdout";
    return options.interface.empty() ? record<SerialCapture>(texts, options)
                                     : record<InterfaceCapture>(texts, options);
}

}  // namespace takt::app
