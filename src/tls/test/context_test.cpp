#include "takt/tls/context.hpp"

#include <gtest/gtest.h>

#include <cerrno>
#include <fstream>

#include "certificates.hpp"

namespace takt::tls {
namespace context_test {

const Identity kRoot = make({.name = "Root"});
const Identity kServer = make({.usage = "serverAuth", .also = "DNS:localhost"}, &kRoot);

Error error_of(const model::TlsFiles& files) {
    const auto loaded = Context::load(Side::server, files);
    return loaded ? Error{} : loaded.error();
}

Error fault(TlsFault fault, const std::string& file) {
    return {Code::tls_failed, std::string_view(file), {static_cast<std::int64_t>(fault), 0, 0}};
}

TEST(Context, NamesTheFileThatCannotBeUsed) {
    const Folder folder;
    const auto good = folder.files(kRoot, kServer);
    const auto text = folder.path("text.pem");
    std::ofstream(text) << "-----BEGIN CERTIFICATE-----\nAAAA\n-----END CERTIFICATE-----\n";
    auto files = good;
    files.ca = folder.path("missing.pem");
    EXPECT_EQ(error_of(files), (Error{Code::cannot_open, std::string_view(files.ca), {ENOENT, 0, 0}}));
    files = good;
    files.ca = text;
    EXPECT_EQ(error_of(files), fault(TlsFault::file, text));
    files = good;
    files.certificate = good.key;
    EXPECT_EQ(error_of(files), fault(TlsFault::file, good.key));
    files = good;
    files.key = good.ca;
    EXPECT_EQ(error_of(files), fault(TlsFault::file, good.ca));
    files = good;
    files.key = folder.write("other.key", kRoot, true);
    EXPECT_EQ(error_of(files), fault(TlsFault::key, files.key));
    files = good;
    files.crl = good.ca;
    EXPECT_EQ(error_of(files), fault(TlsFault::file, good.ca));
    files = good;
    files.ca = "/tmp";
    EXPECT_EQ(error_of(files).code, Code::cannot_open);
}

}  // namespace context_test
}  // namespace takt::tls
