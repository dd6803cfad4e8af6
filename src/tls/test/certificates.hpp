// Certificates made for a test, also those that no tool would make.
#pragma once

#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509v3.h>

#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "role.hpp"
#include "takt/model/tls_files.hpp"

namespace takt::tls {

struct Identity {
    std::shared_ptr<EVP_PKEY> key;
    std::shared_ptr<X509> certificate;
};

struct Wanted {
    std::string name = "localhost";
    std::string usage;  ///< "serverAuth"; empty: a root
    std::string also;   ///< subjectAltName, as OpenSSL writes it
    long begins = -3600;
    long ends = 86400;                                  ///< seconds from now
    std::vector<std::vector<std::uint8_t>> roles = {};  ///< DER of each extension
};

/// A UTF8String.
inline std::vector<std::uint8_t> utf8_string(const std::string& text) {
    std::vector<std::uint8_t> der{0x0C, static_cast<std::uint8_t>(text.size())};
    der.insert(der.end(), text.begin(), text.end());
    return der;
}

inline void add(X509* to, X509* issuer, int kind, const char* value) {
    X509V3_CTX context;
    X509V3_set_ctx(&context, issuer, to, nullptr, nullptr, 0);
    X509_EXTENSION* const extension = X509V3_EXT_conf_nid(nullptr, &context, kind, value);
    X509_add_ext(to, extension, -1);
    X509_EXTENSION_free(extension);
}

inline void add_role(X509* to, const std::vector<std::uint8_t>& der) {
    ASN1_OBJECT* const id = OBJ_txt2obj(std::string(kRoleExtension).c_str(), 1);
    ASN1_OCTET_STRING* const value = ASN1_OCTET_STRING_new();
    ASN1_OCTET_STRING_set(value, der.data(), static_cast<int>(der.size()));
    X509_EXTENSION* const extension = X509_EXTENSION_create_by_OBJ(nullptr, id, 0, value);
    X509_add_ext(to, extension, -1);
    X509_EXTENSION_free(extension);
    ASN1_OCTET_STRING_free(value);
    ASN1_OBJECT_free(id);
}

/// A certificate with a key of its own, signed by `issuer`, or by itself.
inline Identity make(const Wanted& wanted, const Identity* issuer = nullptr) {
    static long serial = 0;
    const Identity made{{EVP_EC_gen("P-256"), EVP_PKEY_free}, {X509_new(), X509_free}};
    X509* const it = made.certificate.get();
    const Identity& by = issuer ? *issuer : made;
    X509_set_version(it, 2);
    ASN1_INTEGER_set(X509_get_serialNumber(it), ++serial);
    X509_gmtime_adj(X509_getm_notBefore(it), wanted.begins);
    X509_gmtime_adj(X509_getm_notAfter(it), wanted.ends);
    X509_set_pubkey(it, made.key.get());
    X509_NAME_add_entry_by_txt(X509_get_subject_name(it), "CN", MBSTRING_UTF8,
                               reinterpret_cast<const unsigned char*>(wanted.name.c_str()), -1, -1, 0);
    X509_set_issuer_name(it, X509_get_subject_name(by.certificate.get()));
    const bool root = wanted.usage.empty();
    add(it, by.certificate.get(), NID_basic_constraints, root ? "critical,CA:TRUE" : "critical,CA:FALSE");
    add(it, by.certificate.get(), NID_key_usage,
        root ? "critical,keyCertSign,cRLSign" : "critical,digitalSignature");
    if (!root) add(it, by.certificate.get(), NID_ext_key_usage, wanted.usage.c_str());
    if (!wanted.also.empty()) add(it, by.certificate.get(), NID_subject_alt_name, wanted.also.c_str());
    for (const auto& role : wanted.roles) add_role(it, role);
    X509_sign(it, by.key.get(), EVP_sha256());
    return made;
}

/// The program ignores it (app/program.cpp).
inline const auto kIgnored = std::signal(SIGPIPE, SIG_IGN);

/// The folder of a test, deleted at its end.
class Folder {
public:
    Folder() {
        std::string name = (std::filesystem::temp_directory_path() / "takt-tls-XXXXXX").string();
        path_ = ::mkdtemp(name.data());
    }
    ~Folder() { std::filesystem::remove_all(path_); }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;

    [[nodiscard]] std::string write(const std::string& name, const Identity& what, bool key = false) const {
        return with(name, [&](BIO* out) {
            key ? PEM_write_bio_PrivateKey(out, what.key.get(), nullptr, nullptr, 0, nullptr, nullptr)
                : PEM_write_bio_X509(out, what.certificate.get());
        });
    }

    /// A list of the issuer's revoked certificates, for a day.
    [[nodiscard]] std::string write_list(const std::string& name, const Identity& issuer,
                                         const std::vector<Identity>& revoked) const {
        X509_CRL* const list = X509_CRL_new();
        X509_CRL_set_version(list, 1);
        X509_CRL_set_issuer_name(list, X509_get_subject_name(issuer.certificate.get()));
        ASN1_TIME* const time = X509_gmtime_adj(nullptr, -60);
        X509_CRL_set1_lastUpdate(list, time);
        for (const auto& identity : revoked) {
            X509_REVOKED* const entry = X509_REVOKED_new();
            X509_REVOKED_set_serialNumber(entry, X509_get_serialNumber(identity.certificate.get()));
            X509_REVOKED_set_revocationDate(entry, time);
            X509_CRL_add0_revoked(list, entry);
        }
        X509_gmtime_adj(time, 86400);
        X509_CRL_set1_nextUpdate(list, time);
        ASN1_TIME_free(time);
        X509_CRL_sign(list, issuer.key.get(), EVP_sha256());
        const auto path = with(name, [&](BIO* out) { PEM_write_bio_X509_CRL(out, list); });
        X509_CRL_free(list);
        return path;
    }

    [[nodiscard]] std::string path(const std::string& name) const { return path_ + "/" + name; }

    [[nodiscard]] model::TlsFiles files(const Identity& root, const Identity& own) const {
        return {.ca = write("ca.pem", root),
                .certificate = write("own.pem", own),
                .key = write("own.key", own, true)};
    }

private:
    template <class Write>
    std::string with(const std::string& name, const Write& write) const {
        const auto file = path(name);
        BIO* const out = BIO_new_file(file.c_str(), "w");
        write(out);
        BIO_free(out);
        return file;
    }

    std::string path_;
};

}  // namespace takt::tls
