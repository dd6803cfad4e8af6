// The files of one side of TLS connections.
#pragma once

#include <string>
#include <string_view>

namespace takt::model {

/// The files of one side, in PEM, with absolute paths or paths from the working folder; and the server that a
/// client expects.
/// Source: Modbus/TCP Security v36, R-02, R-03, R-46, section 8.2.
struct TlsFiles {
    std::string ca;           ///< one or more roots; the peer's certificate must lead to one of them
    std::string certificate;  ///< the own one, then those between it and the root, if any
    std::string key;          ///< of the certificate, without a passphrase
    std::string crl;          ///< lists of revoked certificates; empty: none is checked
    std::string server_name;  ///< a client: in the server's certificate; empty: the host it connects to
    friend bool operator==(const TlsFiles&, const TlsFiles&) = default;
};

/// The folder of the certificates of a plant, beside the project or in the working folder.
inline constexpr std::string_view kCertificateFolder = "certs/";

/// The files that are used unless others are named: ca.pem, OWN.pem and OWN.key.
/// @param folder  ends with a slash, or is empty
/// @param own     "client", "server"
[[nodiscard]] inline TlsFiles files_in(const std::string& folder, std::string_view own) {
    const auto name = folder + std::string(own);
    return {.ca = folder + "ca.pem", .certificate = name + ".pem", .key = name + ".key"};
}

}  // namespace takt::model
