// Texts of the errors of module base. A message's key is "error." and the code's name; where the numbers are
// known it is the variant with ".numbers" (and the subject, where there is one, always goes before: "subject:
// message").
#include <netdb.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <optional>

#include "takt/base/ascii.hpp"
#include "takt/text/catalogue.hpp"

namespace takt::text {
namespace {

struct Known {
    int number;
    std::string_view name;
};

// The operating system's errors that a user meets; strerror() knows one language at a time only.
constexpr std::array kSystemErrors{
    Known{ENOENT, "ENOENT"},
    Known{EACCES, "EACCES"},
    Known{EPERM, "EPERM"},
    Known{EIO, "EIO"},
    Known{ENXIO, "ENXIO"},
    Known{ENODEV, "ENODEV"},
    Known{EBUSY, "EBUSY"},
    Known{EISDIR, "EISDIR"},
    Known{ELOOP, "ELOOP"},
    Known{ENOTTY, "ENOTTY"},
    Known{EMFILE, "EMFILE"},
    Known{ENOSPC, "ENOSPC"},
    Known{EPIPE, "EPIPE"},
    Known{EADDRINUSE, "EADDRINUSE"},
    Known{EADDRNOTAVAIL, "EADDRNOTAVAIL"},
    Known{ENETUNREACH, "ENETUNREACH"},
    Known{EHOSTUNREACH, "EHOSTUNREACH"},
    Known{ECONNRESET, "ECONNRESET"},
    Known{ECONNREFUSED, "ECONNREFUSED"},
    Known{ECONNABORTED, "ECONNABORTED"},
    Known{ETIMEDOUT, "ETIMEDOUT"},
    Known{ECANCELED, "ECANCELED"},
    Known{ENOTSOCK, "ENOTSOCK"},
};

std::string system_text(Language language, std::int64_t number) {
    const auto value = static_cast<int>(number);
    if (value < 0)
        return message(language, "system.name_resolution", std::array{Argument{"text", gai_strerror(value)}});
    for (const auto& known : kSystemErrors)
        if (known.number == value) return message(language, "system." + std::string(known.name));
    std::array<char, 128> buffer{};
    return strerror_r(value, buffer.data(), buffer.size());
}

// The names of the numbers of an error in the texts.
struct Placeholder {
    std::string_view name;
    std::size_t index;
};
constexpr std::array kPlaceholders{
    Placeholder{"value", 0},        Placeholder{"least", 1}, Placeholder{"greatest", 2},
    Placeholder{"there", 0},        Placeholder{"limit", 1}, Placeholder{"entries", 0},
    Placeholder{"milliseconds", 0}, Placeholder{"code", 0},  Placeholder{"delay", 1},
    Placeholder{"advised", 2},      Placeholder{"came", 0},  Placeholder{"asked", 1},
};

bool about_device(const Error& error) {
    return error.subject.view().starts_with("/dev/");
}
bool about_network(const Error& error) {
    return error.subject.view().find('/') == std::string_view::npos;
}

// Servers have a port.
bool about_interface(const Error& error) {
    return about_network(error) && error.subject.view().find_first_of(":.") == std::string_view::npos;
}

std::string_view advice_on_opening(const Error& error) {
    const auto number = error.numbers[0];
    if (number < 0) return "advice.host_name";
    switch (number) {
        case ENODEV:
            if (about_interface(error)) return "advice.no_interface";
            [[fallthrough]];
        case ENOENT:
        case ENXIO: return about_device(error) ? "advice.no_device" : "advice.no_file";
        case EACCES:
        case EPERM:
            if (about_device(error)) return "advice.dialout";
            if (about_interface(error)) return {};  // its command names the right
            return about_network(error) ? "advice.low_port" : "advice.file_rights";
        case ELOOP: return "advice.symbolic_link";
        case EBUSY: return "advice.busy";
        case ENOTTY: return "advice.not_serial";
        case ECONNREFUSED: return about_network(error) ? "advice.refused" : "advice.no_run";
        case ENOTSOCK: return "advice.not_control";
        case ETIMEDOUT:
        case EHOSTUNREACH:
        case ENETUNREACH: return "advice.unreachable";
        case EADDRINUSE: return "advice.address_in_use";
        case EADDRNOTAVAIL: return "advice.not_local";
        case EMFILE: return "advice.descriptors";
        default: return {};
    }
}

// A response came after the time-out.
bool came_late(const Error& error) {
    return error.code == Code::timed_out && error.numbers[1] > 0;
}

bool is_cut_short(const Error& error) {
    return error.code == Code::bad_checksum && error.numbers[1] > 0;
}

bool is_serial_protocol_over_tcp(const Error& error) {
    return error.subject.view().find("+tcp://") != std::string_view::npos;
}

HeaderFault header_fault(const Error& error) {
    return static_cast<HeaderFault>(error.numbers[2]);
}

Mismatch::Part mismatch_part(const Error& error) {
    return static_cast<Mismatch::Part>(error.numbers[2]);
}

TlsFault tls_fault(const Error& error) {
    const auto fault = static_cast<std::size_t>(error.numbers[0]);
    return fault < kTlsFaults ? static_cast<TlsFault>(fault) : TlsFault::other;
}

// The type that takes a negative number which an unsigned type does not: "-5 → 0..65535".
std::string_view signed_type(const Error& error) {
    const auto subject = error.subject.view();
    if (!subject.starts_with('-')) return {};
    if (subject.ends_with(" → 0..65535")) return "int16";
    if (subject.ends_with(" → 0..4294967295")) return "int32";
    return subject.ends_with(" → 0..18446744073709551615") ? "int64" : "";
}

std::string exception_key(const Error& error, std::string_view prefix) {
    return std::string(prefix) + std::to_string(error.numbers[0]);
}

std::string advice_key(const Error& error) {
    switch (error.code) {
        case Code::cannot_open: return std::string(advice_on_opening(error));
        case Code::busy: return "advice.busy";
        case Code::not_writable: return "advice.not_writable";
        case Code::overflow: return signed_type(error).empty() ? "" : "advice.overflow.signed";
        case Code::timed_out: return came_late(error) ? "advice.timed_out.late" : "advice.timed_out";
        case Code::replaced: return "advice.replaced";
        case Code::bad_checksum:
            if (is_cut_short(error)) return "advice.bad_checksum.length";
            return is_serial_protocol_over_tcp(error) ? "advice.bad_checksum.tcp" : "advice.bad_checksum";
        case Code::not_modbus:
            return header_fault(error) == HeaderFault::off_by_one ? "advice.not_modbus.length"
                                                                  : "advice.not_modbus";
        case Code::unexpected_reply: return "advice.unexpected_reply";
        case Code::tls_failed: return std::string("advice.tls_failed.").append(name(tls_fault(error)));
        case Code::misdirected:
            return mismatch_part(error) == Mismatch::Part::unit ? "advice.misdirected.unit"
                                                                : "advice.misdirected.other";
        case Code::modbus_exception: return exception_key(error, "advice.exception.");
        default: return {};
    }
}

// Whether the numbers of an error add information to its code.
bool has_numbers(const Error& error) {
    switch (error.code) {
        case Code::out_of_range: return error.numbers[1] != error.numbers[2];
        case Code::too_short:
        case Code::too_long:
        case Code::not_modbus: return error.numbers[1] != 0;
        case Code::queue_full:
        case Code::timed_out:
        case Code::cannot_open:
        case Code::connection_lost:
        case Code::io_failed: return error.numbers[0] != 0;
        default: return false;
    }
}

bool has_system_number(Code code) {
    return code == Code::cannot_open || code == Code::connection_lost || code == Code::io_failed;
}

// The variant of the text of Code::not_modbus.
std::string_view header_variant(const Error& error) {
    switch (header_fault(error)) {
        case HeaderFault::protocol: return ".protocol";
        case HeaderFault::length: return ".length";
        case HeaderFault::off_by_one: return ".off_by_one";
        case HeaderFault::unknown: break;
    }
    return ".numbers";
}

std::string variant_of(const Error& error) {
    if (came_late(error)) return ".late";
    if (is_cut_short(error)) return ".length";
    if (error.code == Code::misdirected) return std::string(".").append(name(mismatch_part(error)));
    if (error.code == Code::tls_failed) return std::string(".").append(name(tls_fault(error)));
    if (!has_numbers(error)) return "";
    return error.code == Code::not_modbus ? std::string(header_variant(error)) : ".numbers";
}

// `count` bytes of a number, the first one in its highest place: "53 53 48 2D (SSH-)".
std::string bytes_text(std::int64_t number, std::int64_t count) {
    std::string hex;
    std::string characters;
    for (auto place = std::clamp<std::int64_t>(count, 0, 8); place-- > 0;) {
        const auto byte = static_cast<unsigned>(static_cast<std::uint64_t>(number) >> (8 * place) & 0xFFU);
        if (!hex.empty()) hex += ' ';
        hex += {hex_digit(byte >> 4), hex_digit(byte)};
        characters += byte >= ' ' && byte <= '~' ? static_cast<char>(byte) : '.';
    }
    return hex + " (" + characters + ')';
}

// The words for the numbers: the system's text, the name of a Modbus exception, or the bytes that came.
std::string detail(Language language, const Error& error) {
    if (has_system_number(error.code)) return system_text(language, error.numbers[0]);
    if (error.code == Code::not_modbus) return bytes_text(error.numbers[0], error.numbers[1]);
    if (error.code != Code::modbus_exception) return {};
    const auto key = exception_key(error, "exception.");
    return message(language, has(Language::english, key) ? key : "exception.unknown");
}

// "what is there → what would be right" (value::beside_allowed)
std::string syntax_text(Language language, std::string_view subject) {
    constexpr std::string_view kArrow = " → ";
    const auto arrow = subject.rfind(kArrow);
    return message(language, "error.syntax.right",
                   std::array{Argument{"given", subject.substr(0, arrow)},
                              Argument{"right", subject.substr(arrow + kArrow.size())}});
}

}  // namespace

std::string what(Language language, const Error& error) {
    if (error.code == Code::syntax && error.subject.view().find(" → ") != std::string_view::npos)
        return syntax_text(language, error.subject.view());
    const std::array numbers{std::to_string(error.numbers[0]), std::to_string(error.numbers[1]),
                             std::to_string(error.numbers[2])};
    const auto words = detail(language, error);
    std::vector<Argument> arguments{{"detail", words}};
    for (const auto& [placeholder, index] : kPlaceholders) arguments.push_back({placeholder, numbers[index]});
    const auto key = "error." + std::string(name(error.code)).append(variant_of(error));
    std::string text;
    if (!error.subject.empty()) text.append(error.subject.view()).append(": ");
    return text + message(language, key, arguments);
}

std::string advice(Language language, const Error& error) {
    const auto key = advice_key(error);
    if (key.empty() || !has(Language::english, key)) return {};
    const auto advised = std::to_string(error.numbers[2]);
    const auto came = std::to_string(error.numbers[0]);
    return message(language, key,
                   std::array{Argument{"subject", error.subject.view()}, Argument{"advised", advised},
                              Argument{"type", signed_type(error)}, Argument{"came", came}});
}

std::string describe(Language language, const Error& error) {
    auto text = what(language, error);
    if (const auto hint = advice(language, error); !hint.empty()) text.append(". ").append(hint);
    return text;
}

}  // namespace takt::text
