#include "takt/app/scan_places.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bitset>
#include <charconv>
#include <optional>

#include "takt/model/fields.hpp"

namespace takt::app {
namespace {

using wire::Parity;

constexpr std::size_t kMaxListed = 4096;

std::unexpected<Error> unreadable(std::string_view name, std::string_view text, std::string_view right) {
    constexpr std::size_t kShown = 40;
    return fail(Code::syntax,
                fmt::format("{}{}{} → {}", name, name.empty() ? "" : " ", text.substr(0, kShown), right));
}

std::string_view example_of(std::string_view name) {
    if (name == "--bauds") return "9600,19200";
    return name == "--stop-bits" ? "1,2" : "1-10,16";
}

std::optional<std::uint32_t> number(std::string_view text) {
    std::uint32_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (text.empty() || end != text.data() + text.size() || error != std::errc{}) return std::nullopt;
    return value;
}

/// Calls `take` with each part of a list; false as soon as one was not taken.
template <class Take>
bool each_part(std::string_view text, Take take) {
    for (;;) {
        const auto comma = std::min(text.find(','), text.size());
        if (!take(text.substr(0, comma))) return false;
        if (comma == text.size()) return true;
        text.remove_prefix(comma + 1);
    }
}

struct Weight {
    std::uint32_t value;
    double weight;
};
// How often lines are set like this, as far as manuals tell.
constexpr std::array kBauds{Weight{9600, 10}, Weight{19200, 7}, Weight{115200, 6}, Weight{38400, 3},
                            Weight{57600, 3}, Weight{4800, 2},  Weight{2400, 1.5}, Weight{1200, 1}};
constexpr double kOtherBaud = 0.5;
constexpr std::size_t kUsualBauds = 5;

double likelihood(const wire::CharacterFormat& format) {
    const auto* const baud = std::ranges::find(kBauds, format.baud, &Weight::value);
    double weight = baud == kBauds.end() ? kOtherBaud : baud->weight;
    weight *= format.parity == Parity::none ? 3 : format.parity == Parity::even ? 2 : 0.4;
    if (format.baud == 19200 && format.parity == Parity::even) weight *= 3;  // the specification's own
    const bool usual_stop =
        format.stop_bits == (format.data_bits == 7 && format.parity == Parity::none ? 2 : 1);
    return usual_stop ? weight : weight * 0.2;
}

std::vector<line::Target> serial_settings(const line::Target& target, std::string_view url,
                                          const LineSettings& wanted) {
    const auto query = url.substr(std::min(url.find('?'), url.size()));
    const auto said = [&](std::string_view key) { return query.find(key) != std::string_view::npos; };
    auto bauds = wanted.bauds;
    if (bauds.empty() && said("baud=")) bauds = {target.format.baud};
    for (std::size_t i = 0; bauds.size() < kUsualBauds && !said("baud=") && wanted.bauds.empty(); ++i)
        bauds.push_back(kBauds[i].value);
    auto parities = wanted.parities;
    if (parities.empty() && said("parity=")) parities = {target.format.parity};
    if (parities.empty()) parities = {Parity::none, Parity::even, Parity::odd};
    auto stop_bits = wanted.stop_bits;
    if (stop_bits.empty() && said("stop_bits=")) stop_bits = {target.format.stop_bits};
    if (stop_bits.empty()) stop_bits = {1};

    std::vector<line::Target> settings;
    for (const auto baud : bauds)
        for (const auto parity : parities)
            for (const auto stop : stop_bits) {
                settings.push_back(target);
                auto& format = settings.back().format;
                format.baud = baud;
                format.parity = parity;
                format.stop_bits = static_cast<std::uint8_t>(stop);
            }
    std::ranges::stable_sort(settings, std::greater(), [](const auto& s) { return likelihood(s.format); });
    return settings;
}

struct HostRange {
    std::uint32_t first = 0;
    std::uint32_t last = 0;
};

std::optional<std::uint32_t> ipv4(std::string_view text) {
    in_addr address{};
    if (inet_pton(AF_INET, std::string(text).c_str(), &address) != 1) return std::nullopt;
    return ntohl(address.s_addr);
}

std::string ipv4_text(std::uint32_t address) {
    return fmt::format("{}.{}.{}.{}", address >> 24U, address >> 16U & 0xFFU, address >> 8U & 0xFFU,
                       address & 0xFFU);
}

// "10.0.0.1-20", "10.0.0.1-10.0.1.20", "10.0.0.0/24"; nothing: one host.
Result<std::optional<HostRange>> host_range(std::string_view host) {
    const auto at = host.find_first_of("-/");
    const auto first = at == std::string_view::npos ? std::nullopt : ipv4(host.substr(0, at));
    if (!first) return std::optional<HostRange>();
    const auto behind = host.substr(at + 1);
    if (host[at] == '/') {
        const auto prefix = number(behind);
        if (!prefix || *prefix > 32) return unreadable({}, host, fmt::format("{}/24", host.substr(0, at)));
        const std::uint32_t hosts = *prefix == 32 ? 0 : 0xFFFFFFFFU >> *prefix;
        const std::uint32_t network = *first & ~hosts;
        const std::uint32_t edge = *prefix < 31 ? 1 : 0;
        const std::uint32_t last = network + hosts;
        return HostRange{network + edge, last - edge};
    }
    auto last = ipv4(behind);
    if (!last)
        if (const auto final_byte = number(behind); final_byte && *final_byte <= 255)
            last = (*first & 0xFFFFFF00U) | *final_byte;
    if (!last || *last < *first) return unreadable({}, host, fmt::format("{}-254", host.substr(0, at)));
    return HostRange{*first, *last};
}

Result<std::vector<ScanPlace>> hosts_of(std::string_view url, std::size_t begin, std::string_view place) {
    const auto colon = std::min(place.find(':'), place.size());
    TAKT_TRY(const auto range, host_range(place.substr(0, colon)));
    std::vector<ScanPlace> places;
    if (!range) {
        TAKT_TRY(auto target, line::parse_target(url));
        places.push_back({{std::move(target)}, false});
        return places;
    }
    const std::uint64_t count = std::uint64_t{range->last} - range->first + 1;
    if (count > kMaxScanPlaces)
        return fail(Code::out_of_range, place, static_cast<std::int64_t>(count), 1, kMaxScanPlaces);
    for (std::uint64_t i = 0; i < count; ++i) {
        const auto host = ipv4_text(range->first + static_cast<std::uint32_t>(i));
        TAKT_TRY(auto target,
                 line::parse_target(fmt::format("{}{}{}", url.substr(0, begin), host, place.substr(colon))));
        places.push_back({{std::move(target)}, count > 1});
    }
    return places;
}

}  // namespace

Result<std::vector<std::uint32_t>> parse_numbers(std::string_view name, std::string_view text,
                                                 std::uint32_t least, std::uint32_t greatest) {
    std::vector<std::uint32_t> numbers;
    Error error;
    const bool read = each_part(text, [&](std::string_view part) {
        const auto dash = part.find('-');
        const auto first = number(part.substr(0, dash));
        const auto last = dash == std::string_view::npos ? first : number(part.substr(dash + 1));
        if (!first || !last || *last < *first) {
            error = unreadable(name, part, example_of(name)).error();
            return false;
        }
        for (const auto bound : {*first, *last})
            if (bound < least || bound > greatest) {
                error = fail(Code::out_of_range, name, bound, least, greatest).error();
                return false;
            }
        for (std::uint32_t value = *first; value <= *last; ++value) {
            if (std::ranges::find(numbers, value) != numbers.end()) continue;
            if (numbers.size() == kMaxListed) {
                error = fail(Code::too_long, name, *last - *first + 1, kMaxListed).error();
                return false;
            }
            numbers.push_back(value);
        }
        return true;
    });
    if (!read) return std::unexpected(error);
    return numbers;
}

Result<std::vector<Parity>> parse_parities(std::string_view text) {
    std::vector<Parity> parities;
    std::string wrong;
    const bool read = each_part(text, [&](std::string_view part) {
        const auto at = std::ranges::find(model::kParities, part);
        if (at == model::kParities.end()) {
            wrong = part;
            return false;
        }
        const auto parity = static_cast<Parity>(at - model::kParities.begin());
        if (std::ranges::find(parities, parity) == parities.end()) parities.push_back(parity);
        return true;
    });
    if (!read) return unreadable("--parities", wrong, "none,even,odd");
    return parities;
}

Result<std::vector<ScanPlace>> scan_places(std::string_view url, const LineSettings& settings) {
    const auto colon = url.find("://");
    const auto scheme = url.substr(0, std::min(colon, url.size()));
    if (colon == std::string_view::npos || (scheme != "tcp" && scheme != "tls" && scheme != "rtu+tcp")) {
        TAKT_TRY(const auto target, line::parse_target(url));
        return std::vector<ScanPlace>{{serial_settings(target, url, settings), false}};
    }
    return hosts_of(url, colon + 3, url.substr(colon + 3));
}

}  // namespace takt::app
