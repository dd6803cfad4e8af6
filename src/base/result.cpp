#include "takt/base/result.hpp"

namespace takt {

std::string_view name(Code code) {
    switch (code) {
        case Code::out_of_range: return "out_of_range";
        case Code::malformed: return "malformed";
        case Code::too_short: return "too_short";
        case Code::too_long: return "too_long";
        case Code::unsupported: return "unsupported";
        case Code::not_found: return "not_found";
        case Code::overflow: return "overflow";
        case Code::not_writable: return "not_writable";
        case Code::read_only: return "read_only";
        case Code::queue_full: return "queue_full";
        case Code::syntax: return "syntax";
        case Code::cannot_open: return "cannot_open";
        case Code::busy: return "busy";
        case Code::connection_lost: return "connection_lost";
        case Code::closed_by_peer: return "closed_by_peer";
        case Code::timed_out: return "timed_out";
        case Code::io_failed: return "io_failed";
        case Code::replaced: return "replaced";
        case Code::tls_failed: return "tls_failed";
        case Code::modbus_exception: return "modbus_exception";
        case Code::bad_checksum: return "bad_checksum";
        case Code::unexpected_reply: return "unexpected_reply";
        case Code::not_modbus: return "not_modbus";
        case Code::misdirected: return "misdirected";
    }
    return "unknown";
}

std::string_view name(TlsFault fault) {
    constexpr std::array<std::string_view, kTlsFaults> kTlsFaultNames{"other",
                                                                      "not_tls",
                                                                      "version",
                                                                      "algorithms",
                                                                      "no_certificate",
                                                                      "untrusted",
                                                                      "expired",
                                                                      "not_yet_valid",
                                                                      "revoked",
                                                                      "other_name",
                                                                      "purpose",
                                                                      "revocation_list",
                                                                      "refused",
                                                                      "refused_untrusted",
                                                                      "refused_expired",
                                                                      "refused_revoked",
                                                                      "file",
                                                                      "key"};
    return kTlsFaultNames[static_cast<std::size_t>(fault)];
}

std::string_view name(Mismatch::Part part) {
    switch (part) {
        case Mismatch::Part::unit: return "unit";
        case Mismatch::Part::function: return "function";
        case Mismatch::Part::length: return "length";
        case Mismatch::Part::transaction: break;
    }
    return "transaction";
}

}  // namespace takt
