// The traffic log: every frame with its time, line, device, port, direction, length, bytes (specification,
// section 5), and in words.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/console/file_reports.hpp"
#include "takt/console/tap_source.hpp"
#include "takt/host/traffic.hpp"
#include "takt/line/traffic_factory.hpp"
#include "takt/model/project.hpp"
#include "takt/os/record_writer.hpp"
#include "takt/os/sink.hpp"
#include "takt/os/ticker.hpp"
#include "takt/report/drawing/texts.hpp"
#include "takt/text/language.hpp"
#include "takt/wire/frame_words.hpp"
#include "takt/wire/pdu.hpp"
#include "takt/wire/traffic.hpp"

namespace takt::console {

/// A file (or stderr) for the frames of all lines.
class TrafficLog {
public:
    static constexpr std::size_t kFileBytes = 50 << 20;  ///< some 400,000 frames

    static constexpr auto kLanguage = text::Language::english;

    /// @param path        "-": stderr; an existing file is overwritten, unless another program has it locked
    /// @param file_bytes  a file is rotated at this size (os::RotatingFile), with three old ones; > 0. A FIFO
    ///                    or device is not
    /// @returns as os::open_anew()
    [[nodiscard]] static Result<std::unique_ptr<TrafficLog>> open(const std::string& path,
                                                                  FileReports reports = {},
                                                                  std::size_t file_bytes = kFileBytes,
                                                                  text::Language language = kLanguage);
    /// Writes to any sink.
    explicit TrafficLog(std::unique_ptr<os::Sink> sink, text::Language language = kLanguage);
    /// Writes what is left.
    ~TrafficLog();
    TrafficLog(const TrafficLog&) = delete;
    TrafficLog& operator=(const TrafficLog&) = delete;

    /// @param line  without its end; control characters are escaped
    void put(std::string_view line);
    /// Frames were lost before they came here.
    void put_lost(std::uint64_t count);

    /// Of the words.
    [[nodiscard]] const report::Texts& texts() const { return texts_; }

private:
    TrafficLog(std::unique_ptr<os::Sink> sink, std::string path, FileReports reports,
               text::Language language);

    report::Texts texts_;
    std::string path_;  // empty: not a file
    FileReports reports_;
    os::LineWriter output_;
};

/// Writes the frames and the incidents of one line into the log. `Tx` is what this program sent.
class LineTraffic final : public wire::TrafficObserver {
public:
    /// The side whose requests are kept, so that responses are logged with their addresses.
    enum class Side : std::uint8_t { master, slave };

    /// @param line  for its name, port and devices' names; copied
    /// @param log   outlives it
    LineTraffic(TrafficLog& log, const model::Line& line, Side side);

    void on_frame(Instant t, wire::Direction direction, UnitId unit, Bytes pdu, Bytes raw) override;
    void on_fault(Instant t, wire::FrameFault fault, Bytes raw) override;
    void on_incident(Instant t, UnitId unit, wire::Incident incident, Duration after,
                     const std::optional<Mismatch>& instead) override;

private:
    [[nodiscard]] std::string name_of(UnitId unit) const;
    [[nodiscard]] std::string bytes_text(Bytes raw) const;

    TrafficLog& log_;
    std::string line_;
    std::string port_;
    Side side_;
    bool ascii_;
    std::array<std::string, 256> devices_;
    wire::FrameWords words_;
};

/// For engines of one-off commands: frames are formatted on the engine's thread.
/// @param log  outlives the observers; nullptr: the factory is empty
[[nodiscard]] line::TrafficFactory traffic_factory(TrafficLog* log, LineTraffic::Side side);

/// Writes what a tap on a host records: a LineTraffic for each source.
class TapLog {
public:
    /// @param log  outlives it
    explicit TapLog(TrafficLog& log) : log_(log) {}
    void put(const host::TrafficRecord& record, const LineOf& line_of);

private:
    using Key = std::tuple<std::uint32_t, host::TrafficSource::Kind, std::size_t>;  // with the generation
    TrafficLog& log_;
    std::map<Key, LineTraffic> sources_;
};

/// Writes the frames of a tap on a thread of its own.
class TapLogger {
public:
    /// @param log  outlives it
    TapLogger(TrafficLog& log, TapSource source);
    /// Writes what the source still has.
    ~TapLogger() = default;

private:
    void turn();

    TrafficLog& log_;
    TapSource source_;
    TapLog tap_;
    std::uint64_t missed_ = 0;  // of the source, up to now
    os::Ticker ticker_;         // last: it uses the other members
};

}  // namespace takt::console
