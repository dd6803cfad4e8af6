// The role in a client's certificate.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

struct x509_st;  // OpenSSL's X509

namespace takt::tls {

/// The extension that holds it: Modbus/TCP Security v36, R-21.
inline constexpr std::string_view kRoleExtension = "1.3.6.1.4.1.50316.802.1";
inline constexpr std::size_t kLongestRole = 64;  ///< bytes of UTF-8

/// The role that a certificate grants. Without one, and with one that is not exactly one UTF8String of 1 to
/// kLongestRole bytes without control characters, it is empty: the null role, which the access rules decide
/// about (R-22, R-23, R-65; OpenSSL itself accepts a certificate with two of these extensions).
[[nodiscard]] std::string role_of(const x509_st& certificate);

/// The text of a UTF8String in DER (X.690, 8.23); empty: it is
/// none, or no role. Pure.
[[nodiscard]] std::string role_text(std::span<const std::uint8_t> der);

}  // namespace takt::tls
