#include "takt/client/raw_request.hpp"

#include <algorithm>

namespace takt::client {

Result<wire::Pdu> parse_pdu(const std::vector<std::string>& words) {
    std::string digits;
    for (const auto& word : words)
        digits += word.starts_with("0x") || word.starts_with("0X") ? word.substr(2) : word;
    std::erase_if(digits, [](char c) { return c == ' ' || c == ':' || c == ','; });
    wire::Pdu pdu;
    if (digits.empty() || digits.size() % 2 != 0) return fail(Code::syntax, digits);
    for (std::size_t i = 0; i < digits.size(); i += 2) {
        const auto pair = digits.substr(i, 2);
        if (pair.find_first_not_of("0123456789abcdefABCDEF") != std::string::npos)
            return fail(Code::syntax, pair);
        if (!pdu.try_push_back(static_cast<std::uint8_t>(std::stoul(pair, nullptr, 16))))
            return fail(Code::too_long, static_cast<std::int64_t>(digits.size() / 2), wire::kMaxPdu);
    }
    return pdu;
}

}  // namespace takt::client
