#include "role.hpp"

#include <openssl/asn1.h>
#include <openssl/objects.h>
#include <openssl/x509.h>

#include <memory>

#include "takt/base/utf8.hpp"

namespace takt::tls {
namespace {

constexpr std::uint8_t kUtf8String = 0x0C;

bool is_name(std::string_view text) {
    while (!text.empty()) {
        const Character first = first_character(text);
        if (first.bytes == 0 || !is_printable(first.code)) return false;
        text.remove_prefix(first.bytes);
    }
    return true;
}

}  // namespace

std::string role_text(std::span<const std::uint8_t> der) {
    constexpr std::size_t kHead = 2;  // type and length; a longer form of the length is for longer texts
    if (der.size() < kHead || der[0] != kUtf8String) return {};
    const std::size_t length = der[1];
    if (length == 0 || length > kLongestRole || der.size() != kHead + length) return {};
    const auto bytes = der.subspan(kHead);
    std::string role(bytes.begin(), bytes.end());
    return is_name(role) ? role : std::string();
}

std::string role_of(const x509_st& certificate) {
    struct Free {
        void operator()(ASN1_OBJECT* object) const { ASN1_OBJECT_free(object); }
    };
    constexpr int kDigitsOnly = 1;
    const std::unique_ptr<ASN1_OBJECT, Free> id(
        OBJ_txt2obj(std::string(kRoleExtension).c_str(), kDigitsOnly));
    const int first = X509_get_ext_by_OBJ(&certificate, id.get(), -1);
    if (first < 0 || X509_get_ext_by_OBJ(&certificate, id.get(), first) >= 0) return {};
    const ASN1_OCTET_STRING* const value = X509_EXTENSION_get_data(X509_get_ext(&certificate, first));
    return role_text({ASN1_STRING_get0_data(value), static_cast<std::size_t>(ASN1_STRING_length(value))});
}

}  // namespace takt::tls
