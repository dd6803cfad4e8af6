// takt latency on large captures: wall time and memory for 1 and for 10 million packets.
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "arguments.hpp"
#include "takt/capture/pcapng_format.hpp"
#include "working_folder.hpp"

namespace takt::bench {
namespace {

constexpr std::size_t kConnections = 64;
constexpr std::size_t kPayload = 12;  // of a request; a response of one register has 11 bytes
constexpr std::size_t kHeaders = 14 + 20 + 20;
constexpr std::size_t kRecord = capture::format::kPcapRecord;

template <class T>
void put(std::uint8_t* at, T value) {
    std::memcpy(at, &value, sizeof value);
}

void put_be16(std::uint8_t* at, unsigned value) {
    at[0] = static_cast<std::uint8_t>(value >> 8);
    at[1] = static_cast<std::uint8_t>(value);
}

void put_be32(std::uint8_t* at, std::uint32_t value) {
    put_be16(at, value >> 16);
    put_be16(at + 2, value & 0xFFFF);
}

struct Connection {
    std::uint32_t client_sequence = 1;
    std::uint32_t server_sequence = 1;
    std::uint16_t transaction = 0;
};

/// Writes Ethernet packets of Modbus TCP: requests of one register and their responses, on many connections.
class CaptureWriter {
public:
    explicit CaptureWriter(const std::string& path) : file_(std::fopen(path.c_str(), "wb"), &std::fclose) {
        if (!file_) throw Failure("cannot write " + path);
        std::array<std::uint8_t, capture::format::kPcapHeader> header{};
        put(header.data(), capture::format::kNanosecondMagic);
        put(header.data() + 4, std::uint16_t{2});
        put(header.data() + 6, std::uint16_t{4});
        put(header.data() + 16, std::uint32_t{65535});
        put(header.data() + 20, std::uint32_t{1});
        write(header.data(), header.size());
    }

    void exchange(std::size_t index) {
        auto& connection = connections_[index % kConnections];
        ++connection.transaction;
        packet(index, connection, true);
        connection.client_sequence += kPayload;
        // A tail: 1 in 50,000 takes 2 ms.
        const bool slow = random() % 50'000 == 0;
        now_ns_ += slow ? 2'000'000 : 100'000 + random() % 100'000;
        packet(index, connection, false);
        connection.server_sequence += kPayload - 1;
        now_ns_ += 20'000;
    }

private:
    std::uint32_t random() { return seed_ = seed_ * 1664525U + 1013904223U, seed_ >> 8; }

    void write(const std::uint8_t* bytes, std::size_t count) {
        if (std::fwrite(bytes, 1, count, file_.get()) != count) throw Failure("the disk is full");
    }

    void packet(std::size_t index, const Connection& connection, bool request) {
        const std::size_t payload = request ? kPayload : kPayload - 1;
        const std::size_t length = kHeaders + payload;
        std::array<std::uint8_t, kRecord + kHeaders + kPayload> bytes{};
        put(bytes.data(), static_cast<std::uint32_t>(now_ns_ / 1'000'000'000));
        put(bytes.data() + 4, static_cast<std::uint32_t>(now_ns_ % 1'000'000'000));
        put(bytes.data() + 8, static_cast<std::uint32_t>(length));
        put(bytes.data() + 12, static_cast<std::uint32_t>(length));
        std::uint8_t* const ip = bytes.data() + kRecord + 14;
        put_be16(ip - 2, 0x0800);
        put_headers(ip, index, connection, request, payload);
        put_adu(ip + 40, connection.transaction, request);
        write(bytes.data(), kRecord + length);
    }

    void put_headers(std::uint8_t* ip, std::size_t index, const Connection& connection, bool request,
                     std::size_t payload) {
        const auto client = 0x0A000100U + static_cast<std::uint32_t>(index % kConnections);
        const auto server = 0x0A000001U + static_cast<std::uint32_t>(index % 8);
        put_be16(ip, 0x4500);
        put_be16(ip + 2, static_cast<unsigned>(40 + payload));
        put_be16(ip + 4, ++identification_ & 0xFFFF);
        put_be16(ip + 8, 0x4006);
        put_be32(ip + 12, request ? client : server);
        put_be32(ip + 16, request ? server : client);
        std::uint8_t* const tcp = ip + 20;
        put_be16(tcp, request ? 40000 : 502);
        put_be16(tcp + 2, request ? 502 : 40000);
        put_be32(tcp + 4, request ? connection.client_sequence : connection.server_sequence);
        put_be32(tcp + 8, request ? connection.server_sequence : connection.client_sequence);
        put_be16(tcp + 12, 0x5018);
        put_be16(tcp + 14, 65535);
    }

    static void put_adu(std::uint8_t* adu, std::uint16_t transaction, bool request) {
        put_be16(adu, transaction);
        put_be16(adu + 4, request ? 6 : 5);
        put_be16(adu + 6, 0x0103);
        put_be32(adu + 8, request ? 0x006B0001 : 0x02002A00);
    }

    std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
    std::vector<Connection> connections_{kConnections};
    std::uint64_t now_ns_ = 1'700'000'000'000'000'000;
    std::uint32_t seed_ = 1;
    unsigned identification_ = 0;
};

struct Run {
    double seconds = 0;
    double cpu_seconds = 0;
    double megabytes = 0;  // resident, at most
};

/// Runs `takt latency` beside this program.
Run measure(const std::string& path) {
    const auto takt = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "takt";
    const auto start = std::chrono::steady_clock::now();
    std::fflush(stdout);  // the child must not write it again
    const auto child = ::fork();
    if (child == 0) {
        if (std::freopen("/dev/null", "w", stdout) == nullptr) ::_exit(127);
        ::execl(takt.c_str(), "takt", "latency", path.c_str(), "--limit", "1ms", "--json", nullptr);
        ::_exit(127);
    }
    int status = 0;
    rusage used{};
    if (child < 0 || ::wait4(child, &status, 0, &used) != child) throw Failure("takt cannot be run");
    // 1: the tail exceeds the limit.
    if (!WIFEXITED(status) || WEXITSTATUS(status) > 1) throw Failure("takt latency failed");
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
    const auto seconds = [](const timeval& time) {
        return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) / 1e6;
    };
    return {wall.count(), seconds(used.ru_utime) + seconds(used.ru_stime),
            static_cast<double>(used.ru_maxrss) / 1024};
}

int run(const Arguments& arguments) {
    const bool json = arguments.json();
    const WorkingFolder work(arguments.text("--directory", "/var/tmp"));
    std::string objects;
    if (!json)
        fmt::print("{:>12} {:>9} {:>9} {:>9} {:>13}\n", "packets", "file, MB", "wall, s", "CPU, s",
                   "memory, MB");
    for (const std::uint64_t packets : {1'000'000U, 10'000'000U}) {
        const auto path = work / "a.pcap";
        {
            CaptureWriter writer(path);
            for (std::size_t i = 0; i < packets / 2; ++i) {
                if (i % 100'000 == 0) check_interrupted();
                writer.exchange(i);
            }
        }
        const auto size = static_cast<double>(std::filesystem::file_size(path)) / 1e6;
        const auto [wall, cpu, memory] = measure(path);
        if (!json)
            fmt::print("{:>12} {:>9.0f} {:>9.2f} {:>9.2f} {:>13.1f}\n", packets, size, wall, cpu, memory);
        objects += fmt::format("{}{{\"packets\":{},\"wall_s\":{:.3f},\"cpu_s\":{:.3f},\"memory_mb\":{:.1f}}}",
                               objects.empty() ? "" : ",", packets, wall, cpu, memory);
    }
    if (json) fmt::print("{{\"latency\":[{}]}}\n", objects);
    return 0;
}

}  // namespace
}  // namespace takt::bench

int main(int count, char** arguments) {
    return takt::bench::run_benchmark(count, arguments, {{"--directory", "D"}}, takt::bench::run);
}
