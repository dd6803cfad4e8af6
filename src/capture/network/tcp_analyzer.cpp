// Connections in the order of their last use: a list whose front was used last, and an index by the ends.
#include "takt/capture/tcp_analyzer.hpp"

#include <algorithm>
#include <list>
#include <unordered_map>
#include <utility>

#include "network/connection.hpp"
#include "network/hash.hpp"

namespace takt::capture {

struct ConnectionKeyHash {
    std::size_t operator()(const ConnectionKey& key) const {
        std::uint64_t hash = kFirstHash;
        for (const auto* end : {&key.low, &key.high}) hash = mixed(mixed(hash, end->address), end->port);
        return hash;
    }
};

namespace {

Roles roles_of(const ConnectionKey& key, const std::vector<std::uint16_t>& ports) {
    const auto is_known = [&](std::uint16_t port) { return std::ranges::find(ports, port) != ports.end(); };
    const bool low = is_known(key.low.port);
    const bool high = is_known(key.high.port);
    return {.server_is_high = high && !low, .certain = low != high};
}

}  // namespace

class TcpAnalyzer::Table {
public:
    Table(TcpAnalyzerConfig config, ExchangeSink& sink) : config_(std::move(config)), sink_(sink) {}

    void on_segment(const Segment& segment, const PacketRef& packet) {
        find(key_of(segment)).on_segment(segment, packet);
    }

    void end() {
        for (auto& connection : connections_) connection.finish(NoResponse::end);
        index_.clear();
        connections_.clear();
    }

    [[nodiscard]] const TcpCounts& counts() const { return counts_; }

private:
    using List = std::list<Connection>;

    Connection& find(const ConnectionKey& key) {
        if (!connections_.empty() && connections_.front().key() == key) return connections_.front();
        if (const auto found = index_.find(key); found != index_.end()) {
            connections_.splice(connections_.begin(), connections_, found->second);
            return connections_.front();
        }
        if (connections_.size() >= kMostConnections) evict();
        connections_.emplace_front(key, roles_of(key, config_.ports), config_, counts_, sink_);
        index_.emplace(key, connections_.begin());
        return connections_.front();
    }

    void evict() {
        auto& oldest = connections_.back();
        oldest.finish(NoResponse::unanswered);
        index_.erase(oldest.key());
        connections_.pop_back();
        ++counts_.evicted;
    }

    TcpAnalyzerConfig config_;
    ExchangeSink& sink_;
    TcpCounts counts_;
    List connections_;
    std::unordered_map<ConnectionKey, List::iterator, ConnectionKeyHash> index_;
};

TcpAnalyzer::TcpAnalyzer(TcpAnalyzerConfig config, ExchangeSink& sink)
    : table_(std::make_unique<Table>(std::move(config), sink)) {}

TcpAnalyzer::~TcpAnalyzer() = default;

void TcpAnalyzer::on_segment(const Segment& segment, const PacketRef& packet) {
    table_->on_segment(segment, packet);
}

void TcpAnalyzer::end() {
    table_->end();
}

TcpCounts TcpAnalyzer::counts() const {
    return table_->counts();
}

}  // namespace takt::capture
