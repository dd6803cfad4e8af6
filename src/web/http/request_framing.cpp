#include "http/request_framing.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <set>

#include "http/lower_ascii.hpp"
#include "takt/base/ascii.hpp"

namespace takt::web {
namespace {

constexpr std::string_view kEnd = "\r\n\r\n";

// Fields that the program reads. Each may be there once.
constexpr std::array<std::string_view, 10> kKnown = {
    "host",   "origin",          "connection",      "content-type",  "authorization",
    "x-takt", "accept-encoding", "accept-language", "if-none-match", "sec-fetch-site"};

// Fields of proxies. Each proxy may append a line of its own; together they are one list (RFC 9110, 5.3).
constexpr std::array<std::string_view, 3> kLists = {"x-forwarded-for", "x-forwarded-host",
                                                    "x-forwarded-proto"};

bool is_token(std::string_view text) {
    constexpr std::string_view kMarks = "!#$%&'*+-.^_`|~";
    return !text.empty() && std::ranges::all_of(text, [&](char c) {
        return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
               kMarks.find(c) != std::string_view::npos;
    });
}

bool is_printable(std::string_view text) {
    return std::ranges::all_of(
        text, [](char c) { return c == '\t' || (static_cast<unsigned char>(c) >= 0x20 && c != 0x7F); });
}

std::string_view take_line(std::string_view& rest) {
    const auto end = rest.find("\r\n");
    const auto line = rest.substr(0, end);
    rest.remove_prefix(std::min(rest.size(), end + 2));
    return line;
}

/// 0: accepted.
int check_request_line(std::string_view line, const FramingLimits& limits) {
    const auto method_end = line.find(' ');
    const auto target_end = line.rfind(' ');
    if (method_end == std::string_view::npos || target_end == method_end) return 400;
    const auto target = line.substr(method_end + 1, target_end - method_end - 1);
    const auto version = line.substr(target_end + 1);
    if (!is_token(line.substr(0, method_end)) || target.find(' ') != std::string_view::npos) return 400;
    if (target.empty() || target.front() != '/') return 400;
    if (target.size() > limits.target_bytes) return 414;
    if (!version.starts_with("HTTP/")) return 400;
    return version == "HTTP/1.1" || version == "HTTP/1.0" ? 0 : 505;
}

class HeadParser {
public:
    explicit HeadParser(const FramingLimits& limits) : limits_(limits) {}

    void end() {
        for (std::size_t i = 0; i < kLists.size(); ++i)
            if (!lists_[i].empty()) put(kLists[i], lists_[i]);
        head.text += "\r\n";
    }

    /// @returns 0 or the status
    int line(std::string_view text) {
        if (++count_ > limits_.fields) return 431;
        const auto colon = text.find(':');
        if (colon == std::string_view::npos || !is_token(text.substr(0, colon))) return 400;
        return field(lower_ascii(text.substr(0, colon)), trimmed(text.substr(colon + 1), " \t"));
    }

    RequestHead head;

private:
    int field(const std::string& name, std::string_view value) {
        const bool known = std::ranges::find(kKnown, name) != kKnown.end();
        if (name == "transfer-encoding") return 501;
        if (name == "content-encoding" && lower_ascii(value) != "identity") return 415;
        if (const auto list = std::ranges::find(kLists, name); list != kLists.end()) {
            auto& text = lists_[static_cast<std::size_t>(list - kLists.begin())];
            text.append(text.empty() ? "" : ", ").append(value);
            return 0;
        }
        if (!known && name != "content-length" && name != "expect") return 0;
        if (!seen_.insert(name).second) return 400;
        if (name == "content-length") return content_length(value);
        if (name == "expect") {
            head.expects_continue = lower_ascii(value) == "100-continue";
            return head.expects_continue ? 0 : 417;
        }
        put(name, value);
        return 0;
    }

    void put(std::string_view name, std::string_view value) {
        head.text.append(name).append(": ").append(value).append("\r\n");
    }

    int content_length(std::string_view value) {
        const auto* const begin = value.data();
        const auto* const end = begin + value.size();
        const auto [rest, error] = std::from_chars(begin, end, head.body_bytes);
        if (error == std::errc::result_out_of_range) return 413;
        if (error != std::errc() || rest != end) return 400;
        return head.body_bytes > limits_.body_bytes ? 413 : 0;
    }

    const FramingLimits& limits_;
    std::set<std::string, std::less<>> seen_;
    std::size_t count_ = 0;
    std::array<std::string, kLists.size()> lists_;
};

}  // namespace

std::optional<std::size_t> head_size(std::string_view bytes, std::size_t from) {
    const auto found = bytes.find(kEnd, from < kEnd.size() ? 0 : from - (kEnd.size() - 1));
    if (found == std::string_view::npos) return std::nullopt;
    return found + kEnd.size();
}

ParsedHead parse_head(std::string_view head, const FramingLimits& limits) {
    if (head.size() > limits.head_bytes) return {.status = 431};
    auto rest = head.substr(0, head.size() - 2);  // the last line keeps its end
    const auto request_line = take_line(rest);
    if (!is_printable(request_line)) return {.status = 400};
    if (const int status = check_request_line(request_line, limits)) return {.status = status};
    HeadParser parser(limits);
    parser.head.text = std::string(request_line) + "\r\n";
    while (!rest.empty()) {
        const auto line = take_line(rest);
        if (!is_printable(line)) return {.status = 400};
        if (const int status = parser.line(line)) return {.status = status};
    }
    parser.end();
    return {.head = std::move(parser.head)};
}

}  // namespace takt::web
