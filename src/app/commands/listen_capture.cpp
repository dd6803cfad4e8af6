#include "commands/listen_capture.hpp"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>

#include "capture_input.hpp"
#include "commands/listen_output.hpp"
#include "output.hpp"
#include "stoppable_input.hpp"
#include "takt/capture/capture_reader.hpp"
#include "takt/capture/serial_packet.hpp"
#include "takt/line/loop.hpp"
#include "takt/listen/line_listener.hpp"
#include "takt/report/history_time.hpp"
#include "takt/report/latency_report.hpp"

namespace takt::app {
namespace {

/// A line of a capture. Sections and rotated files number their interfaces from 0, and Takt writes two
/// interfaces for a line: the name is the same.
struct CapturedLine {
    std::string name;
    std::uint32_t interface = 0;

    [[nodiscard]] bool has(const capture::Packet& packet) const {
        return name.empty() ? packet.interface == interface : packet.interface_name == name;
    }
};

class ListenCapture final : private capture::PacketSink {
public:
    ListenCapture(const Texts& texts, const ListenOptions& options)
        : texts_(texts),
          options_(options),
          name_(std::filesystem::path(options.port).filename().string()),
          output_(texts, options, name_,
                  [](Instant t) { return report::local_time_text(t.time_since_epoch().count()); }),
          listener_({.timeout = options.timeout}, output_),
          reader_(*this) {}

    ExitCode run() {
        if (!output_.prepare()) return ExitCode::usage;
        const auto read =
            read_capture(options_.port, reader_, [this](const report::Done& done) { show_progress(done); });
        if (!read) return ended_by(texts_, read.error());
        output_.progress().clear();
        if (reader_.error()) print_error(report::capture_error_text(texts_, options_.port, *reader_.error()));
        if (reader_.error() && reader_.packets() == 0) return ExitCode::usage;
        const auto code = line_ ? finish() : no_frames();
        const bool whole = !reader_.error() && !StoppableInput::stopped();
        return code == ExitCode::ok && !whole ? ExitCode::partly : code;
    }

private:
    void show_progress(const report::Done& done) {
        const auto& counts = listener_.statistics().counts();
        output_.progress().show(
            line::now(), done,
            texts_("app.listen.progress", {{"port", name_},
                                           {"setting", report::line_setting_text(connection(), false)},
                                           {"requests", std::to_string(counts.requests)},
                                           {"damaged", std::to_string(counts.damaged)}}));
    }

    void on_packet(const capture::Packet& packet) override {
        const capture::SerialPacket serial(packet);
        const auto kind = packet.timed ? serial.kind() : capture::SerialPacket::Kind::none;
        if (!line_ && kind == capture::SerialPacket::Kind::frame) choose(packet);
        if (!line_ && kind == capture::SerialPacket::Kind::damaged) damaged_bytes_ += serial.bytes().size();
        if (!line_ || !line_->has(packet) || kind == capture::SerialPacket::Kind::none) {
            ++left_out_;
            return;
        }
        last_ = std::max(last_, Instant(Duration(packet.time_ns)));
        if (kind == capture::SerialPacket::Kind::damaged)
            return listener_.on_captured_damage(last_, serial.bytes());
        is_ascii_ = is_ascii_ || serial.bytes()[0] == ':';
        listener_.on_captured(last_, serial.bytes(), serial.sender());
    }

    void choose(const capture::Packet& packet) {
        line_.emplace(std::string(packet.interface_name), packet.interface);
        output_.use_line(line_->name);
    }

    [[nodiscard]] model::Line connection() const {
        model::Line connection{.port = "/dev/ttyUSB0"};
        if (!is_ascii_) return connection;
        connection.framing = wire::Framing::ascii;
        connection.format.data_bits = 7;
        return connection;
    }

    ExitCode finish() {
        listener_.end();
        if (left_out_ > 0)
            print_status(texts_("app.listen.other_interfaces",
                                {{"file", name_}, {"count", std::to_string(left_out_)}}) +
                         '\n');
        return output_.finish(listener_.statistics(), connection(), false, 0);
    }

    [[nodiscard]] ExitCode no_frames() const {
        print_error(texts_(damaged_bytes_ > 0 ? "app.listen.capture_damaged" : "app.listen.capture_no_serial",
                           {{"file", options_.port},
                            {"packets", std::to_string(reader_.packets())},
                            {"bytes", std::to_string(damaged_bytes_)}}));
        return damaged_bytes_ > 0 ? ExitCode::bad_frame : ExitCode::no;
    }

    Texts texts_;
    const ListenOptions& options_;
    std::string name_;
    ListenOutput output_;
    listen::LineListener listener_;
    capture::CaptureReader reader_;
    std::optional<CapturedLine> line_;  // of the first frame
    std::uint64_t left_out_ = 0;        // packets
    std::uint64_t damaged_bytes_ = 0;   // before the first frame
    bool is_ascii_ = false;
    Instant last_ = Instant::min();
};

}  // namespace

ExitCode listen_to_capture(const Texts& texts, const ListenOptions& options) {
    return ListenCapture(texts, options).run();
}

}  // namespace takt::app
