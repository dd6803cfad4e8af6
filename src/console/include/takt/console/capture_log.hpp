// The capture of a running program: the frames of its lines and endpoints as pcapng files.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/console/capture_file.hpp"
#include "takt/console/file_reports.hpp"
#include "takt/console/tap_source.hpp"
#include "takt/host/traffic.hpp"
#include "takt/os/ticker.hpp"
#include "takt/report/times/traffic_capture.hpp"

namespace takt::console {

/// Writes a capture on a thread of its own, in the order of the frames' times: a serial line knows the time
/// of a frame before or after it is recorded. Frames that the thread or the disk could not take are lost; the
/// capture has their number as a comment of the next packet and in its interface statistics.
class CaptureLog {
public:
    CaptureLog(CaptureFile file, TapSource source, FileReports reports);
    /// Writes what the source still has, and the end of the file.
    ~CaptureLog();
    CaptureLog(const CaptureLog&) = delete;
    CaptureLog& operator=(const CaptureLog&) = delete;

private:
    void turn(bool ending);
    void take_all();
    void add(const host::TrafficRecord& record);
    void add_settled(Instant until);
    void flush();
    void rotate();
    void note(const Error& error);

    TapSource source_;
    FileReports reports_;
    CaptureFile file_;  // of the thread, as all up to error_
    report::TrafficCapture capture_;
    std::vector<host::TrafficRecord> pending_;  // an earlier frame may still come before them
    std::int64_t offset_ns_ = 0;                // of the wall clock
    std::string blocks_;                        // not written yet
    std::uint64_t frames_ = 0;                  // in blocks_
    std::uint64_t in_file_ = 0;                 // frames in the current file, with those in blocks_
    std::uint64_t missed_ = 0;                  // of the source, up to now
    std::int64_t last_ns_ = 0;                  // of the last frame
    int error_ = 0;                             // of the first write that failed
    bool failing_ = false;                      // no frame was written since a write failed
    bool rotation_failed_ = false;              // the last one
    std::optional<os::Ticker> ticker_;
};

}  // namespace takt::console
