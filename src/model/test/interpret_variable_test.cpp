// The keys of variables.
#include <gtest/gtest.h>

#include <limits>
#include <optional>
#include <string>

#include "findings_text.hpp"
#include "takt/model/fields.hpp"
#include "takt/model/findings.hpp"

namespace takt::model::test {
namespace interpret_variable_test {

TEST(Interpret, NamesWhatAnotherNotationMeans) {
    const struct {
        Changes changes;
        std::string_view code;
        std::vector<std::pair<std::string, std::string>> arguments;
    } cases[] = {
        {{.device = "{fc16: true}"},
         "key.unlike",
         {{"variant", "function"}, {"function", "write: 0x10"}, {"number", "16"}}},
        {{.device = "{FC_03: true}"},
         "key.unlike",
         {{"variant", "function"}, {"function", "read: 0x03"}, {"number", "3"}}},
        {{.variable = "{fc06: true}"},
         "key.unlike",
         {{"variant", "function"}, {"function", "write: 0x06"}, {"number", "6"}}},
        {{.device = "{fc17: true}"}, "key.unlike", {{"variant", "other_function"}, {"number", "17"}}},
        {{.device = "{fc24: true}"}, "key.unlike", {{"variant", "other_function"}, {"number", "24"}}},
        {{.device = "{fc32: true}"}, "key.unlike", {{"variant", "other_function"}, {"number", "32"}}},
        {{.device = "{fc2: true}"},
         "key.unlike",
         {{"variant", "function"}, {"function", "read: 0x02"}, {"number", "2"}}},
        {{.variable = "{write: FC 16}"},
         "function.not_allowed",
         {{"variant", "function"}, {"function", "write: 0x10"}, {"number", "16"}}},
        {{.variable = "{write: \"fc22\"}"}, "function.not_allowed", {{"variant", "mask"}}},
        {{.variable = "{scale: \"1/10\"}"}, "number.malformed", {{"variant", "fraction"}, {"meant", "0.1"}}},
        {{.variable = "{write: 0x16}"}, "function.not_allowed", {{"variant", "mask"}}},
        {{.variable = "{write: 22}"}, "function.not_allowed", {{"variant", "mask"}}},
        {{.variable = "{write: 0x17}"}, "function.not_allowed", {{"variant", "read_write"}}},
        {{.variable = "{write: 0x15}"}, "function.not_allowed", {}},
        {{.device = "{poll_period: \"1,000ms\"}"},
         "number.comma",
         {{"meant", "1.000ms"}, {"variant", "two_meanings"}, {"other", "1000ms"}}},
        {{.variable = "{scale: \"12,500\"}"},
         "number.comma",
         {{"meant", "12.500"}, {"variant", "two_meanings"}, {"other", "12500"}}},
        {{.device = "{poll_period: \"0,500s\"}"}, "number.comma", {{"meant", "0.500s"}}},
        {{.device = "{poll_period: \"1,00s\"}"}, "number.comma", {{"meant", "1.00s"}}},
        {{.device = "{poll_period: \"1,000,000us\"}"}, "number.thousands", {{"meant", "1000000us"}}},
        {{.variable = "{type: INT8}"}, "field.unknown_word", {{"nearest", "int16"}}},
        {{.variable = "{type: DOBLE}"}, "field.unknown_word", {{"nearest", "double"}}},
        {{.variable = "{type: SINT}"}, "field.unknown_word", {{"nearest", "int16"}}},
        {{.variable = "{type: BYT}"}, "field.unlike_word", {}},
        {{.line = "{port: \"/dev/ttyUSB0,9600,8N1\"}"},
         "line.port_settings",
         {{"keys", "port: /dev/ttyUSB0, baud: 9600, data_bits: 8, parity: none, stop_bits: 1"}}},
        {{.line = "{port: COM3}"},
         "line.port_settings",
         {{"keys", "port: /dev/ttyUSB0"}, {"variant", "com"}, {"device", "/dev/ttyS2"}}},
        {{.line = "{port: ttyS1}"}, "line.port_settings", {{"keys", "port: /dev/ttyS1"}}},
        {{.line = "{port: \"rtu+tcp://plc:4001\"}"},
         "line.port_settings",
         {{"keys", "transport: tcp, host: plc, tcp_port: 4001, framing: rtu"}}},
    };
    for (const auto& [changes, code, arguments] : cases) {
        const auto findings = interpret(document(changes)).findings;
        ASSERT_FALSE(findings.empty()) << code;
        EXPECT_EQ(findings[0].code, code) << findings[0].value;
        EXPECT_EQ(findings[0].arguments, arguments) << findings[0].value;
    }
}

TEST(Interpret, Variable) {
    const Case cases[] = {
        {"{name: ~}", "field.missing name="},
        {"{type: ~}",
         "field.missing type= [bool, int16, uint16, int32, uint32, int64, uint64, float, double, "
         "string, int, real]"},
        {"{type: word}",
         "field.unknown_word type=word [bool, int16, uint16, int32, uint32, int64, uint64, float, "
         "double, string, int, real]"},
        {"{register: ~}", "variable.address_missing register= [0..65535]"},
        {"{register: -1}", "field.out_of_range register=-1 [0..65535]"},
        {"{register: 65535}", ""},
        {"{register: \"1,000\"}", "number.thousands register=1,000 [0..65535]"},
        {"{register: \"1,00\"}", "number.comma register=1,00 [0..65535]"},
        {"{scale: \"1,000\"}", "number.comma scale=1,000"},
        {"{register: 65536}", "field.out_of_range register=65536 [0..65535]"},
        {"{register: 0107}", "integer.leading_zero register=0107 [0..65535]"},
        {"{register: \"107\"}", "field.quoted_number register=107 [0..65535]"},
        {"{type: float, register: 65534}", ""},
        {"{type: float, register: 65535}", "variable.beyond_end register=65535 [0..65534]"},
        {"{type: double, register: 65533}", "variable.beyond_end register=65533 [0..65532]"},
        {"{read: 3}", ""},
        {"{read: none, write: 0x10}", ""},
        {"{read: ~, write: 16}", ""},
        {"{read: 0x05}", "function.not_allowed read=0x05 [none, 0x01, 0x02, 0x03, 0x04]"},
        {"{read: 03}", "integer.leading_zero read=03 [none, 0x01, 0x02, 0x03, 0x04]"},
        {"{read: \"0x03\"}", "field.quoted_number read=0x03 [none, 0x01, 0x02, 0x03, 0x04]"},
        {"{read: holding}", "function.not_allowed read=holding [none, 0x01, 0x02, 0x03, 0x04]"},
        {"{read: -3}", "function.not_allowed read=-3 [none, 0x01, 0x02, 0x03, 0x04]"},
        {"{write: 0x17}", "function.not_allowed write=0x17 [none, 0x05, 0x06, 0x0F, 0x10]"},
        {"{read: none}",
         "variable.area_missing area= [coil, discrete_input, input_register, holding_register]; "
         "?variable.no_traffic read=none"},
        {"{read: none, area: holding_register}", "?variable.no_traffic read=none"},
        {"{read: none, area: holding_register, used: false}", ""},
        {"{read: ~, write: none, area: holding_register}", "?variable.no_traffic write=none"},
        {"{read: ~, write: none, area: holding_register, used: false}", ""},
        {"{read: none, write: none, area: holding_register}", "?variable.no_traffic read=none"},
        {"{read: ~}", "variable.area_missing area= [coil, discrete_input, input_register, holding_register]"},
        {"{read: ~, area: input_register}", ""},
        {"{area: input_register}", "variable.function_area read=0x03 [none, 0x04]"},
        {"{write: 0x05}", "variable.function_area write=0x05 [none, 0x06, 0x10]"},
        {"{read: 0x04, write: 0x10}", "?variable.overlaid_areas write=0x10 [none]"},
        {"{read: 0x04, area: input_register, write: 0x10}", "variable.read_only_area write=0x10 [none]"},
        {"{read: 0x01}", "variable.type_area type=int [bool]"},
        {"{write: 0x06}", ""},
        {"{type: float, write: 0x06}", "variable.single_register write=0x06 [none, 0x10]"},
        {"{type: float, write: 0x10}", ""},
        {"{bit: 3}", "variable.bit_type bit=3"},
        {"{length: 4}", "variable.length_type length=4"},
        {"{type: string}", "variable.length_missing length= [1..125]"},
        {"{type: string, length: 125}", ""},
        {"{type: string, length: 126}", "field.out_of_range length=126 [1..125]"},
        {"{type: string, length: 0}", "field.out_of_range length=0 [1..125]"},
        {"{type: string, length: 124, write: 0x10}", "field.out_of_range length=124 [1..123]"},
        {"{write_on_change: true}", "?field.without_effect write_on_change=true"},
        {"{write: none, write_on_change: true}", "?field.without_effect write_on_change=true"},
        {"{write_on_change: true, write: 0x10}", ""},
        {"{write_trigger: go}", "variable.needs_write write_trigger=go"},
        {"{read_trigger: go}", ""},
        {"{read_trigger: go, read: none, write: 0x10}", "variable.needs_read read_trigger=go"},
        {"{read_trigger: gone}", "local.unknown read_trigger=gone"},
        {"{read_trigger: state}", "local.type read_trigger=state [bool]"},
        {"{status: state}", ""},
        {"{status: 7}", "local.unknown status=7"},
        {"{verify: true}", "variable.needs_write verify=true"},
        {"{period: 50ms, deadline: 100ms}", ""},
        {"{period: 0ms, deadline: 100ms}", "variable.deadline_without_period deadline=100ms"},
        {"{deadline: 0ms}", "field.out_of_range deadline=0ms [1us..24h]"},
        {"{retain: true}", ""},
        {"{retain: false}", ""},
        {"{scale: 0.1, offset: -40}", ""},
        {"{scale: 0}", "variable.scale_zero scale=0"},
        {"{scale: \"0.1\"}", "field.quoted_number scale=0.1"},
        {"{scale: 0.1x}", "number.malformed scale=0.1x"},
        {"{scale: \"0,1\"}", "number.comma scale=0,1"},
        {"{offset: \"-10,25\"}", "number.comma offset=-10,25"},
        {"{dead_band: -1}", "field.out_of_range dead_band=-1 [>= 0]"},
        {"{unit: °C, comment: outside, hold_last: true, safe_to_repeat: true, write: 0x10}", ""},
        {"{name: [a, b]}", "field.not_a_value name="},
    };
    for (const auto& [keys, expected] : cases) EXPECT_EQ(findings_text({.variable = keys}), expected) << keys;
}

TEST(Interpret, WriteRange) {
    const Case cases[] = {
        {"{write: 0x06, write_range: 0..120}", ""},
        {"{write: 0x06, write_range: 0.., scale: 0.1}", ""},
        {"{write: 0x06, write_range: ..-5.5, scale: 0.1}", ""},
        {"{write: 0x06, write_range: -5 .. 40}", ""},
        {"{write: 0x06, write_range: 5..5}", ""},
        {"{write: 0x06, write_range: 0..32767}", ""},
        {"{write: 0x06, write_range: -3276.8..3276.7, scale: 0.1}", ""},
        {"{write: 0x06, write_range: 0..32768}", "default.out_of_range write_range=0..32768 [-32768..32767]"},
        {"{write: 0x06, write_range: ..1e9}", "default.out_of_range write_range=..1e9 [-32768..32767]"},
        {"{write: 0x06, write_range: 0..17000, scale: -0.5, offset: 20}",
         "default.out_of_range write_range=0..17000 [-16363.5..16404]"},
        {"{type: uint16, write: 0x06, write_range: -1..5}",
         "default.out_of_range write_range=-1..5 [0..65535]"},
        {"{type: double, write: 0x10, write_range: -1e300..1e300}", ""},
        {"{write: 0x06, write_range: 120..0}", "range.reversed write_range=120..0 [-32768..32767]"},
        {"{write: 0x06, write_range: ..}",
         "variable.write_range_malformed write_range=.. [0..120, -5.5..40, 0.., ..120]"},
        {"{write: 0x06, write_range: 5}",
         "variable.write_range_malformed write_range=5 [0..120, -5.5..40, 0.., ..120]"},
        {"{write: 0x06, write_range: 0-120}",
         "variable.write_range_malformed write_range=0-120 [0..120, -5.5..40, 0.., ..120]"},
        {"{write: 0x06, write_range: \"0,5..10\"}",
         "variable.write_range_malformed write_range=0,5..10 [0..120, -5.5..40, 0.., ..120]"},
        {"{write: 0x06, write_range: 0..nan}",
         "variable.write_range_malformed write_range=0..nan [0..120, -5.5..40, 0.., ..120]"},
        {"{write: 0x06, write_range: 1..2..3}",
         "variable.write_range_malformed write_range=1..2..3 [0..120, -5.5..40, 0.., ..120]"},
        {"{write: 0x06, write_range: [0, 120]}", "field.not_a_value write_range="},
        {"{write_range: 0..120}", "variable.needs_write write_range=0..120"},
        {"{write: 0x06, write_range: 0..5, enumeration: {0: off}}", "?field.without_effect write_range=0..5"},
        {"{type: string, length: 2, write: 0x10, write_range: 0..5}", "variable.scale_type write_range=0..5"},
        {"{type: bool, bit: 0, read: 0x01, write: 0x05, write_range: 0..1}",
         "variable.scale_type write_range=0..1"},
    };
    for (const auto& [keys, expected] : cases) EXPECT_EQ(findings_text({.variable = keys}), expected) << keys;
    const auto range_of = [](std::string_view keys) {
        return interpret(document({.variable = keys})).project.lines[0].devices[0].variables[0].write_range;
    };
    constexpr double kNone = std::numeric_limits<double>::infinity();
    EXPECT_EQ(range_of("{write: 0x06, write_range: -2.5..40}"), (WriteRange{-2.5, 40}));
    EXPECT_EQ(range_of("{write: 0x06, write_range: 0..}"), (WriteRange{0, kNone}));
    EXPECT_EQ(range_of("{write: 0x06, write_range: ..40}"), (WriteRange{-kNone, 40}));
    EXPECT_EQ(range_of("{write: 0x06}"), std::nullopt);
    EXPECT_EQ(range_of("{write: 0x06, write_range: 0..99999}"), std::nullopt);
}

TEST(Interpret, Bits) {
    const Case cases[] = {
        {"{read: 0x01, bit: 3}", ""},
        {"{read: 0x01, bit: 16}", "field.out_of_range bit=16 [0..15]"},
        {"{read: 0x01}", "?variable.bit_assumed register=0 [0..15]"},
        {"{read: 0x01, register: 17}", "?variable.coil_assumed register=17 [0..15]"},
        {"{read: 0x02, register: 5}", "?variable.discrete_input_assumed register=5 [0..15]"},
        {"{read: 0x03}", "?variable.bit_assumed register=0 [0..15]"},
        {"{read: 0x01, register: 4095, bit: 15}", ""},
        {"{read: 0x01, register: 4096, bit: 0}", "variable.beyond_end register=4096 [0..4095]"},
        {"{read: 0x03, register: 65535, bit: 15}", ""},
        {"{register: ~, coil: 65535}", "variable.coil_area coil=65535 [coil, discrete_input]"},
        {"{register: ~, coil: 65535, read: 0x01}", ""},
        {"{register: ~, coil: 65535, read: 0x02}", ""},
        {"{register: ~, coil: 5, read: ~}", ""},
        {"{register: ~, coil: 65536, read: 0x01}", "field.out_of_range coil=65536 [0..65535]"},
        {"{coil: 5, read: 0x01}", "variable.address_twice register=0"},
        {"{register: ~, coil: 5, bit: 5, read: 0x01}", "variable.address_twice bit=5"},
        {"{read: 0x01, bit: 0, write: 0x05}", ""},
        {"{read: 0x01, bit: 0, write: 0x0F}", ""},
        {"{read: 0x01, bit: 0, write: 0x10}", "variable.function_area write=0x10 [none, 0x05, 0x0F]"},
        {"{read: 0x02, bit: 0, write: 0x05}", "?variable.overlaid_areas write=0x05 [none]"},
        {"{read: 0x02, bit: 0, write: 0x10}", "variable.read_only_area write=0x10 [none]"},
        {"{read: 0x03, bit: 0, write: 0x06}", "?variable.bit_write write=0x06 [none]"},
        {"{read: 0x04, bit: 15}", ""},
        {"{read: 0x01, bit: 0, scale: 2}", "variable.scale_type scale=2"},
    };
    for (const auto& [keys, expected] : cases) {
        const auto variable = "{type: bool, " + std::string(keys.substr(1));
        EXPECT_EQ(findings_text({.variable = variable}), expected) << keys;
    }
}

TEST(Interpret, ABitOfARegisterIsReadOnly) {
    const auto checked =
        interpret(document({.variable = "{type: bool, bit: 0, write: 0x06, write_on_change: true}"}));
    EXPECT_EQ(findings_text(checked), "?variable.bit_write write=0x06 [none]");
    EXPECT_EQ(checked.project.lines[0].devices[0].variables[0].write, std::nullopt);
    const auto coil = interpret(document({.variable = "{type: bool, bit: 0, read: 0x01, write: 0x05}"}));
    EXPECT_EQ(findings_text(coil), "");
    EXPECT_EQ(coil.project.lines[0].devices[0].variables[0].write, wire::Function::write_single_coil);
}

TEST(Interpret, References) {
    struct ReferenceCase {
        std::string_view keys;
        wire::Area area;
        int start;
        std::string_view findings;
    };
    using enum wire::Area;
    const ReferenceCase cases[] = {
        {"{reference: \"40108\", read: ~}", holding_register, 107, ""},
        {"{reference: \"40001\"}", holding_register, 0, ""},
        {"{reference: \"465536\"}", holding_register, 65535, ""},
        {"{reference: \"30001\", read: ~}", input_register, 0, ""},
        {"{type: bool, reference: \"10001\", read: ~}", discrete_input, 0, ""},
        {"{type: bool, reference: \"00001\", read: ~}", coil, 0, ""},
        {"{type: bool, reference: \"000020\", read: 0x01, write: 0x05}", coil, 19, ""},
        {"{type: bool, reference: \"40001\", bit: 7}", holding_register, 0, ""},
        {"{reference: \"30001\"}", input_register, 0, "variable.function_area"},
        {"{type: bool, reference: \"00001\", bit: 3, read: ~}", coil, 0, "variable.address_twice"},
        {"{reference: \"40001\", register: 0}", holding_register, 0, "variable.address_twice"},
        {"{reference: \"40001\", area: holding_register}", holding_register, 0, "variable.address_twice"},
        {"{reference: \"40001\", type: float, write: 0x06}", holding_register, 0, "variable.single_register"},
        {"{reference: \"465536\", type: float}", holding_register, 65535, "variable.beyond_end"},
        {"{reference: 40108}", holding_register, 107, ""},
        {"{reference: \"40000\"}", holding_register, 0, "reference.malformed"},
        {"{reference: \"400000\"}", holding_register, 0, "reference.malformed"},
        {"{reference: \"465537\"}", holding_register, 0, "reference.malformed"},
        {"{reference: \"20001\"}", holding_register, 0, "reference.malformed"},
        {"{reference: \"4001\"}", holding_register, 0, "reference.malformed"},
        {"{reference: \"4000a\"}", holding_register, 0, "reference.malformed"},
    };
    for (const auto& [keys, area, start, findings] : cases) {
        const auto variable = "{register: ~, " + std::string(keys.substr(1));
        const auto checked = interpret(document({.variable = variable}));
        const auto& read = checked.project.lines[0].devices[0].variables[0];
        EXPECT_EQ(read.area, area) << keys;
        EXPECT_EQ(read.start(), start) << keys;
        EXPECT_EQ(checked.findings.size(), findings.empty() ? 0U : 1U)
            << keys << ": " << findings_text(checked);
        for (const auto& finding : checked.findings) EXPECT_EQ(finding.code, findings) << keys;
    }
}

TEST(Interpret, AddressesThatLookLikeReferences) {
    const Case cases[] = {
        {"{register: 40001}", "?address.like_reference register=40001"},
        {"{register: 49999}", "?address.like_reference register=49999"},
        {"{register: 0x9C41}", ""},
        {"{register: 40000}", ""},
        {"{register: 30001}", ""},
        {"{register: 30001, read: 0x04}", "?address.like_reference register=30001"},
        {"{register: 40001, read: 0x04}", ""},
        {"{type: bool, register: ~, coil: 10001, read: 0x02}", "?address.like_reference coil=10001"},
        {"{register: 400001}", "address.is_reference register=400001 [0..65535]"},
        {"{register: 465537}", "field.out_of_range register=465537 [0..65535]"},
        {"{type: bool, register: 10001, bit: 0, read: 0x02}",
         "address.is_reference register=10001 [0..4095]"},
    };
    for (const auto& [keys, expected] : cases) EXPECT_EQ(findings_text({.variable = keys}), expected) << keys;
}

TEST(Interpret, Constants) {
    struct ConstantCase {
        std::string_view keys;
        Constant value;
        std::string_view finding;
    };
    const ConstantCase cases[] = {
        {"{type: int, default: -32768}", {.number = -32768, .integer = -32768}, ""},
        {"{type: int, default: 32768}", {}, "default.out_of_range default=32768 [-32768..32767]"},
        {"{type: uint16, default: 0xFFFF}", {.number = 65535, .integer = 65535}, ""},
        {"{type: uint16, default: -1}", {}, "default.out_of_range default=-1 [0..65535]"},
        {"{type: uint64, default: 18446744073709551615}",
         {.number = 18446744073709551615.0, .integer = -1},
         ""},
        {"{type: int64, default: 9223372036854775808}",
         {},
         "default.out_of_range default=9223372036854775808 [-9223372036854775808..9223372036854775807]"},
        {"{type: int, default: 1.5}", {}, "integer.fraction default=1.5 [-32768..32767]"},
        {"{type: int, default: 07}", {}, "integer.leading_zero default=07 [-32768..32767]"},
        {"{type: int, default: cold}", {}, "integer.malformed default=cold [-32768..32767]"},
        {"{type: int, default: \"1\"}", {}, "field.quoted_number default=1"},
        {"{type: bool, default: true}", {.number = 1, .integer = 1}, ""},
        {"{type: bool, default: 0}", {}, ""},
        {"{type: bool, default: 2}", {}, "boolean.malformed default=2 [true, false, 0, 1]"},
        {"{type: float, default: -1.5}", {.number = -1.5}, ""},
        {"{type: float, default: 1e39}",
         {},
         "default.out_of_range default=1e39 [-3.4028234663852886e+38..3.4028234663852886e+38]"},
        {"{type: float, default: 1.5e}", {}, "number.malformed default=1.5e"},
        {"{type: double, default: 1e39}", {.number = 1e39}, ""},
        {"{type: string, default: \"007\"}", {.text = "007"}, ""},
    };
    for (const auto& [keys, value, finding] : cases) {
        const auto checked = interpret(document({.local = keys}));
        EXPECT_TRUE(findings_text(checked).starts_with(finding)) << keys << ": " << findings_text(checked);
        const auto& local = checked.project.locals[2].default_value;
        if (finding.empty())
            EXPECT_EQ(local, value) << keys;
        else
            EXPECT_EQ(local, std::nullopt) << keys;
    }
    EXPECT_EQ(findings_text({.variable = "{scale: 0.1, default: 3276.7}"}), "");
    EXPECT_EQ(findings_text({.variable = "{scale: 0.5, default: 16384}"}),
              "default.out_of_range default=16384 [-16384..16383.5]");
    EXPECT_EQ(findings_text({.variable = "{scale: -0.5, offset: 1, default: -16383}"}),
              "default.out_of_range default=-16383 [-16382.5..16385]");
    EXPECT_EQ(findings_text({.variable = "{type: string, length: 2, default: abcd}"}), "");
    EXPECT_EQ(findings_text({.variable = "{type: string, length: 2, default: abcde}"}),
              "default.too_long default=abcde [0..4]");
}

}  // namespace interpret_variable_test
}  // namespace takt::model::test
