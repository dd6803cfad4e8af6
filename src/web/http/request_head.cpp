#include "http/request_head.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <set>
#include <utility>

#include "http/lower_ascii.hpp"
#include "takt/base/ascii.hpp"

namespace takt::web {
namespace {

constexpr std::string_view kEnd = "\r\n\r\n";

// Fields that the program reads, and that may be there once.
constexpr std::array<std::string_view, 6> kKnown = {"host",          "origin", "content-type",
                                                    "authorization", "x-takt", "sec-fetch-site"};

// Lists: several lines are one list (RFC 9110, 5.3). Each proxy may append a line of its own.
constexpr std::array<std::string_view, 7> kLists = {"connection",       "accept-encoding", "accept-language",
                                                    "if-none-match",    "x-forwarded-for", "x-forwarded-host",
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

/// @returns nothing: a `%` without two digits behind it
std::optional<std::string> decoded(std::string_view text, bool plus_is_blank) {
    std::string result;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] != '%') {
            result += text[i] == '+' && plus_is_blank ? ' ' : text[i];
            continue;
        }
        const auto high = i + 2 < text.size() ? hex_value(text[i + 1]) : std::nullopt;
        const auto low = high ? hex_value(text[i + 2]) : std::nullopt;
        if (!low) return std::nullopt;
        result += static_cast<char>(*high * 16 + *low);
        i += 2;
    }
    return result;
}

/// Sets path and query. @returns 0 or the status
int read_target(std::string_view target, RequestHead& head) {
    target = target.substr(0, target.find('#'));
    const auto mark = target.find('?');
    auto path = decoded(target.substr(0, mark), false);
    if (!path) return 400;
    head.path = path->empty() ? "/" : *std::move(path);
    auto rest = mark == std::string_view::npos ? std::string_view() : target.substr(mark + 1);
    while (!rest.empty()) {
        const auto part = rest.substr(0, rest.find('&'));
        rest.remove_prefix(std::min(rest.size(), part.size() + 1));
        const auto equals = std::min(part.find('='), part.size());
        auto name = decoded(part.substr(0, equals), true);
        auto value = decoded(part.substr(std::min(part.size(), equals + 1)), true);
        if (!name || !value) return 400;
        if (!name->empty()) head.query.emplace(*std::move(name), *std::move(value));
    }
    return 0;
}

/// `http://host/path` as `/path`: its host replaces the field of this name (RFC 9112, 3.2.2). False: it has
/// another form.
bool take_authority(std::string_view& target, RequestHead& head) {
    for (const std::string_view scheme : {"http://", "https://"}) {
        if (lower_ascii(target.substr(0, scheme.size())) != scheme) continue;
        target.remove_prefix(scheme.size());
        const auto end = std::min(target.find_first_of("/?#"), target.size());
        head.fields.emplace("host", target.substr(0, end));
        target.remove_prefix(end);
        return true;
    }
    return false;
}

/// @returns 0 or the status
int read_request_line(std::string_view line, const HeadLimits& limits, RequestHead& head) {
    const auto method_end = line.find(' ');
    const auto target_end = line.rfind(' ');
    if (method_end == std::string_view::npos || target_end == method_end) return 400;
    auto target = line.substr(method_end + 1, target_end - method_end - 1);
    const auto version = line.substr(target_end + 1);
    head.method = line.substr(0, method_end);
    if (!is_token(head.method) || target.find(' ') != std::string_view::npos) return 400;
    if (target.size() > limits.target_bytes) return 414;
    if (!take_authority(target, head) && !target.starts_with('/')) return 400;
    if (!version.starts_with("HTTP/")) return 400;
    head.keeps_alive = version == "HTTP/1.1";
    if (version != "HTTP/1.1" && version != "HTTP/1.0") return 505;
    return read_target(target, head);
}

class HeadParser {
public:
    explicit HeadParser(const HeadLimits& limits) : limits_(limits) {}

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
        if (std::ranges::find(kLists, name) != kLists.end()) {
            auto& text = head.fields[name];
            text.append(text.empty() ? "" : ", ").append(value);
            if (name == "connection") keep_alive(lower_ascii(value));
            return 0;
        }
        if (!known && name != "content-length" && name != "expect") return 0;
        if (!seen_.insert(name).second) return 400;
        if (name == "content-length") return content_length(value);
        if (name == "expect") {
            head.expects_continue = lower_ascii(value) == "100-continue";
            return head.expects_continue ? 0 : 417;
        }
        head.fields.emplace(name, value);
        return 0;
    }

    void keep_alive(const std::string& value) {
        if (value.contains("close"))
            head.keeps_alive = false;
        else if (value.contains("keep-alive"))
            head.keeps_alive = true;
    }

    int content_length(std::string_view value) {
        const auto* const begin = value.data();
        const auto* const end = begin + value.size();
        const auto [rest, error] = std::from_chars(begin, end, head.body_bytes);
        if (error == std::errc::result_out_of_range) return 413;
        if (error != std::errc() || rest != end) return 400;
        return head.body_bytes > limits_.body_bytes ? 413 : 0;
    }

    const HeadLimits& limits_;
    std::set<std::string, std::less<>> seen_;
    std::size_t count_ = 0;
};

}  // namespace

std::optional<std::size_t> head_size(std::string_view bytes, std::size_t from) {
    const auto found = bytes.find(kEnd, from < kEnd.size() ? 0 : from - (kEnd.size() - 1));
    if (found == std::string_view::npos) return std::nullopt;
    return found + kEnd.size();
}

ParsedHead parse_head(std::string_view head, const HeadLimits& limits) {
    if (head.size() > limits.head_bytes) return {.status = 431};
    auto rest = head.substr(0, head.size() - 2);  // the last line keeps its end
    const auto request_line = take_line(rest);
    if (!is_printable(request_line)) return {.status = 400};
    HeadParser parser(limits);
    if (const int status = read_request_line(request_line, limits, parser.head)) return {.status = status};
    while (!rest.empty()) {
        const auto line = take_line(rest);
        if (!is_printable(line)) return {.status = 400};
        if (const int status = parser.line(line)) return {.status = status};
    }
    return {.head = std::move(parser.head)};
}

std::optional<std::string> RequestHead::field(std::string_view name) const {
    const auto found = fields.find(name);
    return found == fields.end() ? std::nullopt : std::optional(found->second);
}

std::string_view RequestHead::text_of(std::string_view name) const {
    const auto found = fields.find(name);
    return found == fields.end() ? std::string_view() : found->second;
}

std::optional<std::string> RequestHead::parameter(std::string_view name) const {
    const auto found = query.find(name);
    return found == query.end() ? std::nullopt : std::optional(found->second);
}

}  // namespace takt::web
