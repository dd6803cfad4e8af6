// Tables to projects and back.
#include "takt/file/convert.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "converted.hpp"
#include "outline.hpp"
#include "takt/model/target_url.hpp"
#include "yaml/source.hpp"

namespace takt::file {
namespace convert_test {

constexpr std::string_view kIdeTable =
    "Имя переменной;Тип переменной;Функция чтения;Функция записи;Адрес регистра;Адрес "
    "бита;Комментарий;Период, "
    "мс;Множитель;Запуск записи;;\r\n"
    "T1;С плавающей запятой;03 (0x03) Read Holding Registers;нет;0x10;-;\"Подача,\r\nсекция "
    "\"\"А\"\"\";500;0,1;;;\r\n"
    ";;;;;;;;;;;\r\n"
    "Насос;Логический;нет;5;2;3;;;;пуск;;\r\n"
    "Счётчик;2-регистровый целочисленный;4;-;10h;;;;;;;\r\n";

TEST(Convert, TheTableOfAnIdeBecomesAProject) {
    const auto project = project_of(std::string(kIdeTable));
    EXPECT_EQ(errors_of(project), Findings{});
    const auto text = write_project(project.document.root);
    const auto at = text.find("        variables:\n");
    ASSERT_NE(at, std::string::npos);
    EXPECT_EQ(text.substr(at),
              "        variables:\n"
              "          - {name: T1, type: float, read: 0x03, write: none, register: 0x10, comment: "
              "\"Подача, секция "
              "\\\"А\\\"\", period: 500ms, scale: 0.1}\n"
              "          - {name: Насос, type: bool, read: none, write: 5, register: 2, bit: 3, "
              "write_trigger: пуск}\n"
              "          - {name: Счётчик, type: int32, read: 4, write: none, register: 0x10}\n"
              "locals:\n"
              "  - {name: пуск, type: bool}\n");
}

TEST(Convert, TagsAreOneCell) {
    const auto project = project_of(
        "name;type;register;read;Теги\r\nA;int;1;3;energy, b-2;\r\nB;int;2;3;;\r\nC;int;3;3;x\r\n");
    EXPECT_EQ(errors_of(project), Findings{});
    const auto yaml = write_project(project.document.root);
    EXPECT_NE(yaml.find("tags: [energy, b-2]"), std::string::npos) << yaml;
    const auto read = load_text("p.yaml", yaml);
    EXPECT_EQ(errors_of(read), Findings{});
    const auto written = write_table(rows_of_device(rows_of_project(read.document), "D"), {});
    EXPECT_TRUE(written.findings.empty());
    EXPECT_NE(written.bytes.find("\"energy, b-2\""), std::string::npos) << written.bytes;
    EXPECT_EQ(described(model::interpret(project_of(written.bytes).document).project),
              described(model::interpret(project.document).project));
}

TEST(Convert, AStarWithoutQuotesIsAnAlias) {
    for (const auto* list : {"[*]", "[*A]", "[*, A]"})
        EXPECT_EQ(load_text("p.yaml", std::string("takt: 1\noutputs:\n- {variables: ") + list + "}\n")
                      .findings.at(0)
                      .code,
                  "file.alias")
            << list;
}

TEST(Convert, OutputsAreWrittenAsTheyWere) {
    constexpr std::string_view kProject =
        "takt: 1\n"
        "lines:\n"
        "  - name: L\n"
        "    host: h\n"
        "    devices:\n"
        "      - name: D\n"
        "        address: 1\n"
        "        variables:\n"
        "          - {name: A, type: int, register: 1, read: 3, tags: [x, y]}\n"
        "outputs:\n"
        "  - name: cloud\n"
        "    transport: mqtt\n"
        "    brokers: [\"mqtts://b\", \"mqtt://[::1]:1884\"]\n"
        "    version: auto\n"
        "    topic: \"p/{device}/{variable}\"\n"
        "    period: 10s\n"
        "    variables: [\"*\"]\n"
        "    select:\n"
        "      - {tags: [x], period: 1s, topic: \"q/{variable}\"}\n"
        "      - {variables: [A, \"?\"]}\n";
    EXPECT_EQ(write_project(load_text("p.yaml", std::string(kProject)).document.root), kProject);
}

TEST(Convert, AProjectMayNameTheTableOfAnIde) {
    std::string table(kIdeTable);
    const auto in_cp1251 =
        write_table(load_table_text("t", table).document.root.items,
                    {.headings = Headings::russian, .separator = ';', .encoding = Encoding::cp1251});
    ASSERT_TRUE(in_cp1251.findings.empty());
    EXPECT_TRUE(find_foreign(in_cp1251.bytes)) << "not UTF-8";
    for (const auto& bytes : {table, in_cp1251.bytes}) {
        const auto loaded = load_text("p.yaml",
                                      "takt: 1\nlines: [{name: L, port: /dev/ttyS0, devices: [{name: D, "
                                      "address: 1, variables: t.csv}]}]\n"
                                      "locals: [{name: пуск, type: bool}]\n",
                                      [&](const std::string&) -> Result<std::string> { return bytes; });
        EXPECT_EQ(errors_of(loaded), Findings{});
        const auto checked = model::interpret(loaded.document);
        const auto variables = variables_of(checked.project);
        ASSERT_EQ(variables.size(), 3U);
        EXPECT_EQ(variables[1].name, "Насос");
        EXPECT_EQ(variables[2].type, DataType::int32);
    }
}

TEST(Convert, AddressesInTheOneBasedNotation) {
    struct Case {
        std::string_view rows;
        Addresses addresses;
        std::vector<int> registers;
        Findings findings;
    };
    const Case cases[] = {
        {"A,int,3,40001\nB,int,4,30002\n", Addresses::automatic, {0, 1}, {"1/2:9 csv.taken_as_references"}},
        {"A,int,3,400001\n", Addresses::automatic, {0}, {"1/2:9 csv.taken_as_references"}},
        {"A,int,3,40001\nB,int,3,7\n", Addresses::automatic, {40001, 7}, {}},
        {"A,int,4,40001\n", Addresses::automatic, {40001}, {}},  // not in the area of 0x04
        {"A,int,3,40001\n", Addresses::zero_based, {40001}, {}},
        {"A,int,3,40001\nB,int,3,7\n", Addresses::zero_based, {40001, 7}, {}},
        {"A,int,3,0x9C41\n", Addresses::automatic, {40001}, {}},
        {"A,int,3,40001\nB,int,4,8\n", Addresses::reference, {0, 7}, {}},
        {"A,int,3,00001\n", Addresses::automatic, {}, {}},  // a coil's
    };
    for (const auto& [rows, addresses, registers, findings] : cases) {
        const auto table = load_table_text("t.csv", "name,type,read,register\n" + std::string(rows),
                                           {.addresses = addresses});
        EXPECT_EQ(locations_and_codes(table), findings) << rows;
        const auto project = project_of_table(table, kAround);
        if (registers.empty()) {
            EXPECT_NE(errors_of(project), Findings{}) << rows;
            continue;
        }
        std::vector<int> found;
        for (const auto& variable : variables_of(model::interpret(project.document).project))
            found.push_back(variable.register_number);
        EXPECT_EQ(found, registers) << rows;
    }
}

TEST(Convert, ClassicNumbersInOtherNotations) {
    struct Case {
        Notation notation;
        std::string_view row;
        std::string_view expected;
    };
    constexpr Case kCases[] = {
        {Notation::coils_at_20001, "bool,1,20001", "00001"},
        {Notation::coils_at_20001, "bool,1,29999", "09999"},
        {Notation::coils_at_20001, "bool,1,5", "00005"},
        {Notation::coils_at_20001, "bool,2,10001", "10001"},
        {Notation::coils_at_20001, "int,3,40001", "40001"},
        {Notation::coils_at_20001, "int,3,107", "40107"},
        {Notation::zero_based, "int,3,40000", "40001"},
        {Notation::zero_based, "int,4,30000", "30001"},
        {Notation::zero_based, "int,3,49999", "410000"},
        {Notation::zero_based, "int,3,465535", "465536"},
        {Notation::zero_based, "bool,1,20000", "00001"},
        {Notation::zero_based, "bool,1,00000", "00001"},
        {Notation::zero_based, "int,3,107", "40108"},
        {Notation::zero_based, "int,,40107", "40108"},
    };
    for (const auto& [notation, row, expected] : kCases) {
        const auto table = load_table_text("t.csv", "name,type,read,register\nA," + std::string(row) + "\n",
                                           {.notation = notation});
        EXPECT_EQ(locations_and_codes(table), Findings{}) << row;
        const auto* const reference = table.document.root.items.at(0).find("reference");
        ASSERT_NE(reference, nullptr) << row;
        EXPECT_EQ(reference->text, expected) << row;
        EXPECT_EQ(errors_of(project_of_table(table, kAround)), Findings{}) << row;
    }
    const auto master = load_table_text("t.csv",
                                        "Имя переменной;Тип переменной;Функция чтения;Функция записи;Адрес "
                                        "регистра;Адрес бита (ов)\nA;Булевское;0x01;0x05;20001;0\n",
                                        {.notation = Notation::coils_at_20001});
    EXPECT_EQ(errors_of(project_of_table(master, kAround)), Findings{});
    const auto loaded =
        load_text("p.yaml",
                  "takt: 1\nlines: [{name: L, port: /dev/ttyS0, devices: [{name: D, address: 1, "
                  "notation: zero_based, variables: t.csv}]}]\n",
                  [](const std::string&) -> Result<std::string> {
                      return std::string("name,type,read,register\nA,int,3,40000\n");
                  });
    EXPECT_EQ(errors_of(loaded), Findings{});
    EXPECT_EQ(variables_of(model::interpret(loaded.document).project).at(0).register_number, 0);
}

TEST(Convert, AColumnThatIsNotKnownIsOneFinding) {
    std::string table = "name,type,reed,register,Цвет\n";
    for (int i = 0; i < 100; ++i) table += "V" + std::to_string(i) + ",int,3,0,red\n";
    const auto loaded = load_table_text("t.csv", table, {.strict = true});
    EXPECT_EQ(locations_and_codes(loaded),
              (Findings{"1/1:11 csv.unknown_column", "1/1:25 csv.unknown_column"}));
    EXPECT_EQ(loaded.findings[0].arguments[0].second, "read");
    EXPECT_EQ(errors_of(project_of(table, {.strict = true})),
              (Findings{"file.csv.unknown_column reed", "file.csv.unknown_column Цвет"}));
    EXPECT_EQ(errors_of(project_of("Kind,type\n1,int\n2,int\n")), Findings{"file.csv.unknown_column Kind"});
}

TEST(Convert, AWindowHasItsLimitAlsoWithoutGroups) {
    for (const std::string name : {"Группировать запросы", "Группировать", "Групувати", "Group requ"}) {
        const auto project = project_of(
            "Имя;Устройство\nАдрес;16\n" + name + ";Нет\nКол-во регистров в запросе;20\n", {.devices = true});
        EXPECT_EQ(project.findings.size(), 0U) << name;
        const auto checked = model::interpret(project.document);
        const auto& device = checked.project.lines.at(0).devices.at(0);
        EXPECT_EQ(device.registers_per_request, 20);
        EXPECT_FALSE(device.group_requests) << name;
        EXPECT_EQ(std::ranges::count(checked.findings, std::string_view("field.without_effect"),
                                     &model::Finding::code),
                  0);
    }
    const auto several =
        project_of("Имя;Устройство\nАдрес;16\nКол-во;Нет\n", {.devices = true});  // of attempts, of registers
    EXPECT_EQ(locations_and_codes(several), Findings{"1/3:1 csv.column_as_comment"});
}

TEST(Convert, RegistersOfAValueMayStandInAColumn) {
    const auto project = project_of(
        "name;type;read;register;Количество "
        "регистров\nA;int;3;0;2\nB;float;3;2;2\nC;string;3;4;10\nD;bool;1;0;1\n");
    EXPECT_EQ(errors_of(project), Findings{});
    const auto variables = variables_of(model::interpret(project.document).project);
    ASSERT_EQ(variables.size(), 4U);
    EXPECT_EQ(variables[0].type, DataType::int32);
    EXPECT_EQ(variables[2].registers, 10);
    EXPECT_EQ(locations_and_codes(load_table_text("t", "name,type,registers\nA,float,1\nB,int,x\n")),
              (Findings{"1/2:9 csv.register_count", "1/3:7 csv.register_count"}));
}

TEST(Convert, SeveralDevicesInATable) {
    const std::string project =
        "takt: 1\nlines:\n- name: L\n  port: /dev/ttyS0\n  devices:\n"
        "  - {name: A, address: 1, poll_period: 2s, variables: [{name: V, type: int, read: 3, register: "
        "1}]}\n"
        "  - {name: B, address: 7, variables: [{name: W, type: int, read: 3, register: 2}]}\n";
    const auto read = load_text("p.yaml", project);
    const auto written = write_table(rows_of_project(read.document), {});
    EXPECT_EQ(written.bytes,
              "line,device,unit_address,name,type,read,write,register,bit,comment,period\r\n"
              "L,A,1,V,int,3,,1,,,2s\r\nL,B,7,W,int,3,,2,,,\r\n");
    const auto back = project_of(written.bytes, {.devices = true});
    EXPECT_EQ(errors_of(back), Findings{});
    EXPECT_EQ(described(model::interpret(back.document).project),
              described(model::interpret(read.document).project));
    EXPECT_EQ(model::interpret(back.document).project.lines[0].devices[1].address, UnitId{7});
    // in a project each device has its own table
    EXPECT_EQ(locations_and_codes(load_table_text("t", written.bytes)).size(), 3U);
    EXPECT_EQ(locations_and_codes(project_of("device,name,type\nA,V,int\nB,W,int\n", {.devices = true})),
              (Findings{"1/2:1 convert.no_address", "1/3:1 convert.no_address"}));
    EXPECT_EQ(locations_and_codes(
                  project_of("line,unit_address,name,type\nL,1,V,int\nM,2,W,int\n", {.devices = true})),
              (Findings{"1/3:1 convert.several_lines"}));
    EXPECT_EQ(locations_and_codes(
                  project_of("device,unit_address,name,type\nA,1,V,int\nA,2,W,int\n", {.devices = true})),
              (Findings{"1/3:3 convert.two_addresses"}));
    const auto unnamed =
        project_of("unit_address,name,type,read,register\n3,V,int,3,0\n5,V,int,3,0\n", {.devices = true});
    EXPECT_EQ(locations_and_codes(unnamed), Findings{"1/2:3 convert.names_qualified"});
    EXPECT_EQ(errors_of(unnamed), Findings{});
}

TEST(Convert, SeveralLinesInATable) {
    const auto read = load_text(
        "p.yaml",
        "takt: 1\nlines:\n- {name: L, port: /dev/ttyS0, baud: 9600, devices: [{name: A, address: 1, "
        "variables: "
        "[{name: V, type: int, read: 3, register: 1}]}]}\n"
        "- {name: M, host: plc, devices: [{name: B, address: 1, variables: [{name: W, type: int, read: 3, "
        "register: 2}]}]}\n");
    const auto written = write_table(rows_of_project(read.document), {});
    EXPECT_EQ(written.bytes,
              "line,target,device,unit_address,name,type,read,write,register,bit,comment\r\n"
              "L,rtu:///dev/ttyS0?baud=9600&parity=even&stop_bits=1,A,1,V,int,3,,1,,\r\n"
              "M,tcp://plc:502,B,1,W,int,3,,2,,\r\n");
    const auto project = model::interpret(read.document).project;
    auto around = kAround;
    around.connections["rtu:///dev/ttyS0?baud=9600&parity=even&stop_bits=1"] =
        connection_keys(project.lines[0]);
    around.connections["tcp://plc:502"] = connection_keys(project.lines[1]);
    const auto back = project_of_table(load_table_text("t.csv", written.bytes, {.devices = true}), around);
    EXPECT_EQ(errors_of(back), Findings{});
    const auto again = model::interpret(back.document).project;
    EXPECT_EQ(described(again), described(project));
    ASSERT_EQ(again.lines.size(), 2U);
    EXPECT_EQ(model::url_of(again.lines[0]), model::url_of(project.lines[0]));
    EXPECT_EQ(model::url_of(again.lines[1]), model::url_of(project.lines[1]));
}

TEST(Convert, LinesThatDisagreeAreReported) {
    const auto findings = [](const std::string& rows) {
        return locations_and_codes(
            project_of("line,target,device,unit_address,name,type\n" + rows, {.devices = true}));
    };
    EXPECT_EQ(findings("L,tpc://plc,A,1,V,int\n"), Findings{"1/2:3 convert.target"});
    EXPECT_EQ(findings("L,,A,1,V,int\nM,,A,1,W,int\n"),
              (Findings{"1/3:1 convert.several_lines", "1/3:1 convert.two_values"}));
    EXPECT_EQ(findings("L,x,A,1,V,int\nL,y,A,1,W,int\n"),
              (Findings{"1/2:3 convert.target", "1/3:3 convert.two_values"}));
}

TEST(Convert, WhatATableCannotHoldIsRefused) {
    const auto refused = [](std::string_view variable, const TableFormat& format) {
        const auto read = load_text(
            "p.yaml", "lines: [{devices: [{name: D, variables: [{" + std::string(variable) + "}]}]}]\n");
        auto written = write_table(rows_of_project(read.document), format);
        Loaded described;
        described.document.files = {"p.yaml"};
        described.findings = std::move(written.findings);
        EXPECT_EQ(written.bytes.empty(), !described.findings.empty());
        return locations_and_codes(described);
    };
    EXPECT_EQ(refused("name: V, read_trigger: нет", {}), Findings{"1:66 csv.cannot_hold"});
    EXPECT_EQ(refused("name: V, type: string, default: \"\"", {}), Findings{"1:75 csv.cannot_hold"});
    EXPECT_EQ(refused("name: 中", {}), Findings{});
    EXPECT_EQ(refused("name: 中", {.encoding = Encoding::cp1251}), Findings{"1:49 csv.not_in_encoding"});
    EXPECT_EQ(refused("name: Р°", {.encoding = Encoding::cp1251}), Findings{"0:0 csv.reads_as_utf8"});
    EXPECT_EQ(refused("name: Р°", {.headings = Headings::russian, .encoding = Encoding::cp1251}), Findings{});
}

TEST(ConnectionKeys, OfSerialAndNetworkLines) {
    using Keys = std::vector<std::pair<std::string, std::string>>;
    model::Line line;
    line.port = "/dev/ttyS1";
    line.format = {.baud = 9600, .data_bits = 8, .parity = wire::Parity::even, .stop_bits = 1};
    EXPECT_EQ(connection_keys(line), (Keys{{"transport", "serial"},
                                           {"port", "/dev/ttyS1"},
                                           {"framing", "rtu"},
                                           {"baud", "9600"},
                                           {"parity", "even"},
                                           {"stop_bits", "1"},
                                           {"data_bits", "8"}}));
    line.rs485 = model::Rs485::rts;
    EXPECT_EQ(connection_keys(line).back(), (Keys::value_type{"rs485", "rts"}));
    line.transport = model::Transport::tcp;
    line.framing = wire::Framing::tcp;
    line.port = "host";
    EXPECT_EQ(connection_keys(line),
              (Keys{{"transport", "tcp"}, {"host", "host"}, {"tcp_port", "502"}, {"framing", "tcp"}}));
}

}  // namespace convert_test
}  // namespace takt::file
