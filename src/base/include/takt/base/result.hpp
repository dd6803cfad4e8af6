// Expected errors are values: a code and its arguments. Their texts are in module `text`.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <string_view>
#include <utility>

#include "takt/base/inplace_string.hpp"

namespace takt {

/// Error codes. The numbers are stable and may be stored; new ones are added at the end of a block.
enum class Code : std::uint16_t {
    // arguments and data
    out_of_range = 1,  ///< value, least, greatest
    malformed,         ///< the bytes violate their format
    too_short,         ///< bytes there, bytes needed
    too_long,          ///< bytes there, bytes allowed
    unsupported,       ///< known, but not available here
    not_found,         ///< subject
    overflow,          ///< a value does not fit its target; subject
    not_writable,      ///< subject
    queue_full,        ///< entries allowed
    syntax,            ///< text that cannot be parsed; subject
    read_only,         ///< a value that the program itself provides; subject
    // environment
    cannot_open = 100,  ///< subject (port, file, host:port), operating system's error number
    busy,               ///< used by another program; subject
    connection_lost,    ///< subject, operating system's error number
    timed_out,          ///< subject, milliseconds waited
    io_failed,          ///< subject, operating system's error number
    replaced,           ///< the file that is open was deleted or replaced; subject
    closed_by_peer,     ///< the connection, instead of a response; subject
    tls_failed,         ///< subject (host:port or file), TlsFault
    // Modbus
    modbus_exception = 200,  ///< exception code
    bad_checksum,            ///< subject; of a response that is cut short the numbers of `misdirected`
    unexpected_reply,
    not_modbus,   ///< subject, the first bytes that came as a number, how many (at most 8; 0: none),
                  ///< HeaderFault
    misdirected,  ///< subject, Mismatch::came, Mismatch::asked, Mismatch::part
};

/// What is wrong with the bytes of Code::not_modbus as an MBAP header.
enum class HeaderFault : std::uint8_t {
    unknown,
    protocol,    ///< bytes 3 and 4, the protocol identifier, are not 0
    length,      ///< bytes 5 and 6, the length, are not 2..254
    off_by_one,  ///< the length differs by one from that of the response
};

/// Why there is no TLS connection.
enum class TlsFault : std::uint8_t {
    other,
    not_tls,     ///< the peer sends something else
    version,     ///< both sides have no version in common: 1.2, 1.3
    algorithms,  ///< nor algorithms
    // the certificate of the peer
    no_certificate,
    untrusted,  ///< it leads to none of the roots
    expired,
    not_yet_valid,
    revoked,
    other_name,       ///< it names another host
    purpose,          ///< it is not for this side of a connection
    revocation_list,  ///< there is no list of its issuer, or an old one
    // the own certificate: the peer refuses it
    refused,
    refused_untrusted,
    refused_expired,
    refused_revoked,
    // a file
    file,  ///< no certificate, key or list in PEM
    key,   ///< it does not belong to the certificate
};
inline constexpr std::size_t kTlsFaults = 18;
/// "other", "not_tls", …
std::string_view name(TlsFault fault);

/// In what a response differs from the one that its request waits for.
struct Mismatch {
    enum class Part : std::uint8_t {
        unit,
        function,
        transaction,
        length,  ///< bytes of the frame: its end is missing
    };
    Part part = Part::unit;
    std::uint16_t came = 0;
    std::uint16_t asked = 0;
    friend bool operator==(const Mismatch&, const Mismatch&) = default;
};
/// "unit", "function", "transaction", "length"
std::string_view name(Mismatch::Part part);

/// The stable name of a code, as in "out_of_range": key of its text, and what --json shows.
std::string_view name(Code code);

/// An error: the code, its subject, and up to three numbers in the order of the code's comment.
struct Error {
    Code code{};
    InplaceString<120> subject{};
    std::array<std::int64_t, 3> numbers{};

    friend bool operator==(const Error&, const Error&) = default;
};

/// Code::misdirected; Mismatch::Part::length: Code::bad_checksum
[[nodiscard]] inline Error misdirected(std::string_view subject, const Mismatch& mismatch) {
    const bool cut_short = mismatch.part == Mismatch::Part::length;
    return {cut_short ? Code::bad_checksum : Code::misdirected,
            subject,
            {mismatch.came, mismatch.asked, static_cast<int>(mismatch.part)}};
}

/// std::expected is [[nodiscard]] in itself.
template <class T>
using Result = std::expected<T, Error>;

[[nodiscard]] inline std::unexpected<Error> fail(Code code, std::int64_t a = 0, std::int64_t b = 0,
                                                 std::int64_t c = 0) {
    return std::unexpected(Error{code, {}, {a, b, c}});
}
[[nodiscard]] inline std::unexpected<Error> fail(Code code, std::string_view subject, std::int64_t a = 0,
                                                 std::int64_t b = 0, std::int64_t c = 0) {
    return std::unexpected(Error{code, subject, {a, b, c}});
}

}  // namespace takt

#define TAKT_CONCAT_(a, b) a##b
#define TAKT_CONCAT(a, b) TAKT_CONCAT_(a, b)
#define TAKT_TRY_(temporary, target, expression)                          \
    auto temporary = (expression);                                        \
    if (!temporary) return std::unexpected(std::move(temporary).error()); \
    target = *std::move(temporary)

/// `TAKT_TRY(auto value, f());` — the value of f(), or return its error from the enclosing function.
#define TAKT_TRY(target, expression) TAKT_TRY_(TAKT_CONCAT(takt_try_, __LINE__), target, expression)

/// The same for a Result<void>.
#define TAKT_CHECK(expression)                                                                             \
    do {                                                                                                   \
        if (auto takt_checked = (expression); !takt_checked) return std::unexpected(takt_checked.error()); \
    } while (false)
