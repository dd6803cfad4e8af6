#include "takt/bus/device_probe.hpp"

#include <algorithm>
#include <array>
#include <numeric>

#include "takt/base/assert.hpp"
#include "takt/wire/frame.hpp"

namespace takt::bus {
namespace {

using namespace std::chrono_literals;
using wire::Area;

constexpr std::array kAllAreas{Area::holding_register, Area::input_register, Area::coil,
                               Area::discrete_input};
constexpr int kBusyTries = 20;
constexpr Duration kBusyPause = 100ms;
constexpr int kReconnects = 10;
constexpr Duration kReconnectPause = 500ms;

bool is_busy(int exception) {
    return exception == static_cast<int>(wire::ExceptionCode::acknowledge) ||
           exception == static_cast<int>(wire::ExceptionCode::server_device_busy);
}

/// Every read of a probe can be encoded: 1 to max_items() items within 65536 addresses.
wire::PreparedRequest request_for(wire::Function function, const ProbeRead& read) {
    const auto request = wire::prepare(wire::ReadRequest{function, DataAddress{read.start}, read.quantity});
    TAKT_ASSERT(request.has_value());
    return *request;
}

class DeviceProbe {
public:
    DeviceProbe(const DeviceProbeConfig& config, ProbeConnection& connection,
                const ProbeProgressSink& progress)
        : config_(config), connection_(connection), progress_(progress) {}

    ProbeFindings run() {
        if (!responds()) {
            findings_.stopped = connection_.interrupted();
            if (findings_.stopped) findings_.no_answer.reset();
            return std::move(findings_);
        }
        for (const auto area : kAllAreas) {
            const auto& wanted = config_.areas;
            if (!wanted.empty() && std::ranges::find(wanted, area) == wanted.end()) continue;
            if (findings_.stopped)
                findings_.not_begun.push_back(area);
            else
                probe(area);
        }
        return std::move(findings_);
    }

private:
    bool responds() {
        for (const auto area : kAllAreas) {
            const auto request = request_for(wire::read_function(area), {config_.first, 1});
            const auto response = connection_.transact(request);
            // A device that closes the connection at an item that it does not have is there.
            if (response || response.error().code == Code::closed_by_peer) {
                findings_.no_answer.reset();
                return true;
            }
            findings_.no_answer = response.error();
            if (connection_.interrupted()) return false;
        }
        return false;
    }

    // Repeats the read while the device is busy or the connection is being restored.
    ProbeReply ask(wire::Function function, const ProbeRead& wanted) {
        const auto request = request_for(function, wanted);
        int lost = 0;
        int busy = 0;
        for (;;) {
            const auto response = connection_.transact(request);
            if (connection_.interrupted()) return ProbeReply::stop;
            if (!response) {
                const auto reply = reply_to(response.error());
                if (reply) return *reply;
                if (++lost > kReconnects) {
                    findings_.lost = response.error();
                    return ProbeReply::stop;
                }
                connection_.pause(kReconnectPause);
                continue;
            }
            const int exception = *response;
            if (exception == 0) return ProbeReply::values;
            if (is_busy(exception) && ++busy < kBusyTries) {
                connection_.pause(kBusyPause);
                continue;
            }
            ++findings_.exceptions[exception];
            return reply_to(exception);
        }
    }

    static ProbeReply reply_to(int exception) {
        switch (static_cast<wire::ExceptionCode>(exception)) {
            case wire::ExceptionCode::illegal_function: return ProbeReply::no_function;
            case wire::ExceptionCode::illegal_data_value: return ProbeReply::bad_value;
            case wire::ExceptionCode::server_device_failure: return ProbeReply::failure;
            default: return ProbeReply::refused;
        }
    }

    /// Nothing: the connection failed, and the read is worth another attempt.
    static std::optional<ProbeReply> reply_to(const Error& error) {
        if (error.code == Code::timed_out || error.code == Code::misdirected ||
            error.code == Code::bad_checksum)
            return ProbeReply::silent;
        if (error.code == Code::unexpected_reply || error.code == Code::closed_by_peer)
            return ProbeReply::refused;
        return std::nullopt;
    }

    void probe(Area area) {
        const auto function = wire::read_function(area);
        ProbeConfig config;
        config.first = config_.first;
        config.last = config_.last;
        config.most = static_cast<std::uint16_t>(wire::max_items(wire::Framing::tcp, function));
        config.step = config_.step.value_or(step_within(config_.max_requests, config_.first, config_.last));
        config.max_requests = config_.max_requests;
        ProbeProgress progress{area, 0, 0,
                               std::min(config.max_requests, most_probe_requests(config, 0, 0, 1))};
        auto result = probe_ranges(config, [&](const ProbeRead& read) {
            const auto reply = ask(function, read);
            progress.start = read.start;
            ++progress.asked;
            if (progress_) progress_(progress);
            return reply;
        });
        findings_.stopped = result.end == ProbeEnd::stopped || result.end == ProbeEnd::fell_silent;
        findings_.areas.push_back({area, config.step, {config.first, config.last}, std::move(result)});
    }

    const DeviceProbeConfig& config_;
    ProbeConnection& connection_;
    const ProbeProgressSink& progress_;
    ProbeFindings findings_;
};

std::size_t size_of(const model::ItemRange& range) {
    return std::size_t{range.last} - range.first + 1;
}

std::size_t count_of(const std::vector<model::ItemRange>& ranges) {
    std::size_t count = 0;
    for (const auto& range : ranges) count += size_of(range);
    return count;
}

}  // namespace

std::uint16_t step_within(std::size_t max_requests, std::uint16_t first, std::uint16_t last) {
    constexpr std::size_t kLargestStep = 0x4000;
    const std::size_t addresses = std::size_t{last} - first + 1;
    if (addresses <= max_requests / 2) return 1;
    std::size_t step = 1;
    while (addresses / step > max_requests / 8 && step < kLargestStep) step *= 2;
    return static_cast<std::uint16_t>(step);
}

bool AreaProbe::complete() const {
    return result.end == ProbeEnd::complete || result.end == ProbeEnd::no_function ||
           result.end == ProbeEnd::no_answer;
}

std::size_t AreaProbe::items() const {
    return count_of(result.readable);
}

std::size_t AreaProbe::addresses() const {
    return size_of(searched);
}

std::size_t AreaProbe::tested() const {
    return count_of(result.tested);
}

std::optional<model::ItemRange> AreaProbe::longest_gap() const {
    std::optional<model::ItemRange> longest;
    int next = searched.first;
    const auto end_gap = [&](int end) {
        if (end <= next) return;
        const model::ItemRange gap{static_cast<std::uint16_t>(next), static_cast<std::uint16_t>(end - 1)};
        if (!longest || size_of(gap) > size_of(*longest)) longest = gap;
    };
    for (const auto& range : result.tested) {
        end_gap(range.first);
        next = range.last + 1;
    }
    end_gap(searched.last + 1);
    return longest;
}

bool ProbeFindings::complete() const {
    return !stopped && std::ranges::all_of(areas, &AreaProbe::complete);
}

std::size_t ProbeFindings::requests() const {
    return std::accumulate(areas.begin(), areas.end(), std::size_t{0},
                           [](std::size_t sum, const AreaProbe& area) { return sum + area.result.requests; });
}

bool ProbeFindings::any_readable() const {
    return std::ranges::any_of(areas, [](const AreaProbe& area) { return !area.result.readable.empty(); });
}

std::optional<std::uint16_t> ProbeFindings::longest_register_read() const {
    std::uint16_t limit = 0;  // 0: none was found
    for (const auto& [area, step, searched, result] : areas)
        if (!is_bit_area(area) && result.limited)
            limit = limit == 0 ? result.longest : std::min(limit, result.longest);
    return limit > 1 ? std::optional(limit) : std::nullopt;
}

bool ProbeFindings::one_register_only() const {
    return std::ranges::any_of(areas, [](const AreaProbe& area) {
        return !is_bit_area(area.area) && area.result.limited && area.result.longest == 1;
    });
}

ProbeFindings probe_device(const DeviceProbeConfig& config, ProbeConnection& connection,
                           const ProbeProgressSink& progress) {
    return DeviceProbe(config, connection, progress).run();
}

}  // namespace takt::bus
