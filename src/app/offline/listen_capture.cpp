#include <algorithm>
#include <deque>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "offline/capture_input.hpp"
#include "offline/listen_output.hpp"
#include "output.hpp"
#include "stoppable_input.hpp"
#include "takt/capture/capture_reader.hpp"
#include "takt/capture/line_listener.hpp"
#include "takt/capture/serial_packet.hpp"
#include "takt/line/loop.hpp"
#include "takt/report/times/history_time.hpp"
#include "takt/report/times/latency_report.hpp"

namespace takt::app {
namespace {

constexpr std::size_t kMostLines = 64;

/// The name of the line of a packet: that of its interface, or its number. Sections and rotated files number
/// their interfaces from 0, and Takt writes two interfaces for a line: the name is the same.
std::string line_name(const capture::Packet& packet) {
    return packet.interface_name.empty() ? std::to_string(packet.interface)
                                         : std::string(packet.interface_name);
}

/// A line of a capture.
struct HeardLine {
    HeardLine(ListenOutput::CapturedLine captured, Duration timeout, ListenOutput& output)
        : line(std::move(captured)), listener({.timeout = timeout}, output) {}

    void take(const capture::Packet& packet, const capture::SerialPacket& serial) {
        last = std::max(last, Instant(Duration(packet.time_ns)));
        if (serial.kind() == capture::SerialPacket::Kind::damaged)
            return listener.on_captured_damage(last, serial.bytes());
        is_ascii = is_ascii || serial.bytes()[0] == ':';
        listener.on_captured(last, serial.bytes(), serial.sender());
    }

    [[nodiscard]] model::Line connection() const {
        model::Line connection{.port = "/dev/ttyUSB0"};
        if (!is_ascii) return connection;
        connection.framing = wire::Framing::ascii;
        connection.format.data_bits = 7;
        return connection;
    }

    ListenOutput::CapturedLine line;
    capture::LineListener listener;
    bool is_ascii = false;
    Instant last = Instant::min();
};

class ListenCapture final : private capture::PacketSink {
public:
    ListenCapture(const Texts& texts, const ListenOptions& options)
        : texts_(texts),
          options_(options),
          name_(std::filesystem::path(options.port).filename().string()),
          output_(texts, options, name_,
                  [](Instant t) { return report::local_time_text(t.time_since_epoch().count()); }),
          reader_(*this) {}

    ExitCode run() {
        if (!output_.prepare()) return ExitCode::usage;
        const auto read =
            read_capture(options_.port, reader_, [this](const report::Done& done) { show_progress(done); });
        if (!read) return ended_by(texts_, read.error());
        output_.progress().clear();
        if (reader_.error()) print_error(report::capture_error_text(texts_, options_.port, *reader_.error()));
        if (reader_.error() && reader_.packets() == 0) return ExitCode::usage;
        const auto code = lines_.empty() ? no_frames() : finish();
        const bool whole = !reader_.error() && !StoppableInput::stopped();
        return code == ExitCode::ok && !whole ? ExitCode::partly : code;
    }

private:
    void show_progress(const report::Done& done) {
        std::uint64_t requests = 0;
        std::uint64_t damaged = 0;
        for (const auto& line : lines_) {
            requests += line.listener.statistics().counts().requests;
            damaged += line.listener.statistics().counts().damaged;
        }
        const auto connection = lines_.empty() ? model::Line() : lines_.front().connection();
        output_.progress().show(
            line::now(), done,
            texts_("app.listen.progress", {{"port", name_},
                                           {"setting", report::line_setting_text(connection, false)},
                                           {"requests", std::to_string(requests)},
                                           {"damaged", std::to_string(damaged)}}));
    }

    void on_packet(const capture::Packet& packet) override {
        const capture::SerialPacket serial(packet);
        const auto kind = packet.timed ? serial.kind() : capture::SerialPacket::Kind::none;
        auto* const line = kind == capture::SerialPacket::Kind::none ? nullptr : line_of(packet, kind);
        if (!line) {
            if (kind == capture::SerialPacket::Kind::damaged) damaged_bytes_ += serial.bytes().size();
            ++left_out_;
            return;
        }
        output_.use_line(line->line, lines_.size() > 1);
        line->take(packet, serial);
    }

    /// A frame begins a line. nullptr: none.
    HeardLine* line_of(const capture::Packet& packet, capture::SerialPacket::Kind kind) {
        const auto name = line_name(packet);
        const auto known = std::ranges::find(lines_, name, [](const auto& line) { return line.line.name; });
        if (known != lines_.end()) return &*known;
        if (kind != capture::SerialPacket::Kind::frame || lines_.size() == kMostLines) return nullptr;
        return &lines_.emplace_back(output_.line_of(name), options_.timeout, output_);
    }

    ExitCode finish() {
        std::vector<report::ListenRun> runs;
        for (auto& line : lines_) {
            output_.use_line(line.line, lines_.size() > 1);
            line.listener.end();
            runs.push_back({.port = name_,
                            .connection = line.connection(),
                            .has_settings = false,
                            .statistics = line.listener.statistics(),
                            .names = line.line.names,
                            .line = line.line.name,
                            .one_of_several = lines_.size() > 1});
        }
        if (left_out_ > 0)
            print_status(texts_("app.listen.other_interfaces",
                                {{"file", name_}, {"count", std::to_string(left_out_)}}) +
                         '\n');
        return output_.finish(runs);
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
    capture::CaptureReader reader_;
    std::deque<HeardLine> lines_;      // in the order of their first frames
    std::uint64_t left_out_ = 0;       // packets
    std::uint64_t damaged_bytes_ = 0;  // before the first frame of their line
};

}  // namespace

ExitCode listen_to_capture(const Texts& texts, const ListenOptions& options) {
    return ListenCapture(texts, options).run();
}

}  // namespace takt::app
