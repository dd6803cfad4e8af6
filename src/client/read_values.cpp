#include <algorithm>
#include <span>

#include "takt/client/values.hpp"

namespace takt::client {

std::uint32_t ReadSpec::value_items() const {
    return is_bit_area(area) ? 1 : static_cast<std::uint32_t>(layout.register_count());
}

std::vector<wire::ReadRequest> read_requests(const ReadSpec& spec) {
    const auto function = wire::read_function(spec.area);
    const std::size_t size = spec.value_items();
    const std::size_t most = wire::max_items(wire::Framing::tcp, function) / size * size;
    const std::size_t total = spec.items();
    std::vector<wire::ReadRequest> requests;
    for (std::size_t done = 0; done < total; done += most)
        requests.push_back({function, DataAddress{static_cast<std::uint16_t>(spec.start + done)},
                            static_cast<std::uint16_t>(std::min(most, total - done))});
    return requests;
}

Result<void> append_values(const ReadSpec& spec, std::uint16_t start, const wire::ResponseView& response,
                           std::vector<ReadValue>& values) {
    const auto address = [start](std::size_t item) { return static_cast<std::uint16_t>(start + item); };
    const auto bits = response.bits();
    for (std::size_t i = 0; i < bits.size(); ++i) values.push_back({address(i), value::Value(bits[i])});
    std::vector<std::uint16_t> registers(response.registers().size());
    response.registers().copy_to(registers);
    const std::size_t size = spec.value_items();
    for (std::size_t i = 0; i + size <= registers.size(); i += size) {
        TAKT_TRY(auto value,
                 value::decode(spec.layout, std::span<const std::uint16_t>(registers).subspan(i, size)));
        values.push_back({address(i), std::move(value)});
    }
    return {};
}

Result<void> read_values(Client& client, const ReadSpec& spec, std::vector<ReadValue>& values) {
    for (const auto& request : read_requests(spec)) {
        TAKT_TRY(const auto response, client.ask(request));
        TAKT_CHECK(append_values(spec, request.start.value, response, values));
    }
    return {};
}

}  // namespace takt::client
