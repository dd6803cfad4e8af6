#include "takt/wire/frame_words.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <span>

namespace takt::wire {
namespace {

constexpr std::size_t kMostShown = 32;  // values of one list

template <class... Args>
void add(std::string& out, fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(out), format, std::forward<Args>(args)...);
}

// "7" or "7..9"; beyond 65535 where the request reaches there.
std::string addresses(DataAddress start, std::size_t count) {
    if (count <= 1) return fmt::format("{}", start.value);
    return fmt::format("{}..{}", start.value, start.value + count - 1);
}

std::string list(std::span<const std::uint16_t> values) {
    std::string out;
    for (const std::uint16_t value : values.first(std::min(values.size(), kMostShown)))
        add(out, " {}", value);
    if (values.size() > kMostShown) out += " …";
    return out;
}

std::string list(const Bits& bits) {
    std::string out;
    for (std::size_t i = 0; i < std::min(bits.size(), kMostShown); ++i) out += bits[i] ? " 1" : " 0";
    if (bits.size() > kMostShown) out += " …";
    return out;
}

template <class Values>
std::string counted_text(const Values& values, std::size_t count) {
    if (count == 0) return "no values";
    return fmt::format("{} value{}:{}", count, count == 1 ? "" : "s", list(values));
}

// The text of an identification: control and other bytes outside of ASCII as dots, so that a log stays one
// line.
std::string printable(Bytes bytes) {
    std::string out;
    for (const std::uint8_t byte : bytes) out += byte >= 0x20 && byte < 0x7F ? static_cast<char>(byte) : '.';
    return out;
}

std::string_view sub_function_name(std::uint16_t code) {
    switch (code) {
        case 0: return "return query data";
        case 1: return "restart communications";
        case 2: return "return diagnostic register";
        case 3: return "change ASCII delimiter";
        case 4: return "force listen only mode";
        case 10: return "clear counters";
        case 11: return "return bus message count";
        case 12: return "return bus communication error count";
        case 13: return "return bus exception error count";
        case 14: return "return server message count";
        case 15: return "return server no response count";
        case 16: return "return server NAK count";
        case 17: return "return server busy count";
        case 18: return "return bus character overrun count";
        case 20: return "clear overrun counter";
        default: return "reserved";
    }
}

std::string_view identification(std::uint8_t code) {
    constexpr std::string_view kNames[] = {"basic", "regular", "extended", "one object"};
    return code >= 1 && code <= std::size(kNames) ? kNames[code - 1] : "unknown";
}

void add_ranges(std::string& out, std::span<const FileRange> ranges,
                std::span<const std::uint16_t> values = {}) {
    for (const FileRange& range : ranges) {
        const std::size_t end = std::size_t{range.record} + range.length - 1;
        add(out, "{} file {} record {}", &range == ranges.data() ? ":" : ",", range.file, range.record);
        if (range.length > 1) add(out, "..{}", end);
        if (values.empty()) continue;
        add(out, " ={}", list(values.first(range.length)));
        values = values.subspan(range.length);
    }
}

void add_data(std::string& out, Bytes data) {
    if (!data.empty()) add(out, " {}", hex(data));
}

struct RequestWords {
    std::string& out;

    void operator()(const ReadRequest& r) const { add(out, " {}", addresses(r.start, r.quantity)); }
    void operator()(const WriteSingleCoilRequest& r) const {
        add(out, " {} = {}", r.address.value, r.on ? "on" : "off");
    }
    void operator()(const WriteSingleRegisterRequest& r) const {
        add(out, " {} = {}", r.address.value, r.value);
    }
    void operator()(const DiagnosticsRequest& r) const {
        add(out, " {} ({})", sub_function_name(r.sub_function), r.sub_function);
        add_data(out, r.data.span());
    }
    void operator()(const WriteMultipleCoilsRequest& r) const {
        add(out, " {} ={}", addresses(r.start, r.values.size()), list(r.values));
    }
    void operator()(const WriteMultipleRegistersRequest& r) const {
        add(out, " {} ={}", addresses(r.start, r.values.size()), list(r.values.span()));
    }
    void operator()(const ReadFileRecordRequest& r) const { add_ranges(out, r.ranges.span()); }
    void operator()(const WriteFileRecordRequest& r) const {
        add_ranges(out, r.ranges.span(), r.values.span());
    }
    void operator()(const MaskWriteRegisterRequest& r) const {
        add(out, " {}: AND 0x{:04X}, OR 0x{:04X}", r.address.value, r.and_mask, r.or_mask);
    }
    void operator()(const ReadWriteMultipleRegistersRequest& r) const {
        add(out, " read {}, write {} ={}", addresses(r.read_start, r.read_quantity),
            addresses(r.write_start, r.values.size()), list(r.values.span()));
    }
    void operator()(const ReadFifoQueueRequest& r) const { add(out, " {}", r.address.value); }
    void operator()(const ReadDeviceIdRequest& r) const {
        add(out, " read device identification {} from object {}", identification(r.code), r.object);
    }
    void operator()(const EncapsulatedRequest& r) const {
        add(out, " type {}", r.mei_type);
        add_data(out, r.data.span());
    }
    template <class WithoutData>
    void operator()(const WithoutData& /*request*/) const {}
};

struct ResponseWords {
    std::string& out;

    void operator()(const ExceptionResponse& r) const {
        add(out, "exception {}", static_cast<unsigned>(r.code));
        if (name(r.code) != name(ExceptionCode{})) add(out, " {}", name(r.code));
    }
    void operator()(const ReadBitsResponse& r) const { out += counted_text(r.values, r.values.size()); }
    void operator()(const ReadRegistersResponse& r) const {
        out += counted_text(r.values.span(), r.values.size());
    }
    void operator()(const WriteSingleCoilResponse& r) const {
        add(out, "{} = {}", r.address.value, r.on ? "on" : "off");
    }
    void operator()(const WriteSingleRegisterResponse& r) const {
        add(out, "{} = {}", r.address.value, r.value);
    }
    void operator()(const ReadExceptionStatusResponse& r) const { add(out, "status 0x{:02X}", r.status); }
    void operator()(const DiagnosticsResponse& r) const {
        add(out, "{} ({})", sub_function_name(r.sub_function), r.sub_function);
        add_data(out, r.data.span());
    }
    void operator()(const GetCommEventCounterResponse& r) const {
        add(out, "status 0x{:04X}, {} events", r.status, r.event_count);
    }
    void operator()(const GetCommEventLogResponse& r) const {
        add(out, "status 0x{:04X}, {} events, {} messages:", r.status, r.event_count, r.message_count);
        add_data(out, r.events.span());
    }
    void operator()(const WriteMultipleResponse& r) const {
        add(out, "{} written", addresses(r.start, r.quantity));
    }
    void operator()(const ReportServerIdResponse& r) const { add(out, "{}", hex(r.data.span())); }
    void operator()(const ReadFileRecordResponse& r) const {
        std::span<const std::uint16_t> values = r.values.span();
        for (std::size_t i = 0; i < r.lengths.size(); ++i) {
            add(out, "{}{}", i == 0 ? "" : "; ", counted_text(values.first(r.lengths[i]), r.lengths[i]));
            values = values.subspan(r.lengths[i]);
        }
    }
    void operator()(const WriteFileRecordResponse& r) const {
        out += "written";
        add_ranges(out, r.ranges.span());
    }
    void operator()(const MaskWriteRegisterResponse& r) const {
        add(out, "{}: AND 0x{:04X}, OR 0x{:04X}", r.address.value, r.and_mask, r.or_mask);
    }
    void operator()(const ReadFifoQueueResponse& r) const {
        out += counted_text(r.values.span(), r.values.size());
    }
    void operator()(const ReadDeviceIdResponse& r) const {
        Bytes text = r.text.span();
        for (const DeviceIdObject& object : r.objects) {
            add(out, "{}{} \"{}\"", &object == r.objects.data() ? "" : ", ", object.id,
                printable(text.first(object.length)));
            text = text.subspan(object.length);
        }
        if (r.objects.empty()) out += "no objects";
        if (r.more_follows) add(out, ", more from object {}", r.next_object);
    }
    void operator()(const EncapsulatedResponse& r) const {
        add(out, "type {}", r.mei_type);
        add_data(out, r.data.span());
    }
};

std::string reason(const Error& error) {
    const auto [first, second, third] = error.numbers;
    switch (error.code) {
        case Code::too_short: return fmt::format("too short, {} of {} bytes", first, second);
        case Code::too_long: return fmt::format("too long, {} bytes instead of {}", first, second);
        case Code::out_of_range: return fmt::format("{} is outside {}..{}", first, second, third);
        case Code::unexpected_reply: return "no answer to that request";
        case Code::unsupported: return "unknown";
        default: return "malformed";
    }
}

// "read coils", "function 0x63"; nothing for an empty PDU.
void add_function(std::string& out, Bytes pdu, std::uint8_t mask) {
    if (pdu.empty()) return;
    const auto function = static_cast<Function>(pdu[0] & mask);
    add(out, " {}", name(function));
    if (!is_known(function)) add(out, " 0x{:02X}", static_cast<unsigned>(function));
}

void add_unread(std::string& out, const Error& error, Bytes pdu) {
    add(out, "({})", reason(error));
    add_data(out, pdu);
}

// Only an MBAP header is seven bytes longer than the PDU behind it: RTU has three more, ASCII twice as many.
std::uint16_t transaction_id(Bytes pdu, Bytes raw) {
    constexpr std::size_t kMbapHeader = 7;
    if (pdu.empty() || raw.size() != pdu.size() + kMbapHeader) return 0;
    return static_cast<std::uint16_t>(raw[0] << 8 | raw[1]);
}

}  // namespace

std::string describe_request(UnitId unit, Bytes pdu) {
    return describe_request(unit, pdu, decode_request(pdu));
}

std::string describe_request(UnitId unit, Bytes pdu, const Result<Request>& request) {
    std::string out = fmt::format("unit {}", unit.value);
    add_function(out, pdu, 0xFF);
    if (request) {
        std::visit(RequestWords{out}, *request);
    } else {
        out += ' ';
        add_unread(out, request.error(), pdu);
    }
    return out;
}

std::string describe_response(UnitId unit, Bytes pdu, const Request* request) {
    std::string out = fmt::format("unit {}", unit.value);
    if (request != nullptr) {
        add(out, " {}", name(function_of(*request)));
        std::visit(RequestWords{out}, *request);
    } else {
        add_function(out, pdu, static_cast<std::uint8_t>(~kExceptionBit));
    }
    out += " → ";
    const auto response = request != nullptr ? decode_response(*request, pdu) : decode_response(pdu);
    if (response) {
        std::visit(ResponseWords{out}, *response);
    } else {
        add_unread(out, response.error(), pdu);
    }
    return out;
}

std::string FrameWords::request(UnitId unit, Bytes pdu, Bytes raw) {
    auto decoded = decode_request(pdu);
    auto words = describe_request(unit, pdu, decoded);
    const auto id = transaction_id(pdu, raw);
    std::erase_if(requests_, [&](const Sent& sent) { return sent.unit == unit && sent.id == id; });
    if (requests_.size() == kMost) requests_.pop_front();
    if (decoded) requests_.push_back({unit, id, *std::move(decoded)});
    return words;
}

std::string FrameWords::response(UnitId unit, Bytes pdu, Bytes raw) const {
    const auto id = transaction_id(pdu, raw);
    const auto found =
        std::ranges::find_if(requests_, [&](const Sent& sent) { return sent.unit == unit && sent.id == id; });
    const bool answers =
        found != requests_.end() && (decode_response(found->request, pdu) || !decode_response(pdu));
    return describe_response(unit, pdu, answers ? &found->request : nullptr);
}

std::string hex(Bytes bytes) {
    return fmt::format("{:02X}", fmt::join(bytes, " "));
}

}  // namespace takt::wire
