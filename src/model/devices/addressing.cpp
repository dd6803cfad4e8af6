#include "devices/addressing.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

namespace takt::model {
namespace {

using wire::Area;
using wire::Function;

constexpr std::uint32_t kAddresses = 65536;
constexpr std::uint32_t kBitsPerRegister = 16;

/// `40001` as `0x9C41`.
std::string hexadecimal(std::string_view decimal) {
    std::array<char, 8> digits{};
    const auto number = static_cast<std::uint32_t>(parse_integer(decimal)->magnitude);
    auto* const end = std::to_chars(digits.data(), digits.data() + digits.size(), number, 16).ptr;
    std::string text(digits.data(), end);
    std::ranges::transform(text, text.begin(), [](char c) { return c >= 'a' ? char(c - 'a' + 'A') : c; });
    return "0x" + text;
}

/// The steps of settle_address().
class Settling {
public:
    Settling(Reader& reader, Variable& variable, std::optional<DataType> type)
        : reader_(reader), variable_(variable), type_(type) {}

    void run() {
        read_reference();
        find_area();
        if (area_) check_functions();
        if (area_ && type_) check_type();
        check_notations();
        if (type_ == DataType::boolean)
            find_bit();
        else if (reader_.given("bit"))
            check_bit_without_bool();
        find_number();
    }

private:
    void read_reference() {
        const Node* const node = reader_.scalar("reference");
        if (node == nullptr) return;
        reference_ = parse_reference(node->text);
        if (!reference_) reader_.report(Rule::reference_malformed, "reference", kReferences);
    }

    void find_area() {
        const auto written = reader_.choice<Area>("area");
        if (reference_)
            area_ = reference_->area;
        else if (written)
            area_ = written;
        else if (variable_.read)
            area_ = area_of(*variable_.read);
        else if (variable_.write)
            area_ = area_of(*variable_.write);
        else if (reader_.given("coil"))
            area_ = Area::coil;
        const bool named = reader_.given("area") || reader_.given("reference");
        const bool wrong_function = is_wrong("read", variable_.read) || is_wrong("write", variable_.write);
        if (area_)
            variable_.area = *area_;
        else if (!named && !wrong_function && !reader_.misspelt("read") && !reader_.misspelt("write") &&
                 !reader_.misspelt("area"))
            reader_.report(Rule::variable_area_missing, "area", joined(kAreas));
        if (area_ && !reader_.given("read") && !reader_.given("write"))
            variable_.read = read_function(*area_);
    }

    /// Whether the key holds a function that could not be read.
    bool is_wrong(std::string_view key, const std::optional<Function>& function) const {
        const Node* const node = reader_.value(key);
        return node != nullptr && !function && node->text != "none";
    }

    static std::string joined(std::span<const std::string_view> words) {
        std::string all;
        for (const auto word : words) all.append(all.empty() ? "" : ", ").append(word);
        return all;
    }

    void check_functions() {
        const Arguments area{{"area", area_name(*area_)}};
        if (variable_.read && area_of(*variable_.read) != *area_)
            reader_.report(Rule::variable_function_area, "read", "none, " + read_functions(*area_), area);
        if (!variable_.write) return;
        const Area written = area_of(*variable_.write);
        const bool area_given = reader_.value("area") != nullptr || reader_.value("reference") != nullptr;
        // Some devices show the same registers in both areas: read with 0x04, written with 0x10.
        if (write_functions(*area_).empty() && !area_given && is_bit_area(written) == is_bit_area(*area_))
            reader_.report(Rule::variable_overlaid_areas, "write", "none",
                           {{"area", area_name(*area_)}, {"written", area_name(written)}});
        else if (write_functions(*area_).empty())
            reader_.report(Rule::variable_read_only_area, "write", "none", area);
        else if (written != *area_)
            reader_.report(Rule::variable_function_area, "write", "none, " + write_functions(*area_), area);
    }

    void check_type() {
        if (!is_bit_area(*area_) || type_ == DataType::boolean) return;
        reader_.report(Rule::variable_type_area, "type", "bool",
                       {{"type", std::string(name(*type_))}, {"area", area_name(*area_)}});
        type_.reset();
    }

    /// An address is given in one form only: register and bit, coil, or reference.
    void check_notations() {
        static constexpr std::pair<std::string_view, std::string_view> kExclusive[] = {
            {"register", "coil"},
            {"register", "reference"},
            {"coil", "reference"},
            {"area", "reference"},
            {"bit", "coil"}};
        for (const auto& [key, other] : kExclusive)
            if (reader_.given(key) && reader_.given(other)) clash(key, other);
        if (reader_.given("bit") && reference_ && is_bit_area(reference_->area)) clash("bit", "reference");
        constexpr std::array<std::string_view, 3> kAddressKeys{"register", "coil", "reference"};
        if (std::ranges::none_of(kAddressKeys,
                                 [this](auto key) { return reader_.given(key) || reader_.misspelt(key); }))
            reader_.report(Rule::variable_address_missing, "register", "0..65535");
    }

    void clash(std::string_view key, std::string_view other) {
        reader_.report(Rule::variable_address_twice, key, {},
                       {{"key", std::string(key)}, {"other", std::string(other)}});
    }

    void check_bit_without_bool() {
        reader_.integer("bit");
        if (type_) reader_.report(Rule::variable_bit_type, "bit", {}, {{"type", std::string(name(*type_))}});
    }

    static Rule coil_rule(Area area) {
        return area == Area::coil ? Rule::variable_coil_assumed : Rule::variable_discrete_input_assumed;
    }

    void find_bit() {
        variable_.bit = static_cast<std::uint8_t>(reader_.integer("bit").value_or(0));
        const bool direct = reader_.given("coil") || (reference_ && is_bit_area(reference_->area));
        if (direct || reader_.given("bit")) return;
        const auto number = reader_.given("register") ? reader_.integer("register") : std::nullopt;
        if (number && *number > 0 && area_ && is_bit_area(*area_))
            reader_.report(coil_rule(*area_), "register", "0..15",
                           {{"number", std::to_string(*number)}, {"coil", std::to_string(*number * 16)}});
        else if (reader_.given("register") || reference_)
            reader_.report(Rule::variable_bit_assumed, reader_.given("register") ? "register" : "reference",
                           "0..15");
    }

    void find_number() {
        if (report_reference()) return;
        const auto number = reader_.integer("register");
        const auto coil = reader_.integer("coil");
        if (coil)
            set_coil(static_cast<std::uint16_t>(*coil), "coil");
        else if (reference_ && is_bit_area(reference_->area))
            set_coil(reference_->number, "reference");
        else if (reference_)
            set_register(reference_->number, "reference");
        else if (number)
            set_register(static_cast<std::uint16_t>(*number), "register");
    }

    /// A reference in `register` that is no address on the wire: `400001`, and `10001` as the register of a
    /// discrete input.
    bool report_reference() {
        const auto meant = like_reference(reader_, "register", area_);
        if (!meant) return false;
        const auto address = parse_integer(reader_.value("register")->text)->magnitude;
        const auto addresses = is_bit_area(meant->area) ? kAddresses / kBitsPerRegister : kAddresses;
        if (address < addresses) return false;
        reader_.report(Rule::address_is_reference, "register", "0.." + std::to_string(addresses - 1),
                       {{"area", area_name(meant->area)}, {"number", std::to_string(meant->number)}});
        return true;
    }

    void set_coil(std::uint16_t coil, std::string_view key) {
        variable_.register_number = static_cast<std::uint16_t>(coil / kBitsPerRegister);
        variable_.bit = static_cast<std::uint8_t>(coil % kBitsPerRegister);
        if (area_ && !is_bit_area(*area_) && type_ == DataType::boolean)
            reader_.report(Rule::variable_coil_area, key, "coil, discrete_input",
                           {{"area", area_name(*area_)}});
        else if (key == "coil" && type_ && type_ != DataType::boolean)
            reader_.report(Rule::variable_bit_type, key, {}, {{"type", std::string(name(*type_))}});
    }

    void set_register(std::uint16_t number, std::string_view key) {
        variable_.register_number = number;
        if (!area_ || !type_) return;
        const bool coils = is_bit_area(*area_);
        const std::uint32_t greatest =
            coils ? kAddresses / kBitsPerRegister - 1 : kAddresses - variable_.registers;
        if (number > greatest)
            reader_.report(Rule::variable_beyond_end, key, "0.." + std::to_string(greatest),
                           {{"items", std::to_string(coils ? 1 : variable_.registers)}});
    }

    static constexpr const char* kReferences =
        "\"00001\"..\"09999\", \"10001\"..\"19999\", \"30001\"..\"39999\", \"40001\"..\"49999\"; "
        "\"000001\"..\"065536\", \"100001\"..\"165536\", \"300001\"..\"365536\", \"400001\"..\"465536\"";

    Reader& reader_;
    Variable& variable_;
    std::optional<DataType> type_;
    std::optional<Reference> reference_;
    std::optional<Area> area_;
};

}  // namespace

std::optional<Reference> parse_reference(std::string_view text) {
    if (text.size() != 5 && text.size() != 6) return std::nullopt;
    std::uint32_t number = 0;
    for (const char c : text.substr(1)) {
        if (c < '0' || c > '9') return std::nullopt;
        number = number * 10 + static_cast<std::uint32_t>(c - '0');
    }
    if (number < 1 || number > kAddresses) return std::nullopt;
    const auto zero_based = static_cast<std::uint16_t>(number - 1);
    switch (text[0]) {
        case '0': return Reference{Area::coil, zero_based};
        case '1': return Reference{Area::discrete_input, zero_based};
        case '3': return Reference{Area::input_register, zero_based};
        case '4': return Reference{Area::holding_register, zero_based};
        default: return std::nullopt;
    }
}

std::optional<Reference> like_reference(const Reader& reader, std::string_view key,
                                        std::optional<wire::Area> area) {
    const Node* const node = reader.value(key);
    if (node == nullptr || node->kind != Node::Kind::scalar || is_quoted(*node)) return std::nullopt;
    const auto meant = node->text.starts_with('0') ? std::nullopt : parse_reference(node->text);
    if (!meant || (area && meant->area != *area)) return std::nullopt;
    return meant;
}

void note_like_reference(Interpretation& state, const Reader& reader, const Variable& variable) {
    const bool known = reader.given("area") || reader.given("read") || reader.given("write");
    const auto area = known ? std::optional(variable.area) : std::nullopt;
    for (const std::string_view key : {"register", "coil"}) {
        const auto meant = like_reference(reader, key, area);
        if (!meant || parse_integer(reader.value(key)->text)->magnitude >= kAddresses) continue;
        if (is_bit_area(meant->area) != (key == "coil")) continue;
        auto& seen = state.like_references;
        if (++seen.count > 1) return;
        const Node& node = *reader.value(key);
        seen = {.location = node.location, .path = reader.path_of(key), .text = node.text, .count = 1};
        seen.arguments = {{"area", area_name(meant->area)}, {"number", std::to_string(meant->number)}};
        return;
    }
}

void report_like_references(Interpretation& state) {
    auto seen = std::exchange(state.like_references, {});
    if (seen.count == 0) return;
    seen.arguments.emplace_back("wire", hexadecimal(seen.text));
    seen.arguments.emplace_back("count", std::to_string(seen.count));
    state.findings.add(Rule::address_like_reference, seen.location, seen.path, seen.text, {},
                       std::move(seen.arguments));
}

std::string area_name(wire::Area area) {
    return std::string(kAreas[static_cast<std::size_t>(area)]);
}

std::string read_functions(wire::Area area) {
    return std::string(kReadFunctions[static_cast<std::size_t>(read_function(area))]);
}

std::string write_functions(wire::Area area) {
    if (area == Area::coil) return "0x05, 0x0F";
    if (area == Area::holding_register) return "0x06, 0x10";
    return {};
}

void settle_address(Reader& reader, Variable& variable, std::optional<DataType> type) {
    Settling(reader, variable, type).run();
}

}  // namespace takt::model
