#include "takt/sim/answer_faults.hpp"

#include <algorithm>
#include <charconv>

#include "takt/base/ascii.hpp"
#include "takt/model/scalar.hpp"

namespace takt::sim {
namespace {

constexpr std::array<std::string_view, kAnswerFaults> kAnswerFaultNames{"delay",   "silence",    "exception",
                                                                        "bad_crc", "wrong_unit", "cut"};
constexpr std::uint32_t kMillion = 1'000'000;
constexpr Duration kLongestDelay = std::chrono::minutes(10);
constexpr std::size_t kMbapHead = 7;
constexpr std::size_t kMbapLengthAt = 4;

std::optional<Duration> parse_time(std::string_view text, Duration least, Duration most) {
    const auto parsed = model::parse_duration(text);
    if (!parsed || *parsed < least || *parsed > most) return std::nullopt;
    return *parsed;
}

template <class Number>
std::optional<Number> parse_number(std::string_view text, Number least, Number most) {
    Number number{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc() || end != text.data() + text.size() || !(number >= least && number <= most))
        return std::nullopt;
    return number;
}

/// Removes `mark` and the text behind it. Returns that text; nothing if `mark` does not occur.
std::optional<std::string_view> take_behind(std::string_view& text, char mark) {
    const auto at = text.rfind(mark);
    if (at == std::string_view::npos) return std::nullopt;
    const auto behind = text.substr(at + 1);
    text = text.substr(0, at);
    return behind;
}

bool read_argument(FaultRule& rule, std::string_view text) {
    if (rule.kind == AnswerFault::exception) {
        const auto code = parse_number<unsigned>(text, 1, 255);
        if (code) rule.code = static_cast<std::uint8_t>(*code);
        return code.has_value();
    }
    if (rule.kind != AnswerFault::delay) return false;
    const auto dots = text.find("..");
    const auto least = parse_time(text.substr(0, dots), Duration::zero(), kLongestDelay);
    const auto most = dots == std::string_view::npos
                          ? least
                          : parse_time(text.substr(dots + 2), Duration::zero(), kLongestDelay);
    if (!least || !most || *most < *least) return false;
    rule.least = *least;
    rule.most = *most;
    return true;
}

bool needs_argument(AnswerFault kind) {
    return kind == AnswerFault::delay || kind == AnswerFault::exception;
}

bool applies(const FaultRule& rule, const FaultSubject& subject) {
    if (!rule.scope) return true;
    const auto& scope = *rule.scope;
    if (scope.line != subject.line || scope.unit != subject.unit) return false;
    if (!scope.items) return true;
    const std::uint32_t start = scope.items->start;
    const std::uint32_t end = start + scope.items->count;
    return std::ranges::any_of(subject.accesses, [&](const wire::ItemAccess& access) {
        return access.area == scope.items->area && access.start < end &&
               std::uint32_t{access.start} + access.count > start;
    });
}

/// The unit of a frame; 0 where the frame is too short.
UnitId unit_of(wire::Framing framing, Bytes frame) {
    if (framing == wire::Framing::tcp)
        return UnitId{frame.size() >= kMbapHead ? frame[kMbapHead - 1] : std::uint8_t{0}};
    if (framing == wire::Framing::rtu) return UnitId{frame.empty() ? std::uint8_t{0} : frame[0]};
    constexpr std::size_t kDigitsEnd = 3;  // `:` and two digits
    if (frame.size() < kDigitsEnd) return UnitId{0};
    const auto value = [&](std::size_t at) {
        return frame[at] >= 'A' ? frame[at] - 'A' + 10 : frame[at] - '0';
    };
    return UnitId{static_cast<std::uint8_t>(value(1) << 4 | value(2))};
}

std::uint8_t other_digit(std::uint8_t digit) {
    return digit == '0' ? '1' : '0';
}

/// ASCII frame: `:`, hex digits, two digits of the LRC, CR LF.
void damage_ascii(AnswerFault kind, std::vector<std::uint8_t>& frame) {
    constexpr std::size_t kEnd = 4;
    if (frame.size() < kEnd + 3) return;
    const std::size_t check = frame.size() - kEnd;
    if (kind == AnswerFault::bad_crc) {
        frame[check] = other_digit(frame[check]);
        return;
    }
    const auto hex = [](unsigned nibble) { return static_cast<std::uint8_t>(hex_digit(nibble)); };
    const auto value = [&](std::size_t at) { return hex_value(static_cast<char>(frame[at])).value_or(0); };
    // The LRC is the two's complement of the sum: adding 1 to the unit lowers it by 1.
    const unsigned unit = (value(1) << 4 | value(2)) + 1;
    const unsigned lrc = (value(check) << 4 | value(check + 1)) + 255;
    frame[1] = hex(unit >> 4);
    frame[2] = hex(unit);
    frame[check] = hex(lrc >> 4);
    frame[check + 1] = hex(lrc);
}

void damage_rtu(AnswerFault kind, std::vector<std::uint8_t>& frame) {
    if (frame.size() < 3) return;
    if (kind == AnswerFault::bad_crc) {
        frame.back() ^= 0xFF;
        return;
    }
    ++frame[0];
    const auto body = frame.size() - 2;
    const std::uint16_t crc = wire::crc16(Bytes(frame).first(body));
    frame[body] = static_cast<std::uint8_t>(crc);
    frame[body + 1] = static_cast<std::uint8_t>(crc >> 8);
}

}  // namespace

std::optional<FaultRule> parse_fault(std::string_view text) {
    FaultRule rule;
    if (const auto every = take_behind(text, '@')) {
        const auto time = parse_time(*every, std::chrono::milliseconds(1), std::chrono::hours(24));
        if (!time) return std::nullopt;
        rule.every = *time;
    } else if (const auto rate = take_behind(text, ':')) {
        if (!rate->ends_with('%')) return std::nullopt;
        const auto percent = parse_number<double>(rate->substr(0, rate->size() - 1), 0, 100);
        if (!percent) return std::nullopt;
        rule.per_million = static_cast<std::uint32_t>(*percent * kMillion / 100);
    }
    const auto equals = text.find('=');
    const auto found = std::ranges::find(kAnswerFaultNames, text.substr(0, equals));
    if (found == kAnswerFaultNames.end()) return std::nullopt;
    rule.kind = static_cast<AnswerFault>(found - kAnswerFaultNames.begin());
    const bool argument = equals != std::string_view::npos;
    if (argument != needs_argument(rule.kind)) return std::nullopt;
    if (argument && !read_argument(rule, text.substr(equals + 1))) return std::nullopt;
    return rule;
}

std::string to_text(const FaultRule& rule) {
    std::string text(kAnswerFaultNames[static_cast<std::size_t>(rule.kind)]);
    if (rule.kind == AnswerFault::exception) text += "=" + std::to_string(rule.code);
    if (rule.kind == AnswerFault::delay) text += "=" + model::to_text(rule.least);
    if (rule.kind == AnswerFault::delay && rule.most != rule.least) text += ".." + model::to_text(rule.most);
    if (rule.every != Duration::zero()) return text + "@" + model::to_text(rule.every);
    if (rule.per_million == kMillion) return text;
    std::array<char, 32> percent{};
    const auto end =
        std::to_chars(percent.data(), percent.data() + percent.size(), rule.per_million / 10'000.0);
    return text + ":" + std::string(percent.data(), end.ptr) + "%";
}

UnitId FaultSite::device_of(UnitId unit) const {
    const bool of_host = unit.value == 0 || unit.value == 255;
    if (!of_host || units.empty() || std::ranges::find(units, unit) != units.end()) return unit;
    return units.front();
}

bool damages_frames(AnswerFault kind) {
    return kind == AnswerFault::bad_crc || kind == AnswerFault::wrong_unit || kind == AnswerFault::cut;
}

std::size_t AnswerFaults::clear(std::string_view scope_name) {
    return std::erase_if(
        rules_, [&](const Timed& timed) { return timed.rule.scope && timed.rule.scope->name == scope_name; });
}

bool AnswerFaults::add(Instant t, const FaultRule& rule) {
    if (rules_.size() >= kMost) return false;
    rules_.push_back({rule, after(t, rule.every)});
    return true;
}

std::vector<FaultRule> AnswerFaults::rules() const {
    std::vector<FaultRule> all;
    for (const auto& [rule, due] : rules_) all.push_back(rule);
    return all;
}

const FaultRule* AnswerFaults::strike(Instant t, bool handling, const FaultSubject& subject) {
    for (auto& [rule, due] : rules_) {
        if (damages_frames(rule.kind) == handling || !applies(rule, subject)) continue;
        if (rule.every != Duration::zero()) {
            if (t < due) continue;
            due = after(t, rule.every);
        } else if (!random_.chance(rule.per_million)) {
            continue;
        }
        ++struck_[static_cast<std::size_t>(rule.kind)];
        return &rule;
    }
    return nullptr;
}

Duration AnswerFaults::draw_delay(const FaultRule& rule) {
    return random_.between(rule.least, rule.most);
}

std::vector<std::uint8_t> damaged(const FaultRule& rule, wire::Framing framing, Bytes frame) {
    std::vector<std::uint8_t> result(frame.begin(), frame.end());
    if (rule.kind == AnswerFault::cut) {
        result.resize((result.size() + 1) / 2);
    } else if (framing == wire::Framing::tcp) {
        if (rule.kind == AnswerFault::wrong_unit && result.size() >= kMbapHead) ++result[kMbapHead - 1];
    } else if (framing == wire::Framing::ascii) {
        damage_ascii(rule.kind, result);
    } else {
        damage_rtu(rule.kind, result);
    }
    return result;
}

void FaultyEngine::send(Instant t, Bytes frame) {
    const auto* const rule =
        faults_.strike(t, false, {site_.line, site_.device_of(unit_of(framing_, frame)), {}});
    if (rule == nullptr) {
        out_.insert(out_.end(), frame.begin(), frame.end());
        return;
    }
    const auto changed = damaged(*rule, framing_, frame);
    out_.insert(out_.end(), changed.begin(), changed.end());
}

Bytes FaultyEngine::transmit(Instant t) {
    Bytes rest = inner_.transmit(t);
    out_.clear();
    while (!rest.empty()) {
        std::size_t size = rest.size();
        if (framing_ == wire::Framing::tcp && rest.size() >= kMbapHead)
            size = std::min(
                size, std::size_t{6} + rest[kMbapLengthAt] * std::size_t{256} + rest[kMbapLengthAt + 1]);
        send(t, rest.first(size));
        rest = rest.subspan(size);
    }
    return out_;
}

}  // namespace takt::sim
