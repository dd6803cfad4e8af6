// TLS with certificates that the test makes, and a real mosquitto.
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "broker_process.hpp"
#include "live_session.hpp"

namespace takt::publish {
namespace mosquitto_tls_test {

class Certificates {
public:
    Certificates() {
        authority("ca");
        authority("other");
    }

    void authority(const std::string& name) const {
        run("openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -days 2 -subj /CN=" +
            name + " -keyout " + folder / (name + ".key") + " -out " + folder / (name + ".pem"));
    }
    /// A certificate of "ca" for these names, valid for so many days from now on.
    void issue(const std::string& name, const std::string& names, int days = 2) const {
        folder.write("names", "subjectAltName=" + names + "\n");
        run("openssl req -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -subj /CN=" + name +
            " -keyout " + folder / (name + ".key") + " -out " + folder / "request");
        run("openssl x509 -req -in " + folder / "request" + " -CA " + folder / "ca.pem" + " -CAkey " +
            folder / "ca.key" + " -CAcreateserial -extfile " + folder / "names" + " -days " +
            std::to_string(days) + " -out " + folder / (name + ".pem"));
    }
    [[nodiscard]] std::string settings(const std::string& name, const std::string& more = {}) const {
        return "allow_anonymous true\ncertfile " + folder / (name + ".pem") + "\nkeyfile " +
               folder / (name + ".key") + "\n" + more;
    }

    takt::test::Folder folder;

private:
    static void run(const std::string& command) {
        ASSERT_EQ(std::system((command + " >/dev/null 2>&1").c_str()), 0) << command;
    }
};

struct MosquittoTlsBroker : testing::Test {
    /// A session with a broker of this certificate.
    LiveSession& connect(const std::string& name, MqttTls tls, const std::string& settings = {},
                         const std::string& host = "localhost") {
        broker.emplace(certificates.settings(name, settings));
        live.emplace(broker->port());
        live->options.brokers[0].host = host;
        live->options.brokers[0].tls = std::move(tls);
        live->start();
        return *live;
    }

    Certificates certificates;
    std::string ca = certificates.folder / "ca.pem";
    std::optional<TestBroker> broker;
    std::optional<LiveSession> live;
};

TEST_F(MosquittoTlsBroker, ACertificateOfTheAuthorityForTheNameIsAccepted) {
    certificates.issue("good", "DNS:localhost,IP:127.0.0.1");
    for (const char* host : {"localhost", "127.0.0.1"}) {
        auto& session = connect("good", {.ca_file = ca}, {}, host);
        session.source.count = 2000;
        EXPECT_TRUE(session.delivers_all()) << host;
        session.stop();
    }
}

TEST_F(MosquittoTlsBroker, ACertificateOfAnotherAuthorityIsRejected) {
    certificates.issue("good", "DNS:localhost");
    EXPECT_TRUE(connect("good", {.ca_file = certificates.folder / "other.pem"})
                    .fails_with(MqttFailureKind::tls_unknown_issuer));
    EXPECT_TRUE(connect("good", {}).fails_with(MqttFailureKind::tls_unknown_issuer))
        << "the authorities of the system do not know it";
}

TEST_F(MosquittoTlsBroker, AnExpiredCertificateIsRejected) {
    certificates.issue("expired", "DNS:localhost", -1);
    EXPECT_TRUE(connect("expired", {.ca_file = ca}).fails_with(MqttFailureKind::tls_expired));
}

TEST_F(MosquittoTlsBroker, ACertificateForAnotherNameIsRejected) {
    certificates.issue("other-name", "DNS:broker.example");
    EXPECT_TRUE(connect("other-name", {.ca_file = ca}).fails_with(MqttFailureKind::tls_other_name));
    EXPECT_TRUE(
        connect("other-name", {.ca_file = ca}, {}, "127.0.0.1").fails_with(MqttFailureKind::tls_other_name));
}

TEST_F(MosquittoTlsBroker, AClientCertificateMayBeRequired) {
    certificates.issue("good", "DNS:localhost");
    certificates.issue("client", "DNS:takt");
    const std::string required = "require_certificate true\ncafile " + ca + "\n";
    EXPECT_TRUE(connect("good", {.ca_file = ca}, required).fails_with(MqttFailureKind::tls));
    EXPECT_NE(live->status().last_failure->text.find("certificate"), std::string::npos)
        << live->status().last_failure->text;
    EXPECT_TRUE(connect("good",
                        {.ca_file = ca,
                         .certificate_file = certificates.folder / "client.pem",
                         .key_file = certificates.folder / "client.key"},
                        required)
                    .connects());
}

TEST_F(MosquittoTlsBroker, AFileThatCannotBeUsedIsNamed) {
    certificates.issue("good", "DNS:localhost");
    EXPECT_TRUE(connect("good", {.ca_file = "/no/such/file"}).fails_with(MqttFailureKind::tls_files));
    EXPECT_EQ(live->status().last_failure->text, "/no/such/file: No such file or directory");
    EXPECT_TRUE(connect("good", {.ca_file = ca,
                                 .certificate_file = certificates.folder / "good.pem",
                                 .key_file = certificates.folder / "other.key"})
                    .fails_with(MqttFailureKind::tls_files))
        << "the key of another certificate";
}

TEST_F(MosquittoTlsBroker, AFifoIsNotWaitedFor) {
    certificates.issue("good", "DNS:localhost");
    const auto fifo = certificates.folder / "fifo";
    ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
    for (const MqttTls& files :
         {MqttTls{.ca_file = fifo}, MqttTls{.ca_file = ca, .certificate_file = fifo, .key_file = ca},
          MqttTls{.ca_file = ca, .key_file = fifo}}) {
        EXPECT_TRUE(connect("good", files).fails_with(MqttFailureKind::tls_files));
        EXPECT_EQ(live->status().last_failure->text, fifo + ": not a regular file");
    }
}

TEST_F(MosquittoTlsBroker, APlainBrokerIsNotOneWithTls) {
    broker.emplace();
    live.emplace(broker->port());
    live->options.brokers[0].tls = MqttTls{.ca_file = ca};
    live->start();
    EXPECT_TRUE(live->run([this] { return live->status().last_failure.has_value(); }));
    EXPECT_FALSE(live->connects(500ms));
}

}  // namespace mosquitto_tls_test
}  // namespace takt::publish
