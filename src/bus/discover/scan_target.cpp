#include "takt/bus/scan_target.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <set>
#include <string>
#include <utility>

#include "takt/model/target_url.hpp"

namespace takt::bus {
namespace {

using namespace std::chrono_literals;
using wire::Parity;

constexpr Duration kSerialWait = 100ms;
constexpr Duration kNetworkWait = 1s;
constexpr Duration kLeastRetryWait = 500ms;
constexpr std::uint32_t kLastSerialUnit = 247;
constexpr std::array<std::uint32_t, 3> kUnitsOfHost{1, 0, 255};

struct BaudWeight {
    std::uint32_t baud;
    double weight;
};

// How often devices use each bit rate, estimated from their manuals. The first kUsualBauds are tried unasked.
constexpr std::array kBauds{BaudWeight{9600, 10},  BaudWeight{19200, 7}, BaudWeight{115200, 6},
                            BaudWeight{38400, 3},  BaudWeight{57600, 3}, BaudWeight{4800, 2},
                            BaudWeight{2400, 1.5}, BaudWeight{1200, 1}};
constexpr double kOtherBaudWeight = 0.5;
constexpr std::size_t kUsualBauds = 5;

double likelihood(const wire::CharacterFormat& format) {
    const auto* const known = std::ranges::find(kBauds, format.baud, &BaudWeight::baud);
    double weight = known == kBauds.end() ? kOtherBaudWeight : known->weight;
    weight *= format.parity == Parity::none ? 3 : format.parity == Parity::even ? 2 : 0.4;
    // The default of "MODBUS over serial line" V1.02, section 2.5.1.
    if (format.baud == 19200 && format.parity == Parity::even) weight *= 3;
    const std::uint8_t usual_stop_bits = format.data_bits == 7 && format.parity == Parity::none ? 2 : 1;
    return format.stop_bits == usual_stop_bits ? weight : weight * 0.2;
}

std::vector<std::uint32_t> usual_bauds() {
    std::vector<std::uint32_t> bauds;
    for (std::size_t i = 0; i < kUsualBauds; ++i) bauds.push_back(kBauds[i].baud);
    return bauds;
}

/// The choices that hold for one port: the list of the user, else the value in the URL, else the usual ones.
template <class T>
std::vector<T> chosen(const std::vector<T>& listed, bool in_url, T url_value, std::vector<T> usual) {
    if (!listed.empty()) return listed;
    return in_url ? std::vector<T>{url_value} : std::move(usual);
}

/// Equal for targets with equal settings.
std::string key_of(const ScanTarget& target) {
    std::string key;
    for (const auto& line : target.settings) key.append(model::url_of(line)).append("\n");
    return key;
}

}  // namespace

ScanTarget serial_target(const model::Line& port, std::string_view url, const SerialChoices& choices) {
    const auto query = url.substr(std::min(url.find('?'), url.size()));
    const auto in_url = [query](std::string_view key) { return query.find(key) != std::string_view::npos; };
    const auto& given = port.format;
    const auto bauds = chosen(choices.bauds, in_url("baud="), given.baud, usual_bauds());
    const auto parities =
        chosen(choices.parities, in_url("parity="), given.parity, {Parity::none, Parity::even, Parity::odd});
    const auto stop_bits =
        chosen(choices.stop_bits, in_url("stop_bits="), std::uint32_t{given.stop_bits}, {1U});
    ScanTarget target;
    for (const auto baud : bauds)
        for (const auto parity : parities)
            for (const auto stop : stop_bits) {
                target.settings.push_back(port);
                auto& format = target.settings.back().format;
                format.baud = baud;
                format.parity = parity;
                format.stop_bits = static_cast<std::uint8_t>(stop);
            }
    std::ranges::stable_sort(target.settings, std::greater(),
                             [](const model::Line& line) { return likelihood(line.format); });
    return target;
}

std::vector<ScanTarget> host_targets(const model::Line& first, const HostRange& hosts) {
    std::vector<ScanTarget> targets;
    for (std::uint64_t i = 0; i < hosts.size(); ++i) {
        auto line = first;
        line.port = ipv4_text(hosts.first + static_cast<std::uint32_t>(i));
        line.name = model::host_and_port(line.port, line.tcp_port);
        targets.push_back({{std::move(line)}, hosts.size() > 1});
    }
    return targets;
}

Result<void> add_targets(std::vector<ScanTarget>& targets, std::vector<ScanTarget> added,
                         std::string_view name) {
    std::set<std::string> known;
    for (const auto& target : targets) known.insert(key_of(target));
    for (auto& target : added)
        if (known.insert(key_of(target)).second) targets.push_back(std::move(target));
    if (targets.size() > kMaxScanTargets)
        return fail(Code::out_of_range, name, static_cast<std::int64_t>(targets.size()), 1, kMaxScanTargets);
    return {};
}

Result<ScanConfig> scan_config(const ScanRequest& request, const ScanTarget& target) {
    const bool serial = target.is_serial();
    ScanConfig config;
    auto units = request.units;
    if (units.empty()) {
        if (!serial) units.assign(kUnitsOfHost.begin(), kUnitsOfHost.end());
        for (std::uint32_t unit = serial ? 1 : 2; unit <= kLastSerialUnit; ++unit) units.push_back(unit);
    }
    for (const auto unit : units) {
        if (serial && (unit == 0 || unit > kLastSerialUnit)) continue;
        config.units.push_back(UnitId{static_cast<std::uint8_t>(unit)});
    }
    if (config.units.empty()) return fail(Code::out_of_range, request.units.front(), 1, kLastSerialUnit);
    config.wait = request.wait.value_or(serial ? kSerialWait : kNetworkWait);
    config.retry_wait = std::max(4 * config.wait, kLeastRetryWait);
    config.adaptive = !serial && !request.wait;
    config.identify = request.identify;
    config.thorough = request.thorough;
    return config;
}

}  // namespace takt::bus
